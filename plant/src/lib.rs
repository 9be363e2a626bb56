//! The reaction-wheel pendulum: motion, physical effects, sensors, experiments.
//!
//! One generic right-hand side ([`Plant::derivative`]) serves simulation, the sensitivities of the
//! fit (with [`Dual`] numbers) and linearisation. Experiments are constraints on the same model
//! ([`Kind`]); sensors are part of the model but not of the motion.
//!
//! | file | job |
//! |---|---|
//! | `scalar` | numbers with and without derivatives |
//! | `effect` | the definition of an effect |
//! | `physical` | the values that the cause of an effect can have |
//! | `hiding` | how the exam hides an effect |
//! | `hidden` | the parameters of an effect that the exam hides in a given bench |
//! | `external` | effects that are defined while the program runs |
//! | `learned_curve`, `spline` | curves over a coordinate, as data |
//! | `learned` | torques that were learned as curves |
//! | `late_sensor` | the common parts of the effects that delay or filter a sensor |
//! | `effects/` | the library, one file for each effect |
//! | `per_log` | effects with a parameter for each log |
//! | `model` | which effects a model has; the layout of its parameter vector |
//! | `plant/` | the motion: right-hand side, assembly, motor chain, integrator |
//! | `reading` | the readings of the sensors |
//! | `input` | the recorded current as a function of time |
//! | `linear` | the linear model about upright |
//! | `experiment` | the kinds of experiment |

mod effect;
mod effects;
mod experiment;
mod external;
mod hidden;
mod hiding;
mod input;
mod late_sensor;
mod learned;
mod learned_curve;
mod linear;
mod model;
mod per_log;
mod physical;
mod plant;
mod prior;
mod reading;
mod scalar;
mod spline;

pub use effect::{
    Driving, Effect, EffectInfo, Given, Instant, Linearised, Memory, ParameterInfo, RateFault,
    Ripple, Role, Smoothing, StartFrom, Timing, Unbalance,
};
pub use effects::EffectId;
pub use experiment::Kind;
pub use external::{Definition, External, ExternalEffect, ExternalError, Partials};
pub use hiding::{Hiding, HidingPlace};
pub use input::{Hold, Input};
pub use learned_curve::{FEWEST_KNOTS, LearnedCoordinate, LearnedCurve, MOST_KNOTS};
pub use linear::{LinearModel, LinearisationError, has_seen, linearise, torque_inputs};
pub use model::{
    BASE_PARAMETERS, GRAVITY_TORQUE, Model, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA, period_s,
};
pub use per_log::PerLog;
pub use physical::PhysicalRange;
pub use plant::{Current, Drive, EarlyStep, Late, Plant, State};
pub use prior::{Commonness, Prior};
pub use reading::{Output, Reading};
pub use scalar::{Dual, Scalar};
pub use spline::Spline;
