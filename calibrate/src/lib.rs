//! Calibration from recordings: pure functions from data to numbers with standard errors.
//!
//! Every result says how well it is determined: standard errors, residuals, and a condition
//! number or coverage where the data may not support the answer.
//!
//! # The section `[calibration]` of bench.toml
//! All entries are optional; each recording yields what its line says. Files are CSV with a header
//! line and lie in the bench folder. Counts are raw, as the sensor's registers hold them.
//!
//! ```toml
//! [calibration]
//! accelerometer = ["poses/x-up.csv", "poses/x-down.csv"]  # still poses, 6 or more: ax, ay, az
//! gyroscope     = "still.csv"       # at rest: gx, gy, gz
//! magnetometer  = "all-round.csv"   # turned into all directions: mx, my, mz
//! swing         = "swing.csv"       # wheel locked, swinging about the pivot: gx, gy, gz
//! hanging       = "hanging.csv"     # at rest, hanging: ax, ay, az
//! wheel_speed   = "converter.csv"   # adc_count, wheel_speed_rad_s (by a tachometer)
//! current       = "drive.csv"       # duty, current_A (by an ammeter)
//! gyroscope_scale = 1.0908308e-3    # rad/s per count, from the data sheet
//! sample_time     = 0.001           # s, of the still and swing recordings
//! field           = 48.9            # µT, the local field; left out: 0.1 µT per count is taken
//! columns = { ax = "acc_x" }        # where the header differs
//!
//! [calibration.plumb_lines]         # centre of mass, thesis 3.4; body-fixed drawing, m
//! pivot = [0.0, 0.0]
//! std   = 0.0005                    # of a mark
//! lines = [[[0.1, 0.0], [0.02, -0.13]], [[-0.1, 0.0], [-0.01, -0.13]]]   # two marks on each
//! ```
//!
//! # What goes into model.toml
//! ```toml
//! [calibration.accelerometer]       # likewise gyroscope, magnetometer
//! bias_counts = [41.7, -24.2, 9.9]
//! bias_std    = [0.3, 0.3, 0.3]
//! matrix      = [[…], […], […]]     # SI per count: value = matrix (counts − bias)
//! matrix_std  = [[…], […], […]]
//!
//! [calibration.mounting]
//! axis         = [0.01, -0.02, 0.9997]     # of the pivot in the sensor's frame
//! axis_std_rad = 2e-4
//! angle        = 2.356              # rad, from the body's axis to the sensor's x axis
//! angle_std    = 1e-3
//!
//! [parameters.pivot_to_com]         # as any other parameter, with std and source
//!
//! [calibration.wheel_speed]         # likewise current, duty as a function of A
//! slope = 0.893373   slope_std = 1e-5   offset = -690.574   offset_std = 1e-2
//! ```
#![warn(missing_docs)]

mod error;
mod gyroscope;
mod line_fit;
mod magnetometer;
mod mounting;
mod plumb_lines;
mod specification;
mod sphere_fit;
mod still;
mod still_poses;

pub use error::CalibrationError;
pub use gyroscope::{GyroscopeRest, gyroscope_rest};
pub use line_fit::{LineFit, fit_line};
pub use magnetometer::{
    COVERAGE_MIN, MagnetometerCalibration, magnetometer, mean_field_ut, sphere_coverage,
};
pub use mounting::{Mounting, alignment, mounting};
pub use plumb_lines::{CentreOfMass, PlumbLine, centre_of_mass};
pub use specification::{Calibrated, attitude_spec};
pub use sphere_fit::{Shape, SphereFit, fit_sphere};
pub use still::{Still, still};
pub use still_poses::{AccelerometerCalibration, accelerometer};

use nalgebra::{Matrix3, Vector3};

/// A three-axis sensor's line with its standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorCalibration {
    /// Bias (counts) and matrix (SI per count).
    pub line: attitude::SensorLine,
    /// Standard errors of the bias, counts.
    pub bias_std: Vector3<f64>,
    /// Standard errors of the matrix, SI per count; zero for entries that are not identified.
    pub matrix_std: Matrix3<f64>,
}
