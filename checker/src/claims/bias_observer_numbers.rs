//! The stated numbers of the observer of the angle's bias, checked against the stated plant.
//!
//! With x⁺ = Ad x + Bd u, the measured state y = x + b e₁ and ℓ, f, g, λ the stated `direct`,
//! `from_states`, `from_current` and `decay`,
//!
//! ```text
//! b̂ = z + ℓᵀ y,   z⁺ = λ z + fᵀ y + g u.
//! ```
//!
//! The error e = b̂ − b follows e⁺ = λ e for every x and u exactly if
//!
//! ```text
//! fᵀ + ℓᵀ Ad − λ ℓᵀ = 0,   g + ℓᵀ Bd = 0,   λ + ℓᵀ (I − Ad) e₁ = 1
//! ```
//!
//! (insert y⁺ = Ad x + Bd u + b e₁ into b̂⁺; the three conditions are the terms in x, in u and in b).

use num_rational::BigRational;
use num_traits::{One, Signed};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::exact::rational::{integer, power_of_two, rounded_up};

type Check = Result<(), String>;

/// Least and largest bias that is taken out at most, mrad: 0.6° and 17° (judgement; the generator's is 5.7°).
const LIMITS_MRAD: [i128; 2] = [10, 300];

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
    let [least, most] = LIMITS_MRAD.map(|limit| integer(limit) / integer(1000));
    if !(least..=most).contains(&observer.limit_rad.value) {
        return Err(format!(
            "bias_observer.limit_rad is {}, which is no bias of an angle that an observer takes out",
            observer.limit_rad
        ));
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
