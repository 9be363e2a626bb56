//! Gyroscope, accelerometer and magnetometer: calibration, clipping, and orientation on the body.

use attitude::{AttitudeSpec, SensorLine};
use bench_files::{Hardware, InertialSensor, StoredSensorCalibration};
use nalgebra::{Matrix3, Rotation2, Vector2};

use super::{DIFFER, HardwareError, Work};
use crate::numbers::significant;

/// Largest assumed drift of a gyroscope's bias after its calibration, mainly from temperature, rad/s: 0.5 °/s.
/// Data sheets allow 0.01 to 0.05 °/s per kelvin.
const GYRO_DRIFT_RAD_S: f64 = 8.726_646e-3;

/// Factor by which the filter's largest correction, 2 β, must exceed that drift. With a smaller factor, the error from
/// the drift would exceed the ripple of the correction.
const DRIFT_MARGIN: f64 = 3.0;

/// Largest contribution of the other two axes to a reading, as a share of that of its own axis. Data sheets allow 2 %;
/// a sensor that is soldered at an angle has more.
const CROSS_AXIS_MAX: f64 = 0.5;

/// A calibration must be in the sensor's own axes: each output mainly follows its own axis. If it does
/// not, the mounting is different, and a calibration from vector lengths cannot find it.
fn require_own_axes(name: &str, matrix: &[[f64; 3]; 3]) -> Result<(), HardwareError> {
    for (row, entries) in matrix.iter().enumerate() {
        let own = entries[row];
        let others: f64 = entries.iter().map(|entry| entry.abs()).sum::<f64>() - own.abs();
        if own.is_nan() || own <= 0.0 || others > CROSS_AXIS_MAX * own {
            return Err(HardwareError::Contradiction(format!(
                "[calibration.{name}]: the {} axis of the matrix does not mainly follow its own counts (row \
                 {:?}); write the calibration in the sensor's own axes, and state how they lie on the body \
                 as axes under [hardware.{name}] or as [calibration.mounting]",
                ["x", "y", "z"][row],
                entries
            )));
        }
    }
    Ok(())
}

impl Work<'_> {
    pub(super) fn attitude(&mut self) -> Result<Option<AttitudeSpec>, HardwareError> {
        let thesis = AttitudeSpec::thesis();
        let stated = self.stated;
        let sensor = |pick: fn(&Hardware) -> Option<&InertialSensor>| stated.and_then(pick);
        let gyroscope = sensor(|hardware| hardware.gyroscope.as_ref());
        let accelerometer = sensor(|hardware| hardware.accelerometer.as_ref());
        let magnetometer = sensor(|hardware| hardware.magnetometer.as_ref());
        for (name, found) in [
            ("gyroscope", self.calibration.gyroscope),
            ("accelerometer", self.calibration.accelerometer),
            ("magnetometer", self.calibration.magnetometer),
        ] {
            if let Some(found) = found {
                require_own_axes(name, &found.matrix)?;
            }
        }
        let gyro = self.sensor(
            "gyroscope",
            gyroscope,
            self.calibration.gyroscope,
            (thesis.gyro, thesis.gyro_clip),
            "FXAS21002, ±2000 °/s",
            "part = \"MPU-6050\", or scale in rad/s per count",
        );
        let accel = self.sensor(
            "accelerometer",
            accelerometer,
            self.calibration.accelerometer,
            (thesis.accel, thesis.accel_clip),
            "FXOS8700, ±8 g, 4096 counts/g",
            "part = \"MPU-6050\", or scale in m/s2 per count",
        );
        // The angle needs no magnetometer, so that a missing statement is no error.
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
                .push("magnetometer: not stated, and in no sample".to_owned());
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

    /// The calibrated β, increased if the assumed drift of the gyroscope requires it.
    fn beta(&mut self, otherwise: f64) -> f64 {
        let found = self.calibration.beta_rad_s.unwrap_or(otherwise);
        // The filter's correction turns the estimate by at most 2 β.
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

    /// A sensor's calibration in its own axes, and where it clips.
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
                        "[calibration.{name}] has a scale of {} per count, but {what} states {}: the \
                         calibrated scale is used; look up the range to which the sensor is set",
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
            // If the scale comes from the preset, too, the preset has been named already.
            None if calibrated.is_none() => preset.1,
            None => {
                let from_preset = format!("clips at {:?} counts", preset.1);
                let example = format!("{example}; it states the counts at which the sensor clips");
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
            "{name}: {part}; saturated from {} counts on",
            clip.map(|counts| counts.to_string()).join(", ")
        ));
        Some((line, clip))
    }

    /// The rotations from the axes of gyroscope, accelerometer and magnetometer to those of the filter, and the
    /// remaining mounting angle.
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
                // The rotation of the magnetometer relative to the housing, and the measured orientation of the
                // housing.
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
                     [hardware.accelerometer], or flywheel calibrate with a swing; or [hardware.angle] with kind = \
                     \"encoder\" where an encoder at the pivot shows the angle",
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

    /// Compares the stated axes with the measured mounting: a difference of 20° means that one of them is wrong.
    fn compare_turns(&mut self, stated: &Matrix3<f64>, turn: &Matrix3<f64>, angle_rad: f64) {
        let (sin, cos) = angle_rad.sin_cos();
        // The x axis of the aligned sensor is at the mounting angle from that of the body.
        let about_pivot = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let found = about_pivot * turn;
        let apart = (((stated.transpose() * found).trace() - 1.0) / 2.0)
            .clamp(-1.0, 1.0)
            .acos();
        if apart > 20_f64.to_radians() {
            self.warnings.push(format!(
                "[calibration.mounting] turns the sensor {}° away from the axes that \
                 [hardware.accelerometer] states: the calibrated mounting is used; flywheel bring-up \
                 finds the right one",
                significant(apart.to_degrees(), 2)
            ));
        }
    }
}
