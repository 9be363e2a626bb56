//! What the logs show without a model of the motion.

mod decay;
mod kinematics;

pub use decay::{AtAmplitude, Decay, DecayLaw, Estimate, decay};
pub use kinematics::{RateAgainstAngle, rate_against_angle};
