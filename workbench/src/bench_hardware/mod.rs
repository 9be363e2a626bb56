//! From a model's statements about its bench's sensors and drive (`[hardware]`, `[calibration]`) to the inputs of the
//! generator. Nothing is assumed silently. A missing statement is reported, or a preset that the caller names supplies
//! it; the report then lists it as assumed.

mod body_encoder;
mod inertial;
#[cfg(test)]
mod tests;
mod wheel_and_drive;

use bench_files::{Calibration, Hardware, ModelFile};
use codegen::hardware::{BodySensor, HardwareSpec, RateNeeds};
use codegen::spec::PwmDrive;
use serde::{Deserialize, Serialize};

/// A known bench whose sensors and drive can replace those that a model does not state.
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
    /// Properties that were taken from the preset, as sentences.
    pub(crate) assumed: Vec<String>,
    /// Properties that may be wrong, as sentences.
    pub(crate) warnings: Vec<String>,
}

/// The reason why the hardware is not usable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HardwareError {
    /// A required property is not stated.
    #[error(
        "the bench's hardware is not stated: {}; state it in bench.toml or model.toml, or take the missing parts from the bench of the thesis",
        .missing.join("; ")
    )]
    Missing {
        /// What is missing, each with an example.
        missing: Vec<String>,
    },
    /// A statement contradicts the preset or another statement.
    #[error("{0}")]
    Contradiction(String),
    /// The stated hardware cannot be emitted.
    #[error("{0}")]
    NotEmitted(String),
}

/// A scale of [hardware] and one of [calibration] that differ by more than this factor belong to different parts or
/// settings: data sheets allow 5 % at most, and ranges of one part differ by factors of two.
const DIFFER: f64 = 1.2;

/// Evaluates the statements of `file`. `needs` decides the window of an encoder on the pivot. `preset`, if there is
/// one, supplies what is not stated.
pub(crate) fn bench_hardware(
    file: &ModelFile,
    needs: RateNeeds,
    preset: Option<Preset>,
) -> Result<BenchHardware, HardwareError> {
    let calibration = file.calibration.unwrap_or_default();
    let mut work = Work {
        stated: file.hardware.as_ref(),
        calibration,
        sample_time_s: needs.sample_time_s,
        needs,
        torque_constant: torque_constant(file),
        preset,
        missing: Vec::new(),
        assumed: Vec::new(),
        warnings: Vec::new(),
        registers: Vec::new(),
    };
    let body = match work.body_encoder()? {
        Some(encoder) => Some(BodySensor::Encoder(encoder)),
        None => work
            .attitude()?
            .map(|found| BodySensor::Inertial(Box::new(found))),
    };
    let drive = work.drive()?;
    let wheel = work.wheel_speed(drive.as_ref())?;
    let (Some(body), Some(wheel), Some(drive)) = (body, wheel, drive) else {
        return Err(HardwareError::Missing {
            missing: work.missing,
        });
    };
    let hardware = file.hardware.as_ref();
    let stated = hardware.and_then(|hardware| hardware.accelerometer.as_ref()?.scale);
    let gyroscope = hardware.and_then(|hardware| hardware.gyroscope.as_ref());
    let inertial = match &body {
        BodySensor::Inertial(attitude) => Some(attitude),
        BodySensor::Encoder(_) => None,
    };
    let gyro_rate_hz = match (gyroscope, preset) {
        _ if inertial.is_none() => None,
        (Some(sensor), _) => sensor.rate_hz,
        (None, Some(Preset::ThesisBench)) => HardwareSpec::thesis_bench().gyro_rate_hz,
        (None, None) => None,
    };
    let is_calibrated = calibration.accelerometer.is_some();
    let accelerometer_m_s2_per_count = inertial.and_then(|attitude| {
        stated.or_else(|| (!is_calibrated).then(|| attitude.accel.matrix.column(0).norm()))
    });
    Ok(BenchHardware {
        sensors: HardwareSpec {
            body,
            wheel: wheel.sensor,
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

/// The motor's torque constant in N m/A, which is also its back-EMF constant in V s/rad; `None` if the model knows
/// torques only per unit of inertia.
fn torque_constant(file: &ModelFile) -> Option<f64> {
    let mut parameters = file.parameters.iter();
    let found = parameters.find(|parameter| parameter.name == "torque_constant")?;
    (!found.unit.contains("per kg")).then_some(found.value)
}

struct Work<'a> {
    stated: Option<&'a Hardware>,
    calibration: Calibration,
    sample_time_s: f64,
    needs: RateNeeds,
    torque_constant: Option<f64>,
    preset: Option<Preset>,
    missing: Vec<String>,
    assumed: Vec<String>,
    warnings: Vec<String>,
    registers: Vec<String>,
}

impl Work<'_> {
    /// Fills in a property from the preset, if there is one; otherwise reports it as missing.
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
}
