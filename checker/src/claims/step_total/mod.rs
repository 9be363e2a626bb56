//! Claim `step-total`: raw counts give a duty within the drive's limits, and the duty of zero current if
//! the controller is not armed.

mod body;
pub mod composition;
pub mod ranges;
pub mod runs;
