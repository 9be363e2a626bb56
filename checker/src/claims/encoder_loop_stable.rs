//! Claim `encoder-loop-stable`: the loop with the rate and the speed that encoders show, and with the back-EMF that a
//! voltage drive leaves to the motor, is stable.
//!
//! An encoder's speed is the turn of its axis over N steps, (φ(k) − φ(k − N))/(N T), and so half a window old. A voltage
//! drive holds V = Σ g y over a step, g = R n + k_e e₃ with the emitted gains n, and the current follows the wheel between
//! two steps: ẋ = A x + B (V − k_e φ̇)/R.
//!
//! With the wheel's angle as a fourth state, sampled, the transfer from the held input to each state is a polynomial
//! over D = det(z I − A₄). All states that the windows add are shifts, so that the loop's polynomial is
//!
//! zᴸ D − g₁ zᴸ N_α − g₂ W_α − g₃ W_φ,   W = zᴸ N of a measured speed, (zᴸ − zᴸ⁻ᴺ)/(N T) N of the angle for an encoder,
//!
//! L the longest window. With an observer of the angle's bias ([`crate::claims::emitted_observer`]) the polynomial is
//! z − p times the first term, p the decay of the observer's state under the law, and each g is the polynomial (z −
//! p) g' − R N₁ c: g' of what a reading does at once, c its share in the observer's state. The angle of the wheel
//! enters by its differences alone, so that z = 1 is a root which belongs to no loop; it is taken out. All other
//! roots lie inside the unit circle by Routh's table, in exact arithmetic.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::certificate::reader::Certificate;
use crate::claims::bias_observer_stable::is_stable;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::rational::{half, integer, power_of_two};

/// States: angle, rate, wheel speed, wheel angle.
const ORDER: usize = 4;

/// Terms of the series of the matrix exponential.
const TERMS: i128 = 60;

/// Bits after the point to which the sampled model is rounded: far below what its decimals state.
const BITS: i32 = 140;

type Matrix = Vec<Vec<BigRational>>;
/// Coefficients of z⁰, z¹, …
type Polynomial = Vec<BigRational>;

/// What comes of the claim.
pub fn by_exact_arithmetic(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    let hardware = &certificate.hardware;
    let has_encoder = hardware.wheel_speed.encoder.is_some() || hardware.body_encoder().is_some();
    if !has_encoder && certificate.drive.voltage.is_none() {
        return ClaimOutcome::NotApplicable("no encoder, and a current drive".to_owned());
    }
    let found = polynomial(certificate, law);
    let shifted = about_one(&found);
    // The wheel's angle by itself.
    let (root, rest) = match shifted.split_first() {
        Some((first, rest)) => (first.is_zero(), rest),
        None => (false, &[][..]),
    };
    if !root {
        return ClaimOutcome::Failed("the loop depends on the wheel's angle".to_owned());
    }
    if is_stable(rest, &BigRational::one()) {
        ClaimOutcome::Proved(format!(
            "all {} roots inside the unit circle",
            rest.len() - 1
        ))
    } else {
        ClaimOutcome::Failed("the loop has a root on or outside the unit circle".to_owned())
    }
}

/// The polynomial of the loop in z.
fn polynomial(certificate: &Certificate, law: &EmittedLaw) -> Polynomial {
    let period = &certificate.sample_time_s.value;
    let plant = &certificate.plant;
    let mut a: Matrix = plant
        .a
        .iter()
        .map(|row| row.iter().map(|entry| entry.value.clone()).collect())
        .collect();
    let mut b: Vec<BigRational> = plant.b.iter().map(|entry| entry.value.clone()).collect();
    let mut gains: Vec<BigRational> = law.of_readings().to_vec();
    let mut of_observer = -law.gains[0].clone();
    if let Some(drive) = &certificate.drive.voltage {
        let (r, k_e) = (&drive.winding_ohm.value, &drive.back_emf_v_s.value);
        for (row, push) in a.iter_mut().zip(&b) {
            row[2] -= push * k_e / r;
        }
        for push in &mut b {
            *push /= r;
        }
        for gain in &mut gains {
            *gain *= r;
        }
        of_observer *= r;
        gains[2] += k_e;
    }
    for row in &mut a {
        row.push(BigRational::zero());
    }
    a.push([0, 0, 1, 0].map(integer).to_vec());
    b.push(BigRational::zero());
    let (ad, bd) = sampled(&a, &b, period);
    let (denominator, numerators) = transfer(&ad, &bd);

    let window = certificate.hardware.wheel_speed.encoder.as_ref();
    let window = window.map(|encoder| encoder.window as usize);
    let body = certificate.hardware.body_encoder();
    let body_window = body.map(|encoder| encoder.window as usize);
    let longest = window.max(body_window).unwrap_or(0);
    let shift = |polynomial: &Polynomial, by: usize| -> Polynomial {
        [vec![BigRational::zero(); by], polynomial.clone()].concat()
    };
    let speed = |window: Option<usize>, speed: usize, angle: usize| -> Polynomial {
        let Some(window) = window else {
            return shift(&numerators[speed], longest);
        };
        let over = (integer(window as i128) * period).recip();
        let now = shift(&numerators[angle], longest);
        let before = shift(&numerators[angle], longest - window);
        plus(&scaled(&now, &over), &scaled(&before, &-over))
    };
    let fed_back = [
        shift(&numerators[0], longest),
        speed(body_window, 1, 0),
        speed(window, 2, 3),
    ];
    let Some(observer) = &law.observer else {
        let mut found = shift(&denominator, longest);
        for (gain, measured) in gains.iter().zip(&fed_back) {
            found = plus(&found, &scaled(measured, &-gain));
        }
        return found;
    };
    let decay = observer.own_decay(&law.gains);
    // (z − p) of a polynomial.
    let filtered = |polynomial: &Polynomial| -> Polynomial {
        plus(&shift(polynomial, 1), &scaled(polynomial, &-&decay))
    };
    let into = observer.into_state(&law.gains);
    let mut found = filtered(&shift(&denominator, longest));
    for ((gain, into), measured) in gains.iter().zip(&into).zip(&fed_back) {
        found = plus(&found, &filtered(&scaled(measured, &-gain)));
        found = plus(&found, &scaled(measured, &-(&of_observer * into)));
    }
    found
}

/// exp(A T) and ∫ exp(A σ) dσ B, rounded to [`BITS`].
fn sampled(a: &Matrix, b: &[BigRational], period: &BigRational) -> (Matrix, Vec<BigRational>) {
    let zero = || vec![BigRational::zero(); ORDER];
    let mut ad: Matrix = (0..ORDER).map(|_| zero()).collect();
    let mut bd = zero();
    // (A T)^k/k!, its columns one by one.
    let mut term: Matrix = (0..ORDER)
        .map(|i| (0..ORDER).map(|j| integer(i128::from(i == j))).collect())
        .collect();
    for k in 0..TERMS {
        let order = integer(k + 1);
        for i in 0..ORDER {
            for j in 0..ORDER {
                ad[i][j] += &term[i][j];
                bd[i] += &term[i][j] * &b[j] * period / &order;
            }
        }
        term = (0..ORDER)
            .map(|i| {
                (0..ORDER)
                    .map(|j| {
                        let sum: BigRational = (0..ORDER).map(|l| &term[i][l] * &a[l][j]).sum();
                        on_grid(&(sum * period / &order), 2 * BITS)
                    })
                    .collect()
            })
            .collect();
    }
    for row in &mut ad {
        for entry in row.iter_mut() {
            *entry = on_grid(entry, BITS);
        }
    }
    (ad, bd.iter().map(|entry| on_grid(entry, BITS)).collect())
}

/// The nearest multiple of 2^−bits.
fn on_grid(value: &BigRational, bits: i32) -> BigRational {
    (value * power_of_two(bits) + half()).floor() * power_of_two(-bits)
}

/// det(z I − M), and adj(z I − M) v row by row, by Faddeev and LeVerrier.
fn transfer(m: &Matrix, v: &[BigRational]) -> (Polynomial, Vec<Polynomial>) {
    let size = m.len();
    let mut determinant = vec![BigRational::zero(); size + 1];
    determinant[size] = BigRational::one();
    let mut rows: Vec<Polynomial> = vec![vec![BigRational::zero(); size]; size];
    let mut part: Matrix = vec![vec![BigRational::zero(); size]; size];
    for k in 1..=size {
        // M_k = M M_{k−1} + c_{n−k+1} I is the coefficient of z^(n−k) in the adjugate.
        let mut next = product(m, &part);
        for (i, row) in next.iter_mut().enumerate() {
            row[i] += &determinant[size - k + 1];
        }
        part = next;
        for (i, row) in part.iter().enumerate() {
            rows[i][size - k] = row.iter().zip(v).map(|(entry, x)| entry * x).sum();
        }
        let trace: BigRational = product(m, &part)
            .iter()
            .enumerate()
            .map(|(i, row)| row[i].clone())
            .sum();
        determinant[size - k] = -(trace / integer(k as i128));
    }
    (determinant, rows)
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.iter()
        .map(|row| {
            (0..b.len())
                .map(|j| row.iter().zip(b).map(|(x, other)| x * &other[j]).sum())
                .collect()
        })
        .collect()
}

fn scaled(polynomial: &Polynomial, factor: &BigRational) -> Polynomial {
    polynomial.iter().map(|entry| entry * factor).collect()
}

fn plus(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let zero = BigRational::zero();
    (0..a.len().max(b.len()))
        .map(|k| a.get(k).unwrap_or(&zero) + b.get(k).unwrap_or(&zero))
        .collect()
}

/// The same polynomial in z − 1, by Horner's scheme.
fn about_one(polynomial: &Polynomial) -> Polynomial {
    let mut found = polynomial.clone();
    for first in 0..found.len() {
        for k in (first..found.len().saturating_sub(1)).rev() {
            let above = found[k + 1].clone();
            found[k] += above;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z² − 3 z + 2 = (z − 1)(z − 2), in d = z − 1: d² − d.
    #[test]
    fn a_polynomial_about_one() {
        let found = about_one(&[2, -3, 1].map(integer).to_vec());
        assert_eq!(found, [0, -1, 1].map(integer).to_vec());
    }

    /// A double integrator sampled with 1 s: 1/2 (z + 1)/(z − 1)² and 1/(z − 1).
    #[test]
    fn the_transfer_of_a_double_integrator() {
        let m = vec![vec![integer(1), integer(1)], vec![integer(0), integer(1)]];
        let (determinant, rows) = transfer(&m, &[half(), integer(1)]);
        assert_eq!(determinant, [1, -2, 1].map(integer).to_vec());
        assert_eq!(rows[0], vec![half(), half()]);
        assert_eq!(rows[1], [-1, 1].map(integer).to_vec());
    }
}
