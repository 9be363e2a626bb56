//! Claim `filter-accurate`: the filter computes Madgwick's equations within a tolerance. Apart from the
//! generator of random numbers, this is the only folder with floating point.

pub mod constants;
pub mod equations;
pub mod runs;
