//! Claim `closed-loop-stable`: Hurwitz' criterion for the sampled loop with the emitted gains.
//!
//! With t = T/2 and δ = (z − 1)/T, the map z = (1 + w t)/(1 − w t) takes the left half plane
//! of w to the inside of the unit circle, and δ = w/(1 − w t). A characteristic polynomial
//! δ³ + a δ² + b δ + c becomes h₃ w³ + h₂ w² + h₁ w + h₀ with
//!
//! h₃ = 1 − a t + b t² − c t³,  h₂ = a − 2 b t + 3 c t²,  h₁ = b − 3 c t,  h₀ = c,
//!
//! and all roots lie in the left half plane exactly if all four are positive and h₂ h₁ > h₃ h₀
//! (Hurwitz). Using δ instead of z keeps the accuracy of the small difference z − 1.

use num_rational::BigRational;

use crate::certificate::reader::Certificate;
use crate::claims::closed_loop_for_all_time::loops;
use crate::claims::control_law::EmittedLaw;
use crate::exact::enclosure::Enclosure;
use crate::exact::rational::{half, integer};

/// Checks that the loop Ad + Bd N with the emitted gains is asymptotically stable.
///
/// # Errors
/// A sentence.
pub fn check_stable(certificate: &Certificate, law: &EmittedLaw) -> Result<(), String> {
    let t = &certificate.sample_time_s.value;
    let (_, quantised) = loops(certificate, law);
    let delta = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let identity = integer(i128::from(i == j));
            Enclosure::point(&((&quantised[i][j] - identity) / t))
        })
    });
    match judged(&delta, t) {
        Stability::Stable => Ok(()),
        _ => Err("Ad + Bd N has an eigenvalue on or outside the unit circle".to_owned()),
    }
}

/// What is known of a box of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stability {
    Stable,
    Unstable,
    Undecided,
}

/// Hurwitz' criterion for the δ-form of a loop.
pub(crate) fn judged(m: &[[Enclosure; 3]; 3], sample_time: &BigRational) -> Stability {
    let t = Enclosure::point(&(sample_time * half()));
    let minor = |i: usize, j: usize| &(&m[i][i] * &m[j][j]) - &(&m[i][j] * &m[j][i]);
    let a = -&(&(&m[0][0] + &m[1][1]) + &m[2][2]);
    let b = &(&minor(0, 1) + &minor(0, 2)) + &minor(1, 2);
    let cofactor = |i: usize, j: usize| &(&m[1][i] * &m[2][j]) - &(&m[1][j] * &m[2][i]);
    let determinant = &(&(&m[0][0] * &cofactor(1, 2)) - &(&m[0][1] * &cofactor(0, 2)))
        + &(&m[0][2] * &cofactor(0, 1));
    let c = -&determinant;

    let t2 = &t * &t;
    let t3 = &t2 * &t;
    let two = Enclosure::point(&integer(2));
    let three = Enclosure::point(&integer(3));
    let h3 = &(&(&Enclosure::point(&integer(1)) - &(&a * &t)) + &(&b * &t2)) - &(&c * &t3);
    let h2 = &(&a - &(&(&two * &b) * &t)) + &(&(&three * &c) * &t2);
    let h1 = &b - &(&(&three * &c) * &t);
    let cross = &(&h2 * &h1) - &(&h3 * &c);
    let all = [&h3, &h2, &h1, &c, &cross];
    if all.iter().all(|value| value.is_positive()) {
        Stability::Stable
    } else if all.iter().any(|value| value.is_negative()) {
        Stability::Unstable
    } else {
        Stability::Undecided
    }
}
