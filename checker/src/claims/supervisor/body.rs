//! Claim `supervisor` where an encoder shows the body: the words of `LIMITS`, and a second implementation of the
//! controller's step and of its arming, in integers of any size. Law and duty are the emitted functions, which other
//! claims cover; angle and rate are stated here a second time, in exact lines.

use num_traits::{Signed, ToPrimitive};
use std::f64::consts::TAU;

use crate::certificate::hardware::CertifiedBodyEncoder;
use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::encoder_exact::second::{EncoderWords, WORDS};
use crate::claims::functions::Functions;
use crate::claims::named_words::NamedWords;
use crate::claims::supervisor::second::{
    READY, RUNNING, TRIPPED_ANGLE, TRIPPED_CURRENT, TRIPPED_FAULT, TRIPPED_FROZEN,
    TRIPPED_WHEEL_SPEED,
};
use crate::claims::supervisor::words::{LargestCurrent, near, of_the_plant, real, steps};
use crate::language::module::Module;

/// Time near upright and at rest before it is armed, and time with an unknown wheel speed, s.
const TIMES_S: [f64; 2] = [0.25, 0.020];
/// Shares of the largest current: what may be left over under a count that stands still, and what of it moves the body
/// for certain.
const SHARES: [f64; 2] = [0.5, 0.25];
/// Counts within which a body that is accelerated does not stay for longer than the stated time.
const COUNTS: f64 = 4.0;

/// Checks every word of `LIMITS`.
///
/// A body with the acceleration a that first runs against it leaves an interval of the length d after at most 2 √(2 d/a).
///
/// # Errors
/// A sentence that names the word.
pub(crate) fn check(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    encoder: &CertifiedBodyEncoder,
) -> Result<(), String> {
    let words = NamedWords::read(module, "LIMITS")?;
    let near = |name: &str, wanted: f64| near(&words, name, wanted);
    let LargestCurrent { limit_a, push } = of_the_plant(certificate, module, law, &words)?;
    let period = real(&certificate.sample_time_s.value);
    let window = f64::from(encoder.window) + 1.0;
    near("still_steps", (TIMES_S[0] / period).max(2.0).max(window))?;
    near("wheel_steps", (TIMES_S[1] / period).max(2.0))?;
    let current_unit = 2f64.powi(law.current_bits as i32);
    near("left_over", SHARES[0] * limit_a * current_unit)?;
    let count = TAU / real(&encoder.counts_per_turn.value.abs());
    let frozen_s = 2.0 * (2.0 * COUNTS * count / (SHARES[1] * push * limit_a)).sqrt();
    near("frozen_steps", steps(frozen_s, period))
}

/// What the sensors said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodySample {
    pub(crate) body: i128,
    pub(crate) wheel: i128,
}

/// Counts of a controller, after its encoders and its status.
pub(crate) const WHEEL: usize = 1;
pub(crate) const FROZEN_BACK: usize = 2;
pub(crate) const FROZEN_FORWARD: usize = 3;
pub(crate) const STILL: usize = 4;
pub(crate) const SATURATED: usize = 5;
pub(crate) const CURRENT: usize = 6;

/// Names of the status and of the counts, in the order of the words.
const NAMES: [&str; 7] = [
    "self.status",
    "self.counters.wheel",
    "self.counters.frozen_back",
    "self.counters.frozen_forward",
    "self.counters.still",
    "self.counters.saturated",
    "self.counters.current",
];

/// A line in integers: scale, offset, shift, low, high.
struct ExactLine([i128; 5]);

impl ExactLine {
    fn read(f: &Functions, name: &str) -> Result<ExactLine, String> {
        let words = f.constant("constants", name)?;
        let words: [i128; 5] = words.try_into().map_err(|_| format!("{name} is no line"))?;
        if !(0..63).contains(&words[2]) || words[3] > words[4] {
            return Err(format!("{name} is no line"));
        }
        Ok(ExactLine(words))
    }

    fn at(&self, word: i128) -> i128 {
        let [scale, offset, shift, low, high] = self.0;
        ((scale * word + offset) >> shift).clamp(low, high)
    }
}

/// The supervisor with the numbers of the bench.
pub(crate) struct BodySupervisor<'a> {
    pub(crate) f: Functions<'a>,
    limits: NamedWords,
    pub(crate) body: EncoderWords,
    pub(crate) wheel: Option<EncoderWords>,
    pub(crate) zero: i128,
    angle: ExactLine,
    rate: ExactLine,
    holding: ExactLine,
    pub(crate) current_limit: i128,
    duty_takes_speed: bool,
}

impl<'a> BodySupervisor<'a> {
    pub(crate) fn read(module: &'a Module) -> Result<Self, String> {
        let f = Functions(module);
        let found = BodySupervisor {
            limits: NamedWords::read(module, "LIMITS")?,
            body: EncoderWords::read(module, "BODY_ENCODER")?.ok_or("there is no BODY_ENCODER")?,
            wheel: EncoderWords::read(module, "WHEEL_ENCODER")?,
            zero: f.constant("constants", "BODY_ZERO")?[0],
            angle: ExactLine::read(&f, "BODY_ANGLE_LINE")?,
            rate: ExactLine::read(&f, "BODY_RATE_LINE")?,
            holding: ExactLine::read(&f, "HOLDING_LINE")?,
            current_limit: f.constant("control", "CURRENT_LIMIT")?[0],
            duty_takes_speed: module
                .function("duty")
                .is_some_and(|duty| duty.inputs.len() == 2),
            f,
        };
        let step = module.function("Controller::step");
        let names = &step.ok_or("there is no Controller::step")?.inputs;
        for (index, name) in NAMES.iter().enumerate() {
            let place = found.status() + index;
            if names.get(place).is_none_or(|found| found != name) {
                return Err(format!("word {place} of a controller is not `{name}`"));
            }
        }
        let own = names.iter().filter(|name| name.starts_with("self."));
        if own.count() != found.words() {
            return Err(format!("a controller has not {} words", found.words()));
        }
        Ok(found)
    }

    /// Where the status stands, after the encoders.
    pub(crate) fn status(&self) -> usize {
        WORDS * (1 + usize::from(self.wheel.is_some()))
    }

    /// Words of a controller.
    pub(crate) fn words(&self) -> usize {
        self.status() + NAMES.len()
    }

    pub(crate) fn limit(&self, name: &str) -> Result<i128, String> {
        let word = self.limits.get(&format!("LIMITS.{name}"))?.to_integer();
        word.to_i128()
            .ok_or_else(|| format!("LIMITS.{name} is too large"))
    }

    /// The word of the angle by a count.
    pub(crate) fn angle_of(&self, count: i128) -> i128 {
        let count = count.clamp(0, self.body.wrap - 1);
        self.angle.at(self.body.short(count - self.zero))
    }

    /// The word of the rate by the counts over the window.
    pub(crate) fn rate_of(&self, turned: i128) -> i128 {
        self.rate.at(turned)
    }

    fn counted(&self, count: i128, holds: bool, limit: &str) -> Result<i128, String> {
        let limit = self.limit(limit)?;
        Ok(if holds { (count + 1).min(limit) } else { 0 })
    }

    /// Whether a controller may be armed; its words afterwards.
    pub(crate) fn armed(&self, words: &[i128]) -> Result<(bool, Vec<i128>), String> {
        let mut next = words.to_vec();
        let status = self.status();
        if words[status] == RUNNING {
            return Ok((true, next));
        }
        let may = words[status + STILL] >= self.limit("still_steps")? && words[status + WHEEL] == 0;
        if may {
            next[status] = RUNNING;
            next[status + SATURATED] = 0;
        }
        Ok((may, next))
    }

    /// The words after a trip.
    pub(crate) fn tripped(&self, words: &[i128], why: i128) -> Vec<i128> {
        let mut next = words.to_vec();
        next[self.status()] = why;
        next[self.status() + STILL] = 0;
        next
    }

    /// One sample; `current` in place of the law's where one is given. Duty and words.
    pub(crate) fn step(
        &self,
        words: &[i128],
        sample: &BodySample,
        current: Option<i128>,
    ) -> Result<(i128, Vec<i128>), String> {
        let f = &self.f;
        let status = self.status();
        let mut next = words.to_vec();
        let (body, has_body_jumped) = self.body.update(&words[..WORDS], sample.body);
        next[..WORDS].copy_from_slice(&body);
        let (wheel, has_wheel_jumped) = match &self.wheel {
            Some(encoder) => {
                let (after, has_jumped) = encoder.update(&words[WORDS..status], sample.wheel);
                next[WORDS..status].copy_from_slice(&after);
                (encoder.turned(&after), has_jumped)
            }
            None => (sample.wheel, false),
        };
        let angle = self.angle_of(body[1]);
        let rate = self.rate_of(self.body.turned(&body));
        let speed = f.call("wheel_speed", &[wheel])?[0];

        let is_running = words[status] == RUNNING;
        let is_fixed = is_running && body[1] == words[1];
        let left = words[status + CURRENT] - self.holding.at(angle);
        let most = self.limit("left_over")?;
        let is_unknown = wheel <= self.limit("wheel_low")? || wheel >= self.limit("wheel_high")?;
        let is_still =
            angle.abs() <= self.limit("angle_arm")? && rate.abs() <= self.limit("rate_arm")?;
        for (index, holds, limit) in [
            (WHEEL, is_unknown, "wheel_steps"),
            (FROZEN_BACK, is_fixed && left > most, "frozen_steps"),
            (FROZEN_FORWARD, is_fixed && left < -most, "frozen_steps"),
            (STILL, is_still, "still_steps"),
        ] {
            next[status + index] = self.counted(words[status + index], holds, limit)?;
        }
        let at = |index: usize, limit: &str| -> Result<bool, String> {
            Ok(next[status + index] >= self.limit(limit)?)
        };
        let has_jumped = has_body_jumped || has_wheel_jumped;
        let judgement = if has_jumped {
            TRIPPED_FAULT
        } else if angle.abs() > self.limit("angle_trip")? {
            TRIPPED_ANGLE
        } else if at(FROZEN_BACK, "frozen_steps")? || at(FROZEN_FORWARD, "frozen_steps")? {
            TRIPPED_FROZEN
        } else if at(WHEEL, "wheel_steps")? {
            TRIPPED_WHEEL_SPEED
        } else if at(SATURATED, "saturated_steps")? {
            TRIPPED_CURRENT
        } else {
            RUNNING
        };
        if is_running && judgement == RUNNING {
            let command = match current {
                Some(current) => current.clamp(-self.current_limit, self.current_limit),
                None => f.call("control", &[angle, rate, speed])?[0],
            };
            next[status + CURRENT] = command;
            next[status + SATURATED] = self.counted(
                words[status + SATURATED],
                command.abs() >= self.current_limit,
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
        } else if words[status] == 0 && at(STILL, "still_steps")? {
            next[status] = READY;
        }
        if has_jumped {
            next = self.tripped(&next, TRIPPED_FAULT);
        }
        next[status + CURRENT] = 0;
        Ok((f.constant("constants", "ZERO_CURRENT")?[0], next))
    }
}
