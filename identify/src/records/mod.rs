//! Logs as the fit uses them, and the processing of their samples that needs no model.

mod angle;
mod averages;
mod before;
mod charge;
mod early_steps;
mod jitter;
mod noise;
mod past;
mod record;
mod statistics;
mod thinning;
mod weak_form;

pub use angle::angle_samples;
pub(crate) use averages::{blocks, means};
pub(crate) use early_steps::join_early_steps;
pub use early_steps::{StepTimes, UnknownStep};
pub(crate) use noise::{NOISE_RELATIVE_STD_ROOT_N, NoiseEstimate, noise_by_differences};
pub use noise::{input_noise_std, noise_std, resolution};
pub(crate) use record::ToothStart;
pub use record::{BALANCE_WINDOW_S, Output, Record, RecordedChannel, RecordedCurrent};
pub(crate) use statistics::{StraightLine, median};
pub(crate) use weak_form::{BUMP_S, Bump, FEWEST_HALF_SAMPLES, dot, half_samples};
pub use weak_form::{WeakForm, bumps};
