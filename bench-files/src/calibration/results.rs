//! The results of `flywheel calibrate`, as `[calibration]` of model.toml holds them.

use toml_edit::{Array, TableLike, Value};

use crate::error::Error;
use crate::keys;
use crate::toml_section::Section;
use crate::toml_writing::{number, set, table_in};

/// A three-axis sensor: value = `matrix` (counts − `bias_counts`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredSensorCalibration {
    /// Reading at zero input, counts.
    pub bias_counts: [f64; 3],
    /// Its standard errors, counts.
    pub bias_std: [f64; 3],
    /// SI units (µT for a magnetometer) per count, row by row, in the sensor's own frame.
    pub matrix: [[f64; 3]; 3],
    /// Its standard errors; zero for entries that were not identified.
    pub matrix_std: [[f64; 3]; 3],
}

/// The orientation of the sensor on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountingCalibration {
    /// The pivot axis in the sensor's frame, a unit vector.
    pub axis: [f64; 3],
    /// Standard error of its direction, rad.
    pub axis_std_rad: f64,
    /// Angle from the body's axis to the sensor's x axis, rad.
    pub angle_rad: f64,
    /// Its standard error, rad.
    pub angle_std_rad: f64,
}

/// The position of the accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArmCalibration {
    /// Position relative to the pivot axis, along the sensor's x and y after its alignment by the mounting, m.
    pub position_m: [f64; 2],
    /// Standard errors, m.
    pub position_std_m: [f64; 2],
}

/// A straight line y = `slope` x + `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineCalibration {
    /// Slope.
    pub slope: f64,
    /// Its standard error.
    pub slope_std: f64,
    /// Value at zero.
    pub offset: f64,
    /// Its standard error.
    pub offset_std: f64,
}

/// The results of the calibration: section `[calibration]` of model.toml. Each part may be missing.
///
/// ```toml
/// [calibration.accelerometer]       # likewise gyroscope (with beta) and magnetometer
/// bias_counts = [41.7, -24.2, 9.9]
/// bias_std    = [0.3, 0.3, 0.3]
/// matrix      = [[2.4e-3, 0.0, 0.0], [0.0, 2.4e-3, 0.0], [0.0, 0.0, 2.4e-3]]
/// matrix_std  = [[1e-7, 0.0, 0.0], [0.0, 1e-7, 0.0], [0.0, 0.0, 1e-7]]
/// # beta      = 0.01                # gyroscope only, rad/s
///
/// [calibration.mounting]
/// axis         = [0.01, -0.02, 0.9997]     # of the pivot in the sensor's frame
/// axis_std_rad = 2e-4
/// angle        = 2.356              # rad, from the body's axis to the sensor's x axis
/// angle_std    = 1e-3
///
/// [calibration.lever_arm]           # accelerometer from the pivot axis, the aligned sensor's x, y
/// position     = [0.05, 0.0]        # m; left out, the motion's part of the reading stays in it
/// position_std = [1e-4, 1e-4]
///
/// [calibration.wheel_speed]         # rad/s over counts; likewise current: duty over A
/// slope = 0.893373
/// slope_std = 1e-5
/// offset = -690.574
/// offset_std = 1e-2
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Accelerometer, m/s² per count.
    pub accelerometer: Option<StoredSensorCalibration>,
    /// Gyroscope, rad/s per count.
    pub gyroscope: Option<StoredSensorCalibration>,
    /// Madgwick's β from the gyroscope's noise, rad/s (`beta` under `[calibration.gyroscope]`). The
    /// filter corrects the estimate by at most 2β (rad/s). If the gyroscope's bias changes by more than that
    /// after the recording, for example with temperature, write a larger β here. A new calibration
    /// of the gyroscope overwrites it.
    pub beta_rad_s: Option<f64>,
    /// Magnetometer, µT per count.
    pub magnetometer: Option<StoredSensorCalibration>,
    /// Orientation of the sensor on the body.
    pub mounting: Option<MountingCalibration>,
    /// Position of the accelerometer, which the filter corrects for.
    pub lever_arm: Option<LeverArmCalibration>,
    /// Wheel speed in rad/s over converter counts.
    pub wheel_speed: Option<LineCalibration>,
    /// Duty in counts over the current in A (`[calibration.current]`).
    pub duty: Option<LineCalibration>,
}

impl Calibration {
    /// Reads the section.
    pub(crate) fn read(section: &Section) -> Result<Calibration, Error> {
        section.allow_only(&keys::names(keys::MODEL, "calibration"))?;
        let sensor = |key: &str| -> Result<Option<StoredSensorCalibration>, Error> {
            let Some(table) = section.section(key)? else {
                return Ok(None);
            };
            let mut known = vec!["bias_counts", "bias_std", "matrix", "matrix_std"];
            if key == "gyroscope" {
                known.push("beta");
            }
            table.allow_only(&known)?;
            Ok(Some(StoredSensorCalibration {
                bias_counts: vector(&table, "bias_counts")?,
                bias_std: vector(&table, "bias_std")?,
                matrix: matrix(&table, "matrix")?,
                matrix_std: matrix(&table, "matrix_std")?,
            }))
        };
        let line = |key: &str| -> Result<Option<LineCalibration>, Error> {
            let Some(table) = section.section(key)? else {
                return Ok(None);
            };
            table.allow_only(&["slope", "slope_std", "offset", "offset_std"])?;
            Ok(Some(LineCalibration {
                slope: table.required_number("slope")?,
                slope_std: table.required_number("slope_std")?,
                offset: table.required_number("offset")?,
                offset_std: table.required_number("offset_std")?,
            }))
        };
        let mounting = match section.section("mounting")? {
            None => None,
            Some(table) => {
                table.allow_only(&["axis", "axis_std_rad", "angle", "angle_std"])?;
                Some(MountingCalibration {
                    axis: vector(&table, "axis")?,
                    axis_std_rad: table.required_number("axis_std_rad")?,
                    angle_rad: table.required_number("angle")?,
                    angle_std_rad: table.required_number("angle_std")?,
                })
            }
        };
        let lever_arm = match section.section("lever_arm")? {
            None => None,
            Some(table) => {
                table.allow_only(&["position", "position_std"])?;
                let pair = |key: &str| -> Result<[f64; 2], Error> {
                    let example = "a list of two numbers, along x and y in m";
                    pair(&table, key)?.ok_or_else(|| table.error(table.missing(key, example)))
                };
                Some(LeverArmCalibration {
                    position_m: pair("position")?,
                    position_std_m: pair("position_std")?,
                })
            }
        };
        let beta = match section.section("gyroscope")? {
            None => None,
            Some(table) => table.positive_number("beta")?.map(|beta| beta.value),
        };
        Ok(Calibration {
            accelerometer: sensor("accelerometer")?,
            gyroscope: sensor("gyroscope")?,
            beta_rad_s: beta,
            magnetometer: sensor("magnetometer")?,
            mounting,
            lever_arm,
            wheel_speed: line("wheel_speed")?,
            duty: line("current")?,
        })
    }

    /// Writes the section into a document.
    pub(crate) fn write(&self, root: &mut dyn TableLike) {
        let section = table_in(root, "calibration", true);
        for (key, sensor) in [
            ("accelerometer", &self.accelerometer),
            ("gyroscope", &self.gyroscope),
            ("magnetometer", &self.magnetometer),
        ] {
            let Some(sensor) = sensor else {
                section.remove(key);
                continue;
            };
            let table = table_in(section, key, false);
            set(table, "bias_counts", list(&sensor.bias_counts));
            set(table, "bias_std", list(&sensor.bias_std));
            set(table, "matrix", lists(&sensor.matrix));
            set(table, "matrix_std", lists(&sensor.matrix_std));
            if key == "gyroscope" {
                match self.beta_rad_s {
                    Some(beta) => set(table, "beta", number(beta)),
                    None => {
                        table.remove("beta");
                    }
                }
            }
        }
        match &self.mounting {
            None => {
                section.remove("mounting");
            }
            Some(mounting) => {
                let table = table_in(section, "mounting", false);
                set(table, "axis", list(&mounting.axis));
                set(table, "axis_std_rad", number(mounting.axis_std_rad));
                set(table, "angle", number(mounting.angle_rad));
                set(table, "angle_std", number(mounting.angle_std_rad));
            }
        }
        match &self.lever_arm {
            None => {
                section.remove("lever_arm");
            }
            Some(arm) => {
                let table = table_in(section, "lever_arm", false);
                set(table, "position", list(&arm.position_m));
                set(table, "position_std", list(&arm.position_std_m));
            }
        }
        for (key, line) in [("wheel_speed", &self.wheel_speed), ("current", &self.duty)] {
            let Some(line) = line else {
                section.remove(key);
                continue;
            };
            let table = table_in(section, key, false);
            set(table, "slope", number(line.slope));
            set(table, "slope_std", number(line.slope_std));
            set(table, "offset", number(line.offset));
            set(table, "offset_std", number(line.offset_std));
        }
    }
}

/// Two numbers, along x and y, if the key is there.
pub(super) fn pair(table: &Section, key: &str) -> Result<Option<[f64; 2]>, Error> {
    let numbers = table.numbers(key, &[2], "a list of two numbers, along x and y in m")?;
    Ok(numbers.map(|numbers| [numbers[0], numbers[1]]))
}

fn vector(table: &Section, key: &str) -> Result<[f64; 3], Error> {
    let numbers = table
        .numbers(key, &[3], "a list of three numbers")?
        .ok_or_else(|| table.error(table.missing(key, "a list of three numbers")))?;
    Ok([numbers[0], numbers[1], numbers[2]])
}

fn matrix(table: &Section, key: &str) -> Result<[[f64; 3]; 3], Error> {
    let numbers = table
        .numbers(key, &[3, 3], "three lists of three numbers")?
        .ok_or_else(|| table.error(table.missing(key, "three lists of three numbers")))?;
    Ok([0, 1, 2].map(|row| [0, 1, 2].map(|column| numbers[3 * row + column])))
}

fn list(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|value| number(*value)).collect::<Array>())
}

fn lists(rows: &[[f64; 3]; 3]) -> Value {
    Value::Array(rows.iter().map(|row| list(row)).collect::<Array>())
}
