//! The numbers of the supervisor, from the model, the sensors and the drive.
//!
//! All of them follow from the linear model about upright: τ I/G = |B₂| I/A₂₁ is the sine of the angle
//! at which the largest current just holds the body, 1/√A₂₁ the time constant of its fall, and B₂ + B₃ = τ/j_w
//! the acceleration of the wheel in space for each ampere.

use core::f64::consts::{PI, TAU};

use attitude::AttitudeSpec;

use crate::attitude::AttitudeRefusal;
use crate::hardware::{BodyEncoder, EncoderSpec, WINDOW_MAX, WheelSensor};
use crate::helpers::body_supervisor::Limits as BodyLimits;
use crate::helpers::encoder::EncoderNumbers;
use crate::helpers::filter::FilterConstants;
use crate::helpers::supervisor::{COUNTED_MAX, Limits};
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;

/// Largest angle at which the loop may run, rad: 60°. No motor of such a bench returns from there; the body falls.
const ANGLE_TRIP_MAX_RAD: f64 = PI / 3.0;

/// Largest value of the sine of the holding angle that is used: near one, the angle is too sensitive to the model.
const SINE_MAX: f64 = 0.99;

/// Largest rate at which the controller is armed, as a share of the rate at which the body falls from the holding
/// angle. A hand that holds the body turns it more slowly, and the motor stops this rate within a quarter of the
/// holding angle.
const RATE_ARM_SHARE: f64 = 0.25;

/// Time over which quiet samples are averaged for the attitude, s. At 1 kHz the average of a quarter of a second has a
/// sixteenth of the accelerometer's noise.
const WINDOW_S: f64 = 0.25;

/// Largest deviation of the length of a quiet reading from gravity, as a share of it: larger than the scale error of an
/// uncalibrated sensor (some per cent), smaller than a push of 0.2 g.
const GRAVITY_SHARE: f64 = 0.15;

/// Largest difference of two quiet readings in a component, as a share of gravity: 6° of tilt, or more than six standard
/// deviations of a noise of 10 mg.
const AGREEMENT_SHARE: f64 = 0.1;

/// Largest rate of a quiet sample about each axis, rad/s: it leaves room for the bias of an uncalibrated gyroscope (5 °/s
/// in data sheets) and for the tremor of a hand.
const QUIET_RAD_S: f64 = 0.3;

/// Longest time for which the wheel speed may be unknown, s.
const WHEEL_S: f64 = 0.020;
/// Longest time for which a sensor may be clipped, s.
const CLIPPED_S: f64 = 0.010;
/// Longest time for which the accelerometer may show no gravity, s.
const REJECTED_S: f64 = 2.0;

/// Refresh periods of the gyroscope over which its three words may stand still. With noise of half a
/// count on each axis two readings are alike with a probability of 0.18; twenty in a row come in
/// 10¹⁵ readings, less than once in 10⁸ hours at 1 kHz.
const FROZEN_REFRESHES: f64 = 20.0;

/// Largest acceleration that an encoder may show, in units of that of the largest current: a hand adds to it.
const PUSH_SHARE: f64 = 4.0;
/// Largest error of an encoder's count from step to step, as a share of a turn: a sixty-fourth is 5.6°; a magnet that
/// is not centred causes 1° or 2°.
const ENCODER_SHARE: f64 = 1.0 / 64.0;
/// The smallest such error that is allowed, in counts.
const JUMP_COUNTS_MIN: f64 = 4.0;

/// Share of the largest current that may flow beyond the current that balances gravity while a count stands still.
const LEFT_OVER_SHARE: f64 = 0.5;
/// Share of this excess current that accelerates the body for certain; the rest is a margin for friction and for errors
/// of the model.
const MOVING_SHARE: f64 = 0.5;
/// Distance that the body travels, in counts, within the longest time for which a count may stand still. The hysteresis
/// of an encoder is at most three counts (AS5600).
const FROZEN_COUNTS: f64 = 4.0;

/// The numbers in SI units, as documents state them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupervisorNumbers {
    /// Largest angle while running, rad.
    pub angle_trip_rad: f64,
    /// Largest angle at which the controller is armed, rad.
    pub angle_arm_rad: f64,
    /// Largest rate at which it is armed, rad/s.
    pub rate_arm_rad_s: f64,
    /// Time at the current's limit in which the wheel reaches its largest speed, s.
    pub saturated_s: f64,
    /// Time without a change of the gyroscope's words, s.
    pub frozen_s: f64,
}

/// The numbers for `spec`.
pub fn numbers(spec: &ModuleSpec) -> SupervisorNumbers {
    let (fall, push) = (spec.a[1][0], spec.b[1].abs());
    let sine = push * spec.current_limit_a / fall;
    let holding = if sine.is_finite() && sine > 0.0 {
        sine.min(SINE_MAX).asin()
    } else {
        ANGLE_TRIP_MAX_RAD
    };
    let speed_up = (spec.b[1] + spec.b[2]).abs() * spec.current_limit_a;
    let refresh_s = spec
        .hardware
        .gyro_rate_hz
        .map_or(spec.sample_time_s, |rate| 1.0 / rate)
        .max(spec.sample_time_s);
    SupervisorNumbers {
        angle_trip_rad: (2.0 * holding)
            .min(ANGLE_TRIP_MAX_RAD)
            .min(spec.ranges.angle_rad),
        angle_arm_rad: holding.min(ANGLE_TRIP_MAX_RAD).min(spec.ranges.angle_rad),
        rate_arm_rad_s: RATE_ARM_SHARE * holding * fall.max(0.0).sqrt(),
        saturated_s: countable(spec.ranges.wheel_speed_rad_s / speed_up, spec.sample_time_s),
        frozen_s: countable(FROZEN_REFRESHES * refresh_s, spec.sample_time_s),
    }
}

/// The words of the supervisor.
///
/// # Errors
/// [`AttitudeRefusal::NoLine`] for a number that does not fit its word.
pub fn derive(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    attitude: &AttitudeSpec,
    filter: &FilterConstants,
) -> Result<Limits, AttitudeRefusal> {
    let numbers = numbers(spec);
    let period = spec.sample_time_s;
    let steps = |what: &'static str, time_s: f64| steps(what, time_s, period);
    let [angle_trip, angle_arm, rate_arm] = leaning(&numbers, law)?;
    let window_shift = (WINDOW_S / period).log2().round().clamp(2.0, 15.0) as u32;
    // Accelerometer units of one g, from the words themselves.
    let per_m_s2 = unit_per_m_s2(filter, attitude);
    let gravity = attitude.gravity_m_s2 * per_m_s2;
    let squared = |share: f64| (gravity * share).powi(2) / 2f64.powi(32);
    Ok(Limits {
        angle_trip,
        angle_arm,
        rate_arm,
        window: 1 << window_shift,
        window_shift,
        gravity_low: squared(1.0 - GRAVITY_SHARE) as i32,
        gravity_high: word("the longest gravity", squared(1.0 + GRAVITY_SHARE))?,
        agreement: word("the agreement of readings", gravity * AGREEMENT_SHARE)?,
        quiet_turn: word(
            "the rate at rest",
            QUIET_RAD_S * 0.5 * period * 2f64.powi(32),
        )?,
        gyro_clip: attitude.gyro_clip,
        wheel_low: spec.hardware.wheel_low,
        wheel_high: spec.hardware.wheel_high,
        wheel_steps: steps("the time with an unknown wheel speed", WHEEL_S)?,
        clipped_steps: steps("the time at the end of a range", CLIPPED_S)?,
        frozen_steps: steps("the time with frozen words", numbers.frozen_s)?,
        rejected_steps: steps("the time without gravity", REJECTED_S)?,
        saturated_steps: steps("the time at the current's limit", numbers.saturated_s)?,
    })
}

/// Longest time for which the body's count may stand still under an excess current of [`LEFT_OVER_SHARE`], s. A body
/// with the acceleration a stays within a distance d for at most 2 √(2 d/a), namely if it first runs against the
/// acceleration. Here d is [`FROZEN_COUNTS`] counts, and a is [`MOVING_SHARE`] of the acceleration by that current.
pub fn frozen_count_s(spec: &ModuleSpec, encoder: &EncoderSpec) -> f64 {
    let acceleration = MOVING_SHARE * LEFT_OVER_SHARE * spec.b[1].abs() * spec.current_limit_a;
    let distance = FROZEN_COUNTS * encoder.rad_per_count().abs();
    2.0 * (2.0 * distance / acceleration).sqrt()
}

/// The wheel's speed, rad/s, at which a count that is stuck upright leaves [`LEFT_OVER_SHARE`] of the largest current
/// over. The stuck encoder shows neither angle nor rate, so that the command is −K₃ φ̇. Infinite if the law does not
/// use the wheel's speed.
pub fn stuck_upright_rad_s(spec: &ModuleSpec) -> f64 {
    LEFT_OVER_SHARE * spec.current_limit_a / spec.gains[2].abs()
}

/// The words of the supervisor where an encoder shows the body.
///
/// # Errors
/// [`AttitudeRefusal::NoLine`] for a number that does not fit its word.
pub fn derive_for_encoder(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    encoder: &EncoderSpec,
) -> Result<BodyLimits, AttitudeRefusal> {
    let numbers = numbers(spec);
    let period = spec.sample_time_s;
    let steps = |what: &'static str, time_s: f64| steps(what, time_s, period);
    let [angle_trip, angle_arm, rate_arm] = leaning(&numbers, law)?;
    let current_unit = 2f64.powi(law.current.fraction_bits as i32);
    Ok(BodyLimits {
        angle_trip,
        angle_arm,
        rate_arm,
        // Before the window of an encoder is full, its rate is too small.
        still_steps: steps("the time at rest before it is armed", WINDOW_S)?
            .max(encoder.window as i32 + 1),
        wheel_low: spec.hardware.wheel_low,
        wheel_high: spec.hardware.wheel_high,
        wheel_steps: steps("the time with an unknown wheel speed", WHEEL_S)?,
        left_over: word(
            "the current under which a count may stand still",
            LEFT_OVER_SHARE * spec.current_limit_a * current_unit,
        )?,
        frozen_steps: steps(
            "the time in which a count may stand still",
            frozen_count_s(spec, encoder),
        )?,
        saturated_steps: steps("the time at the current's limit", numbers.saturated_s)?,
    })
}

/// The words of the angle that trips, and of angle and rate at which the controller is armed.
fn leaning(numbers: &SupervisorNumbers, law: &IntegerLaw) -> Result<[i32; 3], AttitudeRefusal> {
    let bits = |index: usize| 2f64.powi(law.terms[index].input.format.fraction_bits as i32);
    Ok([
        word("the largest angle", numbers.angle_trip_rad * bits(0))?,
        word(
            "the angle at which it is armed",
            numbers.angle_arm_rad * bits(0),
        )?,
        word(
            "the rate at which it is armed",
            numbers.rate_arm_rad_s * bits(1),
        )?,
    ])
}

/// A positive number as a word.
fn word(what: &'static str, value: f64) -> Result<i32, AttitudeRefusal> {
    if value >= 1.0 && value <= f64::from(i32::MAX) {
        Ok(value.floor() as i32)
    } else {
        Err(AttitudeRefusal::NoLine { what, value })
    }
}

/// A time in steps, at least two: a single bad reading must not trip.
fn steps(what: &'static str, time_s: f64, period_s: f64) -> Result<i32, AttitudeRefusal> {
    let time_s = countable(time_s, period_s);
    word(what, (time_s / period_s * (1.0 - 1e-9)).ceil().max(2.0))
}

/// A time, or as much of it as the controller counts: it trips sooner, not later. An infinite one stays, and has no word.
fn countable(time_s: f64, period_s: f64) -> f64 {
    if time_s.is_finite() {
        time_s.min(f64::from(COUNTED_MAX) * period_s)
    } else {
        time_s
    }
}

/// The numbers of an encoder whose axis the unit of current accelerates by `acceleration` (rad/s² per A).
///
/// The count may differ from the expected one by the turn that [`PUSH_SHARE`] times the largest current causes in a step,
/// and by [`ENCODER_SHARE`] for noise and for a magnet that is not centred.
///
/// # Errors
/// [`AttitudeRefusal::NoLine`] for an encoder with too few counts for this difference, or with an unsupported window.
pub fn encoder_numbers(
    encoder: &EncoderSpec,
    acceleration: f64,
    spec: &ModuleSpec,
) -> Result<EncoderNumbers, AttitudeRefusal> {
    let per_turn = encoder.counts_per_turn.abs();
    let period = spec.sample_time_s;
    let in_a_step = acceleration.abs() * spec.current_limit_a * period * period;
    let jump = (PUSH_SHARE * in_a_step / TAU + ENCODER_SHARE) * per_turn;
    let jump = jump.ceil().max(JUMP_COUNTS_MIN);
    if !(jump < f64::from(encoder.wrap()) / 2.0 && (4..=16).contains(&encoder.bits)) {
        return Err(AttitudeRefusal::NoLine {
            what: "the counts by which an encoder may turn further in a step than in the one before",
            value: jump,
        });
    }
    if !(1..=WINDOW_MAX).contains(&encoder.window) {
        return Err(AttitudeRefusal::NoLine {
            what: "the window of an encoder, which is 1 to 16 steps",
            value: f64::from(encoder.window),
        });
    }
    Ok(EncoderNumbers {
        wrap: encoder.wrap(),
        window: encoder.window as i32,
        jump: jump as i32,
    })
}

/// Accelerometer units per m/s²: the words of the matrix over the matrix itself, in its largest entry.
fn unit_per_m_s2(filter: &FilterConstants, attitude: &AttitudeSpec) -> f64 {
    let rows = [filter.accel.x, filter.accel.y, filter.accel.z];
    let mut best = (0.0, 0.0);
    for (row, words) in rows.iter().enumerate() {
        for (column, word) in words.iter().enumerate() {
            let entry = attitude.accel.matrix[(row, column)];
            if entry.abs() > best.0 {
                best = (entry.abs(), f64::from(*word) / entry);
            }
        }
    }
    best.1 / 2f64.powi(17)
}

/// The sample time in whole microseconds.
///
/// # Errors
/// [`AttitudeRefusal::NoLine`] for a time that is no whole number of them, or below ten.
pub fn sample_time_us(sample_time_s: f64) -> Result<u32, AttitudeRefusal> {
    let micros = sample_time_s * 1e6;
    if (micros - micros.round()).abs() < 1e-6 && (10.0..=1e6).contains(&micros.round()) {
        Ok(micros.round() as u32)
    } else {
        Err(AttitudeRefusal::SampleTime { sample_time_s })
    }
}

/// The unit in which the ends of the wheel sensor's range are stated.
fn wheel_counts(wheel: &WheelSensor) -> &'static str {
    match wheel {
        WheelSensor::Converter => "counts",
        WheelSensor::Driver => "units of the driver's word",
        WheelSensor::Encoder(_) => "counts over its window",
    }
}

/// The lines that document [`Limits`].
pub fn documents(spec: &ModuleSpec, attitude: &AttitudeSpec) -> Vec<String> {
    let numbers = numbers(spec);
    let degrees = |rad: f64| format!("{:.2}°", rad.to_degrees());
    let counts = wheel_counts(&spec.hardware.wheel);
    let mut lines = vec![
        "When the controller is armed and when it trips.".to_owned(),
        String::new(),
        "| condition | limit |".to_owned(),
        "|---|---|".to_owned(),
        format!(
            "| armed within | {}, {:.3} rad/s, no sensor stuck |",
            degrees(numbers.angle_arm_rad),
            numbers.rate_arm_rad_s
        ),
        format!(
            "| attitude set by | quiet samples of about {WINDOW_S} s: gravity within {:.0} %, readings \
             within {:.0} % of it, below {QUIET_RAD_S} rad/s |",
            100.0 * GRAVITY_SHARE,
            100.0 * AGREEMENT_SHARE
        ),
        format!("| angle | {}, at once |", degrees(numbers.angle_trip_rad)),
        format!(
            "| gyroscope's reading unchanged | {:.4} s (assumes noise of at least half a count) |",
            numbers.frozen_s
        ),
        format!("| gyroscope or accelerometer clipped | {CLIPPED_S} s |"),
        format!("| wheel speed at the ends of its sensor | {WHEEL_S} s |"),
        format!(
            "| ends of the wheel's sensor | {}, {} {counts} |",
            spec.hardware.wheel_low, spec.hardware.wheel_high
        ),
        format!(
            "| ends of the gyroscope | {} counts |",
            attitude
                .gyro_clip
                .map(|counts| counts.to_string())
                .join(", ")
        ),
        format!(
            "| accelerometer shows no gravity | {} s |",
            countable(REJECTED_S, spec.sample_time_s)
        ),
        format!("| current at its limit | {:.3} s |", numbers.saturated_s),
    ];
    if matches!(spec.hardware.wheel, WheelSensor::Encoder(_)) {
        lines.push(
            "| the count of the wheel's encoder jumps further than any motion | at once |"
                .to_owned(),
        );
    }
    lines
}

/// The lines that document the limits where an encoder shows the body.
pub fn documents_for_encoder(spec: &ModuleSpec, body: &BodyEncoder) -> Vec<String> {
    let numbers = numbers(spec);
    let degrees = |rad: f64| format!("{:.2}°", rad.to_degrees());
    let mut lines = vec![
        "When the controller is armed and when it trips.".to_owned(),
        String::new(),
        "| condition | limit |".to_owned(),
        "|---|---|".to_owned(),
        format!(
            "| armed after | {WINDOW_S} s within {} and {:.3} rad/s, the wheel's speed known |",
            degrees(numbers.angle_arm_rad),
            numbers.rate_arm_rad_s
        ),
        format!("| angle | {}, at once |", degrees(numbers.angle_trip_rad)),
        format!(
            "| the body's count unchanged under a current of {:.3} A more than holds it against gravity | {:.3} s |",
            LEFT_OVER_SHARE * spec.current_limit_a,
            frozen_count_s(spec, &body.encoder)
        ),
        "| the count of the body's encoder jumps further than any motion | at once |".to_owned(),
        format!("| wheel speed at the ends of its sensor | {WHEEL_S} s |"),
        format!(
            "| ends of the wheel's sensor | {}, {} {} |",
            spec.hardware.wheel_low,
            spec.hardware.wheel_high,
            wheel_counts(&spec.hardware.wheel)
        ),
        format!("| current at its limit | {:.3} s |", numbers.saturated_s),
    ];
    if matches!(spec.hardware.wheel, WheelSensor::Encoder(_)) {
        lines.push(
            "| the count of the wheel's encoder jumps further than any motion | at once |"
                .to_owned(),
        );
    }
    lines.extend(
        [
            "",
            "A body that moves changes its count within the time for which it may stand still: by four counts, if only",
            "half of the current that gravity does not take accelerates it, and whichever way it ran before. A body that",
            "is held fast by hand while the motor runs looks like a count that is stuck. So does a body at rest that dry",
            "friction holds: an encoder that is stuck near upright asks for hardly any current, and is noticed only when",
        ]
        .map(str::to_owned),
    );
    lines.push(format!(
        "the wheel's speed asks for more. Stuck upright it lets the wheel come to {:.1} rad/s and what it gains in that time.",
        stuck_upright_rad_s(spec)
    ));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_time_is_whole_microseconds() {
        assert_eq!(sample_time_us(0.001), Ok(1000));
        assert_eq!(sample_time_us(0.0119), Ok(11_900));
        for bad in [1.6e-8, 1e-6, 0.000_123_4, 3.0] {
            assert!(sample_time_us(bad).is_err(), "{bad}");
        }
    }
}
