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

/// The outcome for a module without a monitor, if this is one; source and certificate must agree about that.
pub fn absent(module: &Module, certificate: &Certificate) -> Option<ClaimOutcome> {
    let is_there = module.function("Monitor::allows").is_some();
    match (is_there, &certificate.monitor) {
        (true, Some(_)) => None,
        (false, None) => Some(ClaimOutcome::NotApplicable(
            "the module has no monitor; one is emitted where a monitor is asked for".to_owned(),
        )),
        (true, None) => Some(ClaimOutcome::Failed(
            "the source has a monitor, of which the certificate states nothing".to_owned(),
        )),
        (false, Some(_)) => Some(ClaimOutcome::Failed(
            "the certificate states a monitor, which the source does not have".to_owned(),
        )),
    }
}

/// No operation overflows, whatever the words of the monitor and of its arguments are.
pub fn total_by_intervals(module: &Module) -> ClaimOutcome {
    let check = || -> Result<String, String> {
        for name in FUNCTIONS {
            let program = module
                .function(name)
                .ok_or_else(|| format!("there is no {name}"))?;
            ranges(program, &every_bit_pattern(program)).map_err(|finding| finding.to_string())?;
        }
        Ok("no operation leaves its type".to_owned())
    };
    ClaimOutcome::proved(check())
}

/// The words are those that follow from the certificate, rounded outward.
pub fn silent_by_words(
    module: &Module,
    certificate: &Certificate,
    law: &EmittedLaw,
) -> ClaimOutcome {
    let checked = words::check(certificate, module, law);
    ClaimOutcome::proved(checked.map(|limits| {
        format!(
            "the sums may reach {:.2} rad/s for the wheel's own speed and {:.2} rad/s for the body",
            limits[0], limits[1]
        )
    }))
}
