//! Known distortions are recovered from simulated raw counts within the stated uncertainty.
//!
//! "Within" is tested as a statement about many seeds: the squared errors over their stated
//! variances have mean one (a χ² over all seeds and parameters), so that a standard error that
//! is too small fails, and one that is too large fails as well.

mod accelerometer;
mod centre_of_mass;
mod common;
mod converter;
mod gyroscope;
mod lever_arm;
mod magnetometer;
mod mounting;
