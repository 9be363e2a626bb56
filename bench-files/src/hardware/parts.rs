//! Presets from the data sheets of common parts.
//!
//! A part can have several ranges. A preset holds for the one that it names, and every output
//! shows that name. With another range, `scale` in the file overrides the preset.

/// The role of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Gyroscope,
    Accelerometer,
    Magnetometer,
    Encoder,
    CurrentDrive,
    VoltageDrive,
}

/// A part, in one of its roles.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its type number, as files write it.
    pub name: &'static str,
    pub(super) role: Role,
    /// The setting (such as the range) for which the numbers hold.
    pub setting: &'static str,
    /// Document and section.
    pub source: &'static str,
    pub(super) numbers: Numbers,
}

/// The numbers of a preset.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    /// Unit (rad/s, m/s², µT) per count, bits, left-justified, clip, rate in Hz; and, for a sensor
    /// whose axes are not those of the housing, the housing axis of each.
    Inertial {
        scale: f64,
        bits: u32,
        is_left_justified: bool,
        clip: [i32; 3],
        rate_hz: f64,
        axes: [&'static str; 3],
    },
    Encoder {
        counts_per_turn: f64,
        bits: u32,
    },
    Drive {
        bits: u32,
        duty: Option<[u16; 3]>,
        amperes_per_count: Option<f64>,
    },
}

/// π/180.
const DEGREE: f64 = core::f64::consts::PI / 180.0;
/// Standard gravity, m/s².
const G: f64 = 9.80665;
const OWN: [&str; 3] = ["x", "y", "z"];
const FULL: [i32; 3] = [32_767; 3];

const fn inertial(
    scale: f64,
    bits: u32,
    is_left_justified: bool,
    clip: [i32; 3],
    rate_hz: f64,
    axes: [&'static str; 3],
) -> Numbers {
    Numbers::Inertial {
        scale,
        bits,
        is_left_justified,
        clip,
        rate_hz,
        axes,
    }
}

/// All presets. The settings of drives are made in a configuration tool, so only the number of bits
/// and the ends of the duty follow from the part.
static PARTS: &[Part] = &[
    Part {
        name: "FXAS21002",
        role: Role::Gyroscope,
        setting: "±2000 °/s (CTRL_REG0 FS = 0), 800 Hz",
        source: "NXP FXAS21002C data sheet rev. 2.1, mechanical characteristics: 62.5 m°/s per LSB",
        numbers: inertial(0.0625 * DEGREE, 16, false, FULL, 800.0, OWN),
    },
    Part {
        name: "FXOS8700",
        role: Role::Accelerometer,
        setting: "±8 g (XYZ_DATA_CFG FS = 2), 14 bits left-justified, 400 Hz hybrid mode",
        source: "NXP FXOS8700CQ data sheet rev. 8, mechanical characteristics: 0.976 mg per LSB of 14 bits",
        numbers: inertial(G / 4096.0, 14, true, [32_764; 3], 400.0, OWN),
    },
    Part {
        name: "FXOS8700",
        role: Role::Magnetometer,
        setting: "±1200 µT, 400 Hz hybrid mode",
        source: "NXP FXOS8700CQ data sheet rev. 8, magnetic characteristics: 0.1 µT per LSB",
        numbers: inertial(0.1, 16, false, [12_000; 3], 400.0, OWN),
    },
    Part {
        name: "MPU-6050",
        role: Role::Gyroscope,
        setting: "±2000 °/s (FS_SEL = 3), low-pass filter on, 1 kHz",
        source: "InvenSense PS-MPU-6000A-00, gyroscope specifications: 16.4 LSB per °/s",
        numbers: inertial(DEGREE / 16.4, 16, false, FULL, 1000.0, OWN),
    },
    Part {
        name: "MPU-6050",
        role: Role::Accelerometer,
        setting: "±8 g (AFS_SEL = 2), 1 kHz",
        source: "InvenSense PS-MPU-6000A-00, accelerometer specifications: 4096 LSB per g",
        numbers: inertial(G / 4096.0, 16, false, FULL, 1000.0, OWN),
    },
    Part {
        name: "MPU-9250",
        role: Role::Gyroscope,
        setting: "±2000 °/s (FS_SEL = 3), low-pass filter on, 1 kHz",
        source: "InvenSense PS-MPU-9250A-01 rev. 1.0, page 8, table 1: 16.4 LSB per °/s",
        numbers: inertial(DEGREE / 16.4, 16, false, FULL, 1000.0, OWN),
    },
    Part {
        name: "MPU-9250",
        role: Role::Accelerometer,
        setting: "±8 g (AFS_SEL = 2), low-pass filter on, 1 kHz",
        source: "InvenSense PS-MPU-9250A-01 rev. 1.0, accelerometer specifications: 4096 LSB per g",
        numbers: inertial(G / 4096.0, 16, false, FULL, 1000.0, OWN),
    },
    Part {
        name: "MPU-9250",
        role: Role::Magnetometer,
        setting: "AK8963 with 16 bits at 100 Hz; its x and y are the housing's y and x, its z is reversed",
        source: "InvenSense PS-MPU-9250A-01 rev. 1.0, magnetometer specifications and orientation of axes: 0.15 µT per LSB",
        numbers: inertial(0.15, 16, false, [32_760; 3], 100.0, ["y", "x", "-z"]),
    },
    Part {
        name: "ICM-20948",
        role: Role::Gyroscope,
        setting: "±2000 °/s (GYRO_FS_SEL = 3), low-pass filter on, 1125 Hz",
        source: "TDK DS-000189, gyroscope specifications: 16.4 LSB per °/s",
        numbers: inertial(DEGREE / 16.4, 16, false, FULL, 1125.0, OWN),
    },
    Part {
        name: "ICM-20948",
        role: Role::Accelerometer,
        setting: "±8 g (ACCEL_FS_SEL = 2), low-pass filter on, 1125 Hz",
        source: "TDK DS-000189, accelerometer specifications: 4096 LSB per g",
        numbers: inertial(G / 4096.0, 16, false, FULL, 1125.0, OWN),
    },
    Part {
        name: "ICM-20948",
        role: Role::Magnetometer,
        setting: "AK09916 at 100 Hz; its y and z are reversed against the housing's",
        source: "TDK DS-000189, magnetometer specifications and orientation of axes: 0.15 µT per LSB",
        numbers: inertial(0.15, 16, false, [32_752; 3], 100.0, ["x", "-y", "-z"]),
    },
    Part {
        name: "LSM6DS3",
        role: Role::Gyroscope,
        setting: "±2000 °/s (FS_G = 3), 1666 Hz",
        source: "ST LSM6DS3 data sheet, mechanical characteristics: 70 m°/s per LSB",
        numbers: inertial(0.07 * DEGREE, 16, false, FULL, 1666.0, OWN),
    },
    Part {
        name: "LSM6DS3",
        role: Role::Accelerometer,
        setting: "±8 g (FS_XL = 3), 1666 Hz",
        source: "ST LSM6DS3 data sheet, mechanical characteristics: 0.244 mg per LSB",
        numbers: inertial(0.244e-3 * G, 16, false, FULL, 1666.0, OWN),
    },
    Part {
        name: "BNO055",
        role: Role::Gyroscope,
        setting: "raw data at ±2000 °/s in °/s (UNIT_SEL), 100 Hz",
        source: "Bosch BST-BNO055-DS000, gyroscope output units: 16 LSB per °/s",
        numbers: inertial(DEGREE / 16.0, 16, false, [32_000; 3], 100.0, OWN),
    },
    Part {
        name: "BNO055",
        role: Role::Accelerometer,
        setting: "raw data at ±4 g in m/s² (UNIT_SEL), 100 Hz",
        source: "Bosch BST-BNO055-DS000, accelerometer output units: 100 LSB per m/s²",
        numbers: inertial(0.01, 14, false, [3_922; 3], 100.0, OWN),
    },
    Part {
        name: "AS5600",
        role: Role::Encoder,
        setting: "RAW ANGLE register, 12 bits",
        source: "ams AS5600 data sheet, output resolution: 4096 positions in a turn",
        numbers: Numbers::Encoder {
            counts_per_turn: 4096.0,
            bits: 12,
        },
    },
    Part {
        name: "ESCON 24/2",
        role: Role::CurrentDrive,
        setting: "set value by PWM, 10 % to 90 % duty of a 16-bit timer; the current at its ends is set in ESCON Studio",
        source: "maxon ESCON 24/2 hardware reference, digital input with PWM set value",
        numbers: Numbers::Drive {
            bits: 16,
            duty: Some([6_554, 32_768, 58_982]),
            amperes_per_count: None,
        },
    },
    Part {
        name: "SimpleFOC voltage",
        role: Role::VoltageDrive,
        setting: "torque control by voltage (MotionControlType::torque, TorqueControlType::voltage)",
        source: "SimpleFOC documentation, torque control: voltage mode",
        numbers: Numbers::Drive {
            bits: 16,
            duty: None,
            amperes_per_count: None,
        },
    },
];

/// The preset of this part in one of these roles, if there is one.
pub(super) fn named(name: &str, roles: &[Role]) -> Option<&'static Part> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' ', '_', '/'], "");
    PARTS
        .iter()
        .find(|part| roles.contains(&part.role) && plain(part.name) == plain(name))
}

/// Every part with a preset, once for each of its roles.
pub fn known_parts() -> &'static [Part] {
    PARTS
}

impl Part {
    /// What it does.
    pub fn role_name(&self) -> &'static str {
        match self.role {
            Role::Gyroscope => "gyroscope",
            Role::Accelerometer => "accelerometer",
            Role::Magnetometer => "magnetometer",
            Role::Encoder => "encoder",
            Role::CurrentDrive => "current drive",
            Role::VoltageDrive => "voltage drive",
        }
    }
}

/// The parts that have a preset in one of these roles.
pub(super) fn names(roles: &[Role]) -> Vec<&'static str> {
    PARTS
        .iter()
        .filter(|part| roles.contains(&part.role))
        .map(|part| part.name)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_found_however_its_name_is_written() {
        for name in ["MPU-6050", "mpu6050", "MPU 6050"] {
            let part = named(name, &[Role::Gyroscope]).expect("the part is known");
            assert_eq!(part.name, "MPU-6050");
        }
        assert!(named("MPU-6050", &[Role::Encoder]).is_none());
    }
}
