//! Step 1 of the argument in [`super::check`]: inverse square roots, by halving the range of their argument.

use crate::claims::filter_length::algebra::unless;
use crate::domains::intervals::{IntegerInterval, ranges};
use crate::exact::rational::{integer, power_of_two};
use crate::language::module::Module;

/// How many boxes 1. may take.
const BOXES: usize = 4_000_000;

/// 1 in n, the squared length of a scaled vector.
pub(crate) const SCALED_ONE: i128 = 1 << 26;

/// Proof that n r² 2⁻⁸⁶ lies within 1 ± 2^-`bits`, where r is the result of `name` for n, for every n of `domain` (with
/// 2²⁶ in place of a smaller n). If not `is_two_sided`, only the upper bound is proved.
pub(crate) fn inverse_root(
    module: &Module,
    name: &str,
    domain: IntegerInterval,
    bits: i32,
    is_two_sided: bool,
) -> Result<(), String> {
    let program = module
        .function(name)
        .ok_or_else(|| format!("there is no {name}"))?;
    unless(
        program.arguments.len() == 1 && program.results.len() == 1,
        "an inverse length takes and gives one word",
    )?;
    let share = power_of_two(86 - bits).to_integer();
    let one = power_of_two(86).to_integer();
    let mut pending = vec![domain];
    let mut boxes = 0;
    while let Some(n) = pending.pop() {
        boxes += 1;
        let found = ranges(program, &[n]).ok().map(|results| results[0]);
        let is_shown = found.is_some_and(|r| {
            let square = |n: i128, r: i128| integer(n.max(SCALED_ONE)) * integer(r) * integer(r);
            let most = square(n.high, r.high).to_integer();
            let least = square(n.low, r.low).to_integer();
            r.low >= 0 && most <= &one + &share && (!is_two_sided || least >= &one - &share)
        });
        if is_shown {
            continue;
        }
        if n.low == n.high || boxes >= BOXES {
            return Err(format!(
                "`{name}` at n = {} is not shown to be 1/√n to within 2^-{bits} of its square",
                n.low
            ));
        }
        let middle = n.low + (n.high - n.low) / 2;
        pending.push(IntegerInterval::new(n.low, middle));
        pending.push(IntegerInterval::new(middle + 1, n.high));
    }
    Ok(())
}
