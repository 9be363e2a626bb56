//! The words of `LIMITS`, from the certificate's plant, sensors and drive.
//!
//! All follow from the linear model about upright, which is derived here a second time. The largest current
//! holds the body at asin(|B₂| I/A₂₁), which it leaves with the rate constant √A₂₁ (1/s). The wheel alone is accelerated
//! by (B₂ + B₃) I. The times are those that the claim states.

use std::f64::consts::FRAC_PI_3;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::certificate::hardware::CertifiedInertial;
use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::named_words::NamedWords;
use crate::claims::supervisor::second::MOST_COUNTED;
use crate::language::module::Module;

/// How far a word may be from its number: a unit, and a millionth for double precision.
const TOLERANCE: f64 = 1e-6;

/// Times in s: wheel speed unknown, a sensor clipped, no gravity.
pub(crate) const TIMES_S: [(&str, f64); 3] = [
    ("wheel_steps", 0.020),
    ("clipped_steps", 0.010),
    ("rejected_steps", 2.0),
];

/// Refresh periods over which the gyroscope's words may stand still.
const FROZEN_REFRESHES: f64 = 20.0;

/// Time of quiet samples that sets the attitude, s; the window is the nearest power of two of steps, from 2² to 2¹⁵.
const WINDOW_S: f64 = 0.25;
/// Exponents of the shortest and the longest window.
const WINDOW_SHIFTS: [f64; 2] = [2.0, 15.0];

fn word(words: &NamedWords, name: &str) -> Result<f64, String> {
    let word = words.get(&format!("LIMITS.{name}"))?;
    word.to_f64().ok_or_else(|| format!("{name} is too large"))
}

/// A word of LIMITS is its number.
pub(crate) fn near(words: &NamedWords, name: &str, wanted: f64) -> Result<(), String> {
    let found = word(words, name)?;
    if (found - wanted).abs() <= 1.0 + TOLERANCE * wanted.abs() {
        Ok(())
    } else {
        Err(format!(
            "LIMITS.{name} is {found}, but its stated number gives {wanted:.1}"
        ))
    }
}

/// A time as steps: at least two, at most what 16 bits count.
pub(super) fn steps(time_s: f64, period_s: f64) -> f64 {
    (time_s / period_s).clamp(2.0, MOST_COUNTED as f64)
}

/// A number of the certificate.
pub(crate) fn real(value: &BigRational) -> f64 {
    value.to_f64().unwrap_or(f64::NAN)
}

/// What the largest current does to the body.
pub(crate) struct LargestCurrent {
    /// The current, A.
    pub(crate) limit_a: f64,
    /// |B₂|, rad/s² per A.
    pub(crate) push: f64,
}

/// Checks the words that follow from the linear model alone, whatever shows the body: the angles and the rate, the time
/// at the current's limit, and the sample time.
///
/// # Errors
/// A sentence that names the word.
pub(crate) fn of_the_plant(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    words: &NamedWords,
) -> Result<LargestCurrent, String> {
    let near = |name: &str, wanted: f64| near(words, name, wanted);
    let period = real(&certificate.sample_time_s.value);
    let plant = &certificate.plant;
    let (fall, push, wheel) = (
        real(&plant.a[1][0].value),
        real(&plant.b[1].value),
        real(&plant.b[2].value),
    );
    let limit = certificate.constant("CURRENT_LIMIT");
    let limit_a = real(&limit.ok_or("there is no limit")?.real.value);
    let most = FRAC_PI_3.min(real(&certificate.inputs[0].range.value));
    let sine = push.abs() * limit_a / fall;
    let holding = if sine > 0.0 && sine.is_finite() {
        sine.min(0.99).asin()
    } else {
        most
    };
    let unit = |index: usize| 2f64.powi(law.state_bits[index] as i32);
    near("angle_trip", (2.0 * holding).min(most) * unit(0))?;
    near("angle_arm", holding.min(most) * unit(0))?;
    near("rate_arm", 0.25 * holding * fall.max(0.0).sqrt() * unit(1))?;
    let range = real(&certificate.inputs[2].range.value);
    let wheel_alone = (push + wheel).abs() * limit_a;
    near("saturated_steps", steps(range / wheel_alone, period))?;

    let micros = NamedWords::read(module, "SAMPLE_TIME_US")?.get("SAMPLE_TIME_US")?;
    if (real(&micros) - 1e6 * period).abs() > TOLERANCE {
        return Err(format!(
            "SAMPLE_TIME_US is {micros}, the sample time {period} s"
        ));
    }
    Ok(LargestCurrent {
        limit_a,
        push: push.abs(),
    })
}

/// Checks every word.
///
/// # Errors
/// A sentence that names the word.
pub(super) fn check(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    inertial: &CertifiedInertial,
) -> Result<(), String> {
    let words = NamedWords::read(module, "LIMITS")?;
    let word = |name: &str| word(&words, name);
    let near = |name: &str, wanted: f64| near(&words, name, wanted);
    let period = real(&certificate.sample_time_s.value);
    for (name, time_s) in TIMES_S {
        near(name, steps(time_s, period))?;
    }
    of_the_plant(certificate, module, law, &words)?;

    let refresh_s = certificate
        .gyro_rate_hz
        .as_ref()
        .map_or(period, |rate| 1.0 / real(&rate.value))
        .max(period);
    let frozen_s = FROZEN_REFRESHES * refresh_s;
    near("frozen_steps", steps(frozen_s, period))?;

    let window = word("window")?;
    let shift = word("window_shift")?;
    if window != 2f64.powf(shift) {
        return Err(format!("LIMITS.window is {window}, not 2^{shift}"));
    }
    let [least, most] = WINDOW_SHIFTS;
    let wanted = (WINDOW_S / period).log2().clamp(least, most);
    // Half a power of two, as the nearest one may be off, and a millionth for double precision.
    if (shift - wanted).abs() > 0.5 + TOLERANCE || !(least..=most).contains(&shift) {
        return Err(format!(
            "LIMITS.window is {window} steps: not about the {WINDOW_S} s of quiet samples that set the attitude"
        ));
    }
    near("quiet_turn", 0.3 * 0.5 * period * 2f64.powi(32))?;

    // Gravity in the accelerometer's units: the largest row of its matrix adds up to 2³⁰ in Q17.
    let rows = inertial.accelerometer.matrix.iter();
    let row = rows
        .map(|row| {
            row.iter()
                .map(|entry| real(&entry.value).abs())
                .sum::<f64>()
        })
        .fold(0.0, f64::max);
    let gravity = real(&inertial.gravity_m_s2.value) * 2f64.powi(13) / row;
    near("gravity_low", (0.85 * gravity).powi(2) / 2f64.powi(32))?;
    near("gravity_high", (1.15 * gravity).powi(2) / 2f64.powi(32))?;
    near("agreement", 0.1 * gravity)?;
    Ok(())
}
