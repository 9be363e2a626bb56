//! The input of the generator: plain numbers in SI units, from identification and design.

use crate::hardware::{BodySensor, HardwareSpec, WheelSensor};
use crate::refusal::Refusal;
use crate::runtime_parts::{Parts, WheelPart};

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
    /// Sentences about the values of sensors and drive that the bench does not state and that come from another bench.
    pub assumed: Vec<String>,
    /// Identified parameters of the model behind the gains.
    pub parameters: Vec<ModelParameter>,
    /// Correlations of the errors of these parameters, where they are known.
    pub correlation: Option<ParameterCorrelation>,
    /// Diagonal of the state weight Q, in 1/s per rad², (rad/s)², (rad/s)².
    pub state_weights: [f64; 3],
    /// Weight R of the current, in 1/s per A².
    pub current_weight: f64,
    /// State matrix A (3×3) of the continuous linear model, row by row, units of row over column per second.
    pub a: [[f64; 3]; 3],
    /// Input matrix B (3×1) of the continuous linear model, units of row per A and second.
    pub b: [f64; 3],
    /// State matrix Ad (3×3) of the model sampled at `sample_time_s` with a zero-order hold, row by row.
    pub ad: [[f64; 3]; 3],
    /// Input matrix Bd (3×1) of the sampled model, units of row per A.
    pub bd: [f64; 3],
    /// Certificate of the closed loop, which goes into `certificate.json` unchanged. If it is `None`,
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
    /// The ranges that the sensors can show: any angle up to half a turn, every rate within the gyroscope's counts (or
    /// the stated largest rate of an encoder), and every speed within the range of the wheel's sensor. The fifth digit
    /// is rounded up.
    pub fn of(hardware: &HardwareSpec) -> Self {
        let rate = match &hardware.body {
            BodySensor::Inertial(attitude) => {
                let gyro = &attitude.gyro;
                let counts = gyro.bias_counts.map(|bias| 32_768.0 + bias.abs());
                (gyro.matrix.row(2).abs() * counts)[0]
            }
            BodySensor::Encoder(encoder) => encoder.largest_rate_rad_s,
        };
        let speed = |count: i32| {
            hardware.wheel_speed_per_count * f64::from(count) + hardware.wheel_speed_at_zero
        };
        let wheel = speed(hardware.wheel_low)
            .abs()
            .max(speed(hardware.wheel_high).abs());
        Self {
            angle_rad: core::f64::consts::PI,
            rate_rad_s: rounded_up(rate),
            wheel_speed_rad_s: rounded_up(wheel),
        }
    }
}

/// The next larger number with five digits. A number that is not positive stays as it is, so that validation refuses it
/// by name.
fn rounded_up(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return value;
    }
    let digits = 4 - value.log10().floor() as i32;
    let scaled = (value * 10f64.powi(digits) * (1.0 - 1e-12)).ceil();
    // The value is read back from its decimal, because documents print this decimal.
    format!("{scaled:.0}e{}", -digits).parse().unwrap_or(value)
}

/// A drive whose current (or voltage) is a straight line over the duty of a timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwmDrive {
    /// Bits of the timer.
    pub bits: u32,
    /// Duty at zero current (counts).
    pub duty_zero: u16,
    /// Smallest duty that the drive reads as a current.
    pub duty_low: u16,
    /// Largest duty that the drive reads as a current.
    pub duty_high: u16,
    /// A per count; negative if a larger duty drives backwards. For a voltage drive, the current at standstill.
    pub amperes_per_count: f64,
    /// Further properties of a voltage drive; `None` for a current drive.
    pub voltage: Option<VoltageDrive>,
}

/// A drive that sets the voltage V = R u + k_e φ̇ across the winding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageDrive {
    /// V per count; negative where a larger duty drives backwards.
    pub volts_per_count: f64,
    /// Supply voltage: largest |V| (V).
    pub supply_v: f64,
    /// Winding resistance R (Ohm).
    pub winding_ohm: f64,
    /// Back-EMF k_e (V s/rad), the motor's torque constant.
    pub back_emf_v_s: f64,
}

impl PwmDrive {
    /// ESCON 24/2 of the thesis: 10 % to 90 % duty of 16 bits for −2.2 A to 2.2 A.
    pub const THESIS_BENCH: Self = Self {
        bits: 16,
        duty_zero: 32_768,
        duty_low: 6_554,
        duty_high: 58_982,
        amperes_per_count: 2.2 / 26_214.0,
        voltage: None,
    };

    /// Counts of duty between zero and the largest current that the drive gives both ways.
    pub fn counts(&self) -> u16 {
        let above = self.duty_high.saturating_sub(self.duty_zero);
        above.min(self.duty_zero.saturating_sub(self.duty_low))
    }

    /// The largest current that the drive gives both ways (A).
    pub fn current_range_a(&self) -> f64 {
        f64::from(self.counts()) * self.amperes_per_count.abs()
    }
}

/// Correlations of the errors of parameters, dimensionless.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterCorrelation {
    /// Names of the parameters, each with a standard error.
    pub parameters: Vec<String>,
    /// Row by row in that order: symmetric, ones on the diagonal, no negative eigenvalue.
    pub matrix: Vec<Vec<f64>>,
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
    /// The parts of the runtime files that the module has.
    pub fn parts(&self) -> Parts {
        Parts {
            has_body_encoder: self.hardware.body_encoder().is_some(),
            wheel: match self.hardware.wheel {
                WheelSensor::Converter => WheelPart::Converter,
                WheelSensor::Driver => WheelPart::Driver,
                WheelSensor::Encoder(_) => WheelPart::Encoder,
            },
            has_voltage_drive: self.drive.voltage.is_some(),
        }
    }

    /// Refuses numbers that are not finite, and quantities that must be positive and are not.
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
            ("duty span of the drive", f64::from(self.drive.counts())),
            ("current range of the drive", self.drive.current_range_a()),
            ("current weight", self.current_weight),
        ];
        let of_voltage = self.drive.voltage.iter().flat_map(|drive| {
            [
                ("supply voltage", drive.supply_v),
                ("winding resistance", drive.winding_ohm),
                ("back-EMF of the motor", drive.back_emf_v_s),
            ]
        });
        for (what, value) in positive.into_iter().chain(of_voltage) {
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
        let correlations = self
            .correlation
            .iter()
            .flat_map(|found| found.matrix.iter());
        for value in correlations.flatten() {
            finite("a correlation of parameters".to_owned(), *value)?;
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
