//! Claim `filter-accurate`: the filter computes Madgwick's equations, to within a tolerance. Beside the
//! draws of random numbers this is the only folder with floating point.

pub mod constants;
pub mod equations;
pub mod runs;
