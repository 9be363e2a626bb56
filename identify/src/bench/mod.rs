//! A whole bench as the fits take it: what is known, what is free, in which units.

mod coarse;
mod dense;
mod error;
mod parameters;
mod problem;

pub use error::IdentifyError;
pub use problem::FitProblem;
