//! Why a bench cannot be identified.

use crate::progress::Cancelled;

/// Why a bench cannot be identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// No experiment has a usable channel.
    #[error("the bench has no experiment from which anything could be identified")]
    NoExperiments,
    /// The minimisation found no finite simulation.
    #[error(
        "the model could not be simulated from any start that the logs suggest; check units, signs \
         and kinds of the experiments in bench.toml (first suspect: {suspect})"
    )]
    NotFinite {
        /// The experiment with the largest misfit at the start.
        suspect: String,
    },
    /// The work was called off.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
