//! Claim `step-total` by the ranges of its words.

use std::collections::HashMap;

use crate::certificate::reader::Certificate;
use crate::claims::filter_total::{Invariant, analysed};
use crate::claims::outcome::ClaimOutcome;
use crate::domains::intervals::IntegerInterval;
use crate::language::module::Module;
use crate::program::contract::Contract;
use crate::program::steps::Program;

/// What comes of the claim, with the duties of the stated drive.
pub fn by_intervals(
    module: &Module,
    certificate: &Certificate,
    contracts: &HashMap<usize, Contract>,
) -> ClaimOutcome {
    let drive = &certificate.drive;
    let span = drive.duty_max.saturating_sub(drive.duty_zero);
    let low = drive.duty_zero.saturating_sub(span);
    let checked = check(module, contracts, low, drive.duty_zero, drive.duty_max);
    ClaimOutcome::proved(checked.map(|()| format!("duty within {low} to {}", drive.duty_max)))
}

/// Raw counts of any value give a duty within `low` and `high`, and exactly `zero` when
/// not armed; the state keeps its invariant.
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
    let armed = program
        .inputs
        .iter()
        .position(|name| name == "self.is_armed")
        .ok_or("the controller has no flag is_armed")?;
    let is_armed_at_start = start[start.len() - own_words(program) + armed];
    if is_armed_at_start != IntegerInterval::point(0) {
        return Err("a new controller is armed".to_owned());
    }
    let cases = [
        (0, IntegerInterval::point(zero.into())),
        (1, IntegerInterval::new(low.into(), high.into())),
    ];
    for (flag, wanted) in cases {
        let fixed = [(armed, IntegerInterval::point(flag))];
        let results = analysed(module, contracts, name, &invariant, &fixed)?;
        if !results[0].is_within(wanted) {
            return Err(format!(
                "with is_armed = {flag} the duty may lie in [{}, {}], not within [{}, {}]",
                results[0].low, results[0].high, wanted.low, wanted.high
            ));
        }
        invariant.is_kept(program, &results)?;
    }
    Ok(())
}

fn own_words(program: &Program) -> usize {
    let is_own = |name: &&String| name.starts_with("self.");
    program.inputs.iter().filter(is_own).count()
}
