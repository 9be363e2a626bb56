//! The error of the command from sensors, words and duty.
//!
//! A reading is off by at most half a resolution step, and noise adds at most one whole step. The
//! resolution step of left-justified counts is the largest power of two that divides every count at which the sensor
//! clips.
//!
//! Gyroscope and accelerometer show angle and rate by a filter ([`crate::claims::loop_as_shipped::inertial`]).
//!
//! **Encoder on the pivot.** It shows the angle y, and (y(k) − y(k − M))/(M T) as the rate. Since the loop has the
//! shown angles among its states, one error is left: that of the newest reading. Its immediate effect is kept apart
//! from all other errors of the command, whose course over time is not known
//! ([`crate::claims::loop_as_shipped::layout`]).
//!
//! **Observer of the angle's bias.** It knows the command with all its errors. So the errors of what is shown, of the
//! command and of the observer's own state are inputs of one sample each, as that of the encoder's reading is, and
//! only what the drive adds to the command is left to the errors whose course is not known
//! ([`SensorErrors::of_sample`]).
//!
//! **Ends of the sensors.** If a bound on an angle, a rate, an acceleration or the wheel speed lies beyond the range of its
//! sensor, the claim is not settled.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::hardware::{CertifiedBody, CertifiedBodyEncoder, CertifiedInertial};
use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::emitted_observer::EmittedObserver;
use crate::claims::held_loop::{back_emf, held_gains};
use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::inertial::{InertialErrors, MotionBounds};
use crate::exact::rational::{half, integer, power_of_two, short_above as up};

/// The errors that the sensors may have.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorErrors {
    /// Of what shows the body.
    pub body: BodyErrors,
    /// Error of the newest reading of an encoder on the pivot (rad); zero without one.
    pub reading: BigRational,
    /// Error of the encoder's readings while the body is at rest, before the controller is armed: half a count (rad).
    pub at_rest: BigRational,
    /// Of the wheel's speed (rad/s).
    pub wheel_speed: BigRational,
    /// Error of the held current by the rounding of words, sum and duty (A).
    pub rounding: BigRational,
    /// Error of the requested current by the rounding of words and sum (A).
    pub asked_rounding: BigRational,
    /// Half-words of the rate (rad/s).
    pub rate_word: BigRational,
    /// The errors of an observer of the angle's bias; `None` without one.
    pub observer: Option<ObserverErrors>,
    /// Largest wheel speed that its sensor shows in both directions (rad/s).
    pub wheel_range: BigRational,
    /// Of what the drive holds.
    held: [BigRational; 3],
    /// Of the current that the law asks for.
    asked: [BigRational; 3],
}

/// The errors of an observer of the angle's bias.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverErrors {
    /// Words of the states (their units).
    pub words: [BigRational; 3],
    /// Of the command: the rounding of its sum and of the estimate (A).
    pub command: BigRational,
    /// Of the estimate by the rounding to a word (rad).
    pub estimate: BigRational,
    /// Largest estimate (rad).
    pub limit: BigRational,
}

impl ObserverErrors {
    fn of(certificate: &Certificate, law: &EmittedLaw) -> Option<ObserverErrors> {
        let stated = certificate.bias_observer.as_ref()?;
        let [half_word, _, _] = law.half_words();
        Some(ObserverErrors {
            words: law.half_words().map(|word| word * integer(2)),
            command: law.unit() + law.gains[0].abs() * &half_word,
            // The limit is a word too.
            limit: &stated.limit_rad.value - &half_word,
            estimate: half_word,
        })
    }
}

/// The errors of what shows the body.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyErrors {
    /// Gyroscope and accelerometer.
    Inertial(Box<InertialErrors>),
    /// An encoder on the pivot.
    Pivot(PivotErrors),
    /// Angle and rate as they are, to the nearest step of a reading.
    Counts(CountErrors),
}

/// The errors of an angle and a rate that are measured directly, to half a step of accelerometer and gyroscope.
#[derive(Clone, Debug, PartialEq)]
pub struct CountErrors {
    /// Of the angle (rad).
    pub angle: BigRational,
    /// Of the rate, before it becomes a word (rad/s).
    pub rate: BigRational,
    /// The ends of both words.
    pub ranges: [BigRational; 2],
}

impl CountErrors {
    fn of(certificate: &Certificate, inertial: &CertifiedInertial) -> CountErrors {
        CountErrors {
            angle: up(inertial.angle_step() * half()),
            rate: up(inertial.rate_step() * half()),
            ranges: [0, 1].map(|index| certificate.inputs[index].range.value.clone()),
        }
    }
}

/// The errors of an encoder on the pivot.
#[derive(Clone, Debug, PartialEq)]
pub struct PivotErrors {
    /// Error of the rate from two readings, before the rate becomes a word (rad/s).
    pub rate: BigRational,
    /// Largest angle that is shown as it is (rad).
    pub angle_range: BigRational,
    /// Largest rate that is shown correctly (rad/s). Beyond it lies the end of the rate's word, or half a wrap in a
    /// step.
    pub rate_range: BigRational,
}

/// π, from above and from below.
fn pi() -> [BigRational; 2] {
    let ratio = |above: i32, below: i32| BigRational::new(above.into(), below.into());
    [ratio(355, 113), ratio(333, 106)]
}

impl PivotErrors {
    /// The errors that follow from readings with an error of this number of counts, and the error of one reading (rad).
    fn of(
        certificate: &Certificate,
        encoder: &CertifiedBodyEncoder,
        counts: &BigRational,
    ) -> (PivotErrors, BigRational) {
        let [above, below] = pi().map(|pi| integer(2) * pi / encoder.counts_per_turn.value.abs());
        let reading = up(counts * above);
        let t = &certificate.sample_time_s.value;
        let half_wrap = below * power_of_two(encoder.bits as i32 - 1);
        let range = |index: usize| certificate.inputs[index].range.value.clone();
        let both = integer(2) * &reading;
        let errors = PivotErrors {
            rate: up(&both / (integer(encoder.window.into()) * t)),
            angle_range: half_wrap.clone().min(range(0)) - &reading,
            rate_range: ((half_wrap - both) / t).min(range(1)),
        };
        (errors, reading)
    }
}

impl SensorErrors {
    /// The errors of the sensors of a certificate: those of rounding, and with `with_noise` also one resolution step of
    /// noise and a drift.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of(
        certificate: &Certificate,
        law: &EmittedLaw,
        with_noise: bool,
    ) -> Result<SensorErrors, NoBounds> {
        let hardware = &certificate.hardware;
        let steps = if with_noise {
            half() + integer(1)
        } else {
            half()
        };
        let (body, reading) = match &hardware.body {
            CertifiedBody::Inertial(inertial) => {
                let errors = InertialErrors::of(certificate, inertial, &steps, with_noise)?;
                (BodyErrors::Inertial(Box::new(errors)), BigRational::zero())
            }
            CertifiedBody::Encoder(encoder) => {
                let (errors, reading) = PivotErrors::of(certificate, encoder, &steps);
                (BodyErrors::Pivot(errors), reading)
            }
        };
        let wheel = &hardware.wheel_speed;
        let end = |counts: i32| {
            &wheel.rad_s_per_count.value * integer(counts.into()) + &wheel.rad_s_at_zero.value
        };
        let (first, last) = (end(wheel.low_counts), end(wheel.high_counts));
        let wheel_range = if first.is_negative() == last.is_negative() {
            BigRational::zero()
        } else {
            first.abs().min(last.abs())
        };
        let words = law.half_words();
        let count = certificate.drive.amperes_per_count.value.abs();
        // Half a count, and a hundredth of a count for the words of the duty's line.
        let duty = count * BigRational::new(51.into(), 100.into());
        let asked = law.of_readings();
        let observer = ObserverErrors::of(certificate, law);
        let held = held_gains(&asked, &back_emf(certificate));
        // The words of angle, rate and wheel speed are rounded, some of them down: the error is up to a whole unit.
        let in_words = |gains: &[BigRational; 3]| -> BigRational {
            let both = gains.iter().zip(&words);
            both.map(|(gain, word)| gain.abs() * word * integer(2))
                .sum()
        };
        // A reading has an error of half a count and the noise. An encoder's turn is the difference of two readings.
        let readings = integer(if wheel.encoder.is_some() { 2 } else { 1 });
        Ok(SensorErrors {
            body,
            at_rest: up(&reading * half() / &steps),
            reading,
            wheel_speed: up(wheel.rad_s_per_count.value.abs() * &steps * readings),
            rounding: match observer {
                None => up(in_words(&held) + law.unit() + duty),
                Some(_) => up(duty),
            },
            asked_rounding: match observer {
                None => in_words(&asked) + law.unit(),
                Some(_) => BigRational::zero(),
            },
            observer,
            rate_word: &words[1] * integer(2),
            wheel_range,
            held,
            asked,
        })
    }

    /// Those of sensors that return the nearest count, the angle being measured directly and not by a filter.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of_counts(
        certificate: &Certificate,
        law: &EmittedLaw,
    ) -> Result<SensorErrors, NoBounds> {
        let errors = SensorErrors::of(certificate, law, false)?;
        Ok(match certificate.hardware.inertial() {
            None => errors,
            Some(inertial) => SensorErrors {
                body: BodyErrors::Counts(CountErrors::of(certificate, inertial)),
                ..errors
            },
        })
    }

    /// Those of gyroscope and accelerometer; `None` where an encoder shows the body.
    pub fn inertial(&self) -> Option<&InertialErrors> {
        match &self.body {
            BodyErrors::Inertial(errors) => Some(errors),
            BodyErrors::Pivot(_) | BodyErrors::Counts(_) => None,
        }
    }

    /// Largest error of the shown angle (rad).
    ///
    /// # Errors
    /// [`NoBounds::NotShown`] if the correction of the filter is not faster than its disturbances.
    pub fn angle(&self, motion: &MotionBounds) -> Result<BigRational, NoBounds> {
        match &self.body {
            BodyErrors::Inertial(errors) => errors.filter(motion),
            BodyErrors::Pivot(_) => Ok(self.reading.clone()),
            BodyErrors::Counts(errors) => Ok(errors.angle.clone()),
        }
    }

    /// ν: the error of the held current (A) during such a motion. It contains all causes except the drive itself and
    /// the inputs of one sample ([`SensorErrors::of_sample`]).
    ///
    /// # Errors
    /// As [`SensorErrors::angle`].
    pub fn held(&self, motion: &MotionBounds) -> Result<BigRational, NoBounds> {
        Ok(self.weighted(&self.held, motion)? + &self.rounding)
    }

    /// The error of the requested current (A), with the same exceptions.
    ///
    /// # Errors
    /// As [`SensorErrors::angle`].
    pub fn asked(&self, motion: &MotionBounds) -> Result<BigRational, NoBounds> {
        Ok(self.weighted(&self.asked, motion)? + &self.asked_rounding)
    }

    fn weighted(
        &self,
        gains: &[BigRational; 3],
        motion: &MotionBounds,
    ) -> Result<BigRational, NoBounds> {
        if self.observer.is_some() {
            return Ok(BigRational::zero());
        }
        let [n1, n2, n3] = gains;
        let wheel = n3.abs() * &self.wheel_speed;
        if let BodyErrors::Pivot(_) = &self.body {
            return Ok(up(wheel));
        }
        let (angle, rate) = (self.angle(motion)?, self.rate(motion));
        Ok(up(n1.abs() * angle + n2.abs() * rate + wheel))
    }

    /// The sizes of the inputs of one sample ([`crate::claims::loop_as_shipped::plant::Loop::readings`]).
    ///
    /// # Errors
    /// As [`SensorErrors::angle`].
    pub fn of_sample(&self, motion: &MotionBounds) -> Result<Vec<BigRational>, NoBounds> {
        if let BodyErrors::Pivot(_) = &self.body {
            return Ok(vec![self.reading.clone()]);
        }
        let Some(observer) = &self.observer else {
            return Ok(Vec::new());
        };
        let [angle, rate, wheel] = &observer.words;
        Ok(vec![
            up(self.angle(motion)? + angle),
            up(self.rate(motion) + rate),
            up(&self.wheel_speed + wheel),
            observer.command.clone(),
            EmittedObserver::state_rounding(),
        ])
    }

    /// Largest error of the estimated bias by the readings of one sample with these errors (rad), for the observer's
    /// ℓ; zero without an observer.
    pub fn estimate(&self, direct: &[BigRational; 3], sizes: &[BigRational]) -> BigRational {
        let Some(observer) = &self.observer else {
            return BigRational::zero();
        };
        let of_readings = direct.iter().zip(sizes);
        let sum: BigRational = of_readings.map(|(entry, size)| entry.abs() * size).sum();
        up(sum + &observer.estimate)
    }

    /// The error of the rate (rad/s).
    pub fn rate(&self, motion: &MotionBounds) -> BigRational {
        let shown = match &self.body {
            BodyErrors::Inertial(errors) => errors.rate(motion),
            BodyErrors::Pivot(errors) => errors.rate.clone(),
            BodyErrors::Counts(errors) => errors.rate.clone(),
        };
        up(shown + &self.rate_word)
    }

    /// The sensor of the body that reaches the end of its range at this angle (rad), this rate (rad/s) and this motion.
    pub fn beyond(
        &self,
        angle: &BigRational,
        rate: &BigRational,
        motion: &MotionBounds,
    ) -> Option<&'static str> {
        let rate = rate + self.rate(motion);
        match &self.body {
            BodyErrors::Inertial(errors) => (rate >= errors.rate_range)
                .then_some("the gyroscope may come to the end of its range"),
            BodyErrors::Pivot(errors) => (rate >= errors.rate_range
                || *angle >= errors.angle_range)
                .then_some("the encoder on the pivot may come to the end of what it shows"),
            BodyErrors::Counts(errors) => (rate >= errors.ranges[1]
                || angle + &errors.angle >= errors.ranges[0])
                .then_some("angle or rate may come to the end of its word"),
        }
    }
}
