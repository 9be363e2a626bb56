//! The observer of the angle's bias: its numbers against the plant, its words against its numbers,
//! and the loop that it makes.
//!
//! With x⁺ = Ad x + Bd u, the measured state y = x + b e₁ and ℓ, f, g, λ the stated `direct`,
//! `from_states`, `from_current` and `decay`,
//!
//! ```text
//! b̂ = z + ℓᵀ y,   z⁺ = λ z + fᵀ y + g u.
//! ```
//!
//! **Numbers.** The error e = b̂ − b follows e⁺ = λ e whatever x and u do exactly if
//!
//! ```text
//! fᵀ + ℓᵀ Ad − λ ℓᵀ = 0,   g + ℓᵀ Bd = 0,   λ + ℓᵀ (I − Ad) e₁ = 1
//! ```
//!
//! (put y⁺ = Ad x + Bd u + b e₁ into b̂⁺; the three are the terms in x, in u and in b).
//!
//! **Words.** All products have p fraction bits, p the largest with which a sum of products of any
//! words stays within 64 bits; a number c per unit of a word with q fraction bits is the word
//! c 2^(p − q), rounded.
//!
//! **Loop.** Plant, observer and u = N (y − b̂ e₁) with the words as they are: Hurwitz' criterion in
//! δ = (z − 1)/T for the four eigenvalues, and the share of a constant bias that is left at rest.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{BiasObserver, Certificate, matrix, vector};
use crate::claims::control_law::{ControlLaw, exponent};
use crate::claims::hardware_words::{Words, nearest};
use crate::exact::matrices::{Vector, dot};
use crate::exact::rational::{half, integer, power_of_two, rounded_up};
use crate::language::module::Module;

type Check = Result<(), String>;

/// Fraction bits of the word of z (rad).
const STATE_BITS: i32 = 30;
/// Most fraction bits of a product.
const PRODUCT_BITS_MAX: i32 = 60;
/// What is left of a constant bias at rest must be below this share.
const LEFT_MAX: i32 = 100;

/// The stated numbers observe the stated plant, to within what double precision leaves of them.
///
/// # Errors
/// A sentence that names the number.
pub fn check_numbers(certificate: &Certificate) -> Check {
    let Some(observer) = &certificate.bias_observer else {
        return Ok(());
    };
    let ad = matrix(&certificate.plant.ad);
    let bd = vector(&certificate.plant.bd);
    let direct = vector(&observer.direct);
    let decay = &observer.decay.value;
    if !(decay.is_positive() && *decay < BigRational::one()) {
        return Err(format!(
            "bias_observer.decay is {}, which does not lie between 0 and 1",
            observer.decay
        ));
    }
    if !observer.limit_rad.value.is_positive() {
        return Err("bias_observer.limit_rad is not positive".to_owned());
    }
    let vanishes = |name: String, terms: &[BigRational]| {
        let sum: BigRational = terms.iter().sum();
        let size: BigRational = terms.iter().map(Signed::abs).sum();
        if sum.abs() <= size * power_of_two(-46) {
            Ok(())
        } else {
            Err(format!(
                "bias_observer.{name} does not observe the stated Ad and Bd: {} remains",
                rounded_up(&sum, 3)
            ))
        }
    };
    for (j, stated) in observer.from_states.iter().enumerate() {
        let mut terms = vec![stated.value.clone(), -(decay * &direct[j])];
        terms.extend((0..3).map(|i| &direct[i] * &ad[i][j]));
        vanishes(format!("from_states[{j}]"), &terms)?;
    }
    let mut terms = vec![observer.from_current.value.clone()];
    terms.extend((0..3).map(|i| &direct[i] * &bd[i]));
    vanishes("from_current".to_owned(), &terms)?;
    let mut terms = vec![decay.clone(), integer(-1)];
    terms.extend((0..3).map(|i| &direct[i] * (integer(i128::from(i == 0)) - &ad[i][0])));
    vanishes("direct".to_owned(), &terms)
}

/// The words of `BIAS_OBSERVER` are the stated numbers, rounded; all nothing where none are stated.
///
/// # Errors
/// A sentence that names the word.
pub(crate) fn check_words(
    certificate: &Certificate,
    text: &str,
    law: &ControlLaw,
    words: &Words,
) -> Check {
    let documented = |line: &str| {
        if text.lines().any(|found| found.trim() == line) {
            Ok(())
        } else {
            Err(format!("src/constants.rs does not document `{line}`"))
        }
    };
    let Some(observer) = &certificate.bias_observer else {
        documented("/// No observer of the angle's bias: the estimate is zero.")?;
        // Nothing of one is left but shifts that are valid.
        for (name, word) in words.iter() {
            let wanted = i128::from(name.ends_with("_shift"));
            if word != wanted {
                return Err(format!(
                    "{name} is {word} in a module without a bias estimate"
                ));
            }
        }
        return Ok(());
    };
    documented(&format!(
        "/// Observer of the angle's bias with decay {} a step, within ±{} rad.",
        observer.decay, observer.limit_rad
    ))?;
    let angle_bits = exponent(law.state_bits[0]);
    let get = |field: &str| words.get(&format!("BIAS_OBSERVER.{field}"));
    let is = |field: &str, wanted: BigRational| {
        let found = get(field)?;
        if found == wanted {
            Ok(())
        } else {
            Err(format!("BIAS_OBSERVER.{field} is {found}, not {wanted}"))
        }
    };
    let product_bits = (angle_bits.max(STATE_BITS) + 1..=PRODUCT_BITS_MAX)
        .rev()
        .find(|bits| fits(&scaled(observer, law, *bits)))
        .ok_or("the numbers of bias_observer fit no words")?;
    is("unit", power_of_two(product_bits - STATE_BITS))?;
    is("state_shift", integer((product_bits - STATE_BITS).into()))?;
    is("angle_shift", integer((product_bits - angle_bits).into()))?;
    for (field, real) in scaled(observer, law, product_bits) {
        nearest(&format!("BIAS_OBSERVER.{field}"), &get(&field)?, &real)?;
    }
    nearest(
        "BIAS_OBSERVER.limit",
        &get("limit")?,
        &(&observer.limit_rad.value * power_of_two(angle_bits)),
    )
}

/// Each number of the observer in units of its word, for products with `bits` fraction bits.
fn scaled(observer: &BiasObserver, law: &ControlLaw, bits: i32) -> Vec<(String, BigRational)> {
    let unit = |word_bits: i32| power_of_two(bits - word_bits);
    let mut all = vec![("decay".to_owned(), &observer.decay.value * unit(STATE_BITS))];
    for i in 0..3 {
        let state = unit(exponent(law.state_bits[i]));
        all.push((format!("direct[{i}]"), &observer.direct[i].value * &state));
        all.push((
            format!("from_states[{i}]"),
            &observer.from_states[i].value * &state,
        ));
    }
    all.push((
        "from_current".to_owned(),
        &observer.from_current.value * unit(exponent(law.current_bits)),
    ));
    // 1, on the same scale as the decay.
    all.push(("unit".to_owned(), unit(STATE_BITS)));
    all
}

/// Whether sums of products with any words, and the half that rounds, stay below 2⁶³.
fn fits(scaled: &[(String, BigRational)]) -> bool {
    let sum = |names: &[&str]| -> BigRational {
        scaled
            .iter()
            .filter(|(name, _)| names.iter().any(|start| name.starts_with(start)))
            .map(|(_, value)| value.abs().round())
            .sum()
    };
    let largest = power_of_two(31);
    sum(&["unit", "direct"]) < largest && sum(&["decay", "from_"]) < largest
}

/// Shows that plant, regulator and observer are stable together, with the words of the source, and
/// that they leave less than a hundredth of a constant bias at rest. Returns what they leave, as a
/// share of the bias, and how fast the wheel then turns (rad/s for a bias of 1 rad); `None` for a
/// module without observer.
///
/// # Errors
/// A sentence.
pub fn check_loop(
    certificate: &Certificate,
    module: &Module,
    law: &ControlLaw,
) -> Result<Option<(BigRational, BigRational)>, String> {
    if certificate.bias_observer.is_none() {
        return Ok(None);
    }
    let words = Words::read(module, "BIAS_OBSERVER")?;
    let small = |field: &str| words.small(&format!("BIAS_OBSERVER.{field}"));
    // Real numbers again: of z with 2^−30 rad, of an estimate with the angle's unit.
    let angle_bits = exponent(law.state_bits[0]);
    let to_estimate = power_of_two(-small("angle_shift")? - angle_bits);
    let to_state = power_of_two(-small("state_shift")? - STATE_BITS);
    let number = |field: &str, bits: i32, unit: &BigRational| {
        let word = words.get(&format!("BIAS_OBSERVER.{field}"))?;
        Ok::<_, String>(word * unit * power_of_two(bits))
    };
    let mut direct: Vector = [0, 1, 2].map(|_| BigRational::zero());
    let mut from_states = direct.clone();
    for i in 0..3 {
        let bits = exponent(law.state_bits[i]);
        direct[i] = number(&format!("direct[{i}]"), bits, &to_estimate)?;
        from_states[i] = number(&format!("from_states[{i}]"), bits, &to_state)?;
    }
    let unit = number("unit", STATE_BITS, &to_estimate)?;
    let decay = number("decay", STATE_BITS, &to_state)?;
    let from_current = number("from_current", exponent(law.current_bits), &to_state)?;

    // u = N (y − (unit z + ℓᵀ y) e₁) = (N − N₁ ℓᵀ) y − N₁ unit z
    let gains = &law.gains;
    let of_states: Vector = [0, 1, 2].map(|j| &gains[j] - &gains[0] * &direct[j]);
    let of_z = -(&gains[0] * unit);
    let ad = matrix(&certificate.plant.ad);
    let bd = vector(&certificate.plant.bd);
    // Increments a step, M − I, of (x, z), and what a bias of 1 rad adds to them.
    let mut step: Vec<Vec<BigRational>> = Vec::new();
    let mut of_bias = Vec::new();
    for i in 0..3 {
        let mut row: Vec<BigRational> = (0..3)
            .map(|j| &ad[i][j] + &bd[i] * &of_states[j] - integer(i128::from(i == j)))
            .collect();
        row.push(&bd[i] * &of_z);
        step.push(row);
        of_bias.push(&bd[i] * &of_states[0]);
    }
    let mut row: Vec<BigRational> = (0..3)
        .map(|j| &from_states[j] + &from_current * &of_states[j])
        .collect();
    of_bias.push(row[0].clone());
    row.push(decay + &from_current * &of_z - integer(1));
    step.push(row);

    let period = &certificate.sample_time_s.value;
    let delta: Vec<Vec<BigRational>> = step
        .iter()
        .map(|row| row.iter().map(|entry| entry / period).collect())
        .collect();
    if !is_stable(&characteristic_polynomial(&delta), period) {
        return Err(
            "plant, regulator and observer have an eigenvalue on or outside the unit circle"
                .to_owned(),
        );
    }
    // At rest: (M − I) (x, z) + n b = 0.
    let rest = solved(&step, &of_bias).ok_or("the loop with the observer has no state of rest")?;
    let measured: Vector = [&rest[0] + integer(1), rest[1].clone(), rest[2].clone()];
    let estimate = number("unit", STATE_BITS, &to_estimate)? * &rest[3] + dot(&direct, &measured);
    let left = (integer(1) - estimate).abs();
    if &left * integer(LEFT_MAX.into()) >= integer(1) {
        return Err(format!(
            "at rest the observer leaves {} of a constant bias of the angle",
            rounded_up(&left, 3)
        ));
    }
    Ok(Some((left, rest[2].abs())))
}

/// det(λ I − M) by Faddeev and LeVerrier: coefficients of λ⁰ … λⁿ.
fn characteristic_polynomial(m: &[Vec<BigRational>]) -> Vec<BigRational> {
    let size = m.len();
    let mut coefficients = vec![BigRational::one(); size + 1];
    let mut power: Vec<Vec<BigRational>> = vec![vec![BigRational::zero(); size]; size];
    for k in 1..=size {
        // M_k = M M_{k−1} + c_{n−k+1} I
        let mut next = times(m, &power);
        for (i, row) in next.iter_mut().enumerate() {
            row[i] += &coefficients[size - k + 1];
        }
        power = next;
        let trace: BigRational = times(m, &power)
            .iter()
            .enumerate()
            .map(|(i, row)| row[i].clone())
            .sum();
        let order = integer(i128::try_from(k).unwrap_or(i128::MAX));
        coefficients[size - k] = -(trace / order);
    }
    coefficients
}

fn times(a: &[Vec<BigRational>], b: &[Vec<BigRational>]) -> Vec<Vec<BigRational>> {
    a.iter()
        .map(|row| {
            (0..b.len())
                .map(|j| row.iter().zip(b).map(|(x, other)| x * &other[j]).sum())
                .collect()
        })
        .collect()
}

/// Whether all roots of a polynomial in δ = (z − 1)/T lie where |z| < 1: δ = w/(1 − w T/2) takes
/// the left half plane of w there, and Routh's table of the polynomial in w has one sign.
fn is_stable(coefficients: &[BigRational], period: &BigRational) -> bool {
    let degree = coefficients.len() - 1;
    let t = period * half();
    // Σ c_k w^k (1 − t w)^(n − k)
    let mut in_w = vec![BigRational::zero(); degree + 1];
    for (k, coefficient) in coefficients.iter().enumerate() {
        let mut factor = vec![BigRational::one()];
        for _ in k..degree {
            let mut longer = factor.clone();
            longer.push(BigRational::zero());
            for (index, entry) in factor.iter().enumerate() {
                longer[index + 1] -= entry * &t;
            }
            factor = longer;
        }
        for (index, entry) in factor.iter().enumerate() {
            in_w[k + index] += coefficient * entry;
        }
    }
    in_w.reverse();
    let every_second = |start: usize| -> Vec<BigRational> {
        in_w.iter().skip(start).step_by(2).cloned().collect()
    };
    let (mut upper, mut lower) = (every_second(0), every_second(1));
    let mut signs = vec![upper[0].clone()];
    while !lower.is_empty() {
        let pivot = lower[0].clone();
        signs.push(pivot.clone());
        if pivot.is_zero() {
            return false;
        }
        let zero = BigRational::zero();
        let next: Vec<BigRational> = (1..upper.len())
            .map(|j| &upper[j] - &upper[0] * lower.get(j).unwrap_or(&zero) / &pivot)
            .collect();
        (upper, lower) = (lower, next);
    }
    signs.iter().all(Signed::is_positive)
}

/// The x of M x + n = 0 by elimination; `None` where M is singular.
fn solved(m: &[Vec<BigRational>], n: &[BigRational]) -> Option<Vec<BigRational>> {
    let size = m.len();
    let mut rows: Vec<Vec<BigRational>> = m
        .iter()
        .zip(n)
        .map(|(row, right)| row.iter().cloned().chain([-right.clone()]).collect())
        .collect();
    for column in 0..size {
        let pivot = (column..size).find(|row| !rows[*row][column].is_zero())?;
        rows.swap(column, pivot);
        let leading = rows[column].clone();
        for (index, row) in rows.iter_mut().enumerate() {
            if index != column {
                let factor = &row[column] / &leading[column];
                for (entry, other) in row.iter_mut().zip(&leading) {
                    *entry -= &factor * other;
                }
            }
        }
    }
    Some((0..size).map(|i| &rows[i][size] / &rows[i][i]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f64) -> BigRational {
        BigRational::from_float(value).unwrap()
    }

    /// Π (δ − rᵢ), from known roots.
    fn polynomial(roots: &[f64]) -> Vec<BigRational> {
        let mut found = vec![BigRational::one()];
        for root in roots {
            let mut next = vec![BigRational::zero(); found.len() + 1];
            for (index, entry) in found.iter().enumerate() {
                next[index + 1] += entry;
                next[index] -= entry * number(*root);
            }
            found = next;
        }
        found
    }

    #[test]
    fn routh_agrees_with_known_roots() {
        let period = number(0.25);
        // z = 1 + T δ lies inside the unit circle for δ between −8 and 0.
        for (roots, stable) in [
            ([-1.0, -2.0, -3.0, -7.99], true),
            ([-1.0, -2.0, -3.0, -8.01], false),
            ([-1.0, -2.0, -3.0, 0.01], false),
            ([-1.0, -2.0, -3.0, 0.0], false),
            ([-0.001, -0.001, -7.0, -0.5], true),
            ([-9.0, -9.0, -1.0, -1.0], false),
        ] {
            assert_eq!(is_stable(&polynomial(&roots), &period), stable, "{roots:?}");
        }
        // A pair just inside and just outside the unit circle, δ = (r e^{±iθ} − 1)/T.
        for (radius, stable) in [(0.999, true), (1.001, false)] {
            let (re, im) = ((radius * 0.6 - 1.0) / 0.25, radius * 0.8 / 0.25);
            let pair = [number(re * re + im * im), number(-2.0 * re), number(1.0)];
            let others = polynomial(&[-1.0, -2.0]);
            let mut product = vec![BigRational::zero(); 5];
            for (i, a) in pair.iter().enumerate() {
                for (j, b) in others.iter().enumerate() {
                    product[i + j] += a * b;
                }
            }
            assert_eq!(is_stable(&product, &period), stable, "{radius}");
        }
    }

    #[test]
    fn polynomial_of_a_companion_matrix() {
        let m: Vec<Vec<BigRational>> = [[0, 0, 0, -5], [1, 0, 0, 3], [0, 1, 0, -2], [0, 0, 1, 7]]
            .iter()
            .map(|row| row.iter().map(|entry| integer(*entry)).collect())
            .collect();
        let wanted: Vec<BigRational> = [5, -3, 2, -7, 1].map(integer).to_vec();
        assert_eq!(characteristic_polynomial(&m), wanted);
    }

    #[test]
    fn equations_are_solved() {
        let m = vec![vec![integer(0), integer(2)], vec![integer(4), integer(1)]];
        let x = solved(&m, &[integer(-6), integer(-11)]).unwrap();
        assert_eq!(x, vec![integer(2), integer(3)]);
        assert_eq!(solved(&[vec![integer(0)]], &[integer(1)]), None);
    }
}
