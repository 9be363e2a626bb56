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

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::control_law::EmittedLaw;
use crate::exact::enclosure::Enclosure;
use crate::exact::rational::{half, integer};
use crate::exact::slopes::Number;

/// Checks that the loop Ad + Bd N with the emitted gains is asymptotically stable.
///
/// # Errors
/// A sentence.
pub fn check_stable(certificate: &Certificate, law: &EmittedLaw) -> Result<(), String> {
    let t = &certificate.sample_time_s.value;
    // The loop of the design, with the current held; `encoder-loop-stable` speaks of a voltage drive.
    let (ad, bd) = (matrix(&certificate.plant.ad), vector(&certificate.plant.bd));
    let delta = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let identity = integer(i128::from(i == j));
            let entry = &ad[i][j] + &bd[i] * &law.gains[j];
            Enclosure::point(&((entry - identity) / t))
        })
    });
    match judged(&delta, t) {
        Stability::Stable => Ok(()),
        _ => Err("Ad + Bd N has an eigenvalue on or outside the unit circle".to_owned()),
    }
}

/// The knowledge about a box of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stability {
    Stable,
    Unstable,
    Undecided,
}

/// The five numbers of Hurwitz' criterion for the δ-form of a loop: it is stable exactly if all are positive.
pub(crate) fn criterion<R: Number>(m: &[[R; 3]; 3], sample_time: &BigRational) -> [R; 5] {
    let t = R::constant(&(sample_time * half()));
    let minor = |i: usize, j: usize| m[i][i].times(&m[j][j]).minus(&m[i][j].times(&m[j][i]));
    let a = m[0][0].plus(&m[1][1]).plus(&m[2][2]).negated();
    let b = minor(0, 1).plus(&minor(0, 2)).plus(&minor(1, 2));
    let cofactor = |i: usize, j: usize| m[1][i].times(&m[2][j]).minus(&m[1][j].times(&m[2][i]));
    let determinant = m[0][0]
        .times(&cofactor(1, 2))
        .minus(&m[0][1].times(&cofactor(0, 2)))
        .plus(&m[0][2].times(&cofactor(0, 1)));
    let c = determinant.negated();

    let t2 = t.times(&t);
    let t3 = t2.times(&t);
    let two = R::constant(&integer(2));
    let three = R::constant(&integer(3));
    let h3 = R::one()
        .minus(&a.times(&t))
        .plus(&b.times(&t2))
        .minus(&c.times(&t3));
    let h2 = a
        .minus(&two.times(&b).times(&t))
        .plus(&three.times(&c).times(&t2));
    let h1 = b.minus(&three.times(&c).times(&t));
    let cross = h2.times(&h1).minus(&h3.times(&c));
    [h3, h2, h1, c, cross]
}

/// The conclusion from the five numbers.
pub(crate) fn verdict_of(all: &[&Enclosure]) -> Stability {
    if all.iter().all(|value| value.is_positive()) {
        Stability::Stable
    } else if all.iter().any(|value| value.is_negative()) {
        Stability::Unstable
    } else {
        Stability::Undecided
    }
}

/// Hurwitz' criterion for the δ-form of a loop.
pub(crate) fn judged(m: &[[Enclosure; 3]; 3], sample_time: &BigRational) -> Stability {
    verdict_of(&criterion(m, sample_time).each_ref())
}
