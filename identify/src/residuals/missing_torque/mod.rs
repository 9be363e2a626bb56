//! The torque that a model lacks, over time.

mod motion;
mod torque;

pub use motion::MeasuredMotion;
pub use torque::{MissingTorque, TorqueOn, half_bump, missing_torque, missing_torques};
