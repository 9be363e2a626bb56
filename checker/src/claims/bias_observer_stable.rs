//! Claim `bias-observer-stable`: the loop of plant, regulator and observer of the angle's bias is
//! stable.
//!
//! The loop is plant, observer and u = N (y − b̂ e₁) with the emitted words. Hurwitz' criterion in
//! δ = (z − 1)/T is applied to its four eigenvalues, and the share of a constant bias that remains at rest is bounded.
//! [`crate::claims::bias_observer_numbers`] defines the observer.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::control_law::EmittedLaw;
use crate::claims::emitted_observer::EmittedObserver;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::matrices::{Vector, dot};
use crate::exact::rational::{half, integer, rounded_up};
use crate::language::module::Module;

/// The share of a constant bias that may remain at rest.
const LEFT_MAX: i32 = 100;

/// The outcome of the claim.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
) -> ClaimOutcome {
    match check_loop(certificate, module, law) {
        Ok(Some((left, speed))) => ClaimOutcome::Proved(format!(
            "{} of a bias is left; the wheel turns with {} rad/s for each rad of bias",
            rounded_up(&left, 2),
            rounded_up(&speed, 2)
        )),
        Ok(None) => ClaimOutcome::NotApplicable("the module has no observer".to_owned()),
        Err(why) => ClaimOutcome::Failed(why),
    }
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
    law: &EmittedLaw,
) -> Result<Option<(BigRational, BigRational)>, String> {
    if certificate.bias_observer.is_none() {
        return Ok(None);
    }
    let observer = EmittedObserver::read(module, law.state_bits, law.current_bits)?
        .ok_or("src/constants.rs has no observer of the angle's bias")?;
    let (of_states, into) = (
        observer.of_readings(&law.gains),
        observer.into_state(&law.gains),
    );
    let of_z = -law.gains[0].clone();
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
    let mut row = into.to_vec();
    of_bias.push(row[0].clone());
    row.push(observer.own_decay(&law.gains) - integer(1));
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
    let estimate = &rest[3] + dot(&observer.direct, &measured);
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
pub(crate) fn is_stable(coefficients: &[BigRational], period: &BigRational) -> bool {
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
