//! Claim `supervisor`: the motor is driven only after the controller was armed near upright and at
//! rest, and each stated condition ends that within its stated time.

use crate::certificate::hardware::CertifiedBody;
use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::language::module::Module;

pub(crate) mod body;
mod body_runs;
mod runs;
pub mod second;
mod words;

/// Checks every word of the supervisor's limits, by the sensor that shows the body.
///
/// # Errors
/// A sentence that names the word.
pub fn check_words(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
) -> Result<(), String> {
    match &certificate.hardware.body {
        CertifiedBody::Inertial(inertial) => words::check(certificate, module, law, inertial),
        CertifiedBody::Encoder(encoder) => body::check(certificate, module, law, encoder),
    }
}

/// Runs `cases` samples, by the sensor that shows the body. Returns how many it ran.
///
/// # Errors
/// The first sample for which source and second statement differ, or after which a current flows where none may.
pub fn in_runs(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    if module.function("Attitude::new").is_some() {
        runs::run(module, cases, seed)
    } else {
        body_runs::run(module, cases, seed)
    }
}
