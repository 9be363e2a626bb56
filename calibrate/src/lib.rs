//! Calibration from recordings: pure functions from data to numbers with standard errors.
//!
//! Every result states how well it is determined: standard errors, residuals, and a condition
//! number or coverage if the data may not be sufficient.
//!
//! The section `[calibration]` of bench.toml lists the recordings, and that of model.toml holds the
//! results; both are described in `bench-files/src/calibration.rs`.
#![warn(missing_docs)]

mod bring_up;
mod error;
mod gyroscope;
mod lever_arm;
mod line_fit;
mod magnetometer;
mod mounting;
mod plumb_lines;
mod sensor_calibration;
mod sphere_fit;
mod still;
mod still_poses;

pub use bring_up::{
    Doubt, MotorSigns, Recording, TILT_MIN_RAD, TiltShows, Turned, WheelWord, encoder_sign,
    motor_signs, tilt,
};
pub use error::CalibrationError;
pub use gyroscope::{GyroscopeRest, gyroscope_rest};
pub use lever_arm::{LeverArmEstimate, lever_arm};
pub use line_fit::{Counts, LeftOut, LineFit, fit_line, fit_line_within_range};
pub use magnetometer::{
    COVERAGE_MIN, MagnetometerCalibration, SPREAD_MAX, UsableReadings, magnetometer, mean_field_ut,
    sphere_coverage, usable_readings,
};
pub use mounting::{Mounting, alignment, mounting};
pub use plumb_lines::{CentreOfMass, PlumbLine, centre_of_mass};
pub use sensor_calibration::SensorCalibration;
pub use sphere_fit::{Shape, SphereFit, fit_sphere};
pub use still::{Still, still};
pub use still_poses::{AccelerometerCalibration, accelerometer};
