//! From what a model says of its bench's sensors and drive (`[hardware]`, `[calibration]`) to what
//! the generator is told. Nothing is assumed: what nobody stated is named, or taken from a bench
//! that the caller names, and then said.

use attitude::{AttitudeSpec, SensorLine};
use bench_files::{
    AngleSensor, Calibration, Drive, DriveKind, Hardware, InertialSensor, LineCalibration,
    ModelFile, StoredSensorCalibration, WheelSpeedSensor,
};
use codegen::hardware::HardwareSpec;
use codegen::spec::PwmDrive;
use nalgebra::{Matrix3, Rotation2, Vector2};
use serde::{Deserialize, Serialize};

use crate::numbers::significant;

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

/// What a gyroscope's bias may drift by after its calibration, with warmth above all, rad/s: 0.5 °/s,
/// of data sheets that allow 0.01 to 0.05 °/s per kelvin.
const GYRO_DRIFT_RAD_S: f64 = 8.726_646e-3;

/// How many times that drift the correction must be able to outrun: with less the error that the
/// drift leaves grows beyond the ripple of the correction.
const DRIFT_MARGIN: f64 = 3.0;

/// A converter whose line passes no speed further below zero than this share of the highest shows
/// one sense of turning only.
const ONE_WAY: f64 = 0.05;

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

/// A converter's line and its ends.
struct Converter {
    slope: f64,
    offset: f64,
    low: u16,
    high: u16,
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

    fn attitude(&mut self) -> Result<Option<AttitudeSpec>, HardwareError> {
        let thesis = AttitudeSpec::thesis();
        let stated = self.stated;
        let sensor = |pick: fn(&Hardware) -> Option<&InertialSensor>| stated.and_then(pick);
        let gyroscope = sensor(|hardware| hardware.gyroscope.as_ref());
        let accelerometer = sensor(|hardware| hardware.accelerometer.as_ref());
        let magnetometer = sensor(|hardware| hardware.magnetometer.as_ref());
        let gyro = self.sensor(
            "gyroscope",
            gyroscope,
            self.calibration.gyroscope,
            (thesis.gyro, thesis.gyro_clip),
            "FXAS21002 at ±2000 °/s",
            "part = \"MPU-6050\", or scale in rad/s per count",
        );
        let accel = self.sensor(
            "accelerometer",
            accelerometer,
            self.calibration.accelerometer,
            (thesis.accel, thesis.accel_clip),
            "FXOS8700 at ±8 g, 4096 counts/g",
            "part = \"MPU-6050\", or scale in m/s2 per count",
        );
        // A compass does nothing for the angle: one that is not stated is not used.
        let mag = if magnetometer.is_some() || self.calibration.magnetometer.is_some() {
            self.sensor(
                "magnetometer",
                magnetometer,
                self.calibration.magnetometer,
                (thesis.mag, thesis.mag_clip),
                "FXOS8700, 0.1 µT per count",
                "part = \"FXOS8700\", or scale in µT per count",
            )
        } else {
            self.registers
                .push("magnetometer: not stated; leave `mag` out".to_owned());
            Some((thesis.mag, thesis.mag_clip))
        };
        let turns = self.turns(gyroscope, accelerometer, magnetometer);
        let (Some(gyro), Some(accel), Some(mag), Some((turn, mounting_angle_rad))) =
            (gyro, accel, mag, turns)
        else {
            return Ok(None);
        };
        let turned = |line: &SensorLine, turn: &Matrix3<f64>| SensorLine {
            bias_counts: line.bias_counts,
            matrix: turn * line.matrix,
        };
        let on_body = accelerometer.and_then(|sensor| sensor.lever_arm_m);
        let lever_arm_m = match (self.calibration.lever_arm, on_body) {
            (Some(found), _) => found.position_m,
            // From the body's x and y to those of the aligned sensor.
            (None, Some(arm)) => {
                let arm = Rotation2::new(-mounting_angle_rad) * Vector2::from(arm);
                [arm.x, arm.y]
            }
            (None, None) => [0.0, 0.0],
        };
        Ok(Some(AttitudeSpec {
            beta_rad_s: self.beta(thesis.beta_rad_s),
            gyro: turned(&gyro.0, &turn[0]),
            accel: turned(&accel.0, &turn[1]),
            mag: turned(&mag.0, &turn[2]),
            gyro_clip: gyro.1,
            accel_clip: accel.1,
            mag_clip: mag.1,
            mounting_angle_rad,
            lever_arm_m,
            ..thesis
        }))
    }

    /// β as calibrated, or raised to what the gyroscope's drift asks for.
    fn beta(&mut self, otherwise: f64) -> f64 {
        let found = self.calibration.beta_rad_s.unwrap_or(otherwise);
        // The correction turns the estimate by at most 2 β.
        let least = 0.5 * DRIFT_MARGIN * GYRO_DRIFT_RAD_S;
        if found < least {
            self.registers.push(format!(
                "filter: beta raised from {} to {} rad/s, so that a gyroscope's drift of 0.5 °/s after \
                 the calibration does not carry the estimate away",
                significant(found, 2),
                significant(least, 3)
            ));
        }
        found.max(least)
    }

    /// A sensor's line in its own axes, and where it clips.
    fn sensor(
        &mut self,
        name: &'static str,
        stated: Option<&InertialSensor>,
        calibrated: Option<StoredSensorCalibration>,
        preset: (SensorLine, [i32; 3]),
        preset_name: &str,
        example: &str,
    ) -> Option<(SensorLine, [i32; 3])> {
        let what = format!("[hardware.{name}]");
        let scale = stated.and_then(|sensor| sensor.scale);
        let line = match (calibrated, scale) {
            (Some(found), scale) => {
                let line = SensorLine {
                    bias_counts: found.bias_counts.into(),
                    matrix: Matrix3::from_fn(|row, column| found.matrix[row][column]),
                };
                let mean = line.matrix.determinant().abs().cbrt();
                if let Some(scale) = scale
                    && !(1.0 / DIFFER..=DIFFER).contains(&(mean / scale))
                {
                    self.warnings.push(format!(
                        "[calibration.{name}] has {} per count, {what} {}: the calibrated one is \
                         used; look up the sensor's range",
                        significant(mean, 4),
                        significant(scale, 4)
                    ));
                }
                line
            }
            (None, Some(scale)) => SensorLine::ideal(scale),
            (None, None) => {
                if !self.fill(&what, preset_name, example) {
                    return None;
                }
                preset.0
            }
        };
        let clip = match stated {
            Some(sensor) => sensor.clip,
            // Named already where the line is the preset's, too.
            None if calibrated.is_none() => preset.1,
            None => {
                let from_preset = format!("clips at {:?} counts", preset.1);
                let example = format!("{example}; it says where the sensor clips");
                if !self.fill(&what, &from_preset, &example) {
                    return None;
                }
                preset.1
            }
        };
        let part = match stated.and_then(|sensor| sensor.part) {
            Some(part) => format!("{}, {} ({})", part.name, part.setting, part.source),
            None if stated.is_some() => "as stated".to_owned(),
            None => preset_name.to_owned(),
        };
        self.registers.push(format!(
            "{name}: {part}; unknown from {} counts on",
            clip.map(|counts| counts.to_string()).join(", ")
        ));
        Some((line, clip))
    }

    /// From the axes of gyroscope, accelerometer and magnetometer to those of the filter, and the
    /// mounting angle that is left.
    fn turns(
        &mut self,
        gyroscope: Option<&InertialSensor>,
        accelerometer: Option<&InertialSensor>,
        magnetometer: Option<&InertialSensor>,
    ) -> Option<([Matrix3<f64>; 3], f64)> {
        let matrix = |sensor: Option<&InertialSensor>| {
            let rotation = sensor.and_then(|sensor| sensor.rotation)?;
            Some(Matrix3::from_fn(|row, column| rotation[row][column]))
        };
        let of_compass = matrix(magnetometer).unwrap_or_else(Matrix3::identity);
        if let Some(mounting) = self.calibration.mounting {
            let turn = calibrate::alignment(&mounting.axis.into()).into_inner();
            if let Some(stated) = matrix(accelerometer) {
                self.compare_turns(&stated, &turn, mounting.angle_rad);
                // What turns the compass against the housing, and the housing as it was found.
                let against_housing = stated.transpose() * of_compass;
                return Some(([turn, turn, turn * against_housing], mounting.angle_rad));
            }
            return Some(([turn, turn, turn * of_compass], mounting.angle_rad));
        }
        match (matrix(gyroscope), matrix(accelerometer)) {
            (Some(gyro), Some(accel)) => {
                let compass = matrix(magnetometer).unwrap_or(accel);
                Some(([gyro, accel, compass], 0.0))
            }
            (None, None) => self
                .fill(
                    "the sensor's place on the body",
                    "its axes are the body's, z along the pivot axis",
                    "axes = [\"x\", \"y\", \"z\"] under [hardware.gyroscope] and \
                     [hardware.accelerometer], or flywheel calibrate with a swing",
                )
                .then(|| {
                    let own = Matrix3::identity();
                    ([own, own, of_compass], 0.0)
                }),
            (gyro, _) => {
                let lacking = if gyro.is_some() {
                    "accelerometer"
                } else {
                    "gyroscope"
                };
                self.missing.push(format!(
                    "the axes of the {lacking} (axes = [\"x\", \"y\", \"z\"] under \
                     [hardware.{lacking}]; those of the other are stated)"
                ));
                None
            }
        }
    }

    /// Stated axes against the found mounting: 20° apart is another mounting.
    fn compare_turns(&mut self, stated: &Matrix3<f64>, turn: &Matrix3<f64>, angle_rad: f64) {
        let (sin, cos) = angle_rad.sin_cos();
        // The aligned sensor's x axis stands at the mounting angle from the body's.
        let about_pivot = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let found = about_pivot * turn;
        let apart = (((stated.transpose() * found).trace() - 1.0) / 2.0)
            .clamp(-1.0, 1.0)
            .acos();
        if apart > 20_f64.to_radians() {
            self.warnings.push(format!(
                "[calibration.mounting] turns the sensor {}° away from the axes that \
                 [hardware.accelerometer] states: the calibrated mounting is used; flywheel bring-up \
                 settles which is right",
                significant(apart.to_degrees(), 2)
            ));
        }
    }

    fn wheel_speed(&mut self) -> Result<Option<Converter>, HardwareError> {
        let thesis = HardwareSpec::thesis_bench();
        let calibrated = self.calibration.wheel_speed;
        let stated = match self.stated.and_then(|stated| stated.wheel_speed.as_ref()) {
            None => None,
            Some(WheelSpeedSensor::Converter {
                slope,
                offset,
                low,
                high,
            }) => Some((slope.zip(*offset), *low, *high)),
            Some(WheelSpeedSensor::Encoder { .. } | WheelSpeedSensor::Driver { .. }) => {
                return Err(HardwareError::NotEmitted(
                    "[hardware.wheel_speed]: this generator emits kind = \"converter\" only"
                        .to_owned(),
                ));
            }
        };
        let what = "[hardware.wheel_speed]";
        let example = "kind = \"converter\" with slope, offset, low, high";
        let stated_line = stated.and_then(|(line, _, _)| line);
        let line = match (calibrated, stated_line) {
            (Some(found), stated) => {
                self.compare_slopes(&found, stated)?;
                Some((found.slope, found.offset))
            }
            (None, Some(line)) => Some(line),
            (None, None) => None,
        };
        let ends = stated.map(|(_, low, high)| (low, high));
        let (Some((slope, offset)), Some((low, high))) = (line, ends) else {
            let from_preset = match (line.is_some(), ends.is_some()) {
                (false, false) => "ADS1015 at an ESCON 24/2, rpm = 8.53108 count − 6594.5",
                (true, _) => "the converter ends at 0 and 1546 counts",
                (false, true) => "rpm = 8.53108 count − 6594.5",
            };
            if !self.fill(what, from_preset, example) {
                return Ok(None);
            }
            let (slope, offset) =
                line.unwrap_or((thesis.wheel_speed_per_count, thesis.wheel_speed_at_zero));
            let (low, high) = ends.unwrap_or((thesis.wheel_low, thesis.wheel_high));
            return Ok(Some(self.converter(slope, offset, low, high)));
        };
        Ok(Some(self.converter(slope, offset, low, high)))
    }

    fn converter(&mut self, slope: f64, offset: f64, low: u16, high: u16) -> Converter {
        let speed = |count: u16| slope * f64::from(count) + offset;
        let (first, last) = (speed(low), speed(high));
        let (least, most) = (first.min(last), first.max(last));
        if least > -ONE_WAY * most || most < -ONE_WAY * least {
            self.warnings.push(format!(
                "this converter cannot show a {} speed: between its ends it reads {} to {} rad/s, and \
                 the wheel turns both ways; shift its line so that it ends on both sides of zero",
                if least > -ONE_WAY * most { "negative" } else { "positive" },
                significant(least, 3),
                significant(most, 3)
            ));
        }
        self.registers.push(format!(
            "wheel speed: converter counts {low} to {high}, {} to {} rad/s",
            significant(first, 6),
            significant(last, 6)
        ));
        Converter {
            slope,
            offset,
            low,
            high,
        }
    }

    /// The sign of a slope that was found must be the stated one, its size nearly so. Without a
    /// statement a rising count is a rising speed.
    fn compare_slopes(
        &mut self,
        found: &LineCalibration,
        stated: Option<(f64, f64)>,
    ) -> Result<(), HardwareError> {
        let stated = stated.map(|(slope, _)| slope);
        if found.slope * stated.unwrap_or(1.0) <= 0.0 {
            return Err(HardwareError::Contradiction(format!(
                "[calibration.wheel_speed] has a slope of {} rad/s per count, against the sign that \
                 is expected: with it the wheel's speed would be fed back reversed; calibrate the \
                 converter again, or state the negative slope under [hardware.wheel_speed]",
                significant(found.slope, 4)
            )));
        }
        if let Some(stated) = stated
            && !(1.0 / DIFFER..=DIFFER).contains(&(found.slope / stated))
        {
            self.warnings.push(format!(
                "[calibration.wheel_speed] has {} rad/s per count, [hardware.wheel_speed] {}: the \
                 calibrated one is used",
                significant(found.slope, 4),
                significant(stated, 4)
            ));
        }
        Ok(())
    }

    fn drive(&mut self) -> Result<Option<PwmDrive>, HardwareError> {
        let thesis = PwmDrive::THESIS_BENCH;
        let calibrated = self.calibration.duty;
        let Some(stated) = self.stated.and_then(|stated| stated.drive.as_ref()) else {
            let from_preset = match calibrated {
                None => "ESCON 24/2, 16-bit timer, duty 6554 to 58982 for ∓2.2 A",
                Some(_) => "16-bit timer, duty 6554 to 58982",
            };
            let example = "kind = \"current\" with bits, duty_zero, duty_low, duty_high, \
                           amperes_per_count";
            if !self.fill("[hardware.drive]", from_preset, example) {
                return Ok(None);
            }
            let drive = match calibrated {
                None => thesis,
                Some(line) => calibrated_drive(&line, &thesis)?,
            };
            // A timer with other bits has its zero elsewhere.
            let off = f64::from(drive.duty_zero) - f64::from(thesis.duty_zero);
            if off.abs() > (DIFFER - 1.0) * f64::from(thesis.counts()) {
                return Err(HardwareError::Contradiction(format!(
                    "[calibration.current] has no current at a duty of {}, the bench of the thesis at \
                     {}: that is another timer, whose range the preset does not know; state \
                     [hardware.drive] with bits, duty_zero, duty_low, duty_high",
                    drive.duty_zero, thesis.duty_zero
                )));
            }
            self.registers.push(drive_register(&drive));
            return Ok(Some(drive));
        };
        if let DriveKind::Voltage { .. } = stated.kind {
            return Err(HardwareError::NotEmitted(
                "[hardware.drive] kind = \"voltage\": this generator emits current drives only"
                    .to_owned(),
            ));
        }
        let drive = self.stated_drive(stated, calibrated, &thesis)?;
        if let Some(drive) = &drive {
            self.registers.push(drive_register(drive));
        }
        Ok(drive)
    }

    fn stated_drive(
        &mut self,
        stated: &Drive,
        calibrated: Option<LineCalibration>,
        thesis: &PwmDrive,
    ) -> Result<Option<PwmDrive>, HardwareError> {
        let mut duty = |key: &str, stated: Option<u16>, preset: u16| {
            stated.or_else(|| {
                let what = format!("{key} of [hardware.drive]");
                self.fill(&what, &preset.to_string(), "counts of the timer")
                    .then_some(preset)
            })
        };
        let low = duty("duty_low", stated.duty_low, thesis.duty_low);
        let high = duty("duty_high", stated.duty_high, thesis.duty_high);
        let zero_found = calibrated.map(|line| line.offset.round());
        let zero = match zero_found {
            Some(found) => Some(found.clamp(0.0, 65_535.0) as u16),
            None => duty("duty_zero", stated.duty_zero, thesis.duty_zero),
        };
        let slope = match calibrated {
            Some(line) => Some(1.0 / line.slope),
            None => stated.amperes_per_count.or_else(|| {
                let what = "amperes_per_count of [hardware.drive]";
                let example = "8.39246e-5: the range of the current over that of the duty";
                self.fill(what, "2.2 A over 26214 counts", example)
                    .then_some(thesis.amperes_per_count)
            }),
        };
        let (Some(low), Some(high), Some(zero), Some(slope)) = (low, high, zero, slope) else {
            return Ok(None);
        };
        if let (Some(line), Some(stated)) = (calibrated, stated.amperes_per_count) {
            let ratio = 1.0 / (line.slope * stated);
            if ratio <= 0.0 || ratio.is_nan() {
                return Err(HardwareError::Contradiction(format!(
                    "[calibration.current] and [hardware.drive] disagree about the sign of the \
                     current ({} and {} A per count): the motor would push the wrong way; flywheel \
                     bring-up settles which is right",
                    significant(1.0 / line.slope, 4),
                    significant(stated, 4)
                )));
            }
            if !(1.0 / DIFFER..=DIFFER).contains(&ratio) {
                self.warnings.push(format!(
                    "[calibration.current] has {} A per count, [hardware.drive] {}: the calibrated \
                     one is used",
                    significant(1.0 / line.slope, 4),
                    significant(stated, 4)
                ));
            }
        }
        if !(low < zero && zero < high) {
            return Err(HardwareError::Contradiction(format!(
                "the duty without current, {zero}, does not lie between duty_low = {low} and \
                 duty_high = {high} of [hardware.drive]"
            )));
        }
        Ok(Some(PwmDrive {
            bits: stated.bits,
            duty_zero: zero,
            duty_low: low,
            duty_high: high,
            amperes_per_count: slope,
        }))
    }
}

/// `preset` with the line that was found.
fn calibrated_drive(line: &LineCalibration, preset: &PwmDrive) -> Result<PwmDrive, HardwareError> {
    if !line.slope.is_finite() || line.slope == 0.0 {
        return Err(HardwareError::Contradiction(
            "[calibration.current] has a slope of zero".to_owned(),
        ));
    }
    Ok(PwmDrive {
        duty_zero: line.offset.round().clamp(0.0, 65_535.0) as u16,
        amperes_per_count: 1.0 / line.slope,
        ..*preset
    })
}

fn drive_register(drive: &PwmDrive) -> String {
    format!(
        "drive: duty {} to {} of a timer of {} bits, {} without current, {} A per count",
        drive.duty_low,
        drive.duty_high,
        drive.bits,
        drive.duty_zero,
        significant(drive.amperes_per_count, 6)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use attitude::STANDARD_GRAVITY;
    use std::path::Path;

    /// A model of the thesis with other sections of hardware and calibration.
    fn file(more: &str) -> ModelFile {
        let text = format!(
            "[parameters.total_inertia]\nvalue = 2.3e-3\n\n[effects]\npresent = [\"body-viscous-friction\"]\n{more}"
        );
        ModelFile::parse(&text, Path::new("model.toml")).expect("a model")
    }

    fn of(more: &str, preset: bool) -> Result<BenchHardware, HardwareError> {
        bench_hardware(&file(more), preset.then_some(Preset::ThesisBench))
    }

    #[test]
    fn without_a_word_everything_is_missing_or_assumed() {
        let Err(HardwareError::Missing { missing }) = of("", false) else {
            panic!("nothing is stated");
        };
        let text = missing.join("\n");
        for part in [
            "gyroscope",
            "accelerometer",
            "place on the body",
            "wheel_speed",
            "drive",
        ] {
            assert!(text.contains(part), "{text}");
        }
        let filled = of("", true).expect("the bench of the thesis");
        assert_eq!(filled.drive, PwmDrive::THESIS_BENCH);
        assert_eq!(filled.assumed.len(), 5, "{:?}", filled.assumed);
        assert_eq!(filled.sensors.attitude, AttitudeSpec::thesis());
    }

    /// A calibrated line keeps the preset's timer where its zero fits, whatever its slope; a line
    /// about another zero is another timer's.
    #[test]
    fn a_preset_fills_a_timer_and_no_other() {
        for range_a in [0.3, 2.2, 3.2, 3.99, 7.0, 30.0] {
            let slope = 26_214.0 / range_a;
            let more = format!(
                "[calibration.current]\nslope = {slope:?}\nslope_std = 1.0\noffset = 32768.0\noffset_std = 1.0\n"
            );
            let drive = of(&more, true).expect("its timer").drive;
            assert!((drive.current_range_a() / range_a - 1.0).abs() < 1e-12);
        }
        let other = "[calibration.current]\nslope = 745.0\nslope_std = 0.3\noffset = 2048.0\noffset_std = 0.4\n";
        assert!(matches!(
            of(other, true),
            Err(HardwareError::Contradiction(message)) if message.contains("another timer")
        ));
        // Stated, it is what it is.
        let stated = format!(
            "{other}[hardware.drive]\nkind = \"current\"\nbits = 12\nduty_zero = 2048\nduty_low = 410\nduty_high = 3686\n"
        );
        let drive = of(&stated, true).expect("a timer of 12 bits").drive;
        assert_eq!(
            (drive.duty_low, drive.duty_zero, drive.duty_high),
            (410, 2048, 3686)
        );
        assert!((drive.current_range_a() - 1638.0 / 745.0).abs() < 1e-12);
    }

    #[test]
    fn signs_that_contradict_are_refused() {
        let line = |slope: f64| {
            format!(
                "[calibration.wheel_speed]\nslope = {slope:?}\nslope_std = 1e-4\noffset = 0.0\noffset_std = 1.0\n"
            )
        };
        assert!(matches!(
            of(&line(-0.89), true),
            Err(HardwareError::Contradiction(_))
        ));
        let stated = "[hardware.wheel_speed]\nkind = \"converter\"\nslope = -0.9\noffset = 690.0\nlow = 0\nhigh = 1546\n";
        let found = of(&format!("{}{stated}", line(-0.89)), true).expect("stated so");
        assert_eq!(found.sensors.wheel_speed_per_count, -0.89);
        let drive = "[calibration.current]\nslope = -7489.0\nslope_std = 5.0\noffset = 32768.0\noffset_std = 6.0\n\
             [hardware.drive]\nkind = \"current\"\namperes_per_count = 1.3e-4\nduty_zero = 32768\nduty_low = 6554\nduty_high = 58982\n";
        assert!(matches!(
            of(drive, true),
            Err(HardwareError::Contradiction(message)) if message.contains("sign")
        ));
    }

    #[test]
    fn a_one_way_converter_is_warned_of() {
        let one_way = "[calibration.wheel_speed]\nslope = 0.14652\nslope_std = 1e-5\noffset = 0.01\noffset_std = 0.1\n";
        let found = of(one_way, true).expect("with a warning");
        assert!(
            found
                .warnings
                .iter()
                .any(|text| text.contains("cannot show a negative speed")),
            "{:?}",
            found.warnings
        );
        assert!(of("", true).expect("two ways").warnings.is_empty());
    }

    /// Half a turn about the sensor's x axis reverses y and z, stated either way.
    #[test]
    fn an_upside_down_sensor_is_turned() {
        let mounted = "[calibration.mounting]\naxis = [0.0, 0.0, -1.0]\naxis_std_rad = 1e-4\nangle = 0.0\nangle_std = 1e-3\n";
        let axes = "[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = [\"x\", \"-y\", \"-z\"]\n\
             [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"-y\", \"-z\"]\n";
        for more in [mounted, axes] {
            let found = of(more, true).expect("turned").sensors.attitude;
            for line in [found.gyro, found.accel] {
                let reversed = line.matrix.diagonal().map(f64::signum);
                assert_eq!(reversed, nalgebra::Vector3::new(1.0, -1.0, -1.0), "{more}");
                assert!(line.matrix.determinant() > 0.0);
            }
            assert_eq!(found.mounting_angle_rad, 0.0);
        }
    }

    /// 4096 counts at rest are one g, through every part's scale.
    #[test]
    fn the_scale_of_a_part_is_used() {
        let more = "[hardware.accelerometer]\npart = \"LSM6DS3\"\naxes = [\"y\", \"-x\", \"z\"]\n\
             [hardware.gyroscope]\npart = \"LSM6DS3\"\naxes = [\"y\", \"-x\", \"z\"]\n";
        let found = of(more, true).expect("known parts").sensors.attitude;
        let one_g = (1.0 / 0.244e-3_f64).round() as i16;
        let read = found.accel.apply([one_g, 0, 0]);
        assert!((read.y - STANDARD_GRAVITY).abs() < 2e-3, "{read:?}");
        assert!(read.x.abs() < 1e-12 && read.z.abs() < 1e-12);
    }
}
