//! `flywheel calibrate BENCH`

use std::path::{Path, PathBuf};

use bench_files::{
    Calibration, CalibrationRecordings, CountsRecording, LeverArmCalibration, LineCalibration,
    ModelFile, MountingCalibration, Parameter, Problem, SensorCalibration,
};
use calibrate::{CalibrationError, LineFit, MagnetometerCalibration, PlumbLine};
use serde::Serialize;

use crate::cli::{BenchFiles, Output};
use crate::failure::Failure;
use crate::report::Report;
use crate::report::numbers::{significant, with_uncertainty};
use crate::report::table::{Align, Table};

/// Scale of the magnetometer's data sheet (FXOS8700), µT per count.
const MAGNETOMETER_UT_PER_COUNT: f64 = 0.1;

/// A lever arm from the swing that is less certain than this is not used, m: at 30 rad/s², as near
/// 15° from upright, it moves the apparent vertical by a third of a degree.
const LEVER_ARM_STD_MAX_M: f64 = 2e-3;

/// Standard errors between ruler and swing beyond which they contradict each other.
const CONTRADICTION: f64 = 4.0;

/// A gyroscope's scale that is off by more than this is that of another range, or a slip: data sheets
/// allow a few per cent.
const SCALE_ERROR_MAX: f64 = 0.05;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml that has a [calibration] section, or that file
    pub bench: PathBuf,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Default, Serialize)]
struct CalibrateJson {
    model: PathBuf,
    accelerometer: Option<SensorJson>,
    gyroscope: Option<SensorJson>,
    magnetometer: Option<SensorJson>,
    mounting: Option<MountingJson>,
    lever_arm: Option<LeverArmJson>,
    wheel_speed: Option<LineJson>,
    current: Option<LineJson>,
    centre_of_mass: Option<CentreJson>,
    warnings: Vec<String>,
    figures: Vec<PathBuf>,
}

#[derive(Serialize)]
struct SensorJson {
    unit_per_count: &'static str,
    bias_counts: [f64; 3],
    bias_std: [f64; 3],
    matrix: [[f64; 3]; 3],
    matrix_std: [[f64; 3]; 3],
    /// Quality of the fit by name: residual, condition, coverage, noise, …
    quality: Vec<(&'static str, f64)>,
}

#[derive(Serialize)]
struct MountingJson {
    axis: [f64; 3],
    axis_std_rad: f64,
    angle_rad: f64,
    angle_std_rad: f64,
}

#[derive(Serialize)]
struct LeverArmJson {
    /// What went into the model, if anything.
    position_m: Option<[f64; 2]>,
    position_std_m: Option<[f64; 2]>,
    from_swing: Option<LeverArmOfSwingJson>,
}

#[derive(Serialize)]
struct LeverArmOfSwingJson {
    position_m: [f64; 2],
    position_std_m: [f64; 2],
    /// The true rate about the pivot axis is (1 + this) times the calibrated one.
    gyro_scale_error: f64,
    gyro_scale_error_std: f64,
    residual_std_m_s2: f64,
}

#[derive(Serialize)]
struct LineJson {
    slope: f64,
    slope_std: f64,
    offset: f64,
    offset_std: f64,
    residual_std: f64,
}

#[derive(Serialize)]
struct CentreJson {
    position_m: [f64; 2],
    pivot_to_com_m: f64,
    pivot_to_com_std_m: f64,
    crossing_angle_rad: f64,
    residuals_m: Vec<f64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let recordings = CalibrationRecordings::load(&arguments.bench)?;
    let files = &arguments.files;
    let model_path = files
        .model
        .clone()
        .unwrap_or_else(|| recordings.folder.join("model.toml"));
    let out = files
        .out
        .clone()
        .unwrap_or_else(|| recordings.folder.join("out"));
    let mut work = Work {
        recordings: &recordings,
        out,
        found: Calibration::default(),
        text: String::new(),
        json: CalibrateJson {
            model: model_path.clone(),
            ..CalibrateJson::default()
        },
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
    let centre = work.centre_of_mass()?;

    let mut file = match ModelFile::read(&model_path) {
        Ok(file) => file,
        Err(error) if matches!(error.problem(), Problem::NotFound) => ModelFile::new(),
        Err(error) => return Err(error.into()),
    };
    file.calibration = Some(merged(file.calibration, work.found));
    if let Some(centre) = centre {
        file.set_parameter(centre);
    }
    file.write(&model_path)?;
    for warning in &work.json.warnings {
        work.text.push_str(&format!("\nWarning: {warning}\n"));
    }
    work.text
        .push_str(&format!("\nWritten: {}\n", model_path.display()));
    for path in &work.json.figures {
        work.text.push_str(&format!("  {}\n", path.display()));
    }
    Report::new(work.text, &work.json)
}

/// What was found now, and for the rest what was found before.
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

/// A calibration under way: results, text and JSON grow together.
struct Work<'a> {
    recordings: &'a CalibrationRecordings,
    out: PathBuf,
    found: Calibration,
    text: String,
    json: CalibrateJson,
}

impl Work<'_> {
    fn accelerometer(&mut self) -> Result<Option<calibrate::SensorCalibration>, Failure> {
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
        let found = calibrate::accelerometer(&poses, gravity).map_err(in_recording(&first.file))?;
        let worst = found
            .residuals_m_s2
            .iter()
            .fold(0.0_f64, |worst, residual| worst.max(residual.abs()));
        let quality = vec![
            ("poses", poses.len() as f64),
            ("largest_residual_m_s2", worst),
            ("condition", found.condition),
        ];
        self.sensor("Accelerometer", "m/s2", &found.sensor, &quality);
        self.found.accelerometer = Some(to_file(&found.sensor));
        self.json.accelerometer = Some(sensor_json("m/s2", &found.sensor, quality));
        Ok(Some(found.sensor))
    }

    fn gyroscope(&mut self) -> Result<Option<calibrate::SensorCalibration>, Failure> {
        let recordings = self.recordings;
        let (Some(still), Some(scale), Some(sample_time_s)) = (
            &recordings.gyroscope,
            recordings.gyroscope_scale_rad_s,
            recordings.sample_time_s,
        ) else {
            return Ok(None);
        };
        let found = calibrate::gyroscope_rest(&still.counts, scale, sample_time_s)
            .map_err(in_recording(&still.file))?;
        let quality = vec![
            ("noise_rad_s_rthz", found.noise_rad_s_rthz),
            ("largest_drift_rad_s", found.drift_rad_s.amax()),
            ("beta_rad_s", found.beta_rad_s),
        ];
        self.sensor("Gyroscope", "rad/s", &found.sensor, &quality);
        self.found.gyroscope = Some(to_file(&found.sensor));
        self.found.beta_rad_s = Some(found.beta_rad_s);
        self.json.gyroscope = Some(sensor_json("rad/s", &found.sensor, quality));
        Ok(Some(found.sensor))
    }

    fn magnetometer(&mut self) -> Result<(), Failure> {
        let Some(recording) = &self.recordings.magnetometer else {
            return Ok(());
        };
        let counts = &recording.counts;
        let in_file = in_recording(&recording.file);
        let field_ut = match self.recordings.field_ut {
            Some(field) => field,
            None => {
                calibrate::mean_field_ut(counts, MAGNETOMETER_UT_PER_COUNT).map_err(&in_file)?
            }
        };
        let found = calibrate::magnetometer(counts, field_ut).map_err(in_file)?;
        let quality = vec![
            ("field_ut", field_ut),
            ("spread_before", found.spread_before),
            ("spread_after", found.spread_after),
            ("coverage", found.coverage),
            ("condition", found.condition),
        ];
        if !found.is_covered() {
            self.json.warnings.push(format!(
                "the magnetometer was turned through {:.0} % of all directions only ({:.0} % are \
                 needed): bias and scale along the missing ones are not trustworthy",
                100.0 * found.coverage,
                100.0 * calibrate::COVERAGE_MIN
            ));
        }
        self.sensor("Magnetometer", "µT", &found.sensor, &quality);
        self.found.magnetometer = Some(to_file(&found.sensor));
        let path = self.out.join("magnetometer.svg");
        figures::write_svg(&path, &sphere(recording, &found, field_ut))?;
        self.json.figures.push(path);
        self.json.magnetometer = Some(sensor_json("µT", &found.sensor, quality));
        Ok(())
    }

    fn mounting(
        &mut self,
        accelerometer: &calibrate::SensorCalibration,
        gyroscope: &calibrate::SensorCalibration,
    ) -> Result<Option<calibrate::Mounting>, Failure> {
        let (Some(swing), Some(hanging)) = (&self.recordings.swing, &self.recordings.hanging)
        else {
            return Ok(None);
        };
        let found = calibrate::mounting(
            &swing.counts,
            &gyroscope.line,
            &hanging.counts,
            accelerometer,
        )
        .map_err(in_recording(&swing.file))?;
        let axis = [found.axis.x, found.axis.y, found.axis.z];
        self.text.push_str(&format!(
            "\nMounting\n  pivot axis in the sensor's frame ({}) ± {} rad\n  angle from the body's axis to the sensor's x axis {} rad\n",
            axis.map(|component| significant(component, 5)).join(", "),
            significant(found.axis_std_rad, 2),
            with_uncertainty(found.angle_rad, Some(found.angle_std_rad)),
        ));
        self.found.mounting = Some(MountingCalibration {
            axis,
            axis_std_rad: found.axis_std_rad,
            angle_rad: found.angle_rad,
            angle_std_rad: found.angle_std_rad,
        });
        self.json.mounting = Some(MountingJson {
            axis,
            axis_std_rad: found.axis_std_rad,
            angle_rad: found.angle_rad,
            angle_std_rad: found.angle_std_rad,
        });
        Ok(Some(found))
    }

    fn lever_arm_of_swing(
        &self,
        accelerometer: &calibrate::SensorCalibration,
        gyroscope: &calibrate::SensorCalibration,
        mounting: &calibrate::Mounting,
    ) -> Result<Option<calibrate::LeverArm>, Failure> {
        let recordings = self.recordings;
        let (Some(swing), Some(swing_accelerometer), Some(hanging), Some(sample_time_s)) = (
            &recordings.swing,
            &recordings.swing_accelerometer,
            &recordings.hanging,
            recordings.sample_time_s,
        ) else {
            return Ok(None);
        };
        calibrate::lever_arm(
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

    /// The lever arm by the ruler, or else by the swing where that is certain enough.
    fn lever_arm(&mut self, of_swing: Option<calibrate::LeverArm>) {
        let stated = self.recordings.lever_arm;
        if stated.is_none() && of_swing.is_none() {
            return;
        }
        let millimetres = |position: [f64; 2], std: [f64; 2]| {
            [0, 1]
                .map(|axis| with_uncertainty(1e3 * position[axis], Some(1e3 * std[axis])))
                .join(", ")
        };
        self.text
            .push_str("\nAccelerometer from the pivot axis, along x and y of the aligned sensor\n");
        if let Some(stated) = stated {
            self.text.push_str(&format!(
                "  as stated: {} mm\n",
                millimetres(stated.position_m, stated.position_std_m)
            ));
        }
        let mut used = stated;
        if let Some(found) = of_swing {
            self.text.push_str(&format!(
                "  from the swing: {} mm; residual {} m/s2; the gyroscope's scale lacks {} %\n",
                millimetres(found.position_m, found.position_std_m),
                significant(found.residual_std_m_s2, 3),
                with_uncertainty(
                    100.0 * found.gyro_scale_error,
                    Some(100.0 * found.gyro_scale_error_std)
                ),
            ));
            let certain = CONTRADICTION * found.gyro_scale_error_std;
            if found.gyro_scale_error.abs() > SCALE_ERROR_MAX.max(certain) {
                self.json.warnings.push(format!(
                    "by the swing the rate about the pivot is {} times what gyroscope_scale says; \
                     look up the sensor's range",
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
                        self.json.warnings.push(
                            "the stated lever arm contradicts the swing; the stated one is used"
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
                None => self.json.warnings.push(format!(
                    "the swing leaves the lever arm open by {} mm and it is not used: record a \
                     swing from 45° or more, or state lever_arm",
                    significant(1e3 * worst, 2)
                )),
            }
        }
        self.found.lever_arm = used;
        self.json.lever_arm = Some(LeverArmJson {
            position_m: used.map(|arm| arm.position_m),
            position_std_m: used.map(|arm| arm.position_std_m),
            from_swing: of_swing.map(|found| LeverArmOfSwingJson {
                position_m: found.position_m,
                position_std_m: found.position_std_m,
                gyro_scale_error: found.gyro_scale_error,
                gyro_scale_error_std: found.gyro_scale_error_std,
                residual_std_m_s2: found.residual_std_m_s2,
            }),
        });
    }

    fn lines(&mut self) -> Result<(), Failure> {
        let fit = |points: &Option<Vec<(f64, f64)>>| -> Result<Option<LineFit>, Failure> {
            points
                .as_ref()
                .map(|points| calibrate::fit_line(points))
                .transpose()
                .map_err(in_recording(&self.recordings.folder))
        };
        let wheel_speed = fit(&self.recordings.wheel_speed)?;
        let duty = fit(&self.recordings.duty)?;
        let mut table = Table::new(&[
            ("line", Align::Left),
            ("slope", Align::Left),
            ("at zero", Align::Left),
            ("scatter", Align::Right),
        ]);
        for (name, line) in [
            ("wheel speed (rad/s) over converter counts", &wheel_speed),
            ("duty (counts) over current (A)", &duty),
        ] {
            if let Some(line) = line {
                table.row([
                    name.to_owned(),
                    with_uncertainty(line.slope, Some(line.slope_std)),
                    with_uncertainty(line.offset, Some(line.offset_std)),
                    significant(line.residual_std, 3),
                ]);
            }
        }
        if !table.is_empty() {
            self.text
                .push_str(&format!("\nConverters\n{}", table.text()));
        }
        self.found.wheel_speed = wheel_speed.as_ref().map(line_to_file);
        self.found.duty = duty.as_ref().map(line_to_file);
        self.json.wheel_speed = wheel_speed.as_ref().map(line_json);
        self.json.current = duty.as_ref().map(line_json);
        Ok(())
    }

    fn centre_of_mass(&mut self) -> Result<Option<Parameter>, Failure> {
        let Some(drawn) = &self.recordings.plumb_lines else {
            return Ok(None);
        };
        let lines: Vec<PlumbLine> = drawn
            .lines
            .iter()
            .map(|[first, second]| PlumbLine {
                first: (*first).into(),
                second: (*second).into(),
            })
            .collect();
        let found = calibrate::centre_of_mass(&lines, drawn.pivot_m.into(), drawn.mark_std_m)
            .map_err(in_recording(&self.recordings.folder))?;
        self.text.push_str(&format!(
            "\nCentre of mass from {} plumb lines that cross at {}°\n  pivot_to_com = {} m (put it under [known] in bench.toml for the gravity torque)\n",
            lines.len(),
            significant(found.crossing_angle_rad.to_degrees(), 3),
            with_uncertainty(found.pivot_to_com_m, Some(found.pivot_to_com_std_m)),
        ));
        self.json.centre_of_mass = Some(CentreJson {
            position_m: [found.position_m.x, found.position_m.y],
            pivot_to_com_m: found.pivot_to_com_m,
            pivot_to_com_std_m: found.pivot_to_com_std_m,
            crossing_angle_rad: found.crossing_angle_rad,
            residuals_m: found.residuals_m,
        });
        Ok(Some(Parameter {
            name: "pivot_to_com".to_owned(),
            value: found.pivot_to_com_m,
            std: Some(found.pivot_to_com_std_m),
            unit: "m".to_owned(),
            source: "plumb lines".to_owned(),
        }))
    }

    /// The text about a three-axis sensor.
    fn sensor(
        &mut self,
        name: &str,
        unit: &str,
        sensor: &calibrate::SensorCalibration,
        quality: &[(&'static str, f64)],
    ) {
        let mut table = Table::new(&[
            ("axis", Align::Left),
            ("bias in counts", Align::Left),
            ("x", Align::Left),
            ("y", Align::Left),
            ("z", Align::Left),
        ]);
        for (row, axis) in ["x", "y", "z"].iter().enumerate() {
            let entry = |column: usize| {
                let std = sensor.matrix_std[(row, column)];
                with_uncertainty(
                    sensor.line.matrix[(row, column)],
                    (std > 0.0).then_some(std),
                )
            };
            table.row([
                (*axis).to_owned(),
                with_uncertainty(sensor.line.bias_counts[row], Some(sensor.bias_std[row])),
                entry(0),
                entry(1),
                entry(2),
            ]);
        }
        let quality: Vec<String> = quality
            .iter()
            .map(|(what, value)| format!("{} {}", what.replace('_', " "), significant(*value, 3)))
            .collect();
        self.text.push_str(&format!(
            "\n{name}: value in {unit} = matrix (counts − bias)\n{}  {}\n",
            table.text(),
            quality.join(", ")
        ));
    }
}

/// A calibration error with the recording that it is about.
fn in_recording(file: &Path) -> impl Fn(CalibrationError) -> Failure {
    move |error| Failure::in_file(file, error)
}

fn matrix(of: &calibrate::SensorCalibration, std: bool) -> [[f64; 3]; 3] {
    let source = if std { &of.matrix_std } else { &of.line.matrix };
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| source[(row, column)]))
}

fn to_file(sensor: &calibrate::SensorCalibration) -> SensorCalibration {
    SensorCalibration {
        bias_counts: sensor.line.bias_counts.into(),
        bias_std: sensor.bias_std.into(),
        matrix: matrix(sensor, false),
        matrix_std: matrix(sensor, true),
    }
}

fn sensor_json(
    unit: &'static str,
    sensor: &calibrate::SensorCalibration,
    quality: Vec<(&'static str, f64)>,
) -> SensorJson {
    SensorJson {
        unit_per_count: unit,
        bias_counts: sensor.line.bias_counts.into(),
        bias_std: sensor.bias_std.into(),
        matrix: matrix(sensor, false),
        matrix_std: matrix(sensor, true),
        quality,
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

fn line_json(line: &LineFit) -> LineJson {
    LineJson {
        slope: line.slope,
        slope_std: line.slope_std,
        offset: line.offset,
        offset_std: line.offset_std,
        residual_std: line.residual_std,
    }
}

fn sphere(recording: &CountsRecording, found: &MagnetometerCalibration, field_ut: f64) -> String {
    let before: Vec<[f64; 3]> = recording
        .counts
        .iter()
        .map(|counts| counts.map(f64::from))
        .collect();
    let after: Vec<[f64; 3]> = found.points_ut.iter().map(|p| [p.x, p.y, p.z]).collect();
    figures::sphere(&figures::Sphere {
        title: "Magnetometer before and after calibration",
        subtitle: &format!(
            "Length varies by {} % before and {} % after; {:.0} % of all directions covered",
            significant(100.0 * found.spread_before, 3),
            significant(100.0 * found.spread_after, 3),
            100.0 * found.coverage
        ),
        before: &before,
        before_unit: "counts",
        after: &after,
        after_unit: "µT",
        radius: field_ut,
    })
}
