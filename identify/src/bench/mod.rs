//! A whole bench, prepared for the fits: which parameters are known, which are free, and in which units.

mod coarse;
mod dense;
mod error;
mod parameters;
mod problem;
mod toothed;

pub use error::IdentifyError;
pub use problem::FitProblem;
