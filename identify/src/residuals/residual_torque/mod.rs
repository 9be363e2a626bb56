//! The missing torque, over time.

mod motion;
mod slopes;
mod torque;
mod undo;

pub use motion::MeasuredMotion;
pub use torque::{ResidualTorque, TorqueOn, half_bump, residual_torque, residual_torques};
