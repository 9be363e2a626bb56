//! The check that the certificate's sampled model is the discretisation of its continuous one.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::held_loop::HeldLoop;
use crate::exact::matrices::{Matrix, Vector, apply, product};
use crate::exact::rational::{integer, power, rounded_up};

/// Terms of the series of the matrix exponential.
const TERMS: u32 = 80;

/// Checks that Ad and Bd are A and B, sampled with a zero-order hold at the stated time; and likewise those of a voltage
/// that is held, where the drive sets one.
///
/// # Errors
/// A sentence that names the entry.
pub fn check_sampling(certificate: &Certificate) -> Result<(), String> {
    let t = &certificate.sample_time_s.value;
    if !t.is_positive() {
        return Err("the sample time is not positive".to_owned());
    }
    let plant = &certificate.plant;
    let (ad, bd) = (matrix(&plant.ad), vector(&plant.bd));
    is_sampled("", t, &matrix(&plant.a), &vector(&plant.b), &ad, &bd)?;
    if certificate.drive.voltage.is_some() {
        let held = HeldLoop::of(certificate);
        is_sampled("drive.voltage.", t, &held.a, &held.b, &held.ad, &held.bd)?;
    }
    Ok(())
}

/// Checks `stated_ad` and `stated_bd`; `place` is the start of their names.
fn is_sampled(
    place: &str,
    t: &BigRational,
    a: &Matrix,
    b: &Vector,
    stated_ad: &Matrix,
    stated_bd: &Vector,
) -> Result<(), String> {
    let scaled: Matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| &a[i][j] * t));
    let norm = scaled
        .iter()
        .map(|row| row.iter().map(Signed::abs).sum::<BigRational>())
        .max()
        .unwrap_or_default();
    if norm > integer(8) {
        return Err("the sample time is too long for the model: |A| T is above 8".to_owned());
    }
    // The first row of the model is kinematics: the rate is the angle's derivative.
    let first = [&a[0][0], &a[0][1], &a[0][2], &b[0]];
    if first.map(|entry| entry.clone()) != [0, 1, 0, 0].map(integer) {
        return Err("the first row of A and B is not (0, 1, 0) and 0".to_owned());
    }
    // Σ (A T)^k/k! and T Σ (A T)^k/(k + 1)! B, until what is left is below 1e-30.
    let mut left = BigRational::one();
    let zero = || BigRational::zero();
    let one = BigRational::one();
    let mut term: Matrix =
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { one.clone() } else { zero() }));
    let mut ad: Matrix = [0, 1, 2].map(|_| [0, 1, 2].map(|_| zero()));
    let mut bd: Vector = [0, 1, 2].map(|_| zero());
    for k in 0..TERMS {
        let input = apply(&term, b);
        let order = integer(i128::from(k) + 1);
        for i in 0..3 {
            for (sum, entry) in ad[i].iter_mut().zip(&term[i]) {
                *sum += entry;
            }
            bd[i] += &input[i] * t / &order;
        }
        left = left * &norm / &order;
        if left < power(10, -30) && order > &norm * integer(2) {
            break;
        }
        let next = product(&term, &scaled);
        term = next.map(|row| row.map(|entry| entry / &order));
    }
    let close = |what: String, stated: &BigRational, exact: &BigRational| {
        let allowed = exact.abs() * power(10, -12) + power(10, -20);
        if (stated - exact).abs() <= allowed {
            Ok(())
        } else {
            Err(format!(
                "{what} is stated as {}, sampling gives {}",
                rounded_up(stated, 12),
                rounded_up(exact, 12)
            ))
        }
    };
    for i in 0..3 {
        for (j, (entry, exact)) in stated_ad[i].iter().zip(&ad[i]).enumerate() {
            close(format!("{place}Ad[{i}][{j}]"), entry, exact)?;
        }
        close(format!("{place}Bd[{i}]"), &stated_bd[i], &bd[i])?;
    }
    Ok(())
}
