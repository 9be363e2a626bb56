//! The recordings of `[bring_up]`, which show which way is positive.
//!
//! ```toml
//! [bring_up]                     # CSV of raw counts: gx gy gz ax ay az wheel duty time_s
//! hanging      = "hanging.csv"   # the body hangs still
//! tilted       = "tilted.csv"    # from hanging turned by hand towards positive α, and held
//! wheel_spun   = "spun.csv"      # the wheel turned by hand in that sense
//! current_step = "step.csv"      # a small positive current, the body held
//! ```
//!
//! A bench whose angle comes from an encoder has a column `body` in place of the six of the inertial sensor.

use std::path::{Path, PathBuf};

use crate::bench::{SECTIONS, bench_file, folder_of};
use crate::csv_table;
use crate::error::{Error, Names, Problem};
use crate::files::{Files, FilesInMemory};
use crate::hardware::{AngleSensor, Hardware};
use crate::toml_section::Section;
use crate::toml_source::TomlSource;

/// The four recordings, and what bench.toml states of the hardware.
#[derive(Clone, Debug, PartialEq)]
pub struct BringUpRecordings {
    /// The bench's folder.
    pub folder: PathBuf,
    /// Sensors and drive as bench.toml states them.
    pub hardware: Option<Hardware>,
    /// The body hangs still.
    pub hanging: RawRecording,
    /// From hanging turned towards positive α, and held.
    pub tilted: RawRecording,
    /// The wheel turned by hand in the positive sense.
    pub wheel_spun: RawRecording,
    /// A small positive current, the body held; `None` if it is not recorded yet.
    pub current_step: Option<RawRecording>,
}

/// Raw counts over time, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawRecording {
    /// The file.
    pub file: PathBuf,
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// Gyroscope; empty where the bench has none.
    pub gyro: Vec<[f64; 3]>,
    /// Accelerometer; empty where the bench has none.
    pub accel: Vec<[f64; 3]>,
    /// Encoder on the pivot; empty where the bench has none.
    pub body: Vec<f64>,
    /// Word of the wheel's sensor.
    pub wheel: Vec<f64>,
    /// Duty of the drive.
    pub duty: Vec<f64>,
}

/// Fewest samples of a recording: less shows no noise.
const SAMPLES_MIN: usize = 20;

impl BringUpRecordings {
    /// Loads them. `path` is the bench's folder or its bench.toml, which need not have experiments.
    ///
    /// # Errors
    /// The first thing that is wrong, see [`Problem`].
    pub fn load(path: &Path) -> Result<BringUpRecordings, Error> {
        let file = bench_file(path)?;
        BringUpRecordings::read(Files::Disk, &file, folder_of(&file))
    }

    /// The same from files that are in memory, one of them `bench.toml`.
    ///
    /// # Errors
    /// As for [`BringUpRecordings::load`].
    pub fn from_files(files: &FilesInMemory) -> Result<BringUpRecordings, Error> {
        let files = Files::Memory(files);
        BringUpRecordings::read(files, Path::new("bench.toml"), PathBuf::new())
    }

    fn read(files: Files, file: &Path, folder: PathBuf) -> Result<BringUpRecordings, Error> {
        let source = TomlSource::read(files, file)?;
        let document = source.parse()?;
        let root = source.root(&document);
        root.allow_only(&SECTIONS)?;
        let section = root.section("bring_up")?.ok_or_else(|| {
            root.error(root.missing("bring_up", "[bring_up] with hanging = \"hanging.csv\""))
        })?;
        section.allow_only(&["hanging", "tilted", "wheel_spun", "current_step"])?;
        let hardware = Hardware::read(&source, &root)?;
        let has_encoder = matches!(
            hardware.as_ref().and_then(|stated| stated.angle.as_ref()),
            Some(AngleSensor::Encoder { .. })
        );
        let one = |key: &str, example: &'static str| {
            recording(
                files,
                &source,
                &section,
                &folder,
                (key, example),
                has_encoder,
            )
        };
        Ok(BringUpRecordings {
            hanging: one("hanging", "hanging = \"hanging.csv\"")?,
            tilted: one("tilted", "tilted = \"tilted.csv\"")?,
            wheel_spun: one("wheel_spun", "wheel_spun = \"spun.csv\"")?,
            current_step: match section.keys().iter().any(|key| key.value == "current_step") {
                true => Some(one("current_step", "current_step = \"step.csv\"")?),
                false => None,
            },
            hardware,
            folder: folder.clone(),
        })
    }
}

fn recording(
    files: Files,
    source: &TomlSource,
    section: &Section,
    folder: &Path,
    (key, example): (&str, &'static str),
    has_encoder: bool,
) -> Result<RawRecording, Error> {
    let named = section.required_text(key, example)?;
    let path = folder.join(&named.value);
    let mut table = csv_table::open(files, &path).map_err(|error| match error.problem() {
        Problem::NotFound | Problem::NotAFile { .. } => source.error(
            named.span.clone(),
            Problem::NoLog {
                path: path.display().to_string(),
                reason: error.problem().to_string(),
            },
        ),
        _ => error,
    })?;
    let columns: &[&str] = if has_encoder {
        &["time_s", "wheel", "duty", "body"]
    } else {
        &[
            "time_s", "wheel", "duty", "gx", "gy", "gz", "ax", "ay", "az",
        ]
    };
    for column in columns {
        if !table.columns().iter().any(|own| own == column) {
            return Err(table.header_error(
                None,
                Problem::MissingBringUpColumn {
                    column: (*column).to_owned(),
                    names: Names::new(table.columns()),
                },
            ));
        }
    }
    let names: Vec<String> = columns.iter().map(|name| (*name).to_owned()).collect();
    let mut found = RawRecording {
        file: path.clone(),
        ..RawRecording::default()
    };
    table.read_rows(&names, |row| {
        let time_s = row.number(0)?;
        if let Some(before) = found.time_s.last()
            && time_s <= *before
        {
            return Err(row.error(
                0,
                Problem::OutOfRange {
                    key: "time_s".to_owned(),
                    value: time_s,
                    must_be: format!("later than the row before ({before})"),
                },
            ));
        }
        for (k, column) in columns.iter().enumerate().skip(1) {
            let value = row.number(k)?;
            // Words of timers and encoders have no sign.
            let is_inertial = k >= 3 && !has_encoder;
            if is_inertial && (value.fract() != 0.0 || !(-32_768.0..=32_767.0).contains(&value)) {
                return Err(row.error(k, Problem::NotACount { value }));
            }
            if value.fract() != 0.0 || !(-32_768.0..=65_535.0).contains(&value) {
                return Err(row.error(
                    k,
                    Problem::OutOfRange {
                        key: (*column).to_owned(),
                        value,
                        must_be: "a whole number from -32768 to 65535".to_owned(),
                    },
                ));
            }
        }
        found.time_s.push(time_s);
        found.wheel.push(row.number(1)?);
        found.duty.push(row.number(2)?);
        if has_encoder {
            found.body.push(row.number(3)?);
        } else {
            found
                .gyro
                .push([row.number(3)?, row.number(4)?, row.number(5)?]);
            found
                .accel
                .push([row.number(6)?, row.number(7)?, row.number(8)?]);
        }
        Ok(())
    })?;
    if found.time_s.len() < SAMPLES_MIN {
        return Err(table.header_error(
            None,
            Problem::ShortRecording {
                rows: found.time_s.len(),
                least: SAMPLES_MIN,
            },
        ));
    }
    Ok(found)
}
