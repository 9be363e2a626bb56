//! Sensors, mounting, filter and converter, as the certificate states them.

use serde::Deserialize;

use crate::certificate::stated_decimal::{StatedDecimal, stated};

/// All of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedHardware {
    /// Gyroscope, rad/s.
    pub gyroscope: CertifiedSensor,
    /// Accelerometer, m/s².
    pub accelerometer: CertifiedSensor,
    /// Magnetometer, µT.
    pub magnetometer: CertifiedSensor,
    /// β of the attitude filter (rad/s).
    pub beta_rad_s: StatedDecimal,
    /// Time constant with which the gyroscope's drift is tracked (s).
    pub drift_time_s: StatedDecimal,
    /// Largest drift that is tracked (rad/s).
    pub drift_limit_rad_s: StatedDecimal,
    /// Gravity (m/s²).
    pub gravity_m_s2: StatedDecimal,
    /// Weakest usable field (µT).
    #[serde(rename = "field_min_uT")]
    pub field_min_ut: StatedDecimal,
    /// Position of the accelerometer relative to the pivot axis, along its x and y (m).
    pub lever_arm_m: [StatedDecimal; 2],
    /// From the filter's angle to the body's (rad).
    pub mounting_angle_rad: StatedDecimal,
    /// The wheel's speed.
    pub wheel_speed: CertifiedWheelSpeed,
}

/// The calibration of a sensor: value = matrix (counts − bias).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedSensor {
    /// Counts at zero.
    pub bias_counts: [StatedDecimal; 3],
    /// Units per count, row by row.
    pub matrix: [[StatedDecimal; 3]; 3],
    /// Count at or beyond which the true value is unknown.
    pub clip_counts: [i32; 3],
}

/// A straight line from counts.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedWheelSpeed {
    /// `converter`, `driver` or `encoder`.
    pub kind: String,
    /// rad/s per count.
    pub rad_s_per_count: StatedDecimal,
    /// rad/s at zero counts.
    pub rad_s_at_zero: StatedDecimal,
    /// Lower end of the sensor's range; of an encoder, over its window.
    pub low_counts: i32,
    /// Upper end of it.
    pub high_counts: i32,
    /// The encoder; null if it is none.
    #[serde(deserialize_with = "stated")]
    pub encoder: Option<CertifiedEncoder>,
}

/// An absolute encoder.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedEncoder {
    /// Counts per turn; negative if they fall while the angle rises.
    pub counts_per_turn: StatedDecimal,
    /// The count begins again at zero after 2^`bits`.
    pub bits: u32,
    /// Steps over which its turn is taken.
    pub window: u32,
}
