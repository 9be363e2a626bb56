//! The loop as the firmware closes it: from the sensors' raw counts to the duty of the drive.
//!
//! The simulation has the imperfections of a real bench: the accelerometer measures the body's own acceleration at its
//! position, every reading has noise, a bias and quantisation, the emitted filter estimates the attitude, and the
//! current follows from the duty.

mod bench;
mod controller;
mod faults;
mod paced;
mod sensors;

pub use bench::RawLoop;
pub use controller::{InterpretedController, RawController, RawSample};
pub use faults::{Fault, Faulty};
pub use paced::{Paced, SensorPace};
pub use sensors::{CountsLine, EncoderOutput, RawSensors, VoltageOutput, WheelOutput};
