//! Sensors, mounting, filter and converter, as the certificate states them.

use num_rational::BigRational;
use num_traits::Signed;
use serde::Deserialize;
use serde::de::Deserializer;

use crate::certificate::stated_decimal::{StatedDecimal, stated};
use crate::exact::rational::power_of_two;

/// All of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Fields")]
pub struct CertifiedHardware {
    /// What shows the body.
    pub body: CertifiedBody,
    /// The wheel's speed.
    pub wheel_speed: CertifiedWheelSpeed,
}

/// What shows the body.
#[derive(Clone, Debug, PartialEq)]
pub enum CertifiedBody {
    /// Gyroscope and accelerometer.
    Inertial(Box<CertifiedInertial>),
    /// An encoder on the pivot.
    Encoder(CertifiedBodyEncoder),
}

/// Gyroscope and accelerometer, their mounting and the filter.
#[derive(Clone, Debug, PartialEq)]
pub struct CertifiedInertial {
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
    pub field_min_ut: StatedDecimal,
    /// Position of the accelerometer relative to the pivot axis, along its x and y (m).
    pub lever_arm_m: [StatedDecimal; 2],
    /// From the filter's angle to the body's (rad).
    pub mounting_angle_rad: StatedDecimal,
}

/// An encoder on the pivot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedBodyEncoder {
    /// Counts per turn; negative if they fall while the angle rises.
    pub counts_per_turn: StatedDecimal,
    /// The count begins again at zero after 2^`bits`.
    pub bits: u32,
    /// Steps over which its turn is taken.
    pub window: u32,
    /// Count with the body upright.
    pub zero: u32,
}

impl CertifiedBodyEncoder {
    /// Without its zero.
    pub fn encoder(&self) -> CertifiedEncoder {
        CertifiedEncoder {
            counts_per_turn: self.counts_per_turn.clone(),
            bits: self.bits,
            window: self.window,
        }
    }
}

impl CertifiedHardware {
    /// Gyroscope and accelerometer; `None` where an encoder shows the body.
    pub fn inertial(&self) -> Option<&CertifiedInertial> {
        match &self.body {
            CertifiedBody::Inertial(inertial) => Some(inertial),
            CertifiedBody::Encoder(_) => None,
        }
    }

    /// The encoder on the pivot, where there is one.
    pub fn body_encoder(&self) -> Option<&CertifiedBodyEncoder> {
        match &self.body {
            CertifiedBody::Inertial(_) => None,
            CertifiedBody::Encoder(encoder) => Some(encoder),
        }
    }
}

/// The fields as the file has them: either those of gyroscope and accelerometer, all of them, or `body_encoder`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    #[serde(default, deserialize_with = "present")]
    body_encoder: Option<CertifiedBodyEncoder>,
    #[serde(default, deserialize_with = "present")]
    gyroscope: Option<CertifiedSensor>,
    #[serde(default, deserialize_with = "present")]
    accelerometer: Option<CertifiedSensor>,
    #[serde(default, deserialize_with = "present")]
    magnetometer: Option<CertifiedSensor>,
    #[serde(default, deserialize_with = "present")]
    beta_rad_s: Option<StatedDecimal>,
    #[serde(default, deserialize_with = "present")]
    drift_time_s: Option<StatedDecimal>,
    #[serde(default, deserialize_with = "present")]
    drift_limit_rad_s: Option<StatedDecimal>,
    #[serde(default, deserialize_with = "present")]
    gravity_m_s2: Option<StatedDecimal>,
    #[serde(rename = "field_min_uT", default, deserialize_with = "present")]
    field_min_ut: Option<StatedDecimal>,
    #[serde(default, deserialize_with = "present")]
    lever_arm_m: Option<[StatedDecimal; 2]>,
    #[serde(default, deserialize_with = "present")]
    mounting_angle_rad: Option<StatedDecimal>,
    wheel_speed: CertifiedWheelSpeed,
}

/// A field that may be missing but must not be null.
fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

impl Fields {
    /// The names of the fields of gyroscope and accelerometer that are there.
    fn inertial_names(&self) -> Vec<&'static str> {
        let found = [
            ("gyroscope", self.gyroscope.is_some()),
            ("accelerometer", self.accelerometer.is_some()),
            ("magnetometer", self.magnetometer.is_some()),
            ("beta_rad_s", self.beta_rad_s.is_some()),
            ("drift_time_s", self.drift_time_s.is_some()),
            ("drift_limit_rad_s", self.drift_limit_rad_s.is_some()),
            ("gravity_m_s2", self.gravity_m_s2.is_some()),
            ("field_min_uT", self.field_min_ut.is_some()),
            ("lever_arm_m", self.lever_arm_m.is_some()),
            ("mounting_angle_rad", self.mounting_angle_rad.is_some()),
        ];
        let there = found.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(name, _)| name).collect()
    }
}

impl TryFrom<Fields> for CertifiedHardware {
    type Error = String;

    fn try_from(fields: Fields) -> Result<CertifiedHardware, String> {
        let names = fields.inertial_names();
        let missing = |name: &str| format!("missing field `{name}`");
        let body = match fields.body_encoder {
            Some(encoder) => match names.first() {
                None => CertifiedBody::Encoder(encoder),
                Some(name) => return Err(format!("unknown field `{name}` beside `body_encoder`")),
            },
            None => CertifiedBody::Inertial(Box::new(CertifiedInertial {
                gyroscope: fields.gyroscope.ok_or_else(|| missing("gyroscope"))?,
                accelerometer: fields
                    .accelerometer
                    .ok_or_else(|| missing("accelerometer"))?,
                magnetometer: fields.magnetometer.ok_or_else(|| missing("magnetometer"))?,
                beta_rad_s: fields.beta_rad_s.ok_or_else(|| missing("beta_rad_s"))?,
                drift_time_s: fields.drift_time_s.ok_or_else(|| missing("drift_time_s"))?,
                drift_limit_rad_s: fields
                    .drift_limit_rad_s
                    .ok_or_else(|| missing("drift_limit_rad_s"))?,
                gravity_m_s2: fields.gravity_m_s2.ok_or_else(|| missing("gravity_m_s2"))?,
                field_min_ut: fields.field_min_ut.ok_or_else(|| missing("field_min_uT"))?,
                lever_arm_m: fields.lever_arm_m.ok_or_else(|| missing("lever_arm_m"))?,
                mounting_angle_rad: fields
                    .mounting_angle_rad
                    .ok_or_else(|| missing("mounting_angle_rad"))?,
            })),
        };
        Ok(CertifiedHardware {
            body,
            wheel_speed: fields.wheel_speed,
        })
    }
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

impl CertifiedSensor {
    /// The change of the value along axis `row` of the body if every word changes by one step. That of a left-justified
    /// word is more than a count: the largest power of two that divides every count at which the sensor clips.
    pub fn step(&self, row: usize) -> BigRational {
        let clips = self.clip_counts.iter().filter(|clip| **clip != 0);
        let shift = clips.map(|clip| clip.trailing_zeros()).min().unwrap_or(0);
        let entries = self.matrix[row].iter();
        let count: BigRational = entries.map(|entry| entry.value.abs()).sum();
        count * power_of_two(shift as i32)
    }
}

impl CertifiedInertial {
    /// The change of the angle by one step of the accelerometer (rad).
    pub fn angle_step(&self) -> BigRational {
        self.accelerometer.step(0).max(self.accelerometer.step(1)) / &self.gravity_m_s2.value
    }

    /// The change of the body's rate by one step of the gyroscope (rad/s).
    pub fn rate_step(&self) -> BigRational {
        self.gyroscope.step(2)
    }
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
