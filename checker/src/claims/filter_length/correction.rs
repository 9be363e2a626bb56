//! Step 2 of the argument in [`super::check`]: the largest length of a correction.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::filter_length::algebra::{
    clamp_of, is_terms, number, sum_of_squares, unless, with_calls,
};
use crate::claims::filter_length::inverse_root::{SCALED_ONE, inverse_root};
use crate::domains::intervals::IntegerInterval;
use crate::domains::polynomials::Words;
use crate::exact::rational::{integer, power_of_two, root_above};
use crate::language::contracts::stated;
use crate::language::module::Module;
use crate::program::steps::Slot;

/// The same of `coarse_inverse_length`.
const COARSE_BITS: i32 = 7;

fn magnitudes_squared(ranges: &[(Slot, i128, i128)]) -> BigRational {
    ranges
        .iter()
        .map(|(_, low, high)| {
            let most = integer(low.abs().max(high.abs()));
            &most * &most
        })
        .sum()
}

/// 2: an upper bound of the length that a correction adds to the quaternion.
pub(crate) fn correction(module: &Module, beta: &BigRational) -> Result<BigRational, String> {
    const NAME: &str = "madgwick::scaled_correction";
    let not_understood = "`scaled_correction` is not a direction and β over its length";
    let whole = IntegerInterval::new(0, (1 << 30) - 1);
    inverse_root(
        module,
        "root::coarse_inverse_length",
        whole,
        COARSE_BITS,
        false,
    )?;
    let through = [
        "scaling::scaled_up4",
        "product::clamp",
        "root::coarse_inverse_length",
    ];
    let program = with_calls(module, NAME, &through)?;
    let words = Words::of(&program);
    let beta_symbol = *program.arguments.last().ok_or(not_understood)?;
    // SquaredNorms of directions are those of the contract of `scaled_up4`.
    let scaled_up = number(module, "scaling::scaled_up4")?;
    let contract = stated(module, scaled_up).ok_or(not_understood)?;
    let stated: Vec<_> = contract
        .ensures
        .iter()
        .map(|range| (range.word, range.low, range.high))
        .collect();
    unless(stated.len() == 4, not_understood)?;
    let longest_squared = magnitudes_squared(&stated);

    let mut bound = BigRational::zero();
    for tuple in words.alternatives(&program.results) {
        let gain = words.form(tuple[4]);
        if gain.number().is_some_and(|gain| gain.is_zero()) {
            continue;
        }
        // The direction.
        let direction = words
            .call(tuple[0])
            .filter(|call| call.function == "scaled_up4" && call.results == tuple[..4])
            .ok_or(not_understood)?;
        // The gain: inverse times β over 2³².
        let inverse = words
            .calls
            .iter()
            .find(|call| call.function == "coarse_inverse_length")
            .ok_or(not_understood)?;
        let product: &[Slot] = &[inverse.results[0], beta_symbol];
        unless(
            is_terms(gain, &[(product, power_of_two(-32))]),
            not_understood,
        )?;
        // n: four times the clamped sum of squares.
        let n = words.form(inverse.arguments[0]);
        let (symbols, factor) = n.terms.first_key_value().ok_or(not_understood)?;
        unless(
            n.is_exact() && n.terms.len() == 1 && symbols.len() == 1,
            not_understood,
        )?;
        let (_, squares, low, high) = clamp_of(&words, symbols[0]).ok_or(not_understood)?;
        let (coefficient, constant) =
            sum_of_squares(&squares, &direction.results).ok_or(not_understood)?;
        let largest_n = factor * &high;
        unless(
            low.is_zero()
                && constant.is_zero()
                && factor * &coefficient == power_of_two(-32)
                && largest_n >= integer(SCALED_ONE)
                && largest_n <= integer(whole.high),
            not_understood,
        )?;
        // ‖d‖² r² where the clamp does nothing: n + rounding for n; where it does: the longest
        // direction for n.
        let share = BigRational::one() + power_of_two(-COARSE_BITS);
        let rounding = factor * squares.remainder() / integer(SCALED_ONE);
        let plain = power_of_two(32 + 86) * &share * (BigRational::one() + rounding);
        let clamped = &longest_squared * power_of_two(86) * &share / &largest_n;
        let product = root_above(&plain.max(clamped)).ok_or(not_understood)?;
        let longest = root_above(&longest_squared).ok_or(not_understood)?;
        // In Q62 of the quaternion.
        let length = product * beta * power_of_two(-32) + longest * gain.remainder();
        bound = bound.max(length * power_of_two(-62));
    }
    Ok(bound)
}
