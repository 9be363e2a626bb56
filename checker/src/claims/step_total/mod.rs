//! Claim `step-total`: raw counts give a duty within the drive's limits, and that of zero current when
//! not armed.

pub mod composition;
pub mod ranges;
pub mod runs;
