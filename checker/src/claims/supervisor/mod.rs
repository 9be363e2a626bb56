//! Claim `supervisor`: the motor is driven only after the controller was armed near upright and at
//! rest, and each stated condition ends that within its stated time.

pub(crate) mod body;
pub(crate) mod body_runs;
pub mod runs;
pub mod second;
pub mod words;
