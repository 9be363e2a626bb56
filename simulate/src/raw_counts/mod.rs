//! The loop as the firmware closes it: raw counts of the sensors in, duty of the drive out.
//!
//! Nothing between is idealised: the accelerometer feels the body's own acceleration where it
//! sits, every reading has noise, a bias and the steps of its converter, the attitude is found by
//! the emitted filter, and the current is what the duty says.

mod bench;
mod controller;
mod faults;
mod sensors;

pub use bench::RawLoop;
pub use controller::{InterpretedController, RawController, RawSample};
pub use faults::{Fault, Faulty};
pub use sensors::{CountsLine, RawSensors};
