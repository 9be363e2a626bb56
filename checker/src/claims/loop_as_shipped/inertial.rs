//! The errors of gyroscope, accelerometer and filter.
//!
//! **Filter.** v̂ is the direction up that the filter believes, v the true one, both seen from the sensor. A step first
//! turns v̂ by the gyroscope's reading, with an error of at most δ. Then it turns v̂ by c along the great circle
//! towards the direction a that the accelerometer shows. c is at most C = 2βT, and at least 2/3 of it: the gradient's
//! part along the quaternion itself is no longer than the part that turns (a factor of 1/√2), and the rest is slack.
//! Let ∠(a, v) ≤ η, E = ∠(v̂, v), and φ the angle at v̂ between the ways to v and to a, sin φ ≤ η/E. A triangle on a
//! sphere is no longer than in the plane, so after the turn
//!
//! E' ≤ E − c cos φ + c² sin² φ/(2 (E − c cos φ)),
//!
//! which for E ≥ 2C is below E − δ where cos φ − (C/η) sin³ φ > δ/c, or where 1 − 3/2 sin² φ > δ/c. So above
//! E* = max(2C, η/s), s = √(1 − (δ/c + C/η)²) or √(2/3 (1 − δ/c)), E falls, and from below a step leads at most to
//! E* + C + δ. The window of quiet samples sets v̂ = a at the start. The angle about the pivot is off by no more than E.
//! Where δ ≥ 2/3 C nothing closes.
//!
//! **Drift.** In one step the drift that the filter follows moves by at most 2βT over its time constant. The claim
//! assumes that little drift remains, which is plausible only if the filter follows it slowly: with a time constant
//! below 20 s the claim is not settled.
//!
//! **Gyroscope.** Its reading may be as old as the time between its samples. The rate is then off by the acceleration
//! times that age, and the turn of a step by the acceleration times T times the larger of half a step and the age less
//! half a step.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::hardware::{CertifiedInertial, CertifiedSensor};
use crate::certificate::reader::{Certificate, matrix};
use crate::claims::loop_as_shipped::NoBounds;
use crate::exact::matrices::inverse;
use crate::exact::rational::{half, integer, power, root_above, root_below, short_above as up};

/// Bounds of a motion that enter the errors: the body's acceleration and rate, between samples too.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionBounds {
    /// rad/s².
    pub acceleration: BigRational,
    /// rad/s.
    pub rate: BigRational,
}

impl MotionBounds {
    /// Nothing moves.
    #[must_use]
    pub fn still() -> MotionBounds {
        MotionBounds {
            acceleration: BigRational::zero(),
            rate: BigRational::zero(),
        }
    }
}

/// Error of the filter's arithmetic in a step (rad): 2e-7 in each of four components (`filter-accurate`), twice that as
/// an angle, and the same again for the rounding of the normalisation.
fn arithmetic() -> BigRational {
    integer(16) * power(10, -7)
}

/// Error of the arc tangent and of the words of the angle (rad; `filter-accurate`).
fn angle_arithmetic() -> BigRational {
    integer(1) * power(10, -6)
}

/// Shortest time constant of the followed drift (s): in the second that a motion lasts, the drift then moves by no more
/// than a twentieth of 2β.
const FASTEST_DRIFT_S: i128 = 20;

/// Drift of the gyroscope that may remain, as a share of 2β.
fn drift_share() -> BigRational {
    BigRational::new(1.into(), 20.into())
}

/// The errors that gyroscope and accelerometer may have, and the errors of the filter that follow from them.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialErrors {
    /// Of an axis of the gyroscope (rad/s).
    pub gyro_axis: BigRational,
    /// Of its three axes together.
    pub gyro: BigRational,
    /// Of an axis of the accelerometer (m/s²).
    pub accel_axis: BigRational,
    /// Of its three axes together.
    pub accel: BigRational,
    /// Drift of the gyroscope that is left (rad/s).
    pub drift: BigRational,
    /// Age of a reading of the gyroscope (s).
    pub age: BigRational,
    /// Largest rate about the pivot that no axis of the gyroscope clips (rad/s).
    pub rate_range: BigRational,
    accel_range: BigRational,
    gravity: BigRational,
    lever: BigRational,
    t: BigRational,
    turn: BigRational,
}

impl InertialErrors {
    /// The errors that follow from reading errors of this number of resolution `steps`; with `with_drift` the gyroscope
    /// also drifts.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of(
        certificate: &Certificate,
        hardware: &CertifiedInertial,
        steps: &BigRational,
        with_drift: bool,
    ) -> Result<InertialErrors, NoBounds> {
        let both = |sensor: &CertifiedSensor| {
            let axes = [0, 1, 2].map(|row| sensor.step(row) * steps);
            let squares: BigRational = axes.iter().map(|axis| axis * axis).sum();
            let together = root_above(&squares).unwrap_or_default();
            (axes.into_iter().max().unwrap_or_default(), together)
        };
        let (gyro_axis, gyro) = both(&hardware.gyroscope);
        let (accel_axis, accel) = both(&hardware.accelerometer);
        let beta = &hardware.beta_rad_s.value;
        if !beta.is_positive() {
            return Err(NoBounds::Unphysical("the filter never corrects".to_owned()));
        }
        if hardware.drift_time_s.value < integer(FASTEST_DRIFT_S) {
            return Err(NoBounds::NotShown(format!(
                "the gyroscope's drift is followed within {} s: so fast that it follows the correction's ripple",
                hardware.drift_time_s
            )));
        }
        let singular = || NoBounds::Unphysical("a sensor's matrix is singular".to_owned());
        let counts =
            |sensor: &CertifiedSensor| inverse(&matrix(&sensor.matrix)).ok_or_else(singular);
        let (of_gyro, of_accel) = (
            counts(&hardware.gyroscope)?,
            counts(&hardware.accelerometer)?,
        );
        let least = |ranges: Vec<BigRational>| ranges.into_iter().min().unwrap_or_default();
        let room = |sensor: &CertifiedSensor, axis: usize| {
            let bias = sensor.bias_counts[axis].value.abs();
            integer(sensor.clip_counts[axis].into()) - bias - steps * integer(16)
        };
        let rate_range = least(
            (0..3)
                .filter(|axis| !of_gyro[*axis][2].is_zero())
                .map(|axis| room(&hardware.gyroscope, axis) / of_gyro[axis][2].abs())
                .collect(),
        );
        let accel_range = least(
            (0..3)
                .map(|axis| {
                    let row = &of_accel[axis];
                    let squares: BigRational = row.iter().map(|entry| entry * entry).sum();
                    room(&hardware.accelerometer, axis)
                        / root_above(&squares).unwrap_or_else(BigRational::one)
                })
                .collect(),
        );
        let t = certificate.sample_time_s.value.clone();
        let age = match &certificate.gyro_rate_hz {
            Some(rate) if rate.value.is_positive() => rate.value.recip(),
            _ => BigRational::zero(),
        };
        let squares: BigRational = hardware
            .lever_arm_m
            .iter()
            .map(|part| &part.value * &part.value)
            .sum();
        Ok(InertialErrors {
            gyro_axis: up(gyro_axis),
            gyro: up(gyro),
            accel_axis: up(accel_axis),
            accel: up(accel),
            drift: if with_drift {
                up(integer(2) * beta * drift_share())
            } else {
                BigRational::zero()
            },
            age: up(age),
            rate_range,
            accel_range,
            gravity: hardware.gravity_m_s2.value.clone(),
            lever: up(root_above(&squares).unwrap_or_default()),
            turn: integer(2) * beta * &t,
            t,
        })
    }

    /// E: largest error of the filter's direction (rad).
    ///
    /// # Errors
    /// [`NoBounds::NotShown`] if the correction of the filter is not faster than its disturbances.
    pub fn filter(&self, motion: &MotionBounds) -> Result<BigRational, NoBounds> {
        let not_shown = |why: &str| NoBounds::NotShown(why.to_owned());
        // The correction for the lever arm lags. It therefore does not reduce the error in this bound, and may add an
        // error of the same size.
        let moved = integer(2)
            * &self.lever
            * (&motion.acceleration * integer(2) + &motion.rate * &motion.rate)
            + &self.lever * &self.gyro / &self.t;
        let off = up(&self.accel + moved);
        if integer(2) * &off >= self.gravity {
            return Err(not_shown(
                "at the accelerometer the motion is as large as gravity: its lever arm is too long for the argument",
            ));
        }
        if &self.gravity + &off >= self.accel_range {
            return Err(not_shown(
                "the accelerometer may come to the end of its range",
            ));
        }
        // asin x ≤ x/(1 − x); a hundredth for sin η/sin E above η/E, E below a quarter of a radian.
        let direction =
            up(&off / (&self.gravity - &off) * BigRational::new(101.into(), 100.into()));
        let half_step = &self.t * half();
        let old = if self.age > self.t {
            &self.age - &half_step
        } else {
            half_step
        };
        let step =
            up(&self.t * (&self.gyro + &self.drift + &motion.acceleration * old) + arithmetic());
        let least = &self.turn * BigRational::new(2.into(), 3.into());
        let share = up(&step / least);
        let one = BigRational::one();
        if share >= one {
            return Err(not_shown(
                "drift and age of the gyroscope may turn the estimate faster than the filter's beta turns it back",
            ));
        }
        // Two bounds of the largest sin φ = η/E at which a turn still outweighs the disturbances; the first is the
        // better one if the turn of a step is short compared with η.
        let first = up(&share + &self.turn / &direction);
        let mut squared = (&one - &share) * BigRational::new(2.into(), 3.into());
        if first < one {
            squared = squared.max(&one - &first * &first);
        }
        let root = root_below(&squared).ok_or_else(|| not_shown("a negative square"))?;
        if !root.is_positive() {
            return Err(not_shown("the filter's correction is too slow"));
        }
        let settled = (direction / root).max(&self.turn * integer(2));
        Ok(up(settled + &self.turn + step + angle_arithmetic()))
    }

    /// The error of the rate, before it becomes a word (rad/s).
    pub fn rate(&self, motion: &MotionBounds) -> BigRational {
        &self.gyro_axis + &self.drift + &self.age * &motion.acceleration
    }
}
