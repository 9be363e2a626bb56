//! The section `[hardware]` of bench.toml and model.toml: which sensors and which drive the bench
//! has, and what their words mean.
//!
//! ```toml
//! [hardware.gyroscope]               # likewise accelerometer, magnetometer
//! part  = "FXAS21002"                # preset, see `parts`; the keys below override it
//! scale = 1.0908308e-3               # rad/s (accelerometer m/s2, magnetometer uT) per count
//! bits  = 16                         # justified = "right" | "left"
//! clip  = [32767, 32767, 32767]      # counts, per axis: at or beyond them the reading is not used
//! rate  = 800.0                      # fresh samples a second
//! axes  = ["x", "y", "z"]            # the body axis that each sensor axis shows; or rotation
//! lever_arm = [0.0, 0.0]             # m, accelerometer only, along body x and y
//! [hardware.wheel_speed]             # kind = "converter": slope, offset (rad/s), low, high (counts)
//!                                    # kind = "encoder": counts_per_turn, bits, window (samples)
//!                                    # kind = "driver": scale (rad/s per unit)
//! [hardware.angle]                   # kind = "inertial" | "encoder": counts_per_turn, bits, zero
//! [hardware.drive]                   # kind = "current" | "voltage": supply_voltage, winding_resistance
//! bits = 16                          # duty_zero, duty_low, duty_high (counts)
//! amperes_per_count = 8.39246e-5     # negative: inverted
//! ```
//!
//! What a part's preset gives is filled in while reading, so that the rest of the program sees
//! numbers only. The text as it was written is kept and copied from bench.toml to model.toml.

mod parts;
mod reading;

use toml_edit::{Item, TableLike};

pub use parts::{Part, known_parts};

/// What `[hardware]` states. Each part may be missing.
#[derive(Clone, Debug)]
pub struct Hardware {
    /// Angular rate in rad/s.
    pub gyroscope: Option<InertialSensor>,
    /// Specific force in m/s².
    pub accelerometer: Option<InertialSensor>,
    /// Magnetic field in µT.
    pub magnetometer: Option<InertialSensor>,
    /// Speed of the wheel relative to the body.
    pub wheel_speed: Option<WheelSpeedSensor>,
    /// What the body's angle is found from.
    pub angle: Option<AngleSensor>,
    /// What makes the motor's current.
    pub drive: Option<Drive>,
    /// The section as it was written.
    text: Item,
}

/// Two sections are equal if they say the same, however it is written.
impl PartialEq for Hardware {
    fn eq(&self, other: &Self) -> bool {
        self.gyroscope == other.gyroscope
            && self.accelerometer == other.accelerometer
            && self.magnetometer == other.magnetometer
            && self.wheel_speed == other.wheel_speed
            && self.angle == other.angle
            && self.drive == other.drive
    }
}

/// A three-axis sensor whose registers hold signed counts.
#[derive(Clone, Debug, PartialEq)]
pub struct InertialSensor {
    /// The part by whose data sheet missing keys were filled.
    pub part: Option<&'static Part>,
    /// Unit (rad/s, m/s², µT) per count of the 16-bit word that is read.
    pub scale: Option<f64>,
    /// Bits of a reading.
    pub bits: u32,
    /// Whether they stand at the upper end of the 16-bit word.
    pub is_left_justified: bool,
    /// Counts of that word, per axis, at or beyond which (either way) the true value is unknown.
    pub clip: [i32; 3],
    /// Fresh samples a second.
    pub rate_hz: Option<f64>,
    /// From the sensor's axes to the body's: x from the pivot to the centre of mass, z along the
    /// pivot axis.
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Position of an accelerometer from the pivot axis along the body's x and y, m.
    pub lever_arm_m: Option<[f64; 2]>,
}

/// How the wheel's speed relative to the body is read.
#[derive(Clone, Debug, PartialEq)]
pub enum WheelSpeedSensor {
    /// An analogue speed signal behind a converter: speed = `slope` count + `offset`.
    Converter {
        /// rad/s per count; `None` where calibration gives it.
        slope: Option<f64>,
        /// rad/s at zero counts; `None` where calibration gives it.
        offset: Option<f64>,
        /// Count at the lower end of the converter's range: there the speed may be any beyond.
        low: u16,
        /// Count at the upper end.
        high: u16,
    },
    /// An angle of the wheel; its speed is the difference over a window.
    Encoder {
        /// Counts in a turn; negative where they fall while the wheel turns forward.
        counts_per_turn: f64,
        /// Bits after which the count wraps.
        bits: u32,
        /// Samples over which the difference is taken.
        window: u32,
    },
    /// A speed in digital form.
    Driver {
        /// rad/s per unit.
        scale: f64,
    },
}

/// What the body's angle is found from.
#[derive(Clone, Debug, PartialEq)]
pub enum AngleSensor {
    /// Gyroscope and accelerometer.
    Inertial,
    /// An encoder on the pivot.
    Encoder {
        /// Counts in a turn; negative where they fall while the angle rises.
        counts_per_turn: f64,
        /// Bits after which the count wraps.
        bits: u32,
        /// Count upright.
        zero: u32,
    },
}

/// What makes the motor's current from the duty of a timer.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// What the drive holds at the value that the duty stands for.
    pub kind: DriveKind,
    /// Bits of the timer.
    pub bits: u32,
    /// Duty at zero current (voltage), counts.
    pub duty_zero: Option<u16>,
    /// Smallest duty that the drive reads as a value.
    pub duty_low: Option<u16>,
    /// Largest duty that the drive reads as a value.
    pub duty_high: Option<u16>,
    /// A (of a voltage drive: V) per count; negative where a larger duty drives backwards.
    pub amperes_per_count: Option<f64>,
}

/// What a drive holds at the value that the duty stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveKind {
    /// The current.
    Current,
    /// The voltage V = R u + τ φ̇, within the supply's.
    Voltage {
        /// V.
        supply_v: f64,
        /// Ω.
        winding_ohm: f64,
    },
}

impl Hardware {
    /// Puts the section into a document, as it was written; one that says it already stays.
    pub(crate) fn write(&self, root: &mut dyn TableLike) {
        let text = self.text.to_string();
        if root
            .get("hardware")
            .is_none_or(|old| old.to_string() != text)
        {
            root.insert("hardware", self.text.clone());
        }
    }
}
