//! Claim `closed-loop-stable`: Hurwitz' criterion for the sampled loop with the emitted gains.
//!
//! With t = T/2 and δ = (z − 1)/T, the map z = (1 + w t)/(1 − w t) takes the left half plane
//! of w to the inside of the unit circle, and δ = w/(1 − w t). A characteristic polynomial
//! δ³ + a δ² + b δ + c becomes h₃ w³ + h₂ w² + h₁ w + h₀ with
//!
//! h₃ = 1 − a t + b t² − c t³,  h₂ = a − 2 b t + 3 c t²,  h₁ = b − 3 c t,  h₀ = c,
//!
//! and all roots lie in the left half plane exactly if all four are positive and h₂ h₁ > h₃ h₀ (Hurwitz). An observer
//! of the angle's bias adds one state; a polynomial of degree four has all roots there exactly if h₀ … h₄ are
//! positive and (h₃ h₂ − h₄ h₁) h₁ > h₃² h₀ (Liénard and Chipart). Using δ instead of z keeps the accuracy of the
//! small difference z − 1.

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
        let row = [0, 1, 2].map(|j| {
            let identity = integer(i128::from(i == j));
            let entry = &ad[i][j] + &bd[i] * &law.gains[j];
            Enclosure::point(&((entry - identity) / t))
        });
        row.to_vec()
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

/// Sum of the minors of a matrix that take `order` of its rows and the same columns.
fn principal_minors<R: Number>(m: &[Vec<R>], order: usize) -> R {
    let subsets = (0_u32..1 << m.len()).filter(|set| set.count_ones() as usize == order);
    subsets.fold(R::nothing(), |sum, set| {
        let places: Vec<usize> = (0..m.len()).filter(|i| set >> i & 1 == 1).collect();
        sum.plus(&minor(m, &places, &places))
    })
}

/// The minor of some rows and columns, by its first row.
fn minor<R: Number>(m: &[Vec<R>], rows: &[usize], columns: &[usize]) -> R {
    let Some((first, rows)) = rows.split_first() else {
        return R::one();
    };
    let mut sum = R::nothing();
    for (index, column) in columns.iter().enumerate() {
        let others: Vec<usize> = columns.iter().filter(|c| *c != column).copied().collect();
        let term = m[*first][*column].times(&minor(m, rows, &others));
        sum = if index % 2 == 0 {
            sum.plus(&term)
        } else {
            sum.minus(&term)
        };
    }
    sum
}

/// The numbers of the criterion for the δ-form of a loop with three or four states: it is stable exactly if all are positive.
pub(crate) fn criterion<R: Number>(m: &[Vec<R>], sample_time: &BigRational) -> Vec<R> {
    let order = m.len();
    // Of δ⁰, δ¹, …: the coefficient of δⁿ⁻ᵏ is (−1)ᵏ times the sum of the minors of order k.
    let coefficients: Vec<R> = (0..=order)
        .map(|power| {
            let sum = principal_minors(m, order - power);
            match (order - power) % 2 {
                0 => sum,
                _ => sum.negated(),
            }
        })
        .collect();
    // Of w⁰, w¹, … in Σ cₖ wᵏ (1 − w t)ⁿ⁻ᵏ.
    let t = -(sample_time * half());
    let h: Vec<R> = (0..=order)
        .map(|power| {
            (0..=power).fold(R::nothing(), |sum, k| {
                let factor = integer(binomial(order - k, power - k)) * t.pow((power - k) as i32);
                sum.plus(&coefficients[k].times(&R::constant(&factor)))
            })
        })
        .collect();
    let cross = match &h[..] {
        [h0, h1, h2, h3, h4] => h3
            .times(h2)
            .minus(&h4.times(h1))
            .times(h1)
            .minus(&h3.times(h3).times(h0)),
        _ => h[2].times(&h[1]).minus(&h[3].times(&h[0])),
    };
    h.into_iter().chain([cross]).collect()
}

/// The number of choices of k among n.
fn binomial(n: usize, k: usize) -> i128 {
    (0..k).fold(1, |found, i| found * (n - i) as i128 / (i + 1) as i128)
}

/// The conclusion from the numbers of the criterion.
pub(crate) fn verdict_of(all: &[&Enclosure]) -> Stability {
    if all.iter().all(|value| value.is_positive()) {
        Stability::Stable
    } else if all.iter().any(|value| value.is_negative()) {
        Stability::Unstable
    } else {
        Stability::Undecided
    }
}

/// The criterion for the δ-form of a loop.
pub(crate) fn judged(m: &[Vec<Enclosure>], sample_time: &BigRational) -> Stability {
    verdict_of(&criterion(m, sample_time).iter().collect::<Vec<_>>())
}
