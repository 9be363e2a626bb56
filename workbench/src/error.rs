//! What can go wrong, from a slip in a file to a design that the numbers do not allow.

use std::path::PathBuf;

use ::data_check::Finding;
use calibrate::CalibrationError;
use checker::ProveError;
use codegen::{FileError, Refusal};
use design::DesignError;
use figures::FigureError;
use identify::{Cancelled, IdentifyError};
use simulate::SimulateError;

use crate::bench_hardware::HardwareError;
use crate::data_check::refusal_text;

/// Why there is no result. Messages name the file that is to be mended, where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, or something in it is wrong; [`bench_files::Error::place`] has file,
    /// line and column.
    #[error(transparent)]
    File(#[from] bench_files::Error),
    /// The data would lead to a wrong model: see [`check_data`](crate::check_data).
    #[error("{}", refusal_text(file, *line, refusals))]
    Data {
        /// The bench.toml.
        file: PathBuf,
        /// The line of the first finding's experiment.
        line: Option<usize>,
        /// The findings that refuse the data; at least one.
        refusals: Vec<Finding>,
    },
    /// A bench is not begun where one is.
    #[error("{}: there is a bench already; it is left as it is", file.display())]
    BenchExists {
        /// Its bench.toml.
        file: PathBuf,
    },
    /// A folder cannot be made.
    #[error("{}: cannot make the folder: {reason}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The logs cannot be identified.
    #[error("{}: {source}", bench.display())]
    Identify {
        /// The bench's folder, or its name where it is in memory.
        bench: PathBuf,
        /// Why.
        source: IdentifyError,
    },
    /// The session has no model yet: it was never identified.
    #[error("{}: there is no model yet: identify the bench first", model.display())]
    NoModel {
        /// Where the model would be.
        model: PathBuf,
        /// The bench's folder.
        bench: PathBuf,
    },
    /// Neither the library nor the bench has an effect of this name.
    #[error("there is no effect \"{name}\"{}", own_effects_text(own))]
    UnknownEffect {
        /// The name.
        name: String,
        /// The effects that the user of the bench has written.
        own: Vec<String>,
    },
    /// The model has the effect already.
    #[error("{}: {effect} is not added: {reason}", model.display())]
    EffectPresent {
        /// The model's file.
        model: PathBuf,
        /// The effect.
        effect: String,
        /// In which form it is there.
        reason: String,
    },
    /// There is no such coordinate.
    #[error(
        "nothing can be learned over \"{name}\"; a curve stands over angle, rate, wheel_speed or wheel_angle"
    )]
    UnknownCoordinate {
        /// What was asked for.
        name: String,
    },
    /// The model does not have the effect.
    #[error("{}: the model does not have {effect}; it has {}", model.display(), present.join(", "))]
    EffectAbsent {
        /// The model's file.
        model: PathBuf,
        /// The effect.
        effect: String,
        /// What it has.
        present: Vec<String>,
    },
    /// A parameter of the model is in a unit that the bench as it is now does not give.
    #[error("{}: {parameter} is in \"{found}\", but the bench as it is now gives \"{unit}\"", model.display())]
    ParameterUnit {
        /// The model's file.
        model: PathBuf,
        /// The bench's folder.
        bench: PathBuf,
        /// The parameter.
        parameter: String,
        /// Its unit in the model.
        found: String,
        /// The unit that the logs give.
        unit: String,
    },
    /// The model lacks a parameter that the logs of this bench can show.
    #[error("{}: lacks [parameters.{parameter}]", model.display())]
    ParameterMissing {
        /// The model's file.
        model: PathBuf,
        /// The bench's folder.
        bench: PathBuf,
        /// The parameter.
        parameter: String,
    },
    /// The model has no parameter of this name.
    #[error("the model has no parameter \"{name}\"; it has {}", present.join(", "))]
    UnknownParameter {
        /// The name.
        name: String,
        /// The parameters of the model.
        present: Vec<String>,
    },
    /// The diagnosis has no step.
    #[error("{}: the diagnosis has no step: nothing could be fitted", bench.display())]
    NoStep {
        /// The bench's folder.
        bench: PathBuf,
    },
    /// The model cannot be linearised about upright.
    #[error("{}: {reason}", model.display())]
    Linearise {
        /// The model's file.
        model: PathBuf,
        /// Why.
        reason: String,
    },
    /// No controller can be had from this model with these weights.
    #[error("{}: {source}", model.display())]
    Design {
        /// The model's file.
        model: PathBuf,
        /// Why.
        source: DesignError,
    },
    /// The sensors or the drive are not stated, or contradict each other.
    #[error("{}: {source}", model.display())]
    Hardware {
        /// The model's file.
        model: PathBuf,
        /// Why.
        source: HardwareError,
    },
    /// The generator refuses: a claim could not be kept.
    #[error("{}: {source}", model.display())]
    Refused {
        /// The model's file.
        model: PathBuf,
        /// Why, and what would cure it.
        source: Box<Refusal>,
    },
    /// What would be emitted drives the motor the wrong way, or contradicts physics otherwise.
    #[error("{}: {reason}; see [hardware], [calibration] and [parameters]", model.display())]
    Unphysical {
        /// The model's file.
        model: PathBuf,
        /// What contradicts.
        reason: String,
    },
    /// What the generator emitted cannot be read back.
    #[error("{}: the emitted {reason}", model.display())]
    Emitted {
        /// The model's file.
        model: PathBuf,
        /// Why.
        reason: String,
    },
    /// A simulation gave no result.
    #[error("{}: {source}", model.display())]
    Simulate {
        /// The model's file.
        model: PathBuf,
        /// Why.
        source: SimulateError,
    },
    /// An emitted crate cannot be written or read.
    #[error(transparent)]
    EmittedFiles(#[from] FileError),
    /// There is nothing to prove.
    #[error(transparent)]
    Prove(#[from] ProveError),
    /// A claim fails before anything was damaged.
    #[error("{}: the claim {claim} fails without any damage", folder.display())]
    FailsUndamaged {
        /// The emitted crate.
        folder: PathBuf,
        /// The claim.
        claim: String,
    },
    /// A recording does not allow a calibration.
    #[error("{}: {source}", recording.display())]
    Calibrate {
        /// The recording.
        recording: PathBuf,
        /// Why.
        source: CalibrationError,
    },
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A table cannot be put together.
    #[error("the table {name}: {source}")]
    Table {
        /// The table.
        name: String,
        /// Why.
        source: csv::Error,
    },
    /// The session lives in memory and has no file to write its model to.
    #[error("the bench is in memory: say where its model is to be written")]
    NoPlace,
    /// The caller called the work off.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn own_effects_text(own: &[String]) -> String {
    if own.is_empty() {
        "; an own one is written to effects/NAME.toml in the bench folder and named own:NAME"
            .to_owned()
    } else {
        format!("; the bench's own are {}", own.join(", "))
    }
}
