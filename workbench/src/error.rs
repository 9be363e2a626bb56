//! All errors, from a mistake in a file to a design that the numbers do not allow.

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
use crate::refusal::refusal_text;

/// The reason why there is no result. Messages name the file to be corrected, if there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, or its content is wrong; [`bench_files::Error::place`] has file,
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
    /// A bench cannot be created where one exists.
    #[error("{}: a bench exists already and is not changed; choose another folder", file.display())]
    BenchExists {
        /// Its bench.toml.
        file: PathBuf,
    },
    /// A folder cannot be created.
    #[error("{}: cannot create the folder: {reason}", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
        /// The system's error message.
        reason: String,
    },
    /// The logs cannot be identified.
    #[error("{}: {source}", bench.display())]
    Identify {
        /// The bench's folder, or its name if it is in memory.
        bench: PathBuf,
        /// The reason.
        source: IdentifyError,
    },
    /// The session has no model: it has not been identified.
    #[error("{}: there is no model yet: identify the bench first", model.display())]
    NoModel {
        /// Path of the missing model.
        model: PathBuf,
        /// The bench's folder.
        bench: PathBuf,
    },
    /// Neither the library nor the bench has an effect of this name.
    #[error("there is no effect \"{name}\"{}", own_effects_text(own))]
    UnknownEffect {
        /// The name.
        name: String,
        /// The effects that the user of the bench has defined.
        own: Vec<String>,
    },
    /// The model has the effect already.
    #[error("{}: {effect} is not added: {reason}", model.display())]
    EffectPresent {
        /// The model's file.
        model: PathBuf,
        /// The effect.
        effect: String,
        /// The form in which it is there.
        reason: String,
    },
    /// There is no such coordinate.
    #[error(
        "there is no coordinate \"{name}\"; a curve can be learned over angle, rate, wheel_speed or wheel_angle"
    )]
    UnknownCoordinate {
        /// The coordinate that was asked for.
        name: String,
    },
    /// The model does not have the effect.
    #[error("{}: the model does not have {effect}; it has {}", model.display(), present.join(", "))]
    EffectAbsent {
        /// The model's file.
        model: PathBuf,
        /// The effect.
        effect: String,
        /// The effects of the model.
        present: Vec<String>,
    },
    /// A parameter of the model has another unit than the bench now gives.
    #[error("{}: {parameter} is in \"{found}\", but the bench now gives \"{unit}\"", model.display())]
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
    /// The model lacks a parameter that the logs of this bench depend on.
    #[error("{}: lacks [parameters.{parameter}], on which the logs of the bench depend", model.display())]
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
        /// The reason.
        reason: String,
    },
    /// An inertia was set to 1, because the bench does not determine it.
    #[error(
        "{}: a design needs the inertias in kg m2, and the bench does not determine {unknown} (the file has 1, which \
         fixes the scale of the torques only). State it under [known] of bench.toml. Or let the logs show it: \
         total_inertia follows from masses and lengths or gravity_torque under [known]; wheel_inertia follows from \
         torque_constant under [known] and a spin-up with its current (a column, or `constants = {{ current = 0.6 }}`). \
         Then run `flywheel identify` again",
        model.display()
    )]
    OpenScale {
        /// The model's file.
        model: PathBuf,
        /// The inertias that are not determined.
        unknown: String,
    },
    /// No controller can be designed for this model with these weights.
    #[error("{}: {source}", model.display())]
    Design {
        /// The model's file.
        model: PathBuf,
        /// The reason.
        source: DesignError,
    },
    /// The sensors or the drive are not stated, or contradict each other.
    #[error("{}: {source}", model.display())]
    Hardware {
        /// The model's file.
        model: PathBuf,
        /// The reason.
        source: HardwareError,
    },
    /// The generator refuses: a claim could not be kept.
    #[error("{}: {source}", model.display())]
    Refused {
        /// The model's file.
        model: PathBuf,
        /// The reason, with a remedy.
        source: Box<Refusal>,
    },
    /// The controller would drive the motor the wrong way, or contradicts physics in another way.
    #[error("{}: {reason}; see [hardware], [calibration] and [parameters]", model.display())]
    Unphysical {
        /// The model's file.
        model: PathBuf,
        /// The contradiction.
        reason: String,
    },
    /// The emitted source cannot be read back.
    #[error("{}: the emitted {reason}", model.display())]
    Emitted {
        /// The model's file.
        model: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A simulation gave no result.
    #[error("{}: {source}", model.display())]
    Simulate {
        /// The model's file.
        model: PathBuf,
        /// The reason.
        source: SimulateError,
    },
    /// An emitted crate cannot be written or read.
    #[error(transparent)]
    EmittedFiles(#[from] FileError),
    /// There is nothing to be proved.
    #[error(transparent)]
    Prove(#[from] ProveError),
    /// A claim fails even before the crate was damaged.
    #[error("{}: claim {claim} fails before anything is damaged", folder.display())]
    FailsUndamaged {
        /// The emitted crate.
        folder: PathBuf,
        /// The claim.
        claim: String,
    },
    /// A recording is not sufficient for a calibration.
    #[error("{}: {source}", recording.display())]
    Calibrate {
        /// The recording.
        recording: PathBuf,
        /// The reason.
        source: CalibrationError,
    },
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A table cannot be written.
    #[error("the table {name}: {source}")]
    Table {
        /// The table.
        name: String,
        /// The reason.
        source: csv::Error,
    },
    /// Nothing can be recorded from this line.
    #[error("{}: {reason}", port.display())]
    Record {
        /// The serial device.
        port: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The session is in memory, and has no file for its model.
    #[error("the bench is in memory: name a file for its model")]
    NoPlace,
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn own_effects_text(own: &[String]) -> String {
    if own.is_empty() {
        "; a user's effect is defined in effects/NAME.toml in the bench folder and named own:NAME"
            .to_owned()
    } else {
        format!("; the bench's own effects are {}", own.join(", "))
    }
}
