//! A second implementation of the controller's step and of its arming, in integers of any size. Attitude,
//! law, observer and lines are the emitted functions, which other claims cover.

use crate::claims::filter_exact::second::{calibrated, is_saturated, squares};
use crate::claims::functions::Functions;
use crate::claims::named_words::NamedWords;
use crate::language::module::Module;
use num_traits::ToPrimitive;

/// The values of `Status`.
pub(crate) const READY: i128 = 1;
pub(crate) const RUNNING: i128 = 2;
const TRIPPED_ANGLE: i128 = 3;
const TRIPPED_FROZEN: i128 = 4;
const TRIPPED_CLIPPED: i128 = 5;
const TRIPPED_WHEEL_SPEED: i128 = 6;
const TRIPPED_ACCELEROMETER: i128 = 7;
const TRIPPED_CURRENT: i128 = 8;
pub(crate) const TRIPPED_FAULT: i128 = 9;

/// Words of a controller: attitude, status, aligned, window, counts, observer.
pub(crate) const WORDS: usize = ATTITUDE + 18;
pub(crate) const STATUS: usize = ATTITUDE;
pub(crate) const ALIGNED: usize = ATTITUDE + 1;
const WINDOW: usize = ATTITUDE + 2;
pub(crate) const COUNTS: usize = ATTITUDE + 9;
pub(crate) const SATURATED: usize = COUNTS + 4;
pub(crate) const GYRO: usize = COUNTS + 5;
const OBSERVER: usize = ATTITUDE + 17;
/// Words of the attitude: quaternion, rates, drift.
pub(crate) const ATTITUDE: usize = 9;

/// What the sensors said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) gyro: [i128; 3],
    pub(crate) accel: [i128; 3],
    pub(crate) mag: Option<[i128; 3]>,
    pub(crate) wheel: i128,
}

impl Sample {
    /// As the words of an argument.
    pub(crate) fn words(&self) -> Vec<i128> {
        let mut words = [self.gyro, self.accel].concat();
        words.push(i128::from(self.mag.is_some()));
        words.extend(self.mag.unwrap_or_default());
        words.push(self.wheel);
        words
    }
}

/// The supervisor with the numbers of the bench.
pub(crate) struct Supervisor<'a> {
    f: Functions<'a>,
    limits: NamedWords,
    filter: Vec<i128>,
    current_limit: i128,
}

impl<'a> Supervisor<'a> {
    pub(crate) fn read(module: &'a Module) -> Result<Self, String> {
        let f = Functions(module);
        let filter = f.constant("constants", "FILTER")?.to_vec();
        let current_limit = f.constant("control", "CURRENT_LIMIT")?[0];
        Ok(Supervisor {
            f,
            limits: NamedWords::read(module, "LIMITS")?,
            filter,
            current_limit,
        })
    }

    pub(crate) fn limit(&self, name: &str) -> Result<i128, String> {
        let word = self.limits.get(&format!("LIMITS.{name}"))?.to_integer();
        word.to_i128()
            .ok_or_else(|| format!("LIMITS.{name} is too large"))
    }

    fn counted(&self, count: i128, holds: bool, limit: &str) -> Result<i128, String> {
        let limit = self.limit(limit)?;
        Ok(if holds { (count + 1).min(limit) } else { 0 })
    }

    /// The accelerometer's reading, and whether it shows gravity.
    fn reading(&self, accel: &[i128]) -> (Vec<i128>, bool) {
        let up = calibrated(accel, &self.filter[14..28]);
        let shows = !is_saturated(accel, &self.filter[49..52]) && squares(&up) >= self.filter[42];
        (up, shows)
    }

    fn is_quiet(&self, sample: &Sample, up: &[i128]) -> Result<bool, String> {
        let turn = calibrated(&sample.gyro, &self.filter[..14]);
        let most = self.limit("quiet_turn")?;
        let length = squares(up);
        Ok(turn.iter().all(|word| word.abs() < most)
            && !is_saturated(&sample.accel, &self.filter[49..52])
            && length >= self.limit("gravity_low")?
            && length <= self.limit("gravity_high")?)
    }

    /// Whether a controller that does not run may be armed; its words afterwards.
    pub(crate) fn armed(&self, words: &[i128]) -> Result<(bool, Vec<i128>), String> {
        let mut next = words.to_vec();
        if words[STATUS] == RUNNING {
            return Ok((true, next));
        }
        let angle = self.f.call("Attitude::angle", &words[..ATTITUDE])?[0];
        let rate = self.f.call("Attitude::rate", &words[..ATTITUDE])?[0];
        let [wheel, clipped, frozen, rejected] = [0, 1, 2, 3].map(|k| words[COUNTS + k]);
        let may = words[ALIGNED] == 1
            && angle.abs() <= self.limit("angle_arm")?
            && rate.abs() <= self.limit("rate_arm")?
            && frozen < self.limit("frozen_steps")?
            && (wheel, clipped, rejected) == (0, 0, 0);
        if may {
            next[STATUS] = RUNNING;
            next[SATURATED] = 0;
        }
        Ok((may, next))
    }

    /// The words after a trip.
    pub(crate) fn tripped(&self, words: &[i128], status: i128) -> Vec<i128> {
        let mut next = words.to_vec();
        next[STATUS] = status;
        next[ALIGNED] = 0;
        next[WINDOW..WINDOW + 7].fill(0);
        next
    }

    /// One sample; `current` in place of the law's where one is given. Duty and words.
    pub(crate) fn step(
        &self,
        words: &[i128],
        sample: &Sample,
        current: Option<i128>,
    ) -> Result<(i128, Vec<i128>), String> {
        let f = &self.f;
        let mut next = words.to_vec();
        let gyro_clip = [
            self.limit("gyro_clip[0]")?,
            self.limit("gyro_clip[1]")?,
            self.limit("gyro_clip[2]")?,
        ];
        // A clipped gyroscope is held at its last reading.
        let is_gyro_clipped = is_saturated(&sample.gyro, &gyro_clip);
        let gyro = match is_gyro_clipped {
            true => &words[GYRO..GYRO + 3],
            false => &sample.gyro[..],
        };
        // Whatever the magnetometer says.
        let arguments = [&words[..ATTITUDE], gyro, &sample.accel].concat();
        let attitude = f.call("Attitude::update_imu", &arguments)?;
        next[..ATTITUDE].copy_from_slice(&attitude);
        let angle = f.call("Attitude::angle", &attitude)?[0];
        let rate = f.call("Attitude::rate", &attitude)?[0];
        let speed = f.call("wheel_speed", &[sample.wheel])?[0];

        let (up, shows_gravity) = self.reading(&sample.accel);
        let is_clipped = is_gyro_clipped || is_saturated(&sample.accel, &self.filter[49..52]);
        let is_unknown =
            sample.wheel <= self.limit("wheel_low")? || sample.wheel >= self.limit("wheel_high")?;
        let is_frozen = words[GYRO..GYRO + 3] == *gyro;
        for (index, holds, limit) in [
            (0, is_unknown, "wheel_steps"),
            (1, is_clipped, "clipped_steps"),
            (2, is_frozen, "frozen_steps"),
            (3, !shows_gravity, "rejected_steps"),
        ] {
            next[COUNTS + index] = self.counted(words[COUNTS + index], holds, limit)?;
        }
        next[GYRO..GYRO + 3].copy_from_slice(gyro);

        let at = |index: usize, limit: &str| -> Result<bool, String> {
            Ok(next[COUNTS + index] >= self.limit(limit)?)
        };
        let judgement = if angle.abs() > self.limit("angle_trip")? {
            TRIPPED_ANGLE
        } else if at(2, "frozen_steps")? {
            TRIPPED_FROZEN
        } else if at(1, "clipped_steps")? {
            TRIPPED_CLIPPED
        } else if at(0, "wheel_steps")? {
            TRIPPED_WHEEL_SPEED
        } else if at(3, "rejected_steps")? {
            TRIPPED_ACCELEROMETER
        } else if at(4, "saturated_steps")? {
            TRIPPED_CURRENT
        } else {
            RUNNING
        };
        let states = [angle, rate, speed];
        let observer = f.constant("constants", "BIAS_OBSERVER")?;
        if words[STATUS] == RUNNING && judgement == RUNNING {
            let command = match current {
                Some(current) => current.clamp(-self.current_limit, self.current_limit),
                None => {
                    let z = words[OBSERVER];
                    let bias =
                        f.call("estimated_bias", &[&[z], &states[..], observer].concat())?[0];
                    let command = f.call("control", &[angle - bias, rate, speed])?;
                    let arguments = [&[z], &states[..], &command, observer].concat();
                    next[OBSERVER] = f.call("advanced", &arguments)?[0];
                    command[0]
                }
            };
            let is_saturated = command.abs() >= self.current_limit;
            next[SATURATED] = self.counted(words[SATURATED], is_saturated, "saturated_steps")?;
            return Ok((f.call("duty", &[command])?[0], next));
        }
        if words[STATUS] == RUNNING {
            next = self.tripped(&next, judgement);
        } else if words[ALIGNED] == 0 {
            self.gather(&mut next, sample, &up)?;
        }
        next[OBSERVER] = f.call("waiting", &[&states[..], observer].concat())?[0];
        Ok((f.constant("constants", "ZERO_CURRENT")?[0], next))
    }

    /// The window with a sample more; a full one sets the attitude.
    fn gather(&self, next: &mut [i128], sample: &Sample, up: &[i128]) -> Result<(), String> {
        if !self.is_quiet(sample, up)? {
            next[WINDOW..WINDOW + 7].fill(0);
            return Ok(());
        }
        let shift = self.limit("window_shift")?;
        let agreement = self.limit("agreement")?;
        let share: Vec<i128> = up.iter().map(|word| word >> shift).collect();
        let agrees =
            next[WINDOW] > 0 && (0..3).all(|k| (up[k] - next[WINDOW + 1 + k]).abs() < agreement);
        if agrees {
            next[WINDOW] = self.counted(next[WINDOW], true, "window")?;
            for (sum, share) in next[WINDOW + 4..].iter_mut().zip(&share) {
                *sum = (*sum + share).clamp(-(1 << 29), 1 << 29);
            }
        } else {
            next[WINDOW] = 1;
            next[WINDOW + 1..WINDOW + 4].copy_from_slice(up);
            next[WINDOW + 4..WINDOW + 7].copy_from_slice(&share);
        }
        if next[WINDOW] >= self.limit("window")? {
            let sum = next[WINDOW + 4..WINDOW + 7].to_vec();
            let attitude = self.f.call(
                "Attitude::align_to",
                &[&next[..ATTITUDE], &sum[..]].concat(),
            )?;
            next[..ATTITUDE].copy_from_slice(&attitude);
            next[WINDOW..WINDOW + 7].fill(0);
            next[ALIGNED] = 1;
            if next[STATUS] == 0 {
                next[STATUS] = READY;
            }
        }
        Ok(())
    }
}
