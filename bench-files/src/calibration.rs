//! The section `[calibration]`: recordings in bench.toml, results in model.toml.
//!
//! In bench.toml (all entries optional; files are CSV with a header line, in the bench folder;
//! counts are raw, as the registers hold them):
//!
//! ```toml
//! [calibration]
//! accelerometer = ["poses/x-up.csv", "poses/x-down.csv"]  # still poses, 6 or more: ax, ay, az
//! gyroscope     = "still.csv"       # at rest: gx, gy, gz
//! magnetometer  = "all-round.csv"   # turned into all directions: mx, my, mz
//! swing         = "swing.csv"       # wheel locked, swinging freely about the pivot: gx, gy, gz;
//!                                   # with ax, ay, az also where the sensor sits is found
//! hanging       = "hanging.csv"     # at rest, hanging: ax, ay, az
//! wheel_speed   = "converter.csv"   # adc_count, wheel_speed_rad_s (by a tachometer)
//! current       = "drive.csv"       # duty, current_A (by an ammeter)
//! gyroscope_scale = 1.0908308e-3    # rad/s per count, from the data sheet
//! sample_time     = 0.001           # s, of the still and swing recordings
//! field           = 48.9            # µT, the local field; left out: 0.1 µT per count is taken
//! lever_arm       = [0.05, 0.0]     # m, accelerometer from the pivot axis by a ruler, along the
//! lever_arm_std   = 0.001           # sensor's x and y; goes before what the swing says
//! columns = { ax = "acc_x" }        # where the header differs
//!
//! [calibration.plumb_lines]         # centre of mass, thesis 3.4; body-fixed drawing, m
//! pivot = [0.0, 0.0]
//! std   = 0.0005                    # of a mark
//! lines = [[[0.1, 0.0], [0.02, -0.13]], [[-0.1, 0.0], [-0.01, -0.13]]]   # two marks on each
//! ```
//!
//! In model.toml the results, as [`Calibration`] says.

use std::path::{Path, PathBuf};

use toml_edit::{Array, TableLike, Value};

use crate::bench::{SECTIONS, bench_file, folder_of};
use crate::csv_table;
use crate::error::{Error, Names, Problem};
use crate::files::{Files, FilesInMemory};
use crate::hardware::Hardware;
use crate::keys;
use crate::known::Known;
use crate::toml_source::{Located, Section, TomlSource};
use crate::toml_writing::{number, set, table_in};

/// Raw readings of a three-axis sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct CountsRecording {
    /// The file.
    pub file: PathBuf,
    /// Counts along x, y, z, one entry a sample.
    pub counts: Vec<[i16; 3]>,
}

/// Plumb lines drawn on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct PlumbLines {
    /// The pivot in the drawing, m.
    pub pivot_m: [f64; 2],
    /// Standard deviation of each coordinate of a mark, m.
    pub mark_std_m: f64,
    /// Two marks on each line, m.
    pub lines: Vec<[[f64; 2]; 2]>,
}

/// The recordings of `[calibration]`.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationRecordings {
    /// The bench's folder.
    pub folder: PathBuf,
    /// What was measured directly.
    pub known: Known,
    /// The bench's sensors and its drive, where bench.toml states them.
    pub hardware: Option<Hardware>,
    /// Still poses of the accelerometer.
    pub accelerometer: Vec<CountsRecording>,
    /// Gyroscope at rest.
    pub gyroscope: Option<CountsRecording>,
    /// Magnetometer, turned into all directions.
    pub magnetometer: Option<CountsRecording>,
    /// Gyroscope while the body swings about the pivot.
    pub swing: Option<CountsRecording>,
    /// Accelerometer during the swing, where the file has it.
    pub swing_accelerometer: Option<CountsRecording>,
    /// Accelerometer while the body hangs at rest.
    pub hanging: Option<CountsRecording>,
    /// Converter counts and the wheel speed in rad/s at each.
    pub wheel_speed: Option<Vec<(f64, f64)>>,
    /// Current in A and the duty (counts) that made it flow.
    pub duty: Option<Vec<(f64, f64)>>,
    /// Gyroscope scale, rad/s per count.
    pub gyroscope_scale_rad_s: Option<f64>,
    /// Sample time of the recordings, s.
    pub sample_time_s: Option<f64>,
    /// Local magnetic field, µT.
    pub field_ut: Option<f64>,
    /// Position of the accelerometer as it was measured directly.
    pub lever_arm: Option<LeverArmCalibration>,
    /// Plumb lines.
    pub plumb_lines: Option<PlumbLines>,
}

/// The columns that recordings have.
const COLUMNS: [&str; 13] = [
    "ax",
    "ay",
    "az",
    "gx",
    "gy",
    "gz",
    "mx",
    "my",
    "mz",
    "adc_count",
    "wheel_speed_rad_s",
    "duty",
    "current_A",
];

const ACCELEROMETER: [&str; 3] = ["ax", "ay", "az"];
const GYROSCOPE: [&str; 3] = ["gx", "gy", "gz"];
const MAGNETOMETER: [&str; 3] = ["mx", "my", "mz"];

impl CalibrationRecordings {
    /// Loads the recordings of a bench. `path` is the bench's folder or its bench.toml, which need
    /// not have experiments.
    ///
    /// # Errors
    /// The first thing that is wrong, see [`Problem`].
    pub fn load(path: &Path) -> Result<CalibrationRecordings, Error> {
        let file = bench_file(path)?;
        CalibrationRecordings::read(Files::Disk, &file, folder_of(&file))
    }

    /// The same from files that are in memory, one of them `bench.toml`.
    ///
    /// # Errors
    /// As for [`CalibrationRecordings::load`].
    pub fn from_files(files: &FilesInMemory) -> Result<CalibrationRecordings, Error> {
        let files = Files::Memory(files);
        CalibrationRecordings::read(files, Path::new("bench.toml"), PathBuf::new())
    }

    fn read(files: Files, file: &Path, folder: PathBuf) -> Result<CalibrationRecordings, Error> {
        let source = TomlSource::read(files, file)?;
        let document = source.parse()?;
        let root = source.root(&document);
        root.allow_only(&SECTIONS)?;
        let (known, _) = Known::read(root.section("known")?.as_ref())?;
        let section = root.section("calibration")?.ok_or_else(|| {
            root.error(root.missing(
                "calibration",
                "[calibration] with gyroscope = \"still.csv\"",
            ))
        })?;
        section.allow_only(&keys::names(keys::BENCH, "calibration"))?;
        let reader = Reader {
            files,
            source: &source,
            section: &section,
            folder: &folder,
            columns: columns(&section)?,
        };
        let value = |key: &str| -> Result<Option<f64>, Error> {
            Ok(section.positive_number(key)?.map(|number| number.value))
        };
        let accelerometer = section
            .texts("accelerometer")?
            .unwrap_or_default()
            .iter()
            .map(|file| reader.counts(file, ACCELEROMETER))
            .collect::<Result<Vec<_>, Error>>()?;
        let recordings = CalibrationRecordings {
            known,
            hardware: Hardware::read(&source, &root)?,
            accelerometer,
            gyroscope: reader.counts_of("gyroscope", GYROSCOPE)?,
            magnetometer: reader.counts_of("magnetometer", MAGNETOMETER)?,
            swing: reader.counts_of("swing", GYROSCOPE)?,
            swing_accelerometer: match section.text("swing")? {
                Some(file) if reader.has_column(&file, ACCELEROMETER[0])? => {
                    Some(reader.counts(&file, ACCELEROMETER)?)
                }
                _ => None,
            },
            hanging: reader.counts_of("hanging", ACCELEROMETER)?,
            wheel_speed: reader.pairs_of("wheel_speed", ["adc_count", "wheel_speed_rad_s"])?,
            duty: reader.pairs_of("current", ["current_A", "duty"])?,
            gyroscope_scale_rad_s: value("gyroscope_scale")?,
            sample_time_s: value("sample_time")?,
            field_ut: value("field")?,
            lever_arm: stated_lever_arm(&section)?,
            plumb_lines: plumb_lines(&section)?,
            folder: folder.clone(),
        };
        recordings.check_needs(&section)?;
        Ok(recordings)
    }

    /// What a recording needs beside itself.
    fn check_needs(&self, section: &Section) -> Result<(), Error> {
        let needs = |key: &'static str, missing: &'static str, example: &'static str| {
            section.error_at(
                key,
                Problem::NeedsBeside {
                    key,
                    missing,
                    example,
                },
            )
        };
        if !self.accelerometer.is_empty() && self.known.gravity.is_none() {
            let example = "gravity = 9.81 under [known]";
            return Err(needs("accelerometer", "gravity", example));
        }
        if self.gyroscope.is_some() {
            if self.gyroscope_scale_rad_s.is_none() {
                let example = "gyroscope_scale = 1.0908308e-3 (rad/s per count)";
                return Err(needs("gyroscope", "gyroscope_scale", example));
            }
            if self.sample_time_s.is_none() {
                return Err(needs("gyroscope", "sample_time", "sample_time = 0.001 (s)"));
            }
        }
        if self.swing.is_some() {
            if self.gyroscope.is_none() {
                return Err(needs("swing", "gyroscope", "gyroscope = \"still.csv\""));
            }
            if self.hanging.is_none() {
                return Err(needs("swing", "hanging", "hanging = \"hanging.csv\""));
            }
        }
        if self.lever_arm.is_none() && section.has("lever_arm_std") {
            let example = "lever_arm = [0.05, 0.0] (m)";
            return Err(needs("lever_arm_std", "lever_arm", example));
        }
        if self.hanging.is_some() {
            if self.swing.is_none() {
                return Err(needs("hanging", "swing", "swing = \"swing.csv\""));
            }
            if self.accelerometer.is_empty() {
                let example = "accelerometer = [\"x-up.csv\", …], six poses or more";
                return Err(needs("hanging", "accelerometer", example));
            }
        }
        Ok(())
    }
}

/// The mapping of column names.
fn columns(section: &Section) -> Result<Vec<(String, Located<String>)>, Error> {
    let Some(table) = section.section("columns")? else {
        return Ok(Vec::new());
    };
    table.allow_only(&COLUMNS)?;
    table
        .keys()
        .into_iter()
        .map(|key| {
            let name = table.required_text(&key.value, "the name of a column")?;
            Ok((key.value, name))
        })
        .collect()
}

/// Reads the files that the section names.
struct Reader<'a> {
    files: Files<'a>,
    source: &'a TomlSource,
    section: &'a Section<'a>,
    folder: &'a Path,
    columns: Vec<(String, Located<String>)>,
}

impl<'a> Reader<'a> {
    fn counts_of(&self, key: &str, names: [&str; 3]) -> Result<Option<CountsRecording>, Error> {
        self.section
            .text(key)?
            .map(|file| self.counts(&file, names))
            .transpose()
    }

    fn counts(&self, file: &Located<String>, names: [&str; 3]) -> Result<CountsRecording, Error> {
        let path = self.folder.join(&file.value);
        let mut counts = Vec::new();
        self.rows(file, &path, &names, |row| {
            let mut sample = [0_i16; 3];
            for (k, count) in sample.iter_mut().enumerate() {
                let value = row.number(k)?;
                if value.fract() != 0.0 || value.abs() > 32768.0 || value == 32768.0 {
                    return Err(row.error(k, Problem::NotACount { value }));
                }
                *count = value as i16;
            }
            counts.push(sample);
            Ok(())
        })?;
        Ok(CountsRecording { file: path, counts })
    }

    fn pairs_of(&self, key: &str, names: [&str; 2]) -> Result<Option<Vec<(f64, f64)>>, Error> {
        let Some(file) = self.section.text(key)? else {
            return Ok(None);
        };
        let path = self.folder.join(&file.value);
        let mut pairs = Vec::new();
        self.rows(&file, &path, &names, |row| {
            pairs.push((row.number(0)?, row.number(1)?));
            Ok(())
        })?;
        Ok(Some(pairs))
    }

    /// Whether a file has the column that stands for `name`.
    fn has_column(&self, file: &Located<String>, name: &str) -> Result<bool, Error> {
        let path = self.folder.join(&file.value);
        let table = self.open(file, &path)?;
        Ok(table.columns().contains(&self.column(name)))
    }

    /// What the header calls `name`.
    fn column(&self, name: &str) -> String {
        let own = self.columns.iter().find(|(key, _)| key == name);
        own.map_or(name.to_owned(), |(_, column)| column.value.clone())
    }

    fn open<'p>(
        &self,
        file: &Located<String>,
        path: &'p Path,
    ) -> Result<csv_table::OpenTable<'p>, Error>
    where
        'a: 'p,
    {
        csv_table::open(self.files, path).map_err(|error| match error.problem() {
            Problem::NotFound | Problem::NotAFile { .. } => self.source.error(
                file.span.clone(),
                Problem::NoLog {
                    path: path.display().to_string(),
                    reason: error.problem().to_string(),
                },
            ),
            _ => error,
        })
    }

    fn rows(
        &self,
        file: &Located<String>,
        path: &Path,
        names: &[&str],
        take: impl FnMut(&csv_table::Row) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut table = self.open(file, path)?;
        let mapped: Vec<String> = names.iter().map(|name| self.column(name)).collect();
        for (name, column) in names.iter().zip(&mapped) {
            if !table.columns().contains(column) {
                return Err(table.header_error(
                    None,
                    Problem::MissingRecordingColumn {
                        key: (*name).to_owned(),
                        column: column.clone(),
                        names: Names::new(table.columns()),
                    },
                ));
            }
        }
        table.read_rows(&mapped, take)?;
        Ok(())
    }
}

fn stated_lever_arm(section: &Section) -> Result<Option<LeverArmCalibration>, Error> {
    let Some(position_m) = pair(section, "lever_arm")? else {
        return Ok(None);
    };
    let std = section.required_positive_number("lever_arm_std", "lever_arm_std = 0.001 (m)")?;
    Ok(Some(LeverArmCalibration {
        position_m,
        position_std_m: [std; 2],
    }))
}

fn plumb_lines(section: &Section) -> Result<Option<PlumbLines>, Error> {
    let Some(table) = section.section("plumb_lines")? else {
        return Ok(None);
    };
    table.allow_only(&keys::names(keys::BENCH, "calibration.plumb_lines"))?;
    let pivot = "pivot = [0.0, 0.0]";
    let lines = "lines = [[[0.1, 0.0], [0.02, -0.13]], [[-0.1, 0.0], [-0.01, -0.13]]]";
    let pivot_m = table
        .numbers("pivot", &[2], "a list of two numbers, x and y in m")?
        .ok_or_else(|| table.error(table.missing("pivot", pivot)))?;
    let flat = table
        .numbers(
            "lines",
            &[0, 2, 2],
            "a list of lines, each of two marks, each of x and y in m",
        )?
        .ok_or_else(|| table.error(table.missing("lines", lines)))?;
    Ok(Some(PlumbLines {
        pivot_m: [pivot_m[0], pivot_m[1]],
        mark_std_m: table.required_positive_number("std", "std = 0.0005 (m, of a mark)")?,
        lines: flat
            .chunks_exact(4)
            .map(|marks| [[marks[0], marks[1]], [marks[2], marks[3]]])
            .collect(),
    }))
}

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

/// How the sensor sits on the body.
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

/// Where the accelerometer sits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArmCalibration {
    /// From the pivot axis along the sensor's x and y after the mounting's alignment, m.
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

/// What calibration found: the section `[calibration]` of model.toml. Each part may be missing.
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
    /// filter turns the estimate back by at most 2β: where the gyroscope's bias wanders by more
    /// after the recording, with warmth say, a larger β is to be written here. Another calibration
    /// of the gyroscope writes it anew.
    pub beta_rad_s: Option<f64>,
    /// Magnetometer, µT per count.
    pub magnetometer: Option<StoredSensorCalibration>,
    /// Place of the sensor on the body.
    pub mounting: Option<MountingCalibration>,
    /// Place of the accelerometer, for which the filter corrects.
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

    /// Puts the section into a document.
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
fn pair(table: &Section, key: &str) -> Result<Option<[f64; 2]>, Error> {
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
