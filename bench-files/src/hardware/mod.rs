//! The section `[hardware]` of bench.toml and model.toml: the bench's sensors and drive, and how to convert their raw
//! values.
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
//!                                    # encoder and driver: largest (rad/s), where it is known
//! [hardware.angle]                   # kind = "inertial" | "encoder": counts_per_turn, bits, zero
//! [hardware.drive]                   # kind = "current" | "voltage": supply_voltage, winding_resistance
//! bits = 16                          # duty_zero, duty_low, duty_high (counts)
//! amperes_per_count = 8.39246e-5     # negative: inverted
//! ```
//!
//! Missing values are filled in from the part's preset while reading, so the rest of the program uses
//! numbers only. The section's text is kept as written, and copied from bench.toml to model.toml.

mod parts;
mod reading;
mod rotation;

use toml_edit::{DocumentMut, Item, TableLike};

pub use parts::{Part, known_parts};

/// The content of `[hardware]`. Each part may be missing.
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
    /// The source of the body's angle.
    pub angle: Option<AngleSensor>,
    /// The drive of the motor.
    pub drive: Option<Drive>,
    /// The section as it was written.
    text: Item,
}

/// Two sections are equal if their content is equal, even if their text differs.
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
    /// The part whose preset filled in missing keys.
    pub part: Option<&'static Part>,
    /// Unit (rad/s, m/s², µT) per count of the 16-bit word that is read.
    pub scale: Option<f64>,
    /// Number of bits of a reading.
    pub bits: u32,
    /// Whether these bits are at the upper end of the 16-bit word.
    pub is_left_justified: bool,
    /// Count of that word, per axis, at or beyond which (in either direction) the true value is unknown.
    pub clip: [i32; 3],
    /// Rate of new samples, Hz.
    pub rate_hz: Option<f64>,
    /// Rotation matrix from the sensor's axes to the body's: x from the pivot to the centre of mass, z along the
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
        /// rad/s per count; `None` if it comes from the calibration.
        slope: Option<f64>,
        /// rad/s at zero counts; `None` if it comes from the calibration.
        offset: Option<f64>,
        /// Count at the lower end of the converter's range; the true speed may lie beyond.
        low: u16,
        /// Count at the upper end.
        high: u16,
    },
    /// An angle of the wheel; its speed is the difference over a window.
    Encoder {
        /// Counts per turn; negative if they fall while the wheel turns forward.
        counts_per_turn: f64,
        /// Number of bits after which the count wraps around.
        bits: u32,
        /// Number of samples over which the difference is taken.
        window: u32,
        /// Largest speed of the wheel, rad/s; `None` if it is not stated.
        largest_rad_s: Option<f64>,
    },
    /// A digital speed signal from the motor driver.
    Driver {
        /// rad/s per unit.
        scale: f64,
        /// Largest speed of the wheel, rad/s; `None` if it is not stated.
        largest_rad_s: Option<f64>,
    },
}

/// The source of the body's angle.
#[derive(Clone, Debug, PartialEq)]
pub enum AngleSensor {
    /// Gyroscope and accelerometer.
    Inertial,
    /// An encoder on the pivot.
    Encoder {
        /// Counts per turn; negative if they fall while the angle rises.
        counts_per_turn: f64,
        /// Number of bits after which the count wraps around.
        bits: u32,
        /// Count in the upright position.
        zero: u32,
    },
}

/// The drive, which turns the duty of a timer into the motor's current.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The quantity that the drive controls.
    pub kind: DriveKind,
    /// Bits of the timer.
    pub bits: u32,
    /// Duty at zero current (or voltage), counts.
    pub duty_zero: Option<u16>,
    /// Smallest duty that the drive accepts as a set value, counts.
    pub duty_low: Option<u16>,
    /// Largest duty that the drive accepts as a set value, counts.
    pub duty_high: Option<u16>,
    /// A (for a voltage drive: V) per count; negative if a larger duty drives backwards.
    pub amperes_per_count: Option<f64>,
}

/// The quantity that a drive controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveKind {
    /// The current.
    Current,
    /// The voltage V = R u + τ φ̇, limited to that of the supply.
    Voltage {
        /// Supply voltage, V.
        supply_v: f64,
        /// Winding resistance, Ω.
        winding_ohm: f64,
    },
}

impl Hardware {
    /// Writes the section into a document, as it was written in its source. An equal section is kept.
    pub(crate) fn write(&self, root: &mut dyn TableLike) {
        // A table alone prints without its own sections: only a document prints all of it.
        let whole = |section: &Item| {
            let mut document = DocumentMut::new();
            document.insert("hardware", section.clone());
            document.to_string()
        };
        let text = whole(&self.text);
        if root.get("hardware").is_none_or(|old| whole(old) != text) {
            root.insert("hardware", self.text.clone());
        }
    }
}
