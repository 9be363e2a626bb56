//! The position of the accelerometer relative to the pivot axis, from a free swing.
//!
//! At r = (x, y) the aligned accelerometer reads, across the pivot axis,
//!
//! a = g (cos β, −sin β) + α̈ (−y, x) − α̇² (x, y),   β = β₀ + ∫ α̇ dt,
//!
//! with g the length of gravity across the axis, as measured while hanging at rest, and
//! α̇ = (1 + s) ω + d from the gyroscope's ω. Gauss–Newton finds r together with β₀ and with the
//! remaining errors of the gyroscope's scale and bias, s and d. In a free swing, α̈ is proportional to sin α, nearly
//! as gravity is, so a wrong scale would otherwise look like a lever arm.
//!
//! ω and its derivative come from a cubic fitted over ±[`WINDOW_S`] around each sample (Savitzky
//! and Golay 1964). The noise that remains in the derivative shrinks r by its share of the variance of
//! α̈: with 10 mrad/s per sample at 1 kHz, by 4e-5 for a swing of 60°.
//!
//! Standard errors have two sources: the scores of [`BLOCKS`] stretches of the swing, so that slow residuals
//! are weighted correctly, and the standard errors of the accelerometer's calibration and of its
//! mean at rest, each propagated separately.

use crate::error::CalibrationError;
use crate::error::{at_least, positive};
use crate::mounting::Mounting;
use crate::sensor_calibration::SensorCalibration;
use attitude::{SensorLine, WORD_CLIP, is_saturated};
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

/// Half of the smoothing window, s. In this time, the phase of a swing of 10 rad/s changes by 0.2 rad, and the relative
/// error of a cubic is then below 1e-5.
const WINDOW_S: f64 = 0.02;

/// Number of stretches for the standard errors.
const BLOCKS: usize = 40;

/// β₀, s, d, x, y.
const UNKNOWNS: usize = 5;

/// Largest number of steps. The problem is nearly linear; four or five are usual.
const STEPS_MAX: usize = 30;

type Unknowns = SVector<f64, UNKNOWNS>;
type Moments = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// The position of the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArmEstimate {
    /// Position relative to the pivot axis, along x and y of the aligned sensor, m.
    pub position_m: [f64; 2],
    /// Standard errors, m.
    pub position_std_m: [f64; 2],
    /// Scale error s of the gyroscope about the pivot axis: the true rate is (1 + s) times
    /// the calibrated one.
    pub gyro_scale_error: f64,
    /// Standard error of the scale error.
    pub gyro_scale_error_std: f64,
    /// Standard deviation of the residual of the reading, m/s².
    pub residual_std_m_s2: f64,
}

/// One instant of the swing.
#[derive(Clone, Copy)]
struct Instant {
    time_s: f64,
    rate_rad_s: f64,
    acceleration_rad_s2: f64,
    /// ∫ω dt from the first instant, rad.
    turned_rad: f64,
    accel_counts: [i16; 3],
}

/// The lever arm from a swing (gyroscope and accelerometer, raw counts of the same instants) and
/// from hanging at rest (accelerometer). Readings of an accelerometer at its limit are left out.
///
/// # Errors
/// Too few samples; recordings of different length; a gyroscope at its limit; a swing that does not
/// determine the position.
pub fn lever_arm(
    swing: &[[i16; 3]],
    swing_accel: &[[i16; 3]],
    gyro: &SensorLine,
    hanging: &[[i16; 3]],
    accel: &SensorCalibration,
    mounting: &Mounting,
    sample_time_s: f64,
) -> Result<LeverArmEstimate, CalibrationError> {
    let period = positive("the sample time", sample_time_s)?;
    let half = ((WINDOW_S / period).round() as usize).max(2);
    at_least("samples of the swing", swing.len(), 2 * half + 10 * BLOCKS)?;
    at_least(
        "accelerometer samples of the swing",
        swing_accel.len(),
        swing.len(),
    )?;
    if swing.iter().any(|&raw| is_saturated(raw, WORD_CLIP)) {
        return Err(CalibrationError::NotDetermined {
            what: "the lever arm",
            why: "the swing goes beyond the gyroscope's range",
            cure: "record a smaller swing, or choose a larger range",
        });
    }
    let rates: Vec<f64> = swing
        .iter()
        .map(|&raw| (mounting.alignment * gyro.apply(raw)).z)
        .collect();
    let instants = instants(&rates, swing_accel, half, period);
    at_least(
        "accelerometer samples within range",
        instants.len(),
        10 * BLOCKS,
    )?;
    let rest = crate::still::still(hanging)?;

    let fit_with = |line: &SensorLine, rest: Vector3<f64>| -> Option<Fit> {
        let turn = mounting.alignment.matrix() * line.matrix;
        let across = |counts: Vector3<f64>| (turn * (counts - line.bias_counts)).xy();
        let gravity = across(rest).norm();
        let read: Vec<Vector2<f64>> = instants
            .iter()
            .map(|instant| across(instant.accel_counts.map(f64::from).into()))
            .collect();
        fit(&instants, &read, gravity)
    };
    let undetermined = CalibrationError::NotDetermined {
        what: "the lever arm",
        why: "the acceleration of the swing cannot be told from gravity",
        cure: "record a free swing from 45° or more, of 10 s or longer",
    };
    let Some(found) = fit_with(&accel.line, rest.mean) else {
        return Err(undetermined);
    };
    // Each uncertain number of calibration and rest is changed by its standard error.
    let mut moved = Vec::new();
    for axis in 0..3 {
        let mut line = accel.line;
        line.bias_counts[axis] += accel.bias_std[axis];
        moved.push((line, rest.mean));
        let mut at_rest = rest.mean;
        at_rest[axis] += rest.mean_std[axis];
        moved.push((accel.line, at_rest));
    }
    for (entry, std) in accel.matrix_std.iter().enumerate() {
        if *std > 0.0 {
            let mut line = accel.line;
            line.matrix[entry] += std;
            moved.push((line, rest.mean));
        }
    }
    let mut variance = found.variance;
    for (line, at_rest) in moved {
        let Some(other) = fit_with(&line, at_rest) else {
            return Err(undetermined);
        };
        let change = other.at - found.at;
        variance += change.component_mul(&change);
    }
    let std = variance.map(f64::sqrt);
    Ok(LeverArmEstimate {
        position_m: [found.at[3], found.at[4]],
        position_std_m: [std[3], std[4]],
        gyro_scale_error: found.at[1],
        gyro_scale_error_std: std[1],
        residual_std_m_s2: found.residual_std,
    })
}

/// The instants that have a complete window and an accelerometer reading within its range.
fn instants(rates: &[f64], accel: &[[i16; 3]], half: usize, period: f64) -> Vec<Instant> {
    // Sums over the window of j², j⁴ and j⁶, j = −half … half.
    let sum = |power: i32| 2.0 * (1..=half).map(|j| (j as f64).powi(power)).sum::<f64>();
    let (count, s2, s4, s6) = ((2 * half + 1) as f64, sum(2), sum(4), sum(6));
    let mut turned_rad = 0.0;
    let mut found = Vec::new();
    for (index, window) in rates.windows(2 * half + 1).enumerate() {
        let moment = |power: i32| -> f64 {
            (window.iter().enumerate())
                .map(|(k, rate)| rate * (k as f64 - half as f64).powi(power))
                .sum()
        };
        let middle = index + half;
        if index > 0 {
            turned_rad += 0.5 * (rates[middle - 1] + rates[middle]) * period;
        }
        if is_saturated(accel[middle], WORD_CLIP) {
            continue;
        }
        found.push(Instant {
            time_s: index as f64 * period,
            rate_rad_s: (s4 * moment(0) - s2 * moment(2)) / (count * s4 - s2 * s2),
            acceleration_rad_s2: (s6 * moment(1) - s4 * moment(3)) / (s2 * s6 - s4 * s4) / period,
            turned_rad,
            accel_counts: accel[middle],
        });
    }
    found
}

/// A finished fit.
struct Fit {
    at: Unknowns,
    variance: Unknowns,
    residual_std: f64,
}

/// Gauss–Newton from the β₀ of the first readings; `None` if it does not converge or the problem is
/// singular.
fn fit(instants: &[Instant], read: &[Vector2<f64>], gravity: f64) -> Option<Fit> {
    // Without a lever arm, the reading points up; β₀ is the mean of the upward directions, each rotated back.
    let back = |(instant, read): (&Instant, &Vector2<f64>)| {
        let (sin, cos) = instant.turned_rad.sin_cos();
        Vector2::new(cos * read.x - sin * read.y, sin * read.x + cos * read.y)
    };
    let start: Vector2<f64> = instants.iter().zip(read).map(back).sum();
    let mut at = Unknowns::zeros();
    at[0] = (-start.y).atan2(start.x);

    let mut previous = f64::INFINITY;
    for _ in 0..STEPS_MAX {
        let mut normal = Moments::zeros();
        let mut score = Unknowns::zeros();
        let mut squares = 0.0;
        for (instant, read) in instants.iter().zip(read) {
            let (residual, slopes) = linearised(instant, read, gravity, &at);
            normal += slopes * slopes.transpose();
            score += slopes * residual;
            squares += residual.norm_squared();
        }
        let factor = normal.cholesky()?;
        let step = factor.solve(&score);
        at += step;
        if (previous - squares).abs() <= 1e-12 * squares {
            return finished(instants, read, gravity, &at, &factor.inverse());
        }
        previous = squares;
    }
    None
}

/// The residual of one reading and the derivatives of the model, one row per unknown.
fn linearised(
    instant: &Instant,
    read: &Vector2<f64>,
    gravity: f64,
    at: &Unknowns,
) -> (Vector2<f64>, SMatrix<f64, UNKNOWNS, 2>) {
    let [start, scale, bias, x, y] = [at[0], at[1], at[2], at[3], at[4]];
    let rate = (1.0 + scale) * instant.rate_rad_s + bias;
    let acceleration = (1.0 + scale) * instant.acceleration_rad_s2;
    let beta = start + (1.0 + scale) * instant.turned_rad + bias * instant.time_s;
    let (sin, cos) = beta.sin_cos();
    let squared = rate * rate;
    let model = Vector2::new(
        gravity * cos - acceleration * y - squared * x,
        -gravity * sin + acceleration * x - squared * y,
    );
    let by_angle = Vector2::new(-gravity * sin, -gravity * cos);
    let by_rate = Vector2::new(-2.0 * rate * x, -2.0 * rate * y);
    let by_acceleration = Vector2::new(-y, x);
    let rows = [
        by_angle,
        by_angle * instant.turned_rad
            + by_rate * instant.rate_rad_s
            + by_acceleration * instant.acceleration_rad_s2,
        by_angle * instant.time_s + by_rate,
        Vector2::new(-squared, acceleration),
        Vector2::new(-acceleration, -squared),
    ];
    let slopes = SMatrix::from_fn(|row, column| rows[row][column]);
    (read - model, slopes)
}

/// Covariance: the scores of [`BLOCKS`] stretches between two inverse normal matrices (sandwich estimator).
fn finished(
    instants: &[Instant],
    read: &[Vector2<f64>],
    gravity: f64,
    at: &Unknowns,
    inverse: &Moments,
) -> Option<Fit> {
    let length = instants.len().div_ceil(BLOCKS);
    let mut scatter = Moments::zeros();
    let mut squares = 0.0;
    let stretches = instants.chunks(length).zip(read.chunks(length));
    for (instants, read) in stretches {
        let mut score = Unknowns::zeros();
        for (instant, read) in instants.iter().zip(read) {
            let (residual, slopes) = linearised(instant, read, gravity, at);
            score += slopes * residual;
            squares += residual.norm_squared();
        }
        scatter += score * score.transpose();
    }
    // At the minimum, the scores of all stretches sum to zero for every unknown.
    let blocks = BLOCKS as f64;
    let enlarged = scatter * (blocks / (blocks - UNKNOWNS as f64));
    let variance = (inverse * enlarged * inverse).diagonal();
    let freedom = (2 * instants.len() - UNKNOWNS) as f64;
    let is_finite = variance.iter().chain(at.iter()).all(|v| v.is_finite());
    is_finite.then(|| Fit {
        at: *at,
        variance,
        residual_std: (squares / freedom).sqrt(),
    })
}
