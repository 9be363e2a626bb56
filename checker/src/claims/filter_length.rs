//! The length of the attitude's quaternion: no step leaves it outside 1 ± 2⁻¹¹ (squared).
//!
//! No ranges of components can say this, so it is shown by algebra on the source itself, with
//! words as polynomials ([`crate::domains::polynomials`]) and rational arithmetic:
//!
//! 1. `inverse_length`, `coarse_inverse_length`: n r² is 1 to within a stated share, by halving
//!    the range of n.
//! 2. `scaled_correction`: direction times gain is then no longer than a bound, C.
//! 3. `turned`: without the correction the squares of the sum are, as polynomials, those of
//!    q times 1 + ‖h‖², h the half-angles. So the sum's length is known to within C and rounding.
//! 4. `normalised`: its result is q S(ε), ε the excess of ‖q‖² over 1, and (1 + ε) S(ε)² is 1 to
//!    within 5ε³/8 or so, the coefficients being those of the source.
//! 5. `aligned`: four times a unit vector from `unit_q28`, which is one by 1.
//! 6. Whatever changes the attitude's quaternion takes it from `turned` or `aligned`, or leaves it
//!    as it was, and a new one is 1.
//!
//! That no word overflows, and the ranges of half-angles and directions, are for
//! [`crate::claims::filter_total`]; this claim holds together with `filter-total`.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::filter_total::{Invariant, analysed};
use crate::domains::intervals::{Interval, every_bit_pattern, ranges};
use crate::domains::machine::Machine;
use crate::domains::polynomials::{Call, Polynomial, Words};
use crate::exact::rational::{integer, power_of_two, root_above, root_below};
use crate::language::module::Module;
use crate::program::contract::{Contract, Range};
use crate::program::steps::{Action, Program, Slot, Step};

/// Largest distance of the squared length from 1, as a power of two: 2⁻¹¹.
pub const TOLERANCE_BITS: i32 = 11;

/// Share to which `inverse_length` is looked at, 2⁻¹³ of the square; its error is far less.
const FINE_BITS: i32 = 13;

/// The same of `coarse_inverse_length`.
const COARSE_BITS: i32 = 7;

/// How many boxes 1. may take.
const BOXES: usize = 4_000_000;

/// Fraction bits of the quaternion's words.
const FRACTION_BITS: i32 = 30;

/// 1 in n, the squared length of a scaled vector.
const SCALED_ONE: i128 = 1 << 26;

/// From this component on `scaled_up3` has room enough to reach its least length.
const SCALABLE_BITS: u32 = 14;

/// What was found of the squared length.
#[derive(Clone, Debug, PartialEq)]
pub struct Lengths {
    /// Least and largest after a step with the correction, before it is normalised.
    pub before: (BigRational, BigRational),
    /// Least and largest after a step.
    pub after_step: (BigRational, BigRational),
    /// Least and largest after an alignment.
    pub after_alignment: (BigRational, BigRational),
}

/// Claim `filter-length`. `contracts` are those that [`crate::claims::filter_total::proved`] allows.
///
/// # Errors
/// A sentence on what could not be shown.
pub fn check(module: &Module, contracts: &HashMap<usize, Contract>) -> Result<Lengths, String> {
    clamp_is_one(module)?;
    let tolerance = power_of_two(-TOLERANCE_BITS);
    let around_one = (
        BigRational::one() - &tolerance,
        BigRational::one() + &tolerance,
    );
    let sources = Sources::read(module, contracts, &around_one)?;
    let correction = correction(module, &sources.beta)?;
    let before = turned(module, &around_one, &correction)?;
    let after_step = normalised(module, &before)?;
    let after_alignment = aligned(module)?;
    for (what, found) in [("a step", &after_step), ("an alignment", &after_alignment)] {
        if found.0 < around_one.0 || found.1 > around_one.1 {
            return Err(format!(
                "the squared length after {what} is not shown to be within 1 ± 2^-{TOLERANCE_BITS}"
            ));
        }
    }
    Ok(Lengths {
        before,
        after_step,
        after_alignment,
    })
}

/// The function `name`, with the calls of `through` kept as calls.
fn with_calls(module: &Module, name: &str, through: &[&str]) -> Result<Program, String> {
    let mut contracts = HashMap::new();
    for callee in through {
        let (number, contract) = every_word(module, callee)?;
        contracts.insert(number, contract);
    }
    let number = number(module, name)?;
    let program = module.function_with_contracts(number, &contracts);
    program.map_err(|error| error.to_string())
}

/// A contract that names every word of the arguments and promises nothing.
fn every_word(module: &Module, name: &str) -> Result<(usize, Contract), String> {
    let number = number(module, name)?;
    let program = module
        .program(number)
        .ok_or_else(|| format!("there is no {name}"))?;
    let requires = program
        .argument_types
        .iter()
        .enumerate()
        .map(|(word, type_)| {
            let (low, high) = type_.range();
            Range { word, low, high }
        })
        .collect();
    let contract = Contract {
        requires,
        ..Contract::default()
    };
    Ok((number, contract))
}

fn number(module: &Module, name: &str) -> Result<usize, String> {
    let number = module.function_number(name);
    number.ok_or_else(|| format!("there is no function {name}, or several"))
}

fn unless(condition: bool, message: &str) -> Result<(), String> {
    if condition {
        Ok(())
    } else {
        Err(message.to_owned())
    }
}

/// `clamp` only compares and picks among its arguments, so it is settled by every order in which
/// three numbers can stand.
fn clamp_is_one(module: &Module) -> Result<(), String> {
    let program = module
        .function("product::clamp")
        .ok_or("there is no product::clamp")?;
    let mut picked = program.arguments.clone();
    unless(
        picked.len() == 3
            && program.results.len() == 1
            && only_compares(&program.steps, &program.arguments, &mut picked)
            && picked.contains(&program.results[0]),
        "`clamp` does more than compare its arguments",
    )?;
    let mut machine = Machine::new(program);
    for order in 0..27 {
        let (value, low, high) = (order % 3, order / 3 % 3, order / 9);
        if low > high {
            continue;
        }
        let result = machine
            .call(&[value, low, high])
            .map_err(|trap| trap.to_string())?;
        unless(
            result == [value.clamp(low, high)],
            "`clamp` does not give the nearest value",
        )?;
    }
    Ok(())
}

/// Whether all steps compare arguments or join words of `picked`, which grows.
fn only_compares(steps: &[Step], arguments: &[Slot], picked: &mut Vec<Slot>) -> bool {
    steps.iter().all(|step| match &step.action {
        Action::Compare { a, b, .. } => arguments.contains(a) && arguments.contains(b),
        Action::If {
            then,
            otherwise,
            joins,
            ..
        } => {
            only_compares(then, arguments, picked)
                && only_compares(otherwise, arguments, picked)
                && joins.iter().all(|join| {
                    let is_pick = picked.contains(&join.then) && picked.contains(&join.otherwise);
                    picked.push(join.to);
                    is_pick
                })
        }
        _ => false,
    })
}

/// That n r² 2⁻⁸⁶ lies within 1 ± 2^-`bits` for r the result of `name` at every n of `domain`,
/// with the larger of n and 2²⁶ in place of n; only from above if not `is_two_sided`.
fn inverse_root(
    module: &Module,
    name: &str,
    domain: Interval,
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
        pending.push(Interval::new(n.low, middle));
        pending.push(Interval::new(middle + 1, n.high));
    }
    Ok(())
}

/// Where quaternions and corrections come from.
struct Sources {
    /// The largest β T that is handed to `scaled_correction`, as a word in Q35.
    beta: BigRational,
}

impl Sources {
    /// Looks at everything that makes or changes a state with a quaternion.
    fn read(
        module: &Module,
        contracts: &HashMap<usize, Contract>,
        around_one: &(BigRational, BigRational),
    ) -> Result<Sources, String> {
        let invariant = Invariant::read(module)?;
        let mut sources = Sources {
            beta: BigRational::zero(),
        };
        let component = Interval::new(-invariant.component, invariant.component);
        let mut extended = contracts.clone();
        let half_angle = 4..7;
        for (name, narrow, to) in [
            ("madgwick::turned", half_angle, invariant.rate),
            // The unit vector of an alignment; what `aligned` is then shown for.
            ("madgwick::aligned", 0..3, UP_MAX),
            ("madgwick::scaled_correction", 0..0, 0),
        ] {
            let (number, mut contract) = every_word(module, name)?;
            for range in &mut contract.requires {
                if narrow.contains(&range.word) {
                    (range.low, range.high) = (-to, to);
                }
            }
            if name != "madgwick::scaled_correction" {
                contract.ensures = (0..4)
                    .map(|word| Range {
                        word,
                        low: component.low,
                        high: component.high,
                    })
                    .collect();
            }
            extended.insert(number, contract);
        }
        let declarations = module.declarations();
        let mut changes = 0;
        for (number, function) in declarations.functions.iter().enumerate() {
            let mut names = declarations.word_names("", &function.result);
            let receiver = function.arguments.first().filter(|it| it.is_mutable);
            if let Some(receiver) = receiver {
                names.extend(declarations.word_names("self", &receiver.type_));
            }
            let Some(first) = names.iter().position(|name| is_state_of_an_owner(name)) else {
                continue;
            };
            let program = module
                .function_with_contracts(number, &extended)
                .map_err(|error| error.to_string())?;
            unless(
                names.len() == program.results.len(),
                "the words of a state are not where they should be",
            )?;
            // Its calls get what their contracts require.
            analysed(module, &extended, &function.name, &invariant, &[])?;
            let words = Words::of(&program);
            let quaternion = &program.results[first..first + 4];
            for tuple in words.alternatives(quaternion) {
                sources.quaternion(&function.name, &program, &words, &tuple, around_one)?;
            }
            changes += usize::from(receiver.is_some());
        }
        unless(changes > 0, "nothing changes a quaternion")?;
        Ok(sources)
    }

    /// That one quaternion is turned, aligned, unchanged, or a constant of length 1.
    fn quaternion(
        &mut self,
        name: &str,
        program: &Program,
        words: &Words,
        tuple: &[Slot],
        around_one: &(BigRational, BigRational),
    ) -> Result<(), String> {
        let before = state_of(program);
        let symbols: Option<Vec<Slot>> = tuple.iter().map(|slot| words.symbol(*slot)).collect();
        let Some(symbols) = symbols else {
            let constants: Option<Vec<BigRational>> = tuple
                .iter()
                .map(|slot| words.form(*slot).number())
                .collect();
            let squared = constants.map(|words| {
                let sum: BigRational = words.iter().map(|word| word * word).sum();
                sum * power_of_two(-2 * FRACTION_BITS)
            });
            return unless(
                squared.is_some_and(|squared| around_one.0 <= squared && squared <= around_one.1),
                &format!("`{name}` makes a quaternion that is not known to be of length 1"),
            );
        };
        if before.as_ref() == Some(&symbols) {
            return Ok(());
        }
        let call = words
            .call(symbols[0])
            .filter(|call| call.results == symbols);
        match call {
            Some(call) if call.function == "aligned" => Ok(()),
            Some(call) if call.function == "turned" && call.arguments.len() == 12 => {
                // What is turned may have been aligned just before.
                for turned in words.alternatives(&call.arguments[..4]) {
                    self.quaternion(name, program, words, &turned, around_one)?;
                }
                for tuple in words.alternatives(&call.arguments[7..]) {
                    self.correction(name, words, &tuple)?;
                }
                Ok(())
            }
            _ => Err(format!(
                "`{name}` has a quaternion that comes neither from `turned` nor from `aligned`"
            )),
        }
    }

    /// That a correction is none, or from `scaled_correction` with a constant β T.
    fn correction(&mut self, name: &str, words: &Words, tuple: &[Slot]) -> Result<(), String> {
        let numbers: Option<Vec<BigRational>> = tuple
            .iter()
            .map(|slot| words.form(*slot).number())
            .collect();
        if numbers.is_some_and(|numbers| numbers.iter().all(Zero::is_zero)) {
            return Ok(());
        }
        let call = words.call(tuple[0]).filter(|call| call.results == tuple);
        let beta = call
            .filter(|call| call.function == "scaled_correction")
            .and_then(|call| words.form(*call.arguments.last()?).number())
            .filter(|beta| !beta.is_negative());
        let beta = beta.ok_or_else(|| {
            format!(
                "`{name}` corrects by something else than `scaled_correction` with a constant β"
            )
        })?;
        if beta > self.beta {
            self.beta = beta;
        }
        Ok(())
    }
}

/// Largest component of a unit vector in Q28 that `aligned` may be given: 5·2²⁷.
const UP_MAX: i128 = 5 << 27;

/// Whether this is the first word of the quaternion of a struct that holds a state.
fn is_state_of_an_owner(name: &str) -> bool {
    name.ends_with(".state.quaternion[0]")
}

/// The words of the quaternion that the receiver has before.
fn state_of(program: &Program) -> Option<Vec<Slot>> {
    let first = program
        .inputs
        .iter()
        .position(|name| name.starts_with("self.") && is_state_of_an_owner(name))?;
    Some(program.arguments[first..first + 4].to_vec())
}

/// The monomials of a form as (symbols, coefficient).
fn is_terms(form: &Polynomial, terms: &[(&[Slot], BigRational)]) -> bool {
    let wanted = terms
        .iter()
        .fold(Polynomial::zero(), |sum, (symbols, coefficient)| {
            sum.with(symbols.to_vec(), coefficient.clone())
        });
    form.terms == wanted.terms
}

/// The coefficient c of a form c Σ xᵢ² + k + e, and k.
fn sum_of_squares(form: &Polynomial, symbols: &[Slot]) -> Option<(BigRational, BigRational)> {
    let constant = form.terms.get(&Vec::new()).cloned().unwrap_or_default();
    let coefficient = form.terms.get(&vec![symbols[0]; 2])?.clone();
    let wanted = symbols
        .iter()
        .fold(Polynomial::constant(constant.clone()), |sum, symbol| {
            sum.with(vec![*symbol; 2], coefficient.clone())
        });
    let is_sum = form.terms == wanted.terms && coefficient.is_positive();
    is_sum.then_some((coefficient, constant))
}

/// Value and constant ends of a call of `clamp`.
fn clamp_of<'a>(
    words: &'a Words,
    slot: Slot,
) -> Option<(&'a Call, Polynomial, BigRational, BigRational)> {
    let call = words.call(slot).filter(|call| call.function == "clamp")?;
    let [value, low, high] = call.arguments.as_slice() else {
        return None;
    };
    let (low, high) = (words.form(*low).number()?, words.form(*high).number()?);
    Some((call, words.form(*value).clone(), low, high))
}

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
fn correction(module: &Module, beta: &BigRational) -> Result<BigRational, String> {
    const NAME: &str = "madgwick::scaled_correction";
    let not_understood = "`scaled_correction` is not a direction and β over its length";
    let whole = Interval::new(0, (1 << 30) - 1);
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
    // Lengths of directions are those of the contract of `scaled_up4`.
    let scaled_up = number(module, "scaling::scaled_up4")?;
    let contract = crate::language::contracts::stated(module, scaled_up).ok_or(not_understood)?;
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
            is_terms(&gain, &[(product, power_of_two(-32))]),
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

/// 3: squared length of the sum that `turned` hands to `normalised`, for a squared length within
/// `before` and a correction of length `correction`.
fn turned(
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

    let half_angle = integer(Invariant::read(module)?.rate) * power_of_two(-32);
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

/// 4: squared length after `normalised`, for one within `before`.
fn normalised(
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
        .substituted(change, &definition)
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

/// That `scaled_up3` takes each vector within ±2³⁰ with a component of at least 2¹⁴ to one with a
/// component of at least 2²⁹, octave by octave of the largest component.
fn scaled_up_is_long(module: &Module) -> Result<(), String> {
    let program = module
        .function("scaling::scaled_up3")
        .ok_or("there is no scaling::scaled_up3")?;
    for octave in SCALABLE_BITS..=30 {
        let low = 1_i128 << octave;
        let high = if octave == 30 { low } else { 2 * low - 1 };
        for axis in 0..3 {
            for part in [Interval::new(low, high), Interval::new(-high, -low)] {
                let mut domain = vec![Interval::new(-high, high); 3];
                domain[axis] = part;
                let results = ranges(program, &domain).map_err(|finding| finding.to_string())?;
                unless(
                    results[axis].low >= 1 << 29 || results[axis].high <= -(1 << 29),
                    "`scaled_up3` leaves a vector short",
                )?;
                unless(
                    results
                        .iter()
                        .all(|word| word.is_within(Interval::new(-(1 << 30), 1 << 30))),
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
            is_terms(&form, &[(product, power_of_two(-31))]),
            not_understood,
        )?;
        rounding += form.remainder() * form.remainder();
    }
    let n = words.form(inverse.arguments[0]);
    let (coefficient, constant) = sum_of_squares(&n, &scaled.results).ok_or(not_understood)?;
    unless(
        coefficient == power_of_two(-32) && constant.is_zero(),
        not_understood,
    )?;
    // The largest component is 2²⁹ to 2³⁰.
    let rest = n.remainder().ceil().to_integer();
    let least = BigRational::from(power_of_two(26).to_integer() - rest.clone());
    let domain = Interval::new(
        i128::try_from(least.to_integer()).map_err(|error| error.to_string())?,
        (3 << 28) + i128::try_from(rest).map_err(|error| error.to_string())?,
    );
    // Below 2²⁶ the bound counts 2²⁶ for n, which is more by the rounding alone.
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
fn aligned(module: &Module) -> Result<(BigRational, BigRational), String> {
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
                    && is_terms(&form, &[(outer, integer(2))])
                    && is_terms(&value, &[(inner, integer(2))])
                    && high == power_of_two(29)
                    && low == -high,
                not_understood,
            )?;
        }
    }
    short_turns_do_not_reach_it(module, &program, &words, call)?;
    // Clamped to 1, a component that is longer loses what it has beyond.
    let (least, most) = (&unit.0 * &unit.0, &unit.1 * &unit.1);
    let beyond = (&most - &one).max(BigRational::zero());
    Ok((least - beyond, most))
}

/// That `unit_q28` is asked only for vectors with a component of at least 2¹⁴, and within ±2³⁰.
fn short_turns_do_not_reach_it(
    module: &Module,
    program: &Program,
    words: &Words,
    call: &Call,
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
            form.is_exact() && sign.abs().is_one() && is_terms(&form, terms),
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
        domain[word] = Interval::new(low, high);
    }
    unless(seen.len() == program.arguments.len(), not_understood)?;
    // All short ones end in one constant, so that the branch with the call is not reached.
    let whole = module
        .function("madgwick::aligned")
        .ok_or("there is no aligned")?;
    let results = ranges(whole, &domain).map_err(|finding| finding.to_string())?;
    unless(
        results.iter().all(|word| word.low == word.high),
        "`aligned` takes the unit vector of one that is too short",
    )
}

/// Both ends as distances from 1, rounded up, for a sentence.
pub fn distances(squared: &(BigRational, BigRational)) -> String {
    let text = |value: BigRational| crate::exact::rational::rounded_up(&value, 2);
    let below = BigRational::one() - &squared.0;
    let above = &squared.1 - BigRational::one();
    format!("{} below, {} above", text(below), text(above))
}
