//! The section `[calibration]`: in bench.toml it names recordings, in model.toml it holds their results.

mod recordings;
mod results;

pub use recordings::{CalibrationRecordings, CountsRecording, PlumbLines};
pub use results::{
    Calibration, LeverArmCalibration, LineCalibration, MountingCalibration, StoredSensorCalibration,
};
