//! Conversion of the words of a frame to SI units.

use bench_files::{BenchOutline, ModelFile, Problem};
use checker::certificate::Certificate;
use codegen::exact::ShortestDecimal;
use codegen::format::Format;
use codegen::hardware::{BodySensor, RateNeeds, WheelSensor};
use codegen::spec::{PhysicalRanges, PwmDrive};
use serial_frame::Telemetry;

use super::RecordSettings;
use crate::bench_hardware::{HardwareError, bench_hardware};
use crate::error::Error;

/// The units of the words of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Words {
    /// Size of one unit of the words of angle (rad), rate (rad/s) and wheel speed (rad/s).
    units: [f64; 3],
    drive: PwmDrive,
    /// Whether an encoder on the pivot measures the body. The frame then has its count in place of the gyroscope's x.
    pub has_pivot_encoder: bool,
    /// Whether the wheel's word has a sign.
    is_wheel_signed: bool,
    /// Lowest and highest count of the wheel's sensor, at or beyond which the speed is unknown; `None` for an encoder,
    /// whose single count shows no speed.
    wheel_ends: Option<(i32, i32)>,
    /// Largest current that the controller commands, A.
    pub current_limit_a: f64,
}

impl Words {
    /// The units of the emitted crate in [`RecordSettings::module`], else those that follow from
    /// bench.toml and model.toml.
    pub fn of(outline: &BenchOutline, settings: &RecordSettings) -> Result<Words, Error> {
        let model_path = outline.folder.join("model.toml");
        let mut model = match ModelFile::read(&model_path) {
            Ok(model) => model,
            Err(error) if matches!(error.problem(), Problem::NotFound) => ModelFile::new(),
            Err(error) => return Err(error.into()),
        };
        if outline.hardware.is_some() {
            model.hardware.clone_from(&outline.hardware);
        }
        let refused = |source| Error::Hardware {
            model: outline.file.clone(),
            source,
        };
        // The units of an encoder's words do not depend on its window.
        let needs = RateNeeds {
            sample_time_s: model.design.map_or(1e-3, |design| design.sample_time_s),
            rate_gain: 0.0,
            current_limit_a: 1.0,
            delay_margin_s: f64::INFINITY,
        };
        let found = bench_hardware(&model, needs, settings.preset).map_err(refused)?;
        let ranges = PhysicalRanges::of(&found.sensors);
        let unit = |range: f64, what: &str| {
            Format::for_range(&ShortestDecimal::new(range).value)
                .map(|format| 0.5f64.powi(format.fraction_bits as i32))
                .ok_or_else(|| {
                    refused(HardwareError::Contradiction(format!(
                        "the range of the {what}, {range}, does not fit a word of 32 bits; correct the sensor's scale \
                         under [hardware]"
                    )))
                })
        };
        let units = match &settings.module {
            Some(folder) => units_of_module(folder, settings)?,
            None => [
                unit(ranges.angle_rad, "angle")?,
                unit(ranges.rate_rad_s, "rate")?,
                unit(ranges.wheel_speed_rad_s, "wheel speed")?,
            ],
        };
        let drive = &found.drive;
        let reach = drive
            .duty_high
            .saturating_sub(drive.duty_zero)
            .min(drive.duty_zero.saturating_sub(drive.duty_low));
        let of_drive = f64::from(reach) * drive.amperes_per_count.abs();
        let of_design = model.design.map(|design| design.current_limit_a);
        Ok(Words {
            units,
            drive: *drive,
            has_pivot_encoder: matches!(found.sensors.body, BodySensor::Encoder(_)),
            is_wheel_signed: found.sensors.wheel == WheelSensor::Driver,
            wheel_ends: match found.sensors.wheel {
                WheelSensor::Encoder(_) => None,
                _ => Some((found.sensors.wheel_low, found.sensors.wheel_high)),
            },
            current_limit_a: of_design.unwrap_or(of_drive).min(of_drive),
        })
    }

    /// Body angle from upright, rad.
    pub fn angle_from_upright_rad(&self, frame: &Telemetry) -> f64 {
        f64::from(frame.angle) * self.units[0]
    }

    /// Body rate, rad/s.
    pub fn rate_rad_s(&self, frame: &Telemetry) -> f64 {
        f64::from(frame.rate) * self.units[1]
    }

    /// Wheel speed relative to the body, rad/s.
    pub fn wheel_speed_rad_s(&self, frame: &Telemetry) -> f64 {
        f64::from(frame.wheel_speed) * self.units[2]
    }

    /// The current that the duty commands, A. For a voltage drive, the current that the voltage drives through the
    /// winding at the measured wheel speed.
    pub fn current_a(&self, frame: &Telemetry) -> f64 {
        let counts = f64::from(frame.duty) - f64::from(self.drive.duty_zero);
        let of_back_emf = self.drive.voltage.map_or(0.0, |voltage| {
            voltage.back_emf_v_s * self.wheel_speed_rad_s(frame) / voltage.winding_ohm
        });
        counts * self.drive.amperes_per_count - of_back_emf
    }

    /// Whether the wheel may turn faster than its sensor shows.
    pub fn is_wheel_unknown(&self, frame: &Telemetry) -> bool {
        let wheel = if self.is_wheel_signed {
            i32::from(frame.wheel.cast_signed())
        } else {
            i32::from(frame.wheel)
        };
        self.wheel_ends
            .is_some_and(|(low, high)| wheel <= low || wheel >= high)
    }
}

/// The units of the words of an emitted crate, by its certificate.
fn units_of_module(folder: &std::path::Path, settings: &RecordSettings) -> Result<[f64; 3], Error> {
    let refused = |reason: String| Error::Record {
        port: settings.port.clone(),
        reason: format!("--module {}: {reason}", folder.display()),
    };
    let certificate = Certificate::read(folder).map_err(|error| refused(error.to_string()))?;
    let bits: Vec<u32> = certificate
        .inputs
        .iter()
        .map(|input| input.fraction_bits)
        .collect();
    match bits.as_slice() {
        [angle, rate, wheel] => Ok([*angle, *rate, *wheel].map(|bits| 0.5f64.powi(bits as i32))),
        _ => Err(refused(
            "its certificate does not state angle, rate and wheel speed as inputs".to_owned(),
        )),
    }
}
