//! Claims `monitor-total` and `monitor-silent`, for a module with a monitor.

pub mod runs;
pub mod words;

use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::domains::intervals::{every_bit_pattern, ranges};
use crate::language::module::Module;

/// The functions that a firmware calls.
const FUNCTIONS: [&str; 3] = ["Monitor::new", "Monitor::default", "Monitor::allows"];

/// The outcome for a module without a monitor; `None` if the module has one. It is a failure if only one of source and
/// certificate has a monitor.
pub fn absent(module: &Module, certificate: &Certificate) -> Option<ClaimOutcome> {
    let is_there = module.function("Monitor::allows").is_some();
    match (is_there, &certificate.monitor) {
        (true, Some(_)) => None,
        (false, None) => Some(ClaimOutcome::NotApplicable(
            "the module was generated without a monitor".to_owned(),
        )),
        (true, None) => Some(ClaimOutcome::Failed(
            "the source has a monitor, but the certificate has no section monitor".to_owned(),
        )),
        (false, Some(_)) => Some(ClaimOutcome::Failed(
            "the certificate has a section monitor, but the source has no Monitor::allows"
                .to_owned(),
        )),
    }
}

/// Decides by intervals that no operation overflows, for any words of the monitor and of its arguments.
pub fn total_by_intervals(module: &Module) -> ClaimOutcome {
    let check = || -> Result<String, String> {
        for name in FUNCTIONS {
            let program = module
                .function(name)
                .ok_or_else(|| format!("the source has no {name}"))?;
            ranges(program, &every_bit_pattern(program)).map_err(|finding| finding.to_string())?;
        }
        Ok("no operation overflows its type".to_owned())
    };
    ClaimOutcome::proved(check())
}

/// Decides that the words of the monitor are those that follow from the certificate, rounded outward.
pub fn silent_by_words(
    module: &Module,
    certificate: &Certificate,
    law: &EmittedLaw,
) -> ClaimOutcome {
    let checked = words::check(certificate, module, law);
    ClaimOutcome::proved(checked.map(|limits| {
        format!(
            "the sums may reach {:.2} rad/s for the wheel's own speed and {:.2} rad/s for the body's rate, plus their \
             widths",
            limits[0], limits[1]
        )
    }))
}
