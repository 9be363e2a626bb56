//! The closed loop as on the bench: the nonlinear plant with its effects, sensors with
//! noise and quantisation, a command at every sample, the drive's limits, and pushes.
//!
//! | file | job |
//! |---|---|
//! | [`law`] | control laws: exact, in fixed-point words, with bias observer; all behind one trait |
//! | [`interpreted`] | the emitted law of any model, run from its source |
//! | [`sensors`] | the measurement that the controller receives |
//! | [`push`] | pushes on the body |
//! | [`motion`] | the plant that is controlled: nonlinear, or its linear model |
//! | [`closed_loop`] | the loop itself, and its record |
//! | [`attitude_filters`] | methods for the angle, compared on one swing (thesis figure 3.3) |
//! | [`raw_counts`] | the same loop from the sensors' raw counts to the drive's duty |
//! | [`scenario`] | the runs of the thesis: transient, disturbance, half a minute with pushes |
//! | [`transient`] | the quality of a transient: oscillations, overshoot, settling |
//! | [`recovery`] | the largest angle from which the loop recovers |
//! | [`attraction`] | the largest ellipsoid of starts from which the loop returns |
//! | [`mod@overlay`] | a simulated loop compared with a measured balance log |
//! | [`linear_validity`] | where the linear model is valid |
//!
//! Series are plain vectors in SI units; other crates draw and write them.

#![warn(missing_docs)]

pub mod attitude_filters;
pub mod attraction;
pub mod closed_loop;
mod error;
pub mod interpreted;
pub mod law;
pub mod linear_validity;
pub mod motion;
pub mod overlay;
pub mod push;
pub mod raw_counts;
pub mod recovery;
pub mod scenario;
pub mod sensors;
pub mod transient;

pub use attraction::{Attraction, region_of_attraction};
pub use closed_loop::{Actuator, ClosedLoop, Deviation, LoopTrace};
pub use error::SimulateError;
pub use interpreted::InterpretedLaw;
pub use law::{BiasObservingLaw, ExactLaw, Law, LawFailure, Measured, WordFormats, WordLaw};
pub use motion::{LinearMotion, Motion};
pub use overlay::{LoggedLoop, overlay};
pub use push::Push;
pub use raw_counts::{
    CountsLine, EncoderOutput, Fault, Faulty, InterpretedController, Paced, RawController, RawLoop,
    RawSample, RawSensors, SensorPace, VoltageOutput, WheelOutput,
};
pub use recovery::{Recovery, largest_recoverable_angle};
pub use scenario::Scenario;
pub use sensors::{Sensor, Sensors};
pub use transient::{Transient, effects_on_transient};
