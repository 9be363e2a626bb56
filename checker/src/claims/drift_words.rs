//! The words of the tracking of the gyroscope's drift, against its stated numbers.

use num_rational::BigRational;
use num_traits::Signed;

use crate::certificate::hardware::CertifiedInertial;
use crate::claims::named_words::{NamedWords, nearest};
use crate::exact::rational::{half, integer, power_of_two};

/// Longest time in which the gyroscope's drift is followed, s: ten minutes, within which a chip warms up (judgement).
const DRIFT_TIME_MAX_S: i128 = 600;
/// Least and largest drift that is followed at most, mrad/s: 0.6 and 30 °/s (judgement; the generator's is 5 °/s).
/// A larger one would take a swing of the body for drift.
const DRIFT_LIMITS_MRAD_S: [i128; 2] = [10, 524];

/// The words are the stated numbers, with the largest number of bits that leaves room for the largest drift.
///
/// # Errors
/// A sentence that names the word.
pub(crate) fn check(
    filter: &NamedWords,
    hardware: &CertifiedInertial,
    period: &BigRational,
) -> Result<(), String> {
    let time = &hardware.drift_time_s.value;
    let limit = &hardware.drift_limit_rad_s.value;
    if !time.is_positive() || *time > integer(DRIFT_TIME_MAX_S) {
        return Err(format!(
            "drift_time_s is {}: the drift is followed in no time, or not at all",
            hardware.drift_time_s
        ));
    }
    let [least, most] = DRIFT_LIMITS_MRAD_S.map(|limit| integer(limit) / integer(1000));
    if !(least..=most).contains(limit) {
        return Err(format!(
            "drift_limit_rad_s is {}: no drift of a gyroscope, or a motion of the body",
            hardware.drift_limit_rad_s
        ));
    }
    let shift = filter.small("FILTER.drift.shift")?;
    if !(0..=14).contains(&shift) {
        return Err(format!("FILTER.drift.shift is {shift}"));
    }
    nearest(
        "FILTER.drift.gain",
        &filter.get("FILTER.drift.gain")?,
        &(period / time * power_of_two(28 + shift)),
    )?;
    let word = filter.get("FILTER.drift.limit")?;
    let real = limit * period * half() * power_of_two(32 + shift);
    let real = real.min(power_of_two(30));
    if !word.is_positive() || (&word - &real).abs() > integer(1) + &real * power_of_two(-40) {
        return Err(format!("FILTER.drift.limit is {word}"));
    }
    Ok(())
}
