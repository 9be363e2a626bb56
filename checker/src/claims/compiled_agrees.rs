//! Claim `compiled-agrees`: the crate compiled by rustc computes what the reader's interpretation computes.

use crate::claims::outcome::ClaimOutcome;
use crate::compiled::harness::harness;
use crate::compiled::points::points;
use crate::compiled::run::{RunFailure, compare};
use crate::language::emitted::Emitted;
use crate::language::manifest;
use crate::language::module::Module;

/// Compiles the crate and runs it beside the reader: `cases` random points of each function.
pub fn by_running(emitted: &Emitted, module: &Module, cases: usize, seed: u64) -> ClaimOutcome {
    let version = match manifest::read(&emitted.cargo) {
        Ok(manifest) => manifest.fixed_version,
        Err(why) => return ClaimOutcome::NotRun(why),
    };
    let harness = harness(module);
    let points = points(module, &harness, cases, seed);
    let functions = &module.declarations().functions;
    let name_of = |call: usize| {
        let call = harness.calls.get(call);
        call.map_or(String::new(), |call| functions[call.function].name.clone())
    };
    match compare(emitted, &version, &harness, &points, name_of) {
        Ok(cases) => {
            let text = format!("{} functions and methods", harness.calls.len());
            ClaimOutcome::Tested(cases, text)
        }
        Err(RunFailure::NotRun(why)) => ClaimOutcome::NotRun(why),
        Err(RunFailure::Differs(why)) => ClaimOutcome::Failed(why),
    }
}
