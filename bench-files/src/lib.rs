//! All files that are read or written: `bench.toml`, CSV logs, `model.toml`.
//!
//! [`Bench::load`] turns a bench folder into plain data in SI units; [`ModelFile`] reads and
//! writes the model that belongs to it. The results of this crate have been checked: names, units and
//! signs are resolved, times increase, numbers are finite (a drop-out is NaN, and counted in the
//! [`LoadReport`]). An [`Error`] says what is wrong with a file, where, and
//! what would be right.
//!
//! Coordinates are those of the whole project: body angle 0 hanging and π upright, wheel speed
//! relative to the body, positive current drives the wheel forward.

#![warn(missing_docs)]

mod averages;
mod bench;
mod bring_up;
mod calibration;
mod cell;
mod channel;
mod clock;
mod correlation;
mod csv_table;
mod design_section;
mod dialect;
mod drop_out;
mod effects_section;
mod error;
mod experiment;
mod experiment_plan;
mod files;
mod foreign;
mod hardware;
pub mod keys;
mod known;
mod learned_section;
mod log;
mod model_file;
pub mod numbers;
mod outline;
mod own_effect;
mod parameter;
mod table;
mod toml_section;
mod toml_source;
mod toml_writing;
mod units_in_text;
mod verdict_section;
mod write;

pub use bench::{Bench, Controller};
pub use bring_up::{BringUpRecordings, RawRecording};
pub use calibration::{
    Calibration, CalibrationRecordings, CountsRecording, LeverArmCalibration, LineCalibration,
    MountingCalibration, PlumbLines, StoredSensorCalibration,
};
pub use channel::Channel;
pub use correlation::Correlation;
pub use csv_table::{MAX_LOG_BYTES, MAX_LOG_ROWS};
pub use design_section::DesignSection;
pub use drop_out::{LONGEST_DROP_OUT, drop_outs};
pub use effects_section::Tie;
pub use error::{Error, Place, Problem};
pub use experiment::{CurrentMeaning, Experiment};
pub use files::{FilesInMemory, ReadingWatch, WATCHED_BYTES};
pub use hardware::{
    AngleSensor, Drive, DriveKind, Hardware, InertialSensor, Part, WheelSpeedSensor, known_parts,
};
pub use known::{Known, MissingKnowns};
pub use log::{LoadReport, Log, MIN_SAMPLES, Note, Stated, UnstatedUnit};
pub use model_file::ModelFile;
pub use outline::{BenchOutline, NewExperiment, file_name};
pub use own_effect::{OWN_PREFIX, OwnEffect};
pub use parameter::Parameter;
pub use table::Table;
pub use units_in_text::{plain_unit, unit_of_name};
pub use write::{can_write, can_write_into, write_atomically};
