//! Step 5 of the argument in [`super::check`]: an alignment gives a unit quaternion.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::filter_length::algebra::{
    FRACTION_BITS, clamp_of, is_terms, sum_of_squares, unless, with_calls,
};
use crate::claims::filter_length::inverse_root::inverse_root;
use crate::claims::filter_length::sources::UP_MAX;
use crate::domains::intervals::{IntegerInterval, every_bit_pattern, ranges};
use crate::domains::polynomials::{PolynomialCall, Words};
use crate::exact::rational::{integer, power_of_two, root_above, root_below};
use crate::language::module::Module;
use crate::program::steps::{Program, Slot};

/// `inverse_length` is examined in steps of this share of the square, 2⁻¹³. Its error is far smaller.
const FINE_BITS: i32 = 13;

/// log₂ of the least value of the largest component for which the result of `scaled_up3` has at least the required
/// length.
const SCALABLE_BITS: u32 = 14;

/// Proof that `scaled_up3` takes each vector within ±2³⁰ with a component of at least 2¹⁴ to a
/// vector with a component of at least 2²⁹, octave by octave of the largest component.
fn scaled_up_is_long(module: &Module) -> Result<(), String> {
    let program = module
        .function("scaling::scaled_up3")
        .ok_or("there is no scaling::scaled_up3")?;
    for octave in SCALABLE_BITS..=30 {
        let low = 1_i128 << octave;
        let high = if octave == 30 { low } else { 2 * low - 1 };
        for axis in 0..3 {
            for part in [
                IntegerInterval::new(low, high),
                IntegerInterval::new(-high, -low),
            ] {
                let mut domain = vec![IntegerInterval::new(-high, high); 3];
                domain[axis] = part;
                let results = ranges(program, &domain).map_err(|finding| finding.to_string())?;
                unless(
                    results[axis].low >= 1 << 29 || results[axis].high <= -(1 << 29),
                    "`scaled_up3` leaves a vector short",
                )?;
                unless(
                    results
                        .iter()
                        .all(|word| word.is_within(IntegerInterval::new(-(1 << 30), 1 << 30))),
                    "`scaled_up3` makes a vector too long",
                )?;
            }
        }
    }
    Ok(())
}

/// Squared length of `unit_q28` for a vector within ±2³⁰ with a component of at least 2¹⁴.
fn unit_vector(module: &Module) -> Result<(BigRational, BigRational), String> {
    let not_understood = "`unit_q28` is not a vector times its inverse length";
    scaled_up_is_long(module)?;
    let through = ["scaling::scaled_up3", "root::inverse_length"];
    let program = with_calls(module, "madgwick::unit_q28", &through)?;
    let words = Words::of(&program);
    let [scaled, inverse] = words.calls.as_slice() else {
        return Err(not_understood.to_owned());
    };
    unless(
        scaled.function == "scaled_up3"
            && inverse.function == "inverse_length"
            && scaled.arguments == program.arguments
            && scaled.results.len() == 3
            && program.results.len() == 3,
        not_understood,
    )?;
    let mut rounding = BigRational::zero();
    for (result, along) in program.results.iter().zip(&scaled.results) {
        let form = words.form(*result);
        let product: &[Slot] = &[*along, inverse.results[0]];
        unless(
            is_terms(form, &[(product, power_of_two(-31))]),
            not_understood,
        )?;
        rounding += form.remainder() * form.remainder();
    }
    let n = words.form(inverse.arguments[0]);
    let (coefficient, constant) = sum_of_squares(n, &scaled.results).ok_or(not_understood)?;
    unless(
        coefficient == power_of_two(-32) && constant.is_zero(),
        not_understood,
    )?;
    // The largest component is 2²⁹ to 2³⁰.
    let rest = n.remainder().ceil().to_integer();
    let least = BigRational::from(power_of_two(26).to_integer() - rest.clone());
    let domain = IntegerInterval::new(
        i128::try_from(least.to_integer()).map_err(|error| error.to_string())?,
        (3 << 28) + i128::try_from(rest).map_err(|error| error.to_string())?,
    );
    // Below 2²⁶ the bound uses 2²⁶ for n. The difference is the rounding alone.
    inverse_root(module, "root::inverse_length", domain, FINE_BITS, true)?;
    let share = power_of_two(-FINE_BITS);
    let relative = integer(2) * n.remainder() / least;
    let rounding = root_above(&rounding).ok_or(not_understood)? * power_of_two(-28);
    let one = BigRational::one();
    let shortest = root_below(&((&one - &share) * (&one - &relative))).ok_or(not_understood)?;
    let longest = root_above(&((&one + &share) * (&one + &relative))).ok_or(not_understood)?;
    Ok((shortest - &rounding, longest + &rounding))
}

/// 5: squared length after an alignment.
pub(crate) fn aligned(module: &Module) -> Result<(BigRational, BigRational), String> {
    let not_understood = "`aligned` is not four times a unit vector";
    let unit = unit_vector(module)?;
    let through = ["madgwick::unit_q28", "product::clamp"];
    let program = with_calls(module, "madgwick::aligned", &through)?;
    let words = Words::of(&program);
    let call = words
        .calls
        .iter()
        .find(|call| call.function == "unit_q28")
        .ok_or(not_understood)?;
    let one = BigRational::one();
    for tuple in words.alternatives(&program.results) {
        let numbers: Option<Vec<BigRational>> = tuple
            .iter()
            .map(|slot| words.form(*slot).number())
            .collect();
        if let Some(numbers) = numbers {
            let squared: BigRational = numbers.iter().map(|word| word * word).sum();
            unless(
                squared == power_of_two(2 * FRACTION_BITS),
                "`aligned` may give a constant that is not of length 1",
            )?;
            continue;
        }
        let last = words.form(tuple[3]).number();
        unless(last.is_some_and(|last| last.is_zero()), not_understood)?;
        for (slot, along) in tuple.iter().zip(&call.results) {
            let form = words.form(*slot);
            let symbol = form.terms.keys().flatten().next().ok_or(not_understood)?;
            let (clamp, value, low, high) = clamp_of(&words, *symbol).ok_or(not_understood)?;
            let outer: &[Slot] = &clamp.results;
            let inner: &[Slot] = &[*along];
            unless(
                form.is_exact()
                    && value.is_exact()
                    && is_terms(form, &[(outer, integer(2))])
                    && is_terms(&value, &[(inner, integer(2))])
                    && high == power_of_two(29)
                    && low == -high,
                not_understood,
            )?;
        }
    }
    short_turns_do_not_reach_it(module, &program, &words, call)?;
    // A component above 1 is clamped to 1 and loses the excess.
    let (least, most) = (&unit.0 * &unit.0, &unit.1 * &unit.1);
    let beyond = (&most - &one).max(BigRational::zero());
    Ok((least - beyond, most))
}

/// Proof that `unit_q28` is called only with vectors within ±2³⁰ that have a component of at least
/// 2¹⁴.
fn short_turns_do_not_reach_it(
    module: &Module,
    program: &Program,
    words: &Words,
    call: &PolynomialCall,
) -> Result<(), String> {
    let not_understood = "`aligned` turns by something else than the upward direction";
    let short = integer((1 << SCALABLE_BITS) - 1);
    let mut domain = every_bit_pattern(program);
    let mut seen = Vec::new();
    for slot in &call.arguments {
        // ± a word + k.
        let form = words.form(*slot);
        let constant = form.terms.get(&Vec::new()).cloned().unwrap_or_default();
        let (symbols, sign) = form.terms.last_key_value().ok_or(not_understood)?;
        let [symbol] = symbols.as_slice() else {
            return Err(not_understood.to_owned());
        };
        let word = program.arguments.iter().position(|slot| slot == symbol);
        let word = word
            .filter(|word| !seen.contains(word))
            .ok_or(not_understood)?;
        seen.push(word);
        let terms: &[(&[Slot], BigRational)] =
            &[(&[*symbol], sign.clone()), (&[], constant.clone())];
        unless(
            form.is_exact() && sign.abs().is_one() && is_terms(form, terms),
            not_understood,
        )?;
        let largest = integer(UP_MAX) + constant.abs();
        unless(
            largest <= power_of_two(30),
            "`aligned` turns by a vector that is too long",
        )?;
        let middle = -constant * sign;
        let bound = |value: BigRational| i128::try_from(value.to_integer());
        let (low, high) = (bound(&middle - &short), bound(&middle + &short));
        let (Ok(low), Ok(high)) = (low, high) else {
            return Err(not_understood.to_owned());
        };
        domain[word] = IntegerInterval::new(low, high);
    }
    unless(seen.len() == program.arguments.len(), not_understood)?;
    // All short vectors give the same constant, so the branch with the call is not reached.
    let whole = module
        .function("madgwick::aligned")
        .ok_or("there is no aligned")?;
    let results = ranges(whole, &domain).map_err(|finding| finding.to_string())?;
    unless(
        results.iter().all(|word| word.low == word.high),
        "`aligned` takes the unit vector of one that is too short",
    )
}
