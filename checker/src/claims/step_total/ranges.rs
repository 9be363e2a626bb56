//! Claim `step-total`, decided by the ranges of its words.

use std::collections::HashMap;

use crate::certificate::reader::Certificate;
use crate::claims::filter_total::{Invariant, analysed};
use crate::claims::outcome::ClaimOutcome;
use crate::claims::supervisor::second::RUNNING;
use crate::domains::intervals::IntegerInterval;
use crate::language::module::Module;
use crate::program::contract::Contract;
use crate::program::steps::Program;

/// The outcome of the claim, with the duties of the stated drive.
pub fn by_intervals(
    module: &Module,
    certificate: &Certificate,
    contracts: &HashMap<usize, Contract>,
) -> ClaimOutcome {
    let drive = &certificate.drive;
    let (low, high) = (drive.duty_low, drive.duty_high);
    let checked = check(module, contracts, low, drive.duty_zero, high);
    ClaimOutcome::proved(checked.map(|()| format!("duty within {low} to {high}")))
}

/// Raw counts of any value give a duty within `low` and `high`, and exactly `zero` unless the
/// controller runs; the state keeps its invariant, also through `arm`, `disarm` and `fault`.
///
/// # Errors
/// A sentence with the place in the source.
pub fn check(
    module: &Module,
    contracts: &HashMap<usize, Contract>,
    low: u16,
    zero: u16,
    high: u16,
) -> Result<(), String> {
    let invariant = Invariant::read(module)?;
    let name = "Controller::step";
    let program = module
        .function(name)
        .ok_or("there is no Controller::step")?;
    let start = analysed(module, contracts, "Controller::new", &invariant, &[])?;
    invariant.is_kept(program, &start)?;
    let status = program
        .inputs
        .iter()
        .position(|name| name == "self.status")
        .ok_or("the controller has no status")?;
    let status_at_start = start[start.len() - own_words(program) + status];
    if status_at_start != IntegerInterval::point(0) {
        return Err("a new controller is not `NotAligned`".to_owned());
    }
    let no_current = IntegerInterval::point(zero.into());
    let in_range = IntegerInterval::new(low.into(), high.into());
    let (_, last) = program.argument_types[status].range();
    let others = IntegerInterval::new(RUNNING + 1, last);
    let cases = [
        (IntegerInterval::new(0, RUNNING - 1), no_current),
        (IntegerInterval::point(RUNNING), in_range),
        (others, no_current),
    ];
    for (value, wanted) in cases {
        for name in [name, "Controller::step_with_current"] {
            let fixed = [(status, value)];
            let results = analysed(module, contracts, name, &invariant, &fixed)?;
            if !results[0].is_within(wanted) {
                return Err(format!(
                    "with a status of {} to {} the duty of `{name}` may lie in [{}, {}], not within \
                     [{}, {}]",
                    value.low, value.high, results[0].low, results[0].high, wanted.low, wanted.high
                ));
            }
            invariant.is_kept(program, &results)?;
        }
    }
    for name in ["Controller::arm", "Controller::disarm", "Controller::fault"] {
        let program = module
            .function(name)
            .ok_or_else(|| format!("there is no {name}"))?;
        let results = analysed(module, contracts, name, &invariant, &[])?;
        invariant.is_kept(program, &results)?;
    }
    Ok(())
}

fn own_words(program: &Program) -> usize {
    let is_own = |name: &&String| name.starts_with("self.");
    program.inputs.iter().filter(is_own).count()
}
