//! Reads `certificate.json` strictly: every field must exist, and no other field may.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::certificate::hardware::CertifiedHardware;
use crate::certificate::stated_decimal::stated;
use crate::exact::matrices::{Matrix, Vector};

pub use crate::certificate::stated_decimal::StatedDecimal;

/// The whole certificate.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Language of the emitted files if it is not Rust. Such files are not read here; their words are those of the Rust.
    #[serde(default)]
    pub language: Option<String>,
    /// Identification of the generator.
    pub generator: String,
    /// Version of this file's layout.
    pub format_version: u32,
    /// Name of the model.
    pub model: String,
    /// Emitted files.
    pub files: Vec<String>,
    /// Time between two commands (s).
    pub sample_time_s: StatedDecimal,
    /// Identified parameters.
    pub parameters: Vec<CertifiedParameter>,
    /// Correlations of their errors; null if none are known.
    #[serde(deserialize_with = "stated")]
    pub correlation: Option<CertifiedCorrelation>,
    /// Weights of the design.
    pub weights: CertifiedWeights,
    /// Linear model.
    pub plant: CertifiedPlant,
    /// K of u = −K x.
    pub gains: [StatedDecimal; 3],
    /// The current drive.
    pub drive: CertifiedDrive,
    /// Sensors, mounting, filter and converter.
    pub hardware: CertifiedHardware,
    /// The accelerometer's scale from its part or as stated, independent of its calibration (m/s² per count);
    /// null if only a calibration is known.
    #[serde(deserialize_with = "stated")]
    pub accelerometer_m_s2_per_count: Option<StatedDecimal>,
    /// Rate of new gyroscope samples (Hz); null for one in each step.
    #[serde(deserialize_with = "stated")]
    pub gyro_rate_hz: Option<StatedDecimal>,
    /// Properties of sensors and drive that were assumed; sentences.
    pub assumed: Vec<String>,
    /// Arguments of `control`.
    pub inputs: [CertifiedInput; 3],
    /// Result of `control`.
    pub output: CertifiedOutput,
    /// Constants of the source: three gains and the limit.
    pub constants: [CertifiedConstant; 4],
    /// Bounds of one step.
    pub bounds: CertifiedBounds,
    /// The claims.
    pub claims: Vec<CertifiedClaim>,
    /// The observer of the angle's bias; null if the module has none.
    #[serde(deserialize_with = "stated")]
    pub bias_observer: Option<CertifiedObserver>,
    /// Bounds of the closed loop for all time; null if there are none.
    #[serde(deserialize_with = "stated")]
    pub closed_loop: Option<CertifiedLoop>,
    /// Rows of the coordinates in which each mode of the loop decays by itself; null if there are none.
    #[serde(deserialize_with = "stated")]
    pub modes: Option<[[StatedDecimal; 3]; 3]>,
    /// The monitor; missing where the module has none.
    #[serde(default)]
    pub monitor: Option<CertifiedMonitor>,
}

/// The monitor of the motion; see [`crate::claims::monitor`] for what the numbers mean.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedMonitor {
    /// Standard deviations of the measured angle (rad), rate and wheel speed (rad/s).
    pub noise_std: [StatedDecimal; 3],
    /// Change of the body's rate by a push that is allowed (rad/s).
    pub push_rad_s: StatedDecimal,
    /// Limit of the sum of the wheel's own speed (rad/s).
    pub wheel_limit_rad_s: StatedDecimal,
    /// Limit of the sum of the body's rate (rad/s).
    pub body_limit_rad_s: StatedDecimal,
}

/// A parameter of the model.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedParameter {
    /// Name.
    pub name: String,
    /// Value in `unit`.
    pub value: StatedDecimal,
    /// Standard error; null if unknown, but never missing.
    #[serde(deserialize_with = "stated")]
    pub std: Option<StatedDecimal>,
    /// Unit.
    pub unit: String,
}

/// Correlations of the errors of parameters.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedCorrelation {
    /// Names; parameters that are not among them are independent.
    pub parameters: Vec<String>,
    /// Row by row in that order, dimensionless.
    pub matrix: Vec<Vec<StatedDecimal>>,
}

/// Diagonal of Q, and R.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedWeights {
    /// Of the states.
    pub state: [StatedDecimal; 3],
    /// Of the current.
    pub current: StatedDecimal,
}

/// The linear model, continuous and sampled.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "PascalCase")]
pub struct CertifiedPlant {
    /// A.
    pub a: [[StatedDecimal; 3]; 3],
    /// B.
    pub b: [StatedDecimal; 3],
    /// Ad.
    pub ad: [[StatedDecimal; 3]; 3],
    /// Bd.
    pub bd: [StatedDecimal; 3],
}

/// The drive.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedDrive {
    /// Bits of the timer.
    pub bits: u32,
    /// Duty at zero current.
    pub duty_zero: u16,
    /// Smallest duty that the drive reads as a current.
    pub duty_low: u16,
    /// Largest duty that the drive reads as a current.
    pub duty_high: u16,
    /// A per count; negative if a larger duty drives backwards. Of a voltage drive: at standstill.
    pub amperes_per_count: StatedDecimal,
    /// The largest current that the drive gives in both directions (A).
    #[serde(rename = "current_range_A")]
    pub current_range_a: StatedDecimal,
    /// What a voltage drive is besides; null for a current drive.
    #[serde(deserialize_with = "stated")]
    pub voltage: Option<CertifiedVoltage>,
}

/// A drive that sets the voltage V = R u + k_e φ̇.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedVoltage {
    /// V per count; negative if a larger duty drives backwards.
    pub volts_per_count: StatedDecimal,
    /// Supply voltage (V).
    #[serde(rename = "supply_V")]
    pub supply_v: StatedDecimal,
    /// Winding resistance R (Ohm).
    #[serde(rename = "winding_Ohm")]
    pub winding_ohm: StatedDecimal,
    /// Back-EMF k_e (V s/rad).
    #[serde(rename = "back_emf_V_s")]
    pub back_emf_v_s: StatedDecimal,
    /// The linear model sampled with V/R held: see [`crate::claims::held_loop`].
    #[serde(rename = "Ad")]
    pub ad: [[StatedDecimal; 3]; 3],
    /// The sampled B, per ampere at standstill.
    #[serde(rename = "Bd")]
    pub bd: [StatedDecimal; 3],
}

/// An argument of `control`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedInput {
    /// Name.
    pub argument: String,
    /// Alias.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Type of the crate `fixed`.
    pub fixed: String,
    /// Fraction bits.
    pub fraction_bits: u32,
    /// Largest magnitude on the bench.
    pub range: StatedDecimal,
    /// Unit.
    pub unit: String,
}

/// The result of `control`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedOutput {
    /// Alias.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Type of the crate `fixed`.
    pub fixed: String,
    /// Fraction bits.
    pub fraction_bits: u32,
    /// Unit.
    pub unit: String,
}

/// A constant of the source.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedConstant {
    /// Name.
    pub name: String,
    /// File.
    pub file: String,
    /// Line.
    pub line: usize,
    /// Name of the number in the certificate from which it was computed.
    pub from: String,
    /// Real number.
    pub real: StatedDecimal,
    /// Word.
    pub raw: i64,
    /// Fraction bits of the word.
    pub fraction_bits: u32,
    /// Unit.
    pub unit: String,
    /// Claims that depend on it.
    pub claims: Vec<String>,
}

/// Bounds of one step.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedBounds {
    /// Fraction bits of each product.
    pub product_fraction_bits: u32,
    /// Bits that the rounding removes.
    pub shift: u32,
    /// Against the quantised gains (A).
    #[serde(rename = "rounding_A")]
    pub rounding: StatedDecimal,
    /// Against the real gains (A).
    #[serde(rename = "real_gains_A")]
    pub real_gains: StatedDecimal,
    /// Additional error from rounding a real state (A).
    #[serde(rename = "state_rounding_A")]
    pub state_rounding: StatedDecimal,
}

/// Observer of the angle's bias; see [`crate::claims::bias_observer_numbers`] for its equations.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedObserver {
    /// λ, dimensionless.
    pub decay: StatedDecimal,
    /// ℓ, rad per unit of each state.
    pub direct: [StatedDecimal; 3],
    /// f, rad per unit of each state.
    pub from_states: [StatedDecimal; 3],
    /// g (rad/A).
    pub from_current: StatedDecimal,
    /// Largest estimate (rad).
    pub limit_rad: StatedDecimal,
}

/// A claim.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedClaim {
    /// Identifier.
    pub id: String,
    /// One sentence.
    pub statement: String,
    /// For which inputs.
    pub domain: String,
    /// Bound (A), if the claim has one.
    #[serde(rename = "bound_A", default)]
    pub bound: Option<StatedDecimal>,
}

/// Bounds of the closed loop for all time; see [`crate::claims::closed_loop_for_all_time`] for what they mean.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedLoop {
    /// P of the invariant set xᵀ P x ≤ 1.
    pub ellipsoid: [[StatedDecimal; 3]; 3],
    /// γ: the loop maps the set into γ times itself.
    pub contraction: StatedDecimal,
    /// Largest magnitude of each state in the set, rounded up.
    pub extents: [StatedDecimal; 3],
    /// Largest |K x| in the set, rounded up (A).
    #[serde(rename = "command_A")]
    pub command: StatedDecimal,
    /// Size of one step of the sensors' readings: rad, rad/s, rad/s. A left-justified word moves by more than a count.
    pub sensor_steps: [StatedDecimal; 3],
    /// Largest acceleration of the wheel in the set (rad/s²), where an encoder shows its speed over a window; null where
    /// none does.
    #[serde(rename = "wheel_acceleration_rad_s2", deserialize_with = "stated")]
    pub wheel_acceleration: Option<StatedDecimal>,
    /// Share of the set that the perturbations need, at most 1, rounded up.
    pub perturbation_share: StatedDecimal,
    /// Number of terms in the sum; the rest is bounded by a geometric series.
    pub terms: u32,
    /// Bound of that rest for the current, per perturbation of 1 A (A), rounded up.
    #[serde(rename = "rest_A")]
    pub rest: StatedDecimal,
    /// The two kinds of perturbation, with their bounds: by words, by sensors.
    pub cases: [CertifiedLoopCase; 2],
}

/// One kind of perturbation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedLoopCase {
    /// `words` or `sensors`.
    pub name: String,
    /// Largest perturbation of the command in one step (A), rounded up.
    #[serde(rename = "perturbation_A")]
    pub perturbation: StatedDecimal,
    /// Largest difference between the two loops at any time: rad, rad/s, rad/s, rounded up.
    pub states: [StatedDecimal; 3],
    /// The same of K x (A), rounded up.
    #[serde(rename = "command_A")]
    pub command: StatedDecimal,
}

/// The reason why a certificate could not be read.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// The operating system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Not JSON, or not of this layout.
    #[error("certificate.json:{}:{}: {source}", source.line(), source.column())]
    Json {
        /// The reader's error.
        #[from]
        source: serde_json::Error,
    },
}

impl Certificate {
    /// Reads the text of a certificate.
    ///
    /// # Errors
    /// [`CertificateError::Json`] with line and column.
    pub fn parse(text: &str) -> Result<Certificate, CertificateError> {
        Ok(serde_json::from_str(text)?)
    }

    /// Reads `certificate.json` in `directory`.
    ///
    /// # Errors
    /// [`CertificateError`].
    pub fn read(directory: &Path) -> Result<Certificate, CertificateError> {
        let path = directory.join("certificate.json");
        let text =
            fs::read_to_string(&path).map_err(|source| CertificateError::Io { path, source })?;
        Certificate::parse(&text)
    }

    /// A constant by name.
    pub fn constant(&self, name: &str) -> Option<&CertifiedConstant> {
        self.constants.iter().find(|constant| constant.name == name)
    }
}

/// Values of a matrix.
pub fn matrix(entries: &[[StatedDecimal; 3]; 3]) -> Matrix {
    [0, 1, 2].map(|i| vector(&entries[i]))
}

/// Values of a vector.
pub fn vector(entries: &[StatedDecimal; 3]) -> Vector {
    [0, 1, 2].map(|i| entries[i].value.clone())
}
