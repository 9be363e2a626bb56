//! The sensors of a bench on one bus: the parts, and the readings that the loop takes from them in a step.
//!
//! | bench | body | wheel |
//! |---|---|---|
//! | [`InertialBench`] | FXAS21002 and FXOS8700, as in the thesis | a [`WheelPart`] |
//! | [`PivotBench`] | AS5600 on the pivot | a [`WheelPart`] |
//!
//! `[hardware]` in bench.toml must name the same parts. For other parts copy one of the two files.
//!
//! A part that fails counts as missing: the loop receives a fault, and the part is started again while the motor is not
//! driven.
#![no_std]

mod inertial;
mod pivot;
mod wheel;

pub use inertial::InertialBench;
pub use pivot::PivotBench;
pub use wheel::{WheelPart, YourWheel};

/// A part is missing, or has failed in this step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

/// Reads a part. A part that fails counts as missing until it is started again.
fn kept<P, T, E>(
    part: &mut Option<P>,
    read: impl FnOnce(&mut P) -> Result<T, E>,
) -> Result<T, Failed> {
    match part.as_mut().map(read) {
        Some(Ok(value)) => Ok(value),
        _ => {
            *part = None;
            Err(Failed)
        }
    }
}
