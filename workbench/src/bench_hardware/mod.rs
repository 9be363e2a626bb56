//! From what a model says of its bench's sensors and drive (`[hardware]`, `[calibration]`) to what
//! the generator is told. Nothing is assumed: what nobody stated is named, or taken from a bench
//! that the caller names, and then said.

mod inertial;
#[cfg(test)]
mod tests;
mod wheel_and_drive;

use bench_files::{AngleSensor, Calibration, Hardware, ModelFile};
use codegen::hardware::HardwareSpec;
use codegen::spec::PwmDrive;
use serde::{Deserialize, Serialize};

/// A known bench whose sensors and drive may stand in for what a model does not state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// The bench of the thesis: FXAS21002 and FXOS8700, ADS1015 behind an ESCON 24/2.
    ThesisBench,
}

/// Sensors and drive as the generator needs them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BenchHardware {
    /// Sensors.
    pub(crate) sensors: HardwareSpec,
    /// Drive.
    pub(crate) drive: PwmDrive,
    /// What was taken from the preset; sentences.
    pub(crate) assumed: Vec<String>,
    /// What is not as it should be; sentences.
    pub(crate) warnings: Vec<String>,
}

/// Why there is no such hardware.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HardwareError {
    /// Something is stated nowhere.
    #[error(
        "the bench's hardware is not stated: {}; state it in bench.toml or model.toml, or take what is missing from the bench of the thesis with --preset thesis-bench",
        .missing.join("; ")
    )]
    Missing {
        /// What is missing, each with an example.
        missing: Vec<String>,
    },
    /// What is stated contradicts the preset, or itself.
    #[error("{0}")]
    Contradiction(String),
    /// What is stated cannot be emitted.
    #[error("{0}")]
    NotEmitted(String),
}

/// [hardware] and [calibration] that differ by more than this factor are not of the same part or
/// setting: data sheets allow 5 % at most, ranges differ by factors of two.
const DIFFER: f64 = 1.2;

/// Resolves what `file` states; `preset` fills what it does not.
pub(crate) fn bench_hardware(
    file: &ModelFile,
    preset: Option<Preset>,
) -> Result<BenchHardware, HardwareError> {
    let calibration = file.calibration.unwrap_or_default();
    let mut work = Work {
        stated: file.hardware.as_ref(),
        calibration,
        preset,
        missing: Vec::new(),
        assumed: Vec::new(),
        warnings: Vec::new(),
        registers: Vec::new(),
    };
    work.angle()?;
    let attitude = work.attitude()?;
    let wheel = work.wheel_speed()?;
    let drive = work.drive()?;
    let (Some(attitude), Some(wheel), Some(drive)) = (attitude, wheel, drive) else {
        return Err(HardwareError::Missing {
            missing: work.missing,
        });
    };
    let hardware = file.hardware.as_ref();
    let stated = hardware.and_then(|hardware| hardware.accelerometer.as_ref()?.scale);
    let gyroscope = hardware.and_then(|hardware| hardware.gyroscope.as_ref());
    let gyro_rate_hz = match (gyroscope, preset) {
        (Some(sensor), _) => sensor.rate_hz,
        (None, Some(Preset::ThesisBench)) => HardwareSpec::thesis_bench().gyro_rate_hz,
        (None, None) => None,
    };
    let is_calibrated = calibration.accelerometer.is_some();
    let accelerometer_m_s2_per_count =
        stated.or_else(|| (!is_calibrated).then(|| attitude.accel.matrix.column(0).norm()));
    Ok(BenchHardware {
        sensors: HardwareSpec {
            attitude,
            wheel_speed_per_count: wheel.slope,
            wheel_speed_at_zero: wheel.offset,
            wheel_low: wheel.low,
            wheel_high: wheel.high,
            gyro_rate_hz,
            accelerometer_m_s2_per_count,
            registers: work.registers,
            bias_observer: None,
        },
        drive,
        assumed: work.assumed,
        warnings: work.warnings,
    })
}

struct Work<'a> {
    stated: Option<&'a Hardware>,
    calibration: Calibration,
    preset: Option<Preset>,
    missing: Vec<String>,
    assumed: Vec<String>,
    warnings: Vec<String>,
    registers: Vec<String>,
}

impl Work<'_> {
    /// Whether the preset may fill this in; where not, it is missing.
    fn fill(&mut self, what: &str, from_preset: &str, example: &str) -> bool {
        if self.preset.is_some() {
            let what = what.replace(['[', ']'], "");
            self.assumed.push(format!("{what}: {from_preset}"));
            true
        } else {
            self.missing.push(format!("{what} ({example})"));
            false
        }
    }

    fn angle(&mut self) -> Result<(), HardwareError> {
        match self.stated.and_then(|stated| stated.angle.as_ref()) {
            Some(AngleSensor::Inertial) => Ok(()),
            Some(AngleSensor::Encoder { .. }) => Err(HardwareError::NotEmitted(
                "[hardware.angle] kind = \"encoder\": this generator emits the inertial angle only"
                    .to_owned(),
            )),
            // An inertial sensor is there for the angle; without one it is missed below.
            None => Ok(()),
        }
    }
}
