//! Why a bench cannot be identified.

use plant::{LearnedCoordinate, Role};

use crate::fit::NoBetterThanMean;
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
    /// The fit has failed: it costs more than the means of the series do.
    #[error(
        "the fit has failed: {}. No parameter can be had from that. Check units, signs and kind of {} in \
         bench.toml; the log must also be long enough to show its motion (a spin-up a change of speed well above \
         the noise, a swing a good part of a period) at several samples a period. Where all of that is right, \
         `flywheel diagnose` looks for what the model lacks",
        no_better(series),
        if series.len() == 1 { "the experiment" } else { "these experiments" }
    )]
    NoBetterThanMeans {
        /// The series that the model predicts no better than their means, of logs that share parameters and
        /// together cost more than their means.
        series: Vec<NoBetterThanMean>,
    },
    /// No log moves over the coordinate, or none shows the torque that acts along it.
    #[error(
        "nothing can be learned over {}: no log moves over it with the channels that would show a torque. {}",
        .coordinate.words(),
        would_show(*.coordinate)
    )]
    NothingToLearn {
        /// The coordinate.
        coordinate: LearnedCoordinate,
    },
    /// The work was called off.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn would_show(coordinate: LearnedCoordinate) -> &'static str {
    match coordinate.role() {
        Role::Wheel => "An experiment with a turning wheel and a wheel_speed column would show it",
        _ => "A free swing with an angle column would show it",
    }
}

/// Most series that a message names.
const MOST_NAMED: usize = 4;

/// The series with their errors, for a message.
fn no_better(series: &[NoBetterThanMean]) -> String {
    let named: Vec<String> = series
        .iter()
        .take(MOST_NAMED)
        .map(|one| {
            let (output, unit) = (one.output.name(), one.output.unit());
            format!(
                "{}/{output} is predicted no better than by its mean (error {:.3} {unit}, about its mean {:.3} {unit})",
                one.experiment, one.rmse, one.spread
            )
        })
        .collect();
    let more = match series.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    named.join(", ") + &more
}
