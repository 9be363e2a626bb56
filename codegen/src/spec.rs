//! What the generator is told: plain numbers in SI units, from identification and design.

use crate::hardware::HardwareSpec;
use crate::refusal::Refusal;

/// Everything from which a module is emitted.
///
/// States are x = (angle from upright, body rate, wheel speed) in rad, rad/s, rad/s; the law is
/// u = −K x in A. Every `f64` stands for its shortest decimal (the one that `{}` prints), and all
/// later arithmetic is exact on these decimals, so that text and number cannot disagree.
#[derive(Debug, Clone, PartialEq)]
pub struct ModuleSpec {
    /// Name of the model, as the documents of the emitted module state it.
    pub model_name: String,
    /// K of u = −K x: A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// The command is limited to ± this current (A).
    pub current_limit_a: f64,
    /// Time between two commands (s).
    pub sample_time_s: f64,
    /// The physical ranges from which the formats follow.
    pub ranges: PhysicalRanges,
    /// The drive that receives the command.
    pub drive: PwmDrive,
    /// The sensors that the states come from.
    pub hardware: HardwareSpec,
    /// Identified parameters of the model behind the gains.
    pub parameters: Vec<ModelParameter>,
    /// Diagonal of the state weight Q.
    pub state_weights: [f64; 3],
    /// Weight R of the current.
    pub current_weight: f64,
    /// Continuous linear model, A, row by row.
    pub a: [[f64; 3]; 3],
    /// Continuous linear model, B.
    pub b: [f64; 3],
    /// Linear model sampled at `sample_time_s` with a zero-order hold, Ad, row by row.
    pub ad: [[f64; 3]; 3],
    /// Sampled linear model, Bd.
    pub bd: [f64; 3],
    /// Certificate of the closed loop, put into `certificate.json` as it is; where there is none,
    /// [`crate::closed_loop`] finds one.
    pub closed_loop: Option<serde_json::Value>,
}

/// Largest magnitudes that the states reach on the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalRanges {
    /// Body angle from upright (rad).
    pub angle_rad: f64,
    /// Body rate (rad/s).
    pub rate_rad_s: f64,
    /// Wheel speed relative to the body (rad/s).
    pub wheel_speed_rad_s: f64,
}

impl PhysicalRanges {
    /// The bench of the thesis: any angle up to half a turn, every count of its gyroscope
    /// (32768 counts of 62.5 mdps are 35.7443 rad/s), a wheel of about ±700 rad/s.
    pub const THESIS_BENCH: Self = Self {
        angle_rad: core::f64::consts::PI,
        rate_rad_s: 35.745,
        wheel_speed_rad_s: 700.0,
    };
}

/// A current drive fed by a 16-bit PWM whose duty is a straight line of the current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwmDrive {
    /// Current at the ends of the duty range (A).
    pub current_range_a: f64,
    /// Duty at zero current (counts).
    pub duty_zero: u16,
    /// Duty at `current_range_a` (counts); as far below zero for the negative current.
    pub duty_max: u16,
}

impl PwmDrive {
    /// ESCON 24/2 of the thesis: 10 % to 90 % duty for −2.2 A to 2.2 A.
    pub const THESIS_BENCH: Self = Self {
        current_range_a: 2.2,
        duty_zero: 32_768,
        duty_max: 58_982,
    };

    /// Counts of duty between zero and the largest current.
    pub fn counts(&self) -> u16 {
        self.duty_max.saturating_sub(self.duty_zero)
    }
}

/// One identified parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameter {
    /// Name as in the model file, `total_inertia` for instance.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Standard error in `unit`, where one is known.
    pub std: Option<f64>,
    /// Unit as written in the model file.
    pub unit: String,
}

impl ModuleSpec {
    /// Refuses numbers that are no numbers and quantities that must be positive and are not.
    ///
    /// # Errors
    /// [`Refusal::NotFinite`] or [`Refusal::NotPositive`] with the name of the quantity.
    pub fn validate(&self) -> Result<(), Refusal> {
        for (index, gain) in self.gains.iter().enumerate() {
            finite(format!("gain K{}", index + 1), *gain)?;
        }
        let positive = [
            ("current limit", self.current_limit_a),
            ("sample time", self.sample_time_s),
            ("angle range", self.ranges.angle_rad),
            ("rate range", self.ranges.rate_rad_s),
            ("wheel speed range", self.ranges.wheel_speed_rad_s),
            ("current range of the drive", self.drive.current_range_a),
            (
                "duty span of the drive",
                f64::from(self.drive.duty_max) - f64::from(self.drive.duty_zero),
            ),
            ("current weight", self.current_weight),
        ];
        for (what, value) in positive {
            finite(what.to_owned(), value)?;
            if value <= 0.0 {
                return Err(Refusal::NotPositive {
                    what: what.to_owned(),
                    value,
                });
            }
        }
        let matrices = [("A", &self.a), ("Ad", &self.ad)];
        for (name, matrix) in matrices {
            for value in matrix.iter().flatten() {
                finite(format!("an entry of {name}"), *value)?;
            }
        }
        for (name, column) in [("B", &self.b), ("Bd", &self.bd)] {
            for value in column {
                finite(format!("an entry of {name}"), *value)?;
            }
        }
        for value in self.state_weights {
            finite("a state weight".to_owned(), value)?;
        }
        for parameter in &self.parameters {
            finite(format!("parameter {}", parameter.name), parameter.value)?;
            if let Some(std) = parameter.std {
                finite(format!("standard error of {}", parameter.name), std)?;
            }
        }
        Ok(())
    }
}

fn finite(what: String, value: f64) -> Result<(), Refusal> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(Refusal::NotFinite { what, value })
    }
}
