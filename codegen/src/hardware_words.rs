//! The words of the hardware around the control law: constants of the sensors, and straight lines from one word to
//! another.
//!
//! The inputs are raw counts (inertial sensor or encoder, the wheel's sensor), the output is a duty. The slope of a
//! line is rounded once, to 30 bits.

use attitude::AttitudeSpec;

use crate::attitude::{self as attitude_words, AttitudeRefusal};
use crate::hardware::{BiasObserverSpec, BodyEncoder, BodySensor, WheelSensor};
use crate::helpers::bias_observer::BiasObserver;
use crate::helpers::body_supervisor::Limits as BodyLimits;
use crate::helpers::encoder::EncoderNumbers;
use crate::helpers::filter::FilterConstants;
use crate::helpers::line::Line;
use crate::helpers::plane::Plane;
use crate::helpers::supervisor::Limits;
use crate::ir::IntegerLaw;
use crate::spec::{ModuleSpec, PwmDrive, VoltageDrive};
use crate::supervisor;

/// An observer without effect.
const NO_OBSERVER: BiasObserver = BiasObserver {
    unit: 0,
    decay: 0,
    direct: [0; 3],
    from_states: [0; 3],
    from_current: 0,
    state_shift: 1,
    angle_shift: 1,
    limit: 0,
};

/// Smallest number of bits of a line's slope. Its error, half a unit in 2²³, is then a hundredth of a count over the
/// 2¹⁶ counts of a duty.
const SLOPE_BITS_MIN: f64 = 24.0;

/// Smallest shift of the duty's plane. Half a unit of a slope is then 2⁻⁸ counts for the largest word.
const PLANE_SHIFT_MIN: f64 = 38.0;

/// The words from the current to the duty.
#[derive(Debug, Clone, PartialEq)]
pub enum DutyWords {
    /// A current drive: from the word of the current.
    Line(Line),
    /// A voltage drive: from the words of current and wheel speed.
    Plane(Plane),
}

/// The words between the sensors of the body and its angle and rate, and those that supervise them.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyWords {
    /// The words of gyroscope and accelerometer.
    Inertial(Box<InertialWords>),
    /// The words of an encoder on the pivot.
    Encoder(BodyEncoderWords),
}

/// The words of an encoder on the pivot.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyEncoderWords {
    /// The encoder.
    pub encoder: EncoderNumbers,
    /// Its count with the body upright.
    pub zero: i32,
    /// From counts from upright to the word of the angle.
    pub angle: Line,
    /// From counts over the window to the word of the rate.
    pub rate: Line,
    /// From the word of the body's angle to the word of the current that holds the body at this angle.
    pub holding: Line,
    /// The words of the supervisor.
    pub limits: BodyLimits,
}

/// The words of gyroscope and accelerometer.
#[derive(Debug, Clone, PartialEq)]
pub struct InertialWords {
    /// The words of the attitude filter.
    pub filter: FilterConstants,
    /// Mounting angle in Q28 rad.
    pub mounting_angle: i32,
    /// Largest angle whose word fits, less the largest bias, in Q28 rad.
    pub angle_max: i32,
    /// Factor from Q28 rad to the word of the angle, before the shift: a power of two.
    pub angle_factor: i32,
    /// Number of bits by which the angle's word is coarser than Q28.
    pub angle_shift: u32,
    /// From half-angles per step in Q32 to the word of the rate.
    pub rate: Line,
    /// Observer of the angle's bias.
    pub bias_observer: BiasObserver,
    /// The words of the supervisor.
    pub limits: Limits,
}

/// All words of the emitted constants.
#[derive(Debug, Clone, PartialEq)]
pub struct HardwareWords {
    /// The words between the counts of the body's sensors and its angle and rate.
    pub body: BodyWords,
    /// From counts to the word of the wheel speed.
    pub wheel_speed: Line,
    /// The words of the wheel's encoder; `None` for another sensor.
    pub wheel_encoder: Option<EncoderNumbers>,
    /// From the word of the current to the duty.
    pub duty: DutyWords,
    /// Duty at zero current.
    pub zero_current: u16,
    /// Sample time in µs.
    pub sample_time_us: u32,
}

/// The words for `spec`, whose control law is `law`.
///
/// # Errors
/// [`AttitudeRefusal`] for numbers that are not finite or do not fit their format.
pub fn derive(spec: &ModuleSpec, law: &IntegerLaw) -> Result<HardwareWords, AttitudeRefusal> {
    let hardware = &spec.hardware;
    let unit = |bits: u32| 2f64.powi(bits as i32);
    let wheel_unit = unit(law.terms[2].input.format.fraction_bits);
    let current_unit = unit(law.current.fraction_bits);
    let wheel_max = word_at_most(spec.ranges.wheel_speed_rad_s * wheel_unit);
    let drive = &spec.drive;
    let duty = match &drive.voltage {
        None => DutyWords::Line(line(
            "the duty",
            1.0 / drive.amperes_per_count / current_unit,
            f64::from(drive.duty_zero),
            drive.duty_low.into(),
            drive.duty_high.into(),
        )?),
        Some(voltage) => DutyWords::Plane(plane(drive, voltage, current_unit, wheel_unit)?),
    };
    let wheel_encoder = match &hardware.wheel {
        WheelSensor::Encoder(encoder) => {
            Some(supervisor::encoder_numbers(encoder, spec.b[2], spec)?)
        }
        _ => None,
    };
    let body = match &hardware.body {
        BodySensor::Inertial(attitude) => {
            BodyWords::Inertial(Box::new(inertial_words(attitude, spec, law)?))
        }
        BodySensor::Encoder(encoder) => BodyWords::Encoder(body_encoder_words(encoder, spec, law)?),
    };
    Ok(HardwareWords {
        body,
        sample_time_us: supervisor::sample_time_us(spec.sample_time_s)?,
        wheel_speed: line(
            "the wheel speed",
            hardware.wheel_speed_per_count * wheel_unit,
            hardware.wheel_speed_at_zero * wheel_unit,
            -wheel_max,
            wheel_max,
        )?,
        wheel_encoder,
        duty,
        zero_current: drive.duty_zero,
    })
}

fn inertial_words(
    attitude: &AttitudeSpec,
    spec: &ModuleSpec,
    law: &IntegerLaw,
) -> Result<InertialWords, AttitudeRefusal> {
    let filter_spec = AttitudeSpec {
        sample_time_s: spec.sample_time_s,
        ..*attitude
    };
    let angle_bits = law.terms[0].input.format.fraction_bits;
    let rate_unit = 2f64.powi(law.terms[1].input.format.fraction_bits as i32);
    let bias_observer = match &spec.hardware.bias_observer {
        None => NO_OBSERVER,
        Some(observer) => observer_words(observer, law)?,
    };
    // The angle is limited so that angle − bias cannot overflow.
    let angle_max = (i32::MAX - bias_observer.limit) >> angle_bits.saturating_sub(28);
    let filter = attitude_words::derive(&filter_spec)?;
    Ok(InertialWords {
        limits: supervisor::derive(spec, law, attitude, &filter)?,
        filter,
        mounting_angle: attitude_words::mounting_word(filter_spec.mounting_angle_rad)?,
        angle_max,
        angle_factor: 1 << angle_bits.saturating_sub(28),
        angle_shift: 28u32.saturating_sub(angle_bits),
        rate: line(
            "the rate",
            2.0 / spec.sample_time_s * rate_unit / 2f64.powi(32),
            0.0,
            -i32::MAX,
            i32::MAX,
        )?,
        bias_observer,
    })
}

fn body_encoder_words(
    body: &BodyEncoder,
    spec: &ModuleSpec,
    law: &IntegerLaw,
) -> Result<BodyEncoderWords, AttitudeRefusal> {
    let unit = |index: usize| 2f64.powi(law.terms[index].input.format.fraction_bits as i32);
    let (angle_unit, rate_unit) = (unit(0), unit(1));
    let current_unit = 2f64.powi(law.current.fraction_bits as i32);
    let between = |what: &'static str, slope: f64, end: i32| line(what, slope, 0.0, -end, end);
    // The current that holds the body: sin is nearly its angle.
    let holding = spec.a[1][0] / spec.b[1].abs();
    Ok(BodyEncoderWords {
        encoder: supervisor::encoder_numbers(&body.encoder, spec.b[1], spec)?,
        zero: body.zero as i32,
        angle: between(
            "the angle",
            body.encoder.rad_per_count() * angle_unit,
            word_at_most(spec.ranges.angle_rad * angle_unit),
        )?,
        rate: between(
            "the rate",
            body.encoder.rad_s_per_count(spec.sample_time_s) * rate_unit,
            word_at_most(spec.ranges.rate_rad_s * rate_unit),
        )?,
        holding: between(
            "the current that holds the body",
            holding * current_unit / angle_unit,
            i32::MAX,
        )?,
        limits: supervisor::derive_for_encoder(spec, law, &body.encoder)?,
    })
}

/// The largest word at or below `value`, which is positive.
fn word_at_most(value: f64) -> i32 {
    value.floor().min(f64::from(i32::MAX)) as i32
}

/// The line `slope`·word + `at_zero`, rounded to the nearest, as words. The slope has 30 bits, or
/// fewer if the offset would otherwise exceed 2⁶¹. Each bit less doubles the slope's error,
/// which is a share of 2⁻³⁰ with 30 bits; with [`SLOPE_BITS_MIN`] bits, every word of the result is still correct.
fn line(
    what: &'static str,
    slope: f64,
    at_zero: f64,
    low: i32,
    high: i32,
) -> Result<Line, AttitudeRefusal> {
    let refused = |value: f64| AttitudeRefusal::NoLine { what, value };
    // The shift that brings the slope into [2²⁹, 2³⁰).
    let finest = 29.0 - slope.abs().log2().floor();
    // The largest shift with which the offset fits.
    let room = (2f64.powi(61) / (at_zero + 0.5).abs()).log2().floor();
    if !finest.is_finite() || !at_zero.is_finite() {
        return Err(refused(slope));
    }
    let shift = finest.min(room).min(62.0);
    if shift < 1.0 || finest - shift > 30.0 - SLOPE_BITS_MIN {
        return Err(refused(slope));
    }
    let scale = 2f64.powf(shift);
    let offset = (at_zero + 0.5) * scale;
    Ok(Line {
        scale: (slope * scale).round() as i32,
        offset: offset.round() as i64,
        shift: shift as u32,
        low,
        high,
    })
}

/// The plane of a voltage drive, V = R u + k_e φ̇ over the volts of a count, with as many bits as the larger slope and
/// the offset leave room for.
fn plane(
    drive: &PwmDrive,
    voltage: &VoltageDrive,
    current_unit: f64,
    wheel_unit: f64,
) -> Result<Plane, AttitudeRefusal> {
    let of_current = voltage.winding_ohm / voltage.volts_per_count / current_unit;
    let of_speed = voltage.back_emf_v_s / voltage.volts_per_count / wheel_unit;
    let largest = of_current.abs().max(of_speed.abs());
    let at_zero = f64::from(drive.duty_zero) + 0.5;
    let room = (2f64.powi(61) / at_zero).log2().floor();
    let shift = (29.0 - largest.log2().floor()).min(room).min(62.0);
    if !(shift >= PLANE_SHIFT_MIN && largest > 0.0) {
        return Err(AttitudeRefusal::NoLine {
            what: "the duty",
            value: largest,
        });
    }
    let scale = 2f64.powf(shift);
    Ok(Plane {
        current: (of_current * scale).round() as i32,
        speed: (of_speed * scale).round() as i32,
        offset: (at_zero * scale).round() as i64,
        shift: shift as u32,
        low: drive.duty_low.into(),
        high: drive.duty_high.into(),
    })
}

/// The observer's words, with as many fraction bits in the products as fit 64 bits.
fn observer_words(
    spec: &BiasObserverSpec,
    law: &IntegerLaw,
) -> Result<BiasObserver, AttitudeRefusal> {
    const STATE_BITS: i32 = 30;
    let angle_bits = law.terms[0].input.format.fraction_bits as i32;
    let limit = (spec.limit_rad * 2f64.powi(angle_bits)).round();
    let refused = |what: &'static str, value: f64| AttitudeRefusal::NoLine { what, value };
    if !(limit >= 1.0 && limit <= 2f64.powi(29)) {
        return Err(refused("the limit of the angle's bias", spec.limit_rad));
    }
    for product_bits in (STATE_BITS.max(angle_bits) + 1..=60).rev() {
        let word = |value: f64, bits: i32| (value * 2f64.powi(product_bits - bits)).round();
        let of_states = |values: [f64; 3]| {
            [0, 1, 2].map(|i| word(values[i], law.terms[i].input.format.fraction_bits as i32))
        };
        let unit = word(1.0, STATE_BITS);
        let decay = word(spec.decay, STATE_BITS);
        let direct = of_states(spec.direct);
        let from_states = of_states(spec.from_states);
        let from_current = word(spec.from_current, law.current.fraction_bits as i32);
        let sum = |values: [f64; 3]| values.iter().map(|value| value.abs()).sum::<f64>();
        let largest = (unit + sum(direct)).max(decay.abs() + sum(from_states) + from_current.abs());
        // Words below 2³¹ times this number, and a half, stay below 2⁶³.
        if largest < 2f64.powi(31) {
            return Ok(BiasObserver {
                unit: unit as i32,
                decay: decay as i32,
                direct: direct.map(|value| value as i32),
                from_states: from_states.map(|value| value as i32),
                from_current: from_current as i32,
                state_shift: (product_bits - STATE_BITS) as u32,
                angle_shift: (product_bits - angle_bits) as u32,
                limit: limit as i32,
            });
        }
    }
    Err(refused("the bias observer", spec.direct[1]))
}
