//! The recordings that `[calibration]` of bench.toml names (all entries optional; files are CSV with a header line, in the bench folder;
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

use std::path::{Path, PathBuf};

use super::results::{LeverArmCalibration, pair};
use crate::bench::{SECTIONS, bench_file, folder_of};
use crate::csv_table;
use crate::error::{Error, Names, Problem};
use crate::files::{Files, FilesInMemory};
use crate::hardware::Hardware;
use crate::keys;
use crate::known::Known;
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};

/// Raw readings of a three-axis sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct CountsRecording {
    /// The file.
    pub file: PathBuf,
    /// Counts along x, y, z, one entry a sample.
    pub counts: Vec<[i16; 3]>,
}

/// Plumb lines, drawn on the body.
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
    /// The values that were measured directly.
    pub known: Known,
    /// The bench's sensors and its drive, if bench.toml states them.
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
    /// Position of the accelerometer, measured directly.
    pub lever_arm: Option<LeverArmCalibration>,
    /// Plumb lines.
    pub plumb_lines: Option<PlumbLines>,
}

/// The column names of the recordings.
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
    /// Loads the recordings of a bench. `path` is the bench's folder or its bench.toml, which may have no experiments.
    ///
    /// # Errors
    /// The first error, see [`Problem`].
    pub fn load(path: &Path) -> Result<CalibrationRecordings, Error> {
        let file = bench_file(path)?;
        CalibrationRecordings::read(Files::Disk, &file, folder_of(&file))
    }

    /// As [`CalibrationRecordings::load`], from files in memory, one of them `bench.toml`.
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

    /// Checks for other entries that a recording needs.
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

/// Reads the files that the section lists.
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

    /// Whether a file has the column `name`, or the one that `columns` maps to it.
    fn has_column(&self, file: &Located<String>, name: &str) -> Result<bool, Error> {
        let path = self.folder.join(&file.value);
        let table = self.open(file, &path)?;
        Ok(table.columns().contains(&self.column(name)))
    }

    /// The name of a column in the file's header.
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
