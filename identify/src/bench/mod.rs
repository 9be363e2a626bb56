//! A whole bench, prepared for the fits: which parameters are known, which are free, and in which units.

mod coarse;
mod dense;
mod error;
mod parameters;
mod problem;
mod selection;
mod toothed;

pub use error::IdentifyError;
pub use problem::FitProblem;
pub use selection::{HELD_START, SPARSE_COMMANDS, commands_per_row};
