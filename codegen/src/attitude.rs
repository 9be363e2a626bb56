//! The attitude filter's constants: from the real numbers of calibration and mounting to words.
//!
//! The documentation of each field of [`FilterConstants`] states its format. Here the numbers are rounded to that
//! format once, or refused if they do not fit.

use attitude::{AttitudeSpec, GRAVITY_SHARE_MIN, RATE_LAG_STEPS, wrap_angle};
use nalgebra::Matrix3;

use crate::helpers::calibration::SensorLine;
use crate::helpers::drift::DriftGain;
use crate::helpers::filter::FilterConstants;
use crate::helpers::lever_arm::LeverArm;

/// The reason why the filter cannot be built from these numbers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AttitudeRefusal {
    /// A quantity is NaN or infinite, or not positive although it must be.
    #[error("{what} is {value}: a finite number greater than zero is needed")]
    NotPositive {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A quantity is too large for its format.
    #[error(
        "{what} is {value} {unit}, more than the {limit} {unit} that the filter can hold; {cure}"
    )]
    TooLarge {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The largest value that fits.
        limit: f64,
        /// Unit of both.
        unit: &'static str,
        /// The remedy.
        cure: &'static str,
    },
    /// The sample time is no whole number of microseconds.
    #[error(
        "the sample time is {sample_time_s} s: a timer of the firmware needs whole microseconds, at least 10 and at most a second"
    )]
    SampleTime {
        /// The sample time, s.
        sample_time_s: f64,
    },
    /// A straight line between words, or the observer, does not fit into its words.
    #[error(
        "{what}: {value} cannot be brought into 32-bit words; check its unit and the stated ranges"
    )]
    NoLine {
        /// The line.
        what: &'static str,
        /// The number that does not fit.
        value: f64,
    },
}

/// Largest β T: 2⁻⁸. With the largest half-angles, the length of q then stays within 1e-4 of 1.
const BETA_STEP_MAX: f64 = 1.0 / 256.0;

/// Sum of the magnitudes in a row of the accelerometer's and magnetometer's matrix, in Q17 units
/// per count: the range of ±32768 counts becomes ±2²⁸ units.
const ROW_SUM: f64 = (1u64 << 30) as f64;

/// Largest sum of the magnitudes in a row of the gyroscope's matrix, in the same units.
const ROW_SUM_MAX: f64 = 1.5 * ROW_SUM;

/// Largest bias, counts.
const BIAS_MAX: f64 = 8192.0;

/// The words of the filter for `spec`.
///
/// # Errors
/// [`AttitudeRefusal`] for numbers that are not finite, not positive where they must be, or too
/// large for their format.
pub fn derive(spec: &AttitudeSpec) -> Result<FilterConstants, AttitudeRefusal> {
    let period = positive("the sample time", spec.sample_time_s)?;
    let gravity = positive("gravity", spec.gravity_m_s2)?;
    let field_min = positive("the weakest usable field", spec.field_min_ut)?;
    let beta_step = at_most(
        "beta times the sample time",
        positive("beta", spec.beta_rad_s)? * period,
        BETA_STEP_MAX,
        "rad",
        "lower beta",
    )?;

    let half_angle = spec.gyro.matrix * (0.5 * period * 2f64.powi(32 + 17));
    let sum = at_most(
        "the gyroscope's scale times half the sample time",
        positive("the gyroscope's scale", row_sum(&half_angle))? / 2f64.powi(49),
        ROW_SUM_MAX / 2f64.powi(49),
        "rad per count",
        "shorten the sample time or choose a smaller range",
    )?;
    // The words have as many additional bits as fit, so that rounding down three products has no effect.
    let shift = (ROW_SUM_MAX / 2f64.powi(49) / sum).log2().floor().min(16.0) as u32;
    let accel_unit = ROW_SUM / positive("the accelerometer's scale", row_sum(&spec.accel.matrix))?;
    let mag_unit = ROW_SUM / positive("the magnetometer's scale", row_sum(&spec.mag.matrix))?;

    // Units per m/s², the Q17 of the matrix taken off.
    let per_m_s2 = accel_unit / 2f64.powi(17);
    // ω² = (2h/T)² and α̈ = 2e/(N T²) for words h and e in Q32; the products are in Q16.
    let centripetal = 4.0 / (period * period) * per_m_s2 * 2f64.powi(16 - 32);
    let tangential = 2.0 / (RATE_LAG_STEPS * period * period) * per_m_s2 * 2f64.powi(16 - 32);
    let arm = |per_metre: f64| -> Result<[i32; 2], AttitudeRefusal> {
        let word = |lever: f64| {
            let limit = f64::from(i32::MAX) / per_metre;
            at_most(
                "the lever arm",
                lever,
                limit,
                "m",
                "mount the sensor nearer to the pivot",
            )
            .map(|lever| (lever * per_metre).round() as i32)
        };
        Ok([word(spec.lever_arm_m[0])?, word(spec.lever_arm_m[1])?])
    };

    let drift_time = positive("the time in which a drift is followed", spec.drift_time_s)?;
    let drift_limit = positive("the largest drift", spec.drift_limit_rad_s)? * 0.5 * period;
    // The drift's word has as many additional bits as its largest value leaves room for.
    let drift_shift = (30.0 - (drift_limit * 2f64.powi(32)).log2())
        .floor()
        .clamp(0.0, 14.0);
    let drift_gain = at_most(
        "the share of a drift that a step follows",
        period / drift_time,
        f64::from(i32::MAX) / 2f64.powf(28.0 + drift_shift),
        "of it",
        "choose a longer time constant for the drift",
    )? * 2f64.powf(28.0 + drift_shift);
    let drift_word = (drift_limit * 2f64.powf(32.0 + drift_shift)).min(2f64.powi(30));

    Ok(FilterConstants {
        drift: DriftGain {
            gain: drift_gain.round() as i32,
            shift: drift_shift as u32,
            limit: drift_word.floor() as i32,
        },
        gyro: line("the gyroscope's bias", &spec.gyro, &half_angle, shift)?,
        accel: line(
            "the accelerometer's bias",
            &spec.accel,
            &(spec.accel.matrix * accel_unit),
            0,
        )?,
        mag: line(
            "the magnetometer's bias",
            &spec.mag,
            &(spec.mag.matrix * mag_unit),
            0,
        )?,
        gravity_squared_min: squared_word(GRAVITY_SHARE_MIN * gravity * per_m_s2),
        field_squared_min: squared_word(field_min * mag_unit / 2f64.powi(17)),
        lever_arm: LeverArm {
            centripetal: arm(centripetal)?,
            tangential: arm(tangential)?,
        },
        beta: (beta_step * 2f64.powi(35)).round() as i32,
        accel_clip: spec.accel_clip,
        mag_clip: spec.mag_clip,
    })
}

/// The mounting angle in Q28 radians within ±π.
///
/// # Errors
/// [`AttitudeRefusal`] if it is not finite.
pub fn mounting_word(mounting_angle_rad: f64) -> Result<i32, AttitudeRefusal> {
    at_most(
        "the mounting angle",
        mounting_angle_rad,
        1e6,
        "rad",
        "state it within a turn",
    )?;
    Ok((wrap_angle(mounting_angle_rad) * 2f64.powi(28)).round() as i32)
}

/// A squared length in units of 2³², at least one.
fn squared_word(length: f64) -> i32 {
    ((length * length / 2f64.powi(32)).round() as i32).max(1)
}

fn line(
    what: &'static str,
    line: &attitude::SensorLine,
    matrix: &Matrix3<f64>,
    shift: u32,
) -> Result<SensorLine, AttitudeRefusal> {
    let mut bias = [0; 3];
    for (word, counts) in bias.iter_mut().zip(line.bias_counts.iter()) {
        let counts = at_most(
            what,
            *counts,
            BIAS_MAX,
            "counts",
            "calibrate the sensor again",
        )?;
        *word = (counts * 32_768.0).round() as i32;
    }
    let mut rows = [[0; 3]; 3];
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, word) in row.iter_mut().enumerate() {
            *word = (matrix[(i, j)] * f64::from(1u32 << shift)).round() as i32;
        }
    }
    let [x, y, z] = rows;
    Ok(SensorLine {
        bias,
        x,
        y,
        z,
        shift,
        half_unit: ((1 << shift) >> 1) + 1,
    })
}

/// Largest sum of magnitudes in a row.
fn row_sum(matrix: &Matrix3<f64>) -> f64 {
    matrix
        .row_iter()
        .map(|row| row.iter().map(|entry| entry.abs()).sum())
        .fold(
            0.0,
            |a: f64, b: f64| if b > a || b.is_nan() { b } else { a },
        )
}

fn positive(what: &'static str, value: f64) -> Result<f64, AttitudeRefusal> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(AttitudeRefusal::NotPositive { what, value })
    }
}

/// `value` if its magnitude is at most `limit`; NaN is not.
fn at_most(
    what: &'static str,
    value: f64,
    limit: f64,
    unit: &'static str,
    cure: &'static str,
) -> Result<f64, AttitudeRefusal> {
    if value.abs() <= limit {
        Ok(value)
    } else {
        Err(AttitudeRefusal::TooLarge {
            what,
            value,
            limit,
            unit,
            cure,
        })
    }
}
