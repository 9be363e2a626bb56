//! Results from the logs without a model of the motion.

mod decay;
mod kinematics;
mod release;
mod teeth;

pub use decay::{AtAmplitude, DecayLaw, Estimate, FreeDecay, decay};
pub use kinematics::{RateAgainstAngle, rate_against_angle};
pub use release::{HeldStart, held_start};
pub(crate) use teeth::{Teeth, find_teeth};
