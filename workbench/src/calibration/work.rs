//! The individual calibrations, and the checks of their recordings.

use ::calibrate::{Counts, LineFit, PlumbLine};
use bench_files::{
    CalibrationRecordings, CountsRecording, LeverArmCalibration, MountingCalibration,
};

use super::{
    CalibratedLine, CalibratedSensor, LeverArmOfSwing, LeverArmReport, MagnetometerPoints,
    PlumbedCentre, SensorCalibrationReport, SensorMounting, in_recording, line_to_file, to_file,
};
use crate::error::Error;
use crate::numbers::significant;

/// Scale of the magnetometer's data sheet (FXOS8700), µT per count.
const MAGNETOMETER_UT_PER_COUNT: f64 = 0.1;

/// Largest standard error with which a lever arm from the swing is used, m. At an acceleration of 30 rad/s², as for
/// 15° from upright, such an error tilts the apparent vertical by a third of a degree.
const LEVER_ARM_STD_MAX_M: f64 = 2e-3;

/// Ruler and swing contradict each other if they differ by more than this many standard errors.
const CONTRADICTION: f64 = 4.0;

/// Largest scale error of a gyroscope. A larger one means another range or a mistake: data sheets
/// allow a few per cent.
const SCALE_ERROR_MAX: f64 = 0.05;

/// A calibration in progress.
pub(super) struct Work<'a> {
    pub(super) recordings: &'a CalibrationRecordings,
    pub(super) report: SensorCalibrationReport,
}

impl Work<'_> {
    pub(super) fn accelerometer(
        &mut self,
    ) -> Result<Option<::calibrate::SensorCalibration>, Error> {
        let recordings = self.recordings;
        let (Some(first), Some(gravity)) =
            (recordings.accelerometer.first(), recordings.known.gravity)
        else {
            return Ok(None);
        };
        let poses: Vec<Vec<[i16; 3]>> = recordings
            .accelerometer
            .iter()
            .map(|pose| pose.counts.clone())
            .collect();
        let found =
            ::calibrate::accelerometer(&poses, gravity).map_err(in_recording(&first.file))?;
        let worst = found
            .residuals_m_s2
            .iter()
            .fold(0.0_f64, |worst, residual| worst.max(residual.abs()));
        let quality = [
            ("poses", poses.len() as f64),
            ("largest_residual_m_s2", worst),
            ("condition", found.condition),
        ];
        self.report.found.accelerometer = Some(to_file(&found.sensor));
        self.report.accelerometer = Some(CalibratedSensor::of("m/s2", &found.sensor, &quality));
        Ok(Some(found.sensor))
    }

    pub(super) fn gyroscope(&mut self) -> Result<Option<::calibrate::SensorCalibration>, Error> {
        let recordings = self.recordings;
        let (Some(still), Some(scale), Some(sample_time_s)) = (
            &recordings.gyroscope,
            recordings.gyroscope_scale_rad_s,
            recordings.sample_time_s,
        ) else {
            return Ok(None);
        };
        let found = ::calibrate::gyroscope_rest(&still.counts, scale, sample_time_s)
            .map_err(in_recording(&still.file))?;
        let quality = [
            ("noise_rad_s_rthz", found.noise_rad_s_rthz),
            ("largest_drift_rad_s", found.drift_rad_s.amax()),
            ("beta_rad_s", found.beta_rad_s),
        ];
        self.report.found.gyroscope = Some(to_file(&found.sensor));
        self.report.found.beta_rad_s = Some(found.beta_rad_s);
        self.report.gyroscope = Some(CalibratedSensor::of("rad/s", &found.sensor, &quality));
        Ok(Some(found.sensor))
    }

    pub(super) fn magnetometer(&mut self) -> Result<(), Error> {
        let Some(recording) = &self.recordings.magnetometer else {
            return Ok(());
        };
        let usable = self.usable_readings(recording);
        let counts = &usable;
        let in_file = in_recording(&recording.file);
        let field_ut = match self.recordings.field_ut {
            Some(field) => field,
            None => {
                ::calibrate::mean_field_ut(counts, MAGNETOMETER_UT_PER_COUNT).map_err(&in_file)?
            }
        };
        let found = ::calibrate::magnetometer(counts, field_ut).map_err(in_file)?;
        let quality = [
            ("field_ut", field_ut),
            ("spread_before", found.spread_before),
            ("spread_after", found.spread_after),
            ("coverage", found.coverage),
            ("condition", found.condition),
        ];
        if !found.is_covered() {
            self.report.warnings.push(format!(
                "the magnetometer was turned through only {:.0} % of all directions ({:.0} % are \
                 needed): bias and scale along the missing directions are not reliable; turn it through \
                 all directions and record again",
                100.0 * found.coverage,
                100.0 * ::calibrate::COVERAGE_MIN
            ));
        }
        if !found.fits() {
            self.report.warnings.push(format!(
                "the magnetometer's readings do not lie on an ellipsoid: after calibration their \
                 length still varies by {:.1} % ({:.0} % are allowed); record it away from motor and \
                 iron, and within the sensor's range",
                100.0 * found.spread_after,
                100.0 * ::calibrate::SPREAD_MAX
            ));
        }
        self.report.found.magnetometer = Some(to_file(&found.sensor));
        self.report.magnetometer = Some(CalibratedSensor::of("µT", &found.sensor, &quality));
        self.report.magnetometer_points = Some(MagnetometerPoints {
            before: counts.iter().map(|sample| sample.map(f64::from)).collect(),
            after_ut: found.points_ut.iter().map(|p| [p.x, p.y, p.z]).collect(),
            field_ut,
            spread_before: found.spread_before,
            spread_after: found.spread_after,
            coverage: found.coverage,
        });
        Ok(())
    }

    /// The readings within the sensor's range. A warning reports those that were left out.
    fn usable_readings(&mut self, recording: &CountsRecording) -> Vec<[i16; 3]> {
        let hardware = self.recordings.hardware.as_ref();
        let stated = hardware.and_then(|hardware| hardware.magnetometer.as_ref());
        let clip = stated.map_or(attitude::WORD_CLIP, |sensor| sensor.clip);
        let found = ::calibrate::usable_readings(&recording.counts, clip);
        if found.overflowed > 0 {
            self.report.warnings.push(format!(
                "{} of {} readings of the magnetometer overflowed (at a limit of the range, or far \
                 outside the sphere of the others) and were left out",
                found.overflowed,
                recording.counts.len()
            ));
        }
        for (axis, end, times) in &found.clipped {
            self.report.warnings.push(format!(
                "the magnetometer's {axis} axis stops at {end} counts, its value in {times} of {} \
                 readings: it is clipped there, and these readings were left out; choose a larger \
                 range, or take the magnet nearby away",
                recording.counts.len()
            ));
        }
        found.readings
    }

    pub(super) fn mounting(
        &mut self,
        accelerometer: &::calibrate::SensorCalibration,
        gyroscope: &::calibrate::SensorCalibration,
    ) -> Result<Option<::calibrate::Mounting>, Error> {
        let (Some(swing), Some(hanging)) = (&self.recordings.swing, &self.recordings.hanging)
        else {
            return Ok(None);
        };
        let hardware = self.recordings.hardware.as_ref();
        let stated = hardware.and_then(|hardware| hardware.accelerometer.as_ref()?.rotation);
        let is_stated = stated.is_some();
        // The last row of the rotation is the body's z axis in the sensor's frame.
        let nearer_to = stated.map_or([0.0, 0.0, 1.0], |rotation| rotation[2]);
        let found = ::calibrate::mounting(
            &swing.counts,
            &gyroscope.line,
            &hanging.counts,
            accelerometer,
            &nearer_to.into(),
        )
        .map_err(in_recording(&swing.file))?;
        let axis = [found.axis.x, found.axis.y, found.axis.z];
        if !is_stated {
            self.report.warnings.push(
                "no inertial recording shows in which direction the pivot axis points, because a sensor \
                 that is turned by half a turn reads the same swing: the direction nearer to the sensor's z \
                 is used; state axes under [hardware.accelerometer], or find the direction with flywheel bring-up"
                    .to_owned(),
            );
        }
        self.report.found.mounting = Some(MountingCalibration {
            axis,
            axis_std_rad: found.axis_std_rad,
            angle_rad: found.angle_rad,
            angle_std_rad: found.angle_std_rad,
        });
        self.report.mounting = Some(SensorMounting {
            axis,
            axis_std_rad: found.axis_std_rad,
            angle_rad: found.angle_rad,
            angle_std_rad: found.angle_std_rad,
        });
        Ok(Some(found))
    }

    pub(super) fn lever_arm_of_swing(
        &self,
        accelerometer: &::calibrate::SensorCalibration,
        gyroscope: &::calibrate::SensorCalibration,
        mounting: &::calibrate::Mounting,
    ) -> Result<Option<::calibrate::LeverArmEstimate>, Error> {
        let recordings = self.recordings;
        let (Some(swing), Some(swing_accelerometer), Some(hanging), Some(sample_time_s)) = (
            &recordings.swing,
            &recordings.swing_accelerometer,
            &recordings.hanging,
            recordings.sample_time_s,
        ) else {
            return Ok(None);
        };
        ::calibrate::lever_arm(
            &swing.counts,
            &swing_accelerometer.counts,
            &gyroscope.line,
            &hanging.counts,
            accelerometer,
            mounting,
            sample_time_s,
        )
        .map(Some)
        .map_err(in_recording(&swing.file))
    }

    /// The lever arm from the ruler, or else from the swing, if that is precise enough.
    pub(super) fn lever_arm(&mut self, of_swing: Option<::calibrate::LeverArmEstimate>) {
        let stated = self.recordings.lever_arm;
        if stated.is_none() && of_swing.is_none() {
            return;
        }
        let mut used = stated;
        if let Some(found) = of_swing {
            let certain = CONTRADICTION * found.gyro_scale_error_std;
            if found.gyro_scale_error.abs() > SCALE_ERROR_MAX.max(certain) {
                self.report.warnings.push(format!(
                    "according to the swing, the rate about the pivot is {} times the rate by gyroscope_scale; \
                     look up the range to which the sensor is set",
                    significant(1.0 + found.gyro_scale_error, 3)
                ));
            }
            let worst = found.position_std_m[0].max(found.position_std_m[1]);
            match stated {
                Some(stated) => {
                    let contradict = (0..2).any(|axis| {
                        let apart = found.position_m[axis] - stated.position_m[axis];
                        let std = found.position_std_m[axis].hypot(stated.position_std_m[axis]);
                        apart.abs() > CONTRADICTION * std
                    });
                    if contradict {
                        self.report.warnings.push(
                            "the stated lever arm contradicts the swing; the stated one is used; measure it again \
                             from the pivot to the chip"
                                .to_owned(),
                        );
                    }
                }
                None if worst <= LEVER_ARM_STD_MAX_M => {
                    used = Some(LeverArmCalibration {
                        position_m: found.position_m,
                        position_std_m: found.position_std_m,
                    });
                }
                None => self.report.warnings.push(format!(
                    "the lever arm from the swing is uncertain by {} mm and is not used: record a \
                     swing from 45° or more, or state lever_arm",
                    significant(1e3 * worst, 2)
                )),
            }
        }
        self.report.found.lever_arm = used;
        self.report.lever_arm = Some(LeverArmReport {
            position_m: used.map(|arm| arm.position_m),
            position_std_m: used.map(|arm| arm.position_std_m),
            stated_m: stated.map(|arm| arm.position_m),
            stated_std_m: stated.map(|arm| arm.position_std_m),
            from_swing: of_swing.map(|found| LeverArmOfSwing {
                position_m: found.position_m,
                position_std_m: found.position_std_m,
                gyro_scale_error: found.gyro_scale_error,
                gyro_scale_error_std: found.gyro_scale_error_std,
                residual_std_m_s2: found.residual_std_m_s2,
            }),
        });
    }

    pub(super) fn lines(&mut self) -> Result<(), Error> {
        let fit = |points: &Option<Vec<(f64, f64)>>, counts| -> Result<Option<LineFit>, Error> {
            points
                .as_ref()
                .map(|points| ::calibrate::fit_line_within_range(points, counts))
                .transpose()
                .map_err(in_recording(&self.recordings.folder))
        };
        let wheel_speed = fit(&self.recordings.wheel_speed, Counts::X)?;
        let duty = fit(&self.recordings.duty, Counts::Y)?;
        if let Some(line) = &wheel_speed {
            self.warn_of_left_out("the converter", ["counts", "rad/s"], line);
            self.warn_of_one_way();
        }
        if let Some(line) = &duty {
            self.warn_of_left_out("the drive", ["A", "counts"], line);
        }
        self.report.found.wheel_speed = wheel_speed.as_ref().map(line_to_file);
        self.report.found.duty = duty.as_ref().map(line_to_file);
        self.report.wheel_speed = wheel_speed.as_ref().map(CalibratedLine::of);
        self.report.current = duty.as_ref().map(CalibratedLine::of);
        Ok(())
    }

    /// Warns of points that do not lie on a line, with the worst one.
    fn warn_of_left_out(&mut self, what: &str, [unit, result]: [&str; 2], line: &LineFit) {
        let size = |point: &::calibrate::LeftOut| point.residual.abs();
        let worst = line
            .left_out
            .iter()
            .max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(worst) = worst else {
            return;
        };
        self.report.warnings.push(format!(
            "{} points of {what} do not lie on the line of the others and were left out (the worst, at {} {unit}, \
             is off by {} {result}): they lie at the ends of the range, or are mistakes; use {what} only between \
             these ends",
            line.left_out.len(),
            significant(worst.x, 5),
            significant(worst.residual.abs(), 3)
        ));
    }

    /// Warns of a converter that was recorded in one direction only.
    fn warn_of_one_way(&mut self) {
        let points = self.recordings.wheel_speed.iter().flatten();
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for (_, speed) in points {
            least = least.min(*speed);
            most = most.max(*speed);
        }
        // Less than a twentieth of the range beyond zero is not a rotation in the other direction.
        if least > -0.05 * most || most < -0.05 * least {
            self.report.warnings.push(format!(
                "the converter was recorded in one direction only, from {} to {} rad/s, but the wheel turns \
                 in both: a converter whose line ends at zero cannot show the other direction; give its \
                 signal an offset, or record the other direction too",
                significant(least, 3),
                significant(most, 3)
            ));
        }
    }

    pub(super) fn centre_of_mass(&mut self) -> Result<(), Error> {
        let Some(drawn) = &self.recordings.plumb_lines else {
            return Ok(());
        };
        let lines: Vec<PlumbLine> = drawn
            .lines
            .iter()
            .map(|[first, second]| PlumbLine {
                first: (*first).into(),
                second: (*second).into(),
            })
            .collect();
        let found = ::calibrate::centre_of_mass(&lines, drawn.pivot_m.into(), drawn.mark_std_m)
            .map_err(in_recording(&self.recordings.folder))?;
        self.report.centre_of_mass = Some(PlumbedCentre {
            position_m: [found.position_m.x, found.position_m.y],
            pivot_to_com_m: found.pivot_to_com_m,
            pivot_to_com_std_m: found.pivot_to_com_std_m,
            crossing_angle_rad: found.crossing_angle_rad,
            residuals_m: found.residuals_m,
        });
        Ok(())
    }
}
