//! The reasons why a bench cannot be identified.

use bench_files::numbers::{number, with_uncertainty};
use plant::{LearnedCoordinate, Role};

use crate::fit::NoBetterThanMean;
use crate::progress::Cancelled;

/// The reason why a bench cannot be identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// No experiment has a usable channel.
    #[error("no experiment of the bench has a channel from which a parameter could be identified")]
    NoExperiments,
    /// No log says enough for a fit.
    #[error("no log of the bench can be used. {}", notes.join(". "))]
    NothingUsable {
        /// What is not used, and why: one sentence for each log.
        notes: Vec<String>,
    },
    /// No start gave a simulation with finite numbers.
    #[error(
        "the model could not be simulated from any start that the logs suggest; check units, signs \
         and kinds of the experiments in bench.toml (first suspect: {suspect})"
    )]
    NotFinite {
        /// The experiment with the largest misfit at the start.
        suspect: String,
    },
    /// An effect from outside the library has no finite torque where a log has been.
    #[error(
        "{effect} gives no finite torque where experiment \"{experiment}\" has been: {at}; its equation divides by zero \
         there, takes a root or a logarithm of what is not positive, or grows without limit"
    )]
    EffectNotFinite {
        /// The effect's name.
        effect: &'static str,
        /// The experiment.
        experiment: String,
        /// The first such instant, in words.
        at: String,
    },
    /// The fit has failed: its cost is not clearly below that of predicting the mean of every series.
    #[error(
        "the fit has failed: {}. No parameter of this fit is usable. Check units, signs and kind of {} in \
         bench.toml. The log must also show its motion: a spin-up needs a change of speed well above the noise, a \
         swing a good part of a period, both with several samples per period. If all of that is right, \
         a diagnosis looks for an effect that the model lacks",
        no_better(series),
        if series.len() == 1 { "the experiment" } else { "these experiments" }
    )]
    NoBetterThanMeans {
        /// The series that the model predicts no better than their means, in groups of logs that share parameters.
        series: Vec<NoBetterThanMean>,
    },
    /// The fit leaves an inertia open: its standard error is at least as large as its value, or it lies on a bound of its
    /// range.
    #[error(
        "the fit has failed: the logs do not determine {parameter} ({} kg m2). No parameter of this fit is usable. \
         The logs must show how fast the motion changes: a spin-up needs a change of speed well above the noise, a \
         swing a good part of a period, a driven log both. Record longer, or state what is known in [known]",
        with_uncertainty(*.value, *.std)
    )]
    InertiaOpen {
        /// The name of the parameter.
        parameter: &'static str,
        /// Its value in the fit, kg m².
        value: f64,
        /// Its standard error, kg m²; `None` on a bound.
        std: Option<f64>,
    },
    /// No log moves over the coordinate, or none shows the torque that acts along it.
    #[error(
        "no curve over {} can be learned: no log has both a motion along this coordinate and the channels that would show a torque. {}",
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

/// The series with their errors, as text for a message.
fn no_better(series: &[NoBetterThanMean]) -> String {
    let named: Vec<String> = series
        .iter()
        .take(MOST_NAMED)
        .map(|one| {
            let (output, unit) = (one.output.name(), one.output.unit());
            format!(
                "{}/{output} is predicted no better than by its mean (rms error {} {unit}; around the mean {} {unit})",
                one.experiment,
                number(one.rmse),
                number(one.spread)
            )
        })
        .collect();
    let more = match series.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    named.join(", ") + &more
}
