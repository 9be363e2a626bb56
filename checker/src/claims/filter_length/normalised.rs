//! Step 4 of the argument in [`super::check`]: the normalised sum.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::claims::filter_length::algebra::{
    FRACTION_BITS, clamp_of, sum_of_squares, unless, with_calls,
};
use crate::domains::polynomials::{Polynomial, Words};
use crate::exact::rational::{integer, power_of_two, root_above, root_below};
use crate::language::module::Module;
use crate::program::steps::Slot;

/// 4: squared length after `normalised`, for one within `before`.
pub(crate) fn normalised(
    module: &Module,
    before: &(BigRational, BigRational),
) -> Result<(BigRational, BigRational), String> {
    let not_understood = "`normalised` is not a multiple of its argument by a polynomial of ε";
    let program = with_calls(module, "madgwick::normalised", &["product::clamp"])?;
    unless(
        program.arguments.len() == 4 && program.results.len() == 4,
        not_understood,
    )?;
    let words = Words::of(&program);
    // Each result is q times the same S, clamped to the largest component.
    let mut multiple: Option<Polynomial> = None;
    let mut rounding = BigRational::zero();
    let mut largest: Option<BigRational> = None;
    for (q, result) in program.arguments.iter().zip(&program.results) {
        let (_, value, low, high) = clamp_of(&words, *result).ok_or(not_understood)?;
        let mut quotient = Polynomial::zero();
        for (monomial, coefficient) in &value.terms {
            let rest: Vec<Slot> = monomial.iter().copied().filter(|slot| slot != q).collect();
            unless(rest.len() + 1 == monomial.len(), not_understood)?;
            quotient = quotient.with(rest, coefficient.clone());
        }
        unless(
            low == -&high && multiple.as_ref().is_none_or(|known| *known == quotient),
            not_understood,
        )?;
        multiple = Some(quotient);
        rounding += value.remainder() * value.remainder();
        largest = Some(largest.map_or(high.clone(), |known| known.min(high)));
    }
    let (multiple, largest) = multiple.zip(largest).ok_or(not_understood)?;
    // S in terms of the one symbol e, the clamped excess.
    let change = multiple
        .terms
        .keys()
        .flatten()
        .next()
        .copied()
        .ok_or(not_understood)?;
    let definition = words.form(change);
    let multiple = multiple
        .substituted(change, definition)
        .ok_or(not_understood)?;
    let excess = definition
        .terms
        .keys()
        .flatten()
        .next()
        .copied()
        .ok_or(not_understood)?;
    let (_, value, low, high) = clamp_of(&words, excess).ok_or(not_understood)?;
    let (coefficient, constant) =
        sum_of_squares(&value, &program.arguments).ok_or(not_understood)?;
    let unit = &coefficient * power_of_two(2 * FRACTION_BITS);
    let least = &unit * &before.0 + &constant + &value.low;
    let most = &unit * &before.1 + &constant + &value.high;
    unless(
        low <= least && most <= high,
        "the quaternion may be too long or too short to be normalised: β times the sample time is too large",
    )?;
    // ‖q‖² = (e − k − rounding)/unit. With that, ‖q‖² S² as a polynomial in e.
    let squared = Polynomial::symbol(excess)
        .plus(&Polynomial::constant(-constant))
        .scaled(&unit.recip());
    let range = |form: &Polynomial| form.range(excess, &least, &most).ok_or(not_understood);
    let plain = multiple.terms_only();
    let product = range(&squared.times(&plain).times(&plain))?;
    let size = |(low, high): (BigRational, BigRational)| low.abs().max(high.abs());
    let (s, s_rest) = (size(range(&plain)?), multiple.remainder());
    let (n, n_rest) = (size(range(&squared)?), value.remainder() / &unit);
    let whole = &s + &s_rest;
    let rest = n_rest * &whole * &whole + n * &s_rest * (integer(2) * s + &s_rest);
    let rounding = root_above(&rounding).ok_or(not_understood)? * power_of_two(-FRACTION_BITS);
    let shortest = root_below(&(product.0 - &rest)).ok_or(not_understood)? - &rounding;
    let longest = root_above(&(product.1 + &rest)).ok_or(not_understood)? + &rounding;
    unless(shortest.is_positive(), not_understood)?;
    unless(
        &longest * power_of_two(FRACTION_BITS) <= largest,
        "the largest component of the quaternion is less than its length",
    )?;
    Ok((&shortest * &shortest, &longest * &longest))
}
