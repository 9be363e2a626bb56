//! Claim `step-total`: raw counts give a duty within the drive's limits, and the duty of zero current if
//! the controller is not armed.

use crate::certificate::reader::Certificate;
use crate::language::module::Module;

mod body;
pub mod composition;
pub mod ranges;
pub mod runs;

/// Runs `Controller::step` on random samples, by the sensor that shows the body: the duty is that of the law. Returns
/// how many samples it ran.
///
/// # Errors
/// The first sample whose duty is not that of the law.
pub fn step_in_runs(
    module: &Module,
    certificate: &Certificate,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    match certificate.hardware.body_encoder() {
        Some(encoder) => body::step(module, certificate, encoder, cases, seed),
        None => runs::step(module, certificate, cases, seed),
    }
}
