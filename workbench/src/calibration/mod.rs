//! Sensors, mounting, converters and centre of mass from recordings of raw counts.

mod work;

use std::path::Path;

use ::calibrate::{CalibrationError, LineFit};
use bench_files::{
    Calibration, CalibrationRecordings, LineCalibration, ModelFile, Parameter,
    StoredSensorCalibration,
};
use serde::{Deserialize, Serialize};

use crate::error::Error;
use work::Work;

/// The results from the recordings of `[calibration]`: the result of [`calibrate()`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SensorCalibrationReport {
    /// Accelerometer, from counts to m/s².
    pub accelerometer: Option<CalibratedSensor>,
    /// Gyroscope, from counts to rad/s.
    pub gyroscope: Option<CalibratedSensor>,
    /// Magnetometer, from counts to µT.
    pub magnetometer: Option<CalibratedSensor>,
    /// Orientation of the sensor on the body.
    pub mounting: Option<SensorMounting>,
    /// Position of the accelerometer, along x and y of the aligned sensor.
    pub lever_arm: Option<LeverArmReport>,
    /// Wheel speed in rad/s over converter counts.
    pub wheel_speed: Option<CalibratedLine>,
    /// Duty in counts over current in A.
    pub current: Option<CalibratedLine>,
    /// Centre of mass of the body, from plumb lines.
    pub centre_of_mass: Option<PlumbedCentre>,
    /// Warnings about results that are not reliable, with remedies; sentences.
    pub warnings: Vec<String>,
    /// The magnetometer's samples before and after calibration.
    #[serde(skip)]
    pub magnetometer_points: Option<MagnetometerPoints>,
    /// The results as they are written to model.toml.
    #[serde(skip)]
    found: Calibration,
}

/// A three-axis sensor: value = matrix (counts − bias).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibratedSensor {
    /// Unit of the calibrated value.
    pub unit_per_count: String,
    /// Bias, counts.
    pub bias_counts: [f64; 3],
    /// Standard errors of the bias, counts.
    pub bias_std: [f64; 3],
    /// The matrix, row by row, in the unit of the value per count.
    pub matrix: [[f64; 3]; 3],
    /// Standard errors of the matrix; zero for entries that are not identified.
    pub matrix_std: [[f64; 3]; 3],
    /// Quality of the fit by name: residual, condition, coverage, noise, …
    pub quality: Vec<(String, f64)>,
}

/// The orientation of the sensor on the body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorMounting {
    /// The pivot axis in the sensor's frame.
    pub axis: [f64; 3],
    /// Standard error of its direction, rad.
    pub axis_std_rad: f64,
    /// Angle from the body's axis to the sensor's x axis, rad.
    pub angle_rad: f64,
    /// Its standard error.
    pub angle_std_rad: f64,
}

/// The position of the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeverArmReport {
    /// The position that goes into the model, m, if there is one.
    pub position_m: Option<[f64; 2]>,
    /// Standard errors of that position, m.
    pub position_std_m: Option<[f64; 2]>,
    /// The position measured with a ruler, m, if it was.
    pub stated_m: Option<[f64; 2]>,
    /// Standard errors of the position by the ruler, m.
    pub stated_std_m: Option<[f64; 2]>,
    /// The position from the accelerations of the swing.
    pub from_swing: Option<LeverArmOfSwing>,
}

/// The lever arm from the accelerations of a swing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeverArmOfSwing {
    /// Position along x and y of the aligned sensor, m.
    pub position_m: [f64; 2],
    /// Standard errors.
    pub position_std_m: [f64; 2],
    /// Scale error s of the gyroscope: the true rate about the pivot axis is (1 + s) times the calibrated one.
    pub gyro_scale_error: f64,
    /// Standard error of the scale error.
    pub gyro_scale_error_std: f64,
    /// Standard deviation of the residual of the acceleration, m/s².
    pub residual_std_m_s2: f64,
}

/// A straight line with its standard errors; x and y have the units of the calibration that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibratedLine {
    /// Slope, unit of y per unit of x.
    pub slope: f64,
    /// Standard error of the slope.
    pub slope_std: f64,
    /// y at x = 0, unit of y.
    pub offset: f64,
    /// Standard error of the offset, unit of y.
    pub offset_std: f64,
    /// Standard deviation of the points about the line, unit of y.
    pub residual_std: f64,
}

/// A centre of mass from plumb lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlumbedCentre {
    /// Its position in the drawing, m.
    pub position_m: [f64; 2],
    /// Its distance from the pivot, m.
    pub pivot_to_com_m: f64,
    /// Standard error of that distance, m.
    pub pivot_to_com_std_m: f64,
    /// Largest angle between two of the lines.
    pub crossing_angle_rad: f64,
    /// Distance of each line from the centre of mass, m.
    pub residuals_m: Vec<f64>,
}

/// Samples of a magnetometer that was turned into all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct MagnetometerPoints {
    /// Raw readings, counts.
    pub before: Vec<[f64; 3]>,
    /// Calibrated readings, µT.
    pub after_ut: Vec<[f64; 3]>,
    /// Strength of the field, µT.
    pub field_ut: f64,
    /// Relative variation of the field strength before calibration.
    pub spread_before: f64,
    /// Relative variation of the field strength after calibration.
    pub spread_after: f64,
    /// Share of all directions that the samples cover.
    pub coverage: f64,
}

/// Calibrates everything that the recordings allow.
///
/// # Errors
/// [`Error::Calibrate`] with the recording that is not sufficient.
pub fn calibrate(recordings: &CalibrationRecordings) -> Result<SensorCalibrationReport, Error> {
    let mut work = Work {
        recordings,
        report: SensorCalibrationReport::default(),
    };
    let accelerometer = work.accelerometer()?;
    let gyroscope = work.gyroscope()?;
    work.magnetometer()?;
    if let (Some(accelerometer), Some(gyroscope)) = (accelerometer, gyroscope) {
        let mounting = work.mounting(&accelerometer, &gyroscope)?;
        let of_swing = match mounting {
            Some(mounting) => work.lever_arm_of_swing(&accelerometer, &gyroscope, &mounting)?,
            None => None,
        };
        work.lever_arm(of_swing);
    } else {
        work.lever_arm(None);
    }
    work.lines()?;
    work.centre_of_mass()?;
    Ok(work.report)
}

impl SensorCalibrationReport {
    /// Writes the results into a model. Earlier results remain where there is no new one.
    pub fn apply_to(&self, file: &mut ModelFile) {
        file.calibration = Some(merged(file.calibration, self.found));
        if let Some(centre) = &self.centre_of_mass {
            file.set_parameter(Parameter {
                name: "pivot_to_com".to_owned(),
                value: centre.pivot_to_com_m,
                std: Some(centre.pivot_to_com_std_m),
                unit: "m".to_owned(),
                source: "plumb lines".to_owned(),
            });
        }
    }
}

/// The new results, and the earlier ones where there is no new one.
fn merged(before: Option<Calibration>, now: Calibration) -> Calibration {
    let before = before.unwrap_or_default();
    Calibration {
        accelerometer: now.accelerometer.or(before.accelerometer),
        gyroscope: now.gyroscope.or(before.gyroscope),
        beta_rad_s: now.beta_rad_s.or(before.beta_rad_s),
        magnetometer: now.magnetometer.or(before.magnetometer),
        mounting: now.mounting.or(before.mounting),
        lever_arm: now.lever_arm.or(before.lever_arm),
        wheel_speed: now.wheel_speed.or(before.wheel_speed),
        duty: now.duty.or(before.duty),
    }
}

/// Adds the recording to a calibration error.
fn in_recording(file: &Path) -> impl Fn(CalibrationError) -> Error {
    move |source| Error::Calibrate {
        recording: file.to_path_buf(),
        source,
    }
}

fn matrix(of: &::calibrate::SensorCalibration, std: bool) -> [[f64; 3]; 3] {
    let source = if std { &of.matrix_std } else { &of.line.matrix };
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| source[(row, column)]))
}

fn to_file(sensor: &::calibrate::SensorCalibration) -> StoredSensorCalibration {
    StoredSensorCalibration {
        bias_counts: sensor.line.bias_counts.into(),
        bias_std: sensor.bias_std.into(),
        matrix: matrix(sensor, false),
        matrix_std: matrix(sensor, true),
    }
}

impl CalibratedSensor {
    fn of(
        unit: &str,
        sensor: &::calibrate::SensorCalibration,
        quality: &[(&str, f64)],
    ) -> CalibratedSensor {
        CalibratedSensor {
            unit_per_count: unit.to_owned(),
            bias_counts: sensor.line.bias_counts.into(),
            bias_std: sensor.bias_std.into(),
            matrix: matrix(sensor, false),
            matrix_std: matrix(sensor, true),
            quality: quality
                .iter()
                .map(|(name, value)| ((*name).to_owned(), *value))
                .collect(),
        }
    }
}

fn line_to_file(line: &LineFit) -> LineCalibration {
    LineCalibration {
        slope: line.slope,
        slope_std: line.slope_std,
        offset: line.offset,
        offset_std: line.offset_std,
    }
}

impl CalibratedLine {
    fn of(line: &LineFit) -> CalibratedLine {
        CalibratedLine {
            slope: line.slope,
            slope_std: line.slope_std,
            offset: line.offset,
            offset_std: line.offset_std,
            residual_std: line.residual_std,
        }
    }
}
