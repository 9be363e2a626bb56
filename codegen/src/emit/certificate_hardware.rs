//! Sensors, mounting, filter and converter in `certificate.json`: the real numbers whose words are in
//! `src/constants.rs`.

use attitude::AttitudeSpec;
use serde::Serialize;

use crate::exact::ShortestDecimal;
use crate::hardware::{BodySensor, EncoderSpec, WheelSensor};
use crate::spec::ModuleSpec;

/// The hardware of the module.
#[derive(Debug, Serialize)]
pub(super) struct Hardware {
    #[serde(flatten)]
    body: Body,
    wheel_speed: WheelSpeed,
}

/// The sensors that measure the body's angle and rate.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Body {
    Inertial(Box<Inertial>),
    Encoder { body_encoder: BodyCounts },
}

/// An encoder on the pivot.
#[derive(Debug, Serialize)]
struct BodyCounts {
    #[serde(flatten)]
    encoder: Encoder,
    /// Count with the body upright.
    zero: u32,
}

/// Gyroscope and accelerometer, their mounting and the filter.
#[derive(Debug, Serialize)]
struct Inertial {
    gyroscope: Sensor,
    accelerometer: Sensor,
    magnetometer: Sensor,
    /// β of the filter.
    beta_rad_s: String,
    /// Time constant with which the filter follows the gyroscope's drift.
    drift_time_s: String,
    /// Largest drift of the gyroscope that the filter follows.
    drift_limit_rad_s: String,
    gravity_m_s2: String,
    /// Weakest magnetic field that the filter uses.
    #[serde(rename = "field_min_uT")]
    field_min_ut: String,
    /// Lever arm of the accelerometer along its x and y axis, from the pivot.
    lever_arm_m: [String; 2],
    mounting_angle_rad: String,
}

/// Reading = unit · matrix (counts − bias), in rad/s, m/s² or µT.
#[derive(Debug, Serialize)]
struct Sensor {
    bias_counts: [String; 3],
    /// Row by row, units per count.
    matrix: [[String; 3]; 3],
    /// Magnitude in counts, per axis, at and beyond which the true value is unknown.
    clip_counts: [i32; 3],
}

/// The sensor of the wheel speed: a straight line from counts to rad/s.
#[derive(Debug, Serialize)]
struct WheelSpeed {
    /// `converter`, `driver` or `encoder`.
    kind: &'static str,
    rad_s_per_count: String,
    rad_s_at_zero: String,
    /// Lower end of the sensor's range. For an encoder, the range of the difference over its window.
    low_counts: i32,
    high_counts: i32,
    /// The encoder, if the kind is `encoder`.
    encoder: Option<Encoder>,
}

/// An absolute encoder.
#[derive(Debug, Serialize)]
struct Encoder {
    counts_per_turn: String,
    bits: u32,
    /// Number of steps over which the difference of the counts is taken.
    window: u32,
}

impl Encoder {
    fn of(encoder: &EncoderSpec) -> Encoder {
        Encoder {
            counts_per_turn: ShortestDecimal::new(encoder.counts_per_turn).text,
            bits: encoder.bits,
            window: encoder.window,
        }
    }
}

impl Inertial {
    fn of(attitude: &AttitudeSpec) -> Inertial {
        let number = |value: f64| ShortestDecimal::new(value).text;
        let sensor = |line: &attitude::SensorLine, clip_counts: [i32; 3]| Sensor {
            clip_counts,
            bias_counts: [0, 1, 2].map(|axis| number(line.bias_counts[axis])),
            matrix: [0, 1, 2].map(|row| [0, 1, 2].map(|column| number(line.matrix[(row, column)]))),
        };
        Inertial {
            gyroscope: sensor(&attitude.gyro, attitude.gyro_clip),
            accelerometer: sensor(&attitude.accel, attitude.accel_clip),
            magnetometer: sensor(&attitude.mag, attitude.mag_clip),
            beta_rad_s: number(attitude.beta_rad_s),
            drift_time_s: number(attitude.drift_time_s),
            drift_limit_rad_s: number(attitude.drift_limit_rad_s),
            gravity_m_s2: number(attitude.gravity_m_s2),
            field_min_ut: number(attitude.field_min_ut),
            lever_arm_m: attitude.lever_arm_m.map(number),
            mounting_angle_rad: number(attitude.mounting_angle_rad),
        }
    }
}

impl Hardware {
    /// The numbers of `spec`.
    pub(super) fn of(spec: &ModuleSpec) -> Hardware {
        let number = |value: f64| ShortestDecimal::new(value).text;
        let body = match &spec.hardware.body {
            BodySensor::Inertial(attitude) => Body::Inertial(Box::new(Inertial::of(attitude))),
            BodySensor::Encoder(body) => Body::Encoder {
                body_encoder: BodyCounts {
                    encoder: Encoder::of(&body.encoder),
                    zero: body.zero,
                },
            },
        };
        let (kind, encoder) = match &spec.hardware.wheel {
            WheelSensor::Converter => ("converter", None),
            WheelSensor::Driver => ("driver", None),
            WheelSensor::Encoder(encoder) => ("encoder", Some(Encoder::of(encoder))),
        };
        Hardware {
            body,
            wheel_speed: WheelSpeed {
                kind,
                encoder,
                rad_s_per_count: number(spec.hardware.wheel_speed_per_count),
                rad_s_at_zero: number(spec.hardware.wheel_speed_at_zero),
                low_counts: spec.hardware.wheel_low,
                high_counts: spec.hardware.wheel_high,
            },
        }
    }
}
