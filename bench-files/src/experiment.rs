//! One recorded experiment of a bench.

use std::path::PathBuf;

use plant::Kind;

use crate::log::{LoadReport, Log};

/// The meaning of the current column of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurrentMeaning {
    /// The command of the controller.
    #[default]
    Command,
    /// The measured current.
    Measured,
}

/// One recorded experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its name, unique in the bench.
    pub name: String,
    /// What is held still, and around which equilibrium the motion takes place.
    pub kind: Kind,
    /// The log's path.
    pub file: PathBuf,
    /// The samples. Channels by kind: free-swing has at least one of angle and rate; spin-up has the
    /// wheel speed, and the current if it is known; balance has at least one of angle and rate, and the
    /// current; driven has at least one of angle and wheel speed, and the current.
    pub log: Log,
    /// Channels of the file that this kind of experiment holds still. Checks use them, a fit does not. Their
    /// samples belong to the times of `log`; NaN for a cell that is not a number.
    pub beside: Log,
    /// The meaning of the current.
    pub current_meaning: CurrentMeaning,
    /// The findings of the data check that the user accepts for this experiment (`accept`).
    pub accept: Vec<String>,
    /// Line of bench.toml with its name.
    pub line: usize,
    /// How the log was read.
    pub report: LoadReport,
}
