//! Step 3 of the argument in [`super::check`]: the sum of quaternion, rotation and correction.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::filter_length::algebra::{FRACTION_BITS, unless, with_calls};
use crate::claims::filter_total::AttitudeLimits;
use crate::domains::polynomials::{Polynomial, Words};
use crate::exact::rational::{integer, power_of_two, root_above, root_below};
use crate::language::module::Module;
use crate::program::steps::Slot;

/// 3: squared length of the sum that `turned` hands to `normalised`, for a squared length within
/// `before` and a correction of length `correction`.
pub(crate) fn turned(
    module: &Module,
    before: &(BigRational, BigRational),
    correction: &BigRational,
) -> Result<(BigRational, BigRational), String> {
    let not_understood = "`turned` does not add q ⊗ h and the correction to q";
    let program = with_calls(module, "madgwick::turned", &["madgwick::normalised"])?;
    unless(
        program.arguments.len() == 12 && program.results.len() == 4,
        not_understood,
    )?;
    let words = Words::of(&program);
    let (q, h) = (&program.arguments[..4], &program.arguments[4..7]);
    let (direction, gain) = (&program.arguments[7..11], program.arguments[11]);
    let call = words
        .call(program.results[0])
        .filter(|call| call.function == "normalised" && call.results == program.results)
        .ok_or(not_understood)?;
    let mut squares = Polynomial::zero();
    let mut rounding = BigRational::zero();
    for (slot, along) in call.arguments.iter().zip(direction) {
        let form = words.form(*slot);
        let mut rest = form.terms_only();
        let product: Vec<Slot> = vec![*along.min(&gain), *along.max(&gain)];
        let share = rest.terms.remove(&product).ok_or(not_understood)?;
        unless(share.abs() == power_of_two(-32), not_understood)?;
        rounding += form.remainder() * form.remainder();
        squares = squares.plus(&rest.times(&rest));
    }
    // ‖q‖² (1 + ‖h‖²), as polynomials; no correction is left in it.
    let mut wanted = Polynomial::zero();
    for q in q {
        wanted = wanted.with(vec![*q; 2], BigRational::one());
        for h in h {
            wanted = wanted.with(vec![*q, *q, *h, *h], power_of_two(-64));
        }
    }
    unless(squares.terms == wanted.terms, not_understood)?;

    let half_angle = integer(AttitudeLimits::read(module)?.rate) * power_of_two(-32);
    let growth = BigRational::one() + integer(3) * &half_angle * &half_angle;
    let rounding = root_above(&rounding).ok_or(not_understood)? * power_of_two(-FRACTION_BITS);
    let added = correction + rounding;
    let least = root_below(&before.0).ok_or(not_understood)? - &added;
    let most = root_above(&(&before.1 * growth)).ok_or(not_understood)? + &added;
    unless(
        least.is_positive(),
        "the correction is as long as the quaternion",
    )?;
    Ok((&least * &least, &most * &most))
}
