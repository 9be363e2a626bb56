//! Attitude of the pendulum from an inertial sensor, in double precision.
//!
//! These filters are the reference for the emitted fixed-point filters: both receive
//! the same raw counts and follow the same rules, so their difference is the rounding error.
//!
//! # Frames and signs
//! The earth frame E has z upwards, the sensor frame S is that of the chip. A quaternion
//! q = (q₁, q₂, q₃, q₄) = (w, x, y, z) is Madgwick's ˢᴇq̂: it takes a vector from E to S by
//! ˢv = q* ⊗ ᴇv ⊗ q. The body turns with ᴇω about the pivot axis, which is the sensor's z axis,
//! so that a positive rate of the gyroscope's z axis raises the body angle α (0 hanging,
//! π upright). See [`pivot_angle`].
//!
//! # Files
//! - `spec`: properties of sensor and mounting, as plain data
//! - `measurement`: raw counts to SI, and the rule for measurements that cannot be used
//! - `madgwick`: the gradient-descent filter, six and nine axes
//! - `lever_arm`: the acceleration of the accelerometer's own motion
//! - `pivot_angle`: the angle about the pivot axis
//! - `raw_filter`: all of these combined, from raw counts to the angle
//! - `beta`: the filter gain from the gyroscope's error
//! - `complementary`, `low_pass`: the simpler filters, for comparison
#![warn(missing_docs)]

mod beta;
mod complementary;
mod lever_arm;
mod low_pass;
mod madgwick;
mod measurement;
mod pivot_angle;
mod raw_filter;
mod spec;

pub use beta::{beta_from_gyro_error, beta_from_gyro_noise};
pub use complementary::Complementary;
pub use lever_arm::{LeverArm, RATE_LAG_STEPS};
pub use low_pass::{LowPass, LowPassIntegrator};
pub use madgwick::{GRADIENT_MIN, HORIZONTAL_FIELD_MIN, Madgwick};
pub use measurement::{GRAVITY_SHARE_MIN, WORD_CLIP, is_saturated};
pub use pivot_angle::{pivot_angle, pivot_angle_of_gravity, up_in_sensor, wrap_angle};
pub use raw_filter::RawFilter;
pub use spec::{AttitudeSpec, STANDARD_GRAVITY, SensorLine};
