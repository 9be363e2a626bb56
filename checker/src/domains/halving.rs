//! Contracts by interval analysis. Where it is too coarse, the domain is halved repeatedly, down to
//! single words if necessary; then the analysis is exact.

use crate::domains::intervals::{Finding, IntegerInterval, every_bit_pattern, ranges};
use crate::program::contract::Contract;
use crate::program::steps::Program;

/// Proves a contract of `program`, halving the domain where the analysis is too coarse. Returns the number of
/// analysed boxes.
///
/// # Errors
/// [`Finding`]: for a single point, at which the contract really fails, or for the first box if
/// `limit` boxes were not sufficient.
pub fn prove(program: &Program, contract: &Contract, limit: usize) -> Result<usize, Finding> {
    let mut domain = every_bit_pattern(program);
    for range in &contract.requires {
        if let Some(interval) = domain.get_mut(range.word) {
            *interval = IntegerInterval::new(range.low, range.high);
        }
    }
    let mut pending = vec![domain];
    let mut boxes = 0;
    while let Some(domain) = pending.pop() {
        boxes += 1;
        let Err(finding) = meets(program, &domain, contract) else {
            continue;
        };
        let widest = (0..domain.len())
            .max_by_key(|word| domain[*word].high - domain[*word].low)
            .filter(|word| domain[*word].high > domain[*word].low);
        let Some(word) = widest.filter(|_| boxes < limit) else {
            let place = finding.place;
            let text: Vec<_> = program
                .inputs
                .iter()
                .zip(&domain)
                .map(|(name, interval)| format!("{name} in [{}, {}]", interval.low, interval.high))
                .collect();
            return Err(Finding {
                place,
                message: format!("{}, for {}", finding.message, text.join(", ")),
            });
        };
        let IntegerInterval { low, high } = domain[word];
        let middle = low + (high - low) / 2;
        let mut lower = domain.clone();
        lower[word].high = middle;
        let mut upper = domain;
        upper[word].low = middle + 1;
        pending.push(lower);
        pending.push(upper);
    }
    Ok(boxes)
}

fn meets(
    program: &Program,
    domain: &[IntegerInterval],
    contract: &Contract,
) -> Result<(), Finding> {
    let results = ranges(program, domain)?;
    for range in &contract.ensures {
        let found = results.get(range.word).copied();
        let wanted = IntegerInterval::new(range.low, range.high);
        if !found.is_some_and(|found| found.is_within(wanted)) {
            let found = found.map_or("missing".to_owned(), |found| {
                format!("in [{}, {}]", found.low, found.high)
            });
            return Err(Finding {
                place: program.places[0].clone(),
                message: format!(
                    "word {} of the result of `{}` is {found}, not within [{}, {}]",
                    range.word, program.name, range.low, range.high
                ),
            });
        }
    }
    Ok(())
}
