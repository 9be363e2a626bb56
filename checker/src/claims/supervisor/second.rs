//! A second implementation of the controller's step and of its arming, in integers of any size. Attitude,
//! law, observer and lines are the emitted functions, which other claims cover.

use crate::claims::encoder_exact::second::EncoderWords;
use crate::claims::filter_exact::second::{calibrated, is_saturated, squares};
use crate::claims::functions::Functions;
use crate::claims::named_words::NamedWords;
use crate::language::module::Module;
use num_traits::ToPrimitive;

/// The values of `Status`.
pub(crate) const READY: i128 = 1;
pub(crate) const RUNNING: i128 = 2;
pub(crate) const TRIPPED_ANGLE: i128 = 3;
pub(crate) const TRIPPED_FROZEN: i128 = 4;
const TRIPPED_CLIPPED: i128 = 5;
pub(crate) const TRIPPED_WHEEL_SPEED: i128 = 6;
const TRIPPED_ACCELEROMETER: i128 = 7;
pub(crate) const TRIPPED_CURRENT: i128 = 8;
pub(crate) const TRIPPED_FAULT: i128 = 9;

/// Accelerometer units in a unit of the first reading of a window.
const FIRST_UNIT: i128 = 1 << 15;
/// The largest count of 16 bits.
pub(super) const MOST_COUNTED: i128 = 65_535;

/// Where the words of a controller stand: attitude, the wheel's encoder where there is one, status, aligned, window,
/// counts, observer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Words of the attitude: quaternion, rates, drift.
    pub(crate) attitude: usize,
    /// Words of the wheel's encoder.
    pub(crate) wheel: usize,
}

impl Layout {
    /// By the names of the words that a step takes.
    pub(crate) fn of(module: &Module) -> Result<Layout, String> {
        let step = module.function("Controller::step");
        let names = &step.ok_or("there is no Controller::step")?.inputs;
        let count = |start: &str| names.iter().filter(|name| name.starts_with(start)).count();
        let layout = Layout {
            attitude: count("self.attitude."),
            wheel: count("self.wheel."),
        };
        let places = [
            (layout.status(), "self.status"),
            (layout.aligned(), "self.is_aligned"),
            (layout.window(), "self.window.count"),
            (layout.counts(), "self.counters.wheel"),
            (layout.saturated(), "self.counters.saturated"),
            (layout.gyro(), "self.counters.gyro[0]"),
            (layout.observer(), "self.bias_state"),
        ];
        for (place, name) in places {
            if names.get(place).is_none_or(|found| found != name) {
                return Err(format!("word {place} of a controller is not `{name}`"));
            }
        }
        if count("self.") != layout.words() {
            return Err(format!("a controller has not {} words", layout.words()));
        }
        Ok(layout)
    }

    pub(crate) fn status(&self) -> usize {
        self.attitude + self.wheel
    }

    pub(crate) fn aligned(&self) -> usize {
        self.status() + 1
    }

    fn window(&self) -> usize {
        self.status() + 2
    }

    pub(crate) fn counts(&self) -> usize {
        self.status() + 9
    }

    fn saturated(&self) -> usize {
        self.counts() + 4
    }

    pub(crate) fn gyro(&self) -> usize {
        self.counts() + 5
    }

    fn observer(&self) -> usize {
        self.status() + 17
    }

    pub(crate) fn words(&self) -> usize {
        self.status() + 18
    }
}

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
    pub(crate) layout: Layout,
    limits: NamedWords,
    filter: Vec<i128>,
    current_limit: i128,
    wheel_encoder: Option<EncoderWords>,
    /// Whether the duty depends on the wheel's speed, as that of a voltage drive does.
    duty_takes_speed: bool,
}

impl<'a> Supervisor<'a> {
    pub(crate) fn read(module: &'a Module) -> Result<Self, String> {
        let f = Functions(module);
        let filter = f.constant("constants", "FILTER")?.to_vec();
        let current_limit = f.constant("control", "CURRENT_LIMIT")?[0];
        Ok(Supervisor {
            f,
            layout: Layout::of(module)?,
            wheel_encoder: EncoderWords::read(module, "WHEEL_ENCODER")?,
            duty_takes_speed: module
                .function("duty")
                .is_some_and(|duty| duty.inputs.len() == 2),
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

    /// The wheel's encoder, where there is one.
    pub(crate) fn wheel_encoder(&self) -> Option<&EncoderWords> {
        self.wheel_encoder.as_ref()
    }

    fn counted(&self, count: i128, holds: bool, limit: &str) -> Result<i128, String> {
        let limit = self.limit(limit)?;
        Ok(if holds {
            (count + 1).min(limit).min(MOST_COUNTED)
        } else {
            0
        })
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
        if words[self.layout.status()] == RUNNING {
            return Ok((true, next));
        }
        let angle = self
            .f
            .call("Attitude::angle", &words[..self.layout.attitude])?[0];
        let rate = self
            .f
            .call("Attitude::rate", &words[..self.layout.attitude])?[0];
        let [wheel, clipped, frozen, rejected] =
            [0, 1, 2, 3].map(|k| words[self.layout.counts() + k]);
        let may = words[self.layout.aligned()] == 1
            && angle.abs() <= self.limit("angle_arm")?
            && rate.abs() <= self.limit("rate_arm")?
            && frozen < self.limit("frozen_steps")?
            && (wheel, clipped, rejected) == (0, 0, 0);
        if may {
            next[self.layout.status()] = RUNNING;
            next[self.layout.saturated()] = 0;
        }
        Ok((may, next))
    }

    /// The words after a trip.
    pub(crate) fn tripped(&self, words: &[i128], status: i128) -> Vec<i128> {
        let mut next = words.to_vec();
        let window = self.layout.window();
        next[self.layout.status()] = status;
        next[self.layout.aligned()] = 0;
        next[window..window + 7].fill(0);
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
        let gyro = self.layout.gyro();
        let mut next = words.to_vec();
        let gyro_clip = [
            self.limit("gyro_clip[0]")?,
            self.limit("gyro_clip[1]")?,
            self.limit("gyro_clip[2]")?,
        ];
        // A clipped gyroscope is held at its last reading.
        let is_gyro_clipped = is_saturated(&sample.gyro, &gyro_clip);
        let reading = match is_gyro_clipped {
            true => &words[gyro..gyro + 3],
            false => &sample.gyro[..],
        };
        // Whatever the magnetometer says.
        let arguments = [&words[..self.layout.attitude], reading, &sample.accel].concat();
        let attitude = f.call("Attitude::update_imu", &arguments)?;
        next[..self.layout.attitude].copy_from_slice(&attitude);
        let angle = f.call("Attitude::angle", &attitude)?[0];
        let rate = f.call("Attitude::rate", &attitude)?[0];
        let own = self.layout.attitude..self.layout.status();
        let (wheel, has_jumped) = match &self.wheel_encoder {
            Some(encoder) => {
                let (after, has_jumped) = encoder.update(&words[own.clone()], sample.wheel);
                next[own].copy_from_slice(&after);
                (encoder.turned(&after), has_jumped)
            }
            None => (sample.wheel, false),
        };
        let speed = f.call("wheel_speed", &[wheel])?[0];

        let (up, shows_gravity) = self.reading(&sample.accel);
        let is_clipped = is_gyro_clipped || is_saturated(&sample.accel, &self.filter[49..52]);
        let is_unknown = wheel <= self.limit("wheel_low")? || wheel >= self.limit("wheel_high")?;
        let is_frozen = words[gyro..gyro + 3] == *reading;
        for (index, holds, limit) in [
            (0, is_unknown, "wheel_steps"),
            (1, is_clipped, "clipped_steps"),
            (2, is_frozen, "frozen_steps"),
            (3, !shows_gravity, "rejected_steps"),
        ] {
            next[self.layout.counts() + index] =
                self.counted(words[self.layout.counts() + index], holds, limit)?;
        }
        next[gyro..gyro + 3].copy_from_slice(reading);

        let at = |index: usize, limit: &str| -> Result<bool, String> {
            Ok(next[self.layout.counts() + index] >= self.limit(limit)?)
        };
        let judgement = if has_jumped {
            TRIPPED_FAULT
        } else if angle.abs() > self.limit("angle_trip")? {
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
        let is_running = words[self.layout.status()] == RUNNING;
        let states = [angle, rate, speed];
        let observer = f.constant("constants", "BIAS_OBSERVER")?;
        if is_running && judgement == RUNNING {
            let command = match current {
                Some(current) => current.clamp(-self.current_limit, self.current_limit),
                None => {
                    let z = words[self.layout.observer()];
                    let bias =
                        f.call("estimated_bias", &[&[z], &states[..], observer].concat())?[0];
                    let command = f.call("control", &[angle - bias, rate, speed])?;
                    let arguments = [&[z], &states[..], &command, observer].concat();
                    next[self.layout.observer()] = f.call("advanced", &arguments)?[0];
                    command[0]
                }
            };
            let is_saturated = command.abs() >= self.current_limit;
            next[self.layout.saturated()] = self.counted(
                words[self.layout.saturated()],
                is_saturated,
                "saturated_steps",
            )?;
            let duty = if self.duty_takes_speed {
                f.call("duty", &[command, speed])?
            } else {
                f.call("duty", &[command])?
            };
            return Ok((duty[0], next));
        }
        if is_running {
            next = self.tripped(&next, judgement);
        } else if words[self.layout.aligned()] == 0 {
            self.gather(&mut next, sample, &up)?;
        }
        if has_jumped {
            next = self.tripped(&next, TRIPPED_FAULT);
        }
        next[self.layout.observer()] = f.call("waiting", &[&states[..], observer].concat())?[0];
        Ok((f.constant("constants", "ZERO_CURRENT")?[0], next))
    }

    /// The window with a sample more; a full one sets the attitude in the step after it.
    fn gather(&self, next: &mut [i128], sample: &Sample, up: &[i128]) -> Result<(), String> {
        let window = self.layout.window();
        if next[window] >= self.limit("window")? {
            let sum = next[window + 4..window + 7].to_vec();
            let attitude = self.f.call(
                "Attitude::align_to",
                &[&next[..self.layout.attitude], &sum[..]].concat(),
            )?;
            next[..self.layout.attitude].copy_from_slice(&attitude);
            next[window..window + 7].fill(0);
            next[self.layout.aligned()] = 1;
            if next[self.layout.status()] == 0 {
                next[self.layout.status()] = READY;
            }
            return Ok(());
        }
        if !self.is_quiet(sample, up)? {
            next[window..window + 7].fill(0);
            return Ok(());
        }
        let shift = self.limit("window_shift")?;
        let agreement = self.limit("agreement")?;
        let share: Vec<i128> = up.iter().map(|word| word >> shift).collect();
        let agrees = next[window] > 0
            && (0..3).all(|k| (up[k] - next[window + 1 + k] * FIRST_UNIT).abs() < agreement);
        if agrees {
            next[window] = self.counted(next[window], true, "window")?;
            for (sum, share) in next[window + 4..].iter_mut().zip(&share) {
                *sum = (*sum + share).clamp(-(1 << 29), 1 << 29);
            }
        } else {
            next[window] = 1;
            for (first, up) in next[window + 1..].iter_mut().zip(up) {
                *first = up.div_euclid(FIRST_UNIT);
            }
            next[window + 4..window + 7].copy_from_slice(&share);
        }
        Ok(())
    }
}
