//! A bench: `bench.toml` and the logs that it names.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::{Path, PathBuf};

use plant::Kind;

use crate::channel::{Channel, NORMALISED};
use crate::csv_table::{self, OpenTable};
use crate::error::{Error, Names, Problem};
use crate::files::{Files, FilesInMemory, ReadingWatch};
use crate::hardware::Hardware;
use crate::keys;
use crate::known::Known;
use crate::log::{self, ColumnUse, LoadReport, Log, Note};
use crate::own_effect::OwnEffect;
use crate::toml_source::{Located, Section, TomlSource};

/// A bench with all its measurements, checked and in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Its name; the folder's name where bench.toml gives none.
    pub name: String,
    /// The folder that holds bench.toml; logs are named relative to it. Empty for a bench in memory.
    pub folder: PathBuf,
    /// What was measured directly.
    pub known: Known,
    /// The controller of the balance logs.
    pub controller: Option<Controller>,
    /// Its sensors and its drive, where bench.toml states them.
    pub hardware: Option<Hardware>,
    /// The experiments in the order of the file; at least one, names unique.
    pub experiments: Vec<Experiment>,
    /// The effects that its user has written, by name.
    pub own_effects: Vec<OwnEffect>,
    /// What the bench's user should know that concerns no single experiment; sentences.
    pub notes: Vec<String>,
}

/// The controller under which balance logs were recorded: u = −K (α − π, α̇, φ̇), clipped to the
/// current limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Gains K for angle (A/rad), rate (A s/rad) and wheel speed (A s/rad).
    pub gains: [f64; 3],
    /// Largest current either way, A.
    pub current_limit_a: f64,
    /// Time between two commands, s.
    pub sample_time_s: f64,
}

/// What the current column of a log means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurrentMeaning {
    /// What the controller asked for.
    #[default]
    Command,
    /// What flowed.
    Measured,
}

/// One recorded experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its name, unique in the bench.
    pub name: String,
    /// What was held still, and about which equilibrium.
    pub kind: Kind,
    /// The log's path.
    pub file: PathBuf,
    /// The samples. Which channels there are: free-swing at least one of angle and rate; spin-up
    /// wheel speed, and current where it is known; balance at least one of angle and rate, and
    /// current; driven at least one of angle and wheel speed, and current.
    pub log: Log,
    /// The channels that the kind holds still, where the file has them: for checks, no part of a fit. Their
    /// samples belong to the times of `log`; NaN where a cell is no number.
    pub beside: Log,
    /// What the current means.
    pub current_meaning: CurrentMeaning,
    /// Findings of the data check that this experiment may have (`accept`).
    pub accept: Vec<String>,
    /// Line of bench.toml on which its name stands.
    pub line: usize,
    /// How the log was read.
    pub report: LoadReport,
}

impl Bench {
    /// Loads a bench and all its logs. `path` is the bench's folder or its bench.toml.
    ///
    /// # Errors
    /// The first thing that is wrong, see [`Problem`].
    pub fn load(path: &Path) -> Result<Bench, Error> {
        Bench::load_from(path, Files::Disk)
    }

    /// As [`Bench::load`], with somebody who is told how far it is and may call it off.
    ///
    /// # Errors
    /// As for [`Bench::load`]; [`Problem::Unreadable`] where the reading was called off.
    pub fn load_watched(path: &Path, watch: ReadingWatch) -> Result<Bench, Error> {
        Bench::load_from(path, Files::Watched(watch))
    }

    fn load_from(path: &Path, files: Files) -> Result<Bench, Error> {
        let file = bench_file(path)?;
        let folder = folder_of(&file);
        let source = TomlSource::read(files, &file)?;
        let document = source.parse()?;
        read_bench(files, &source, &source.root(&document), folder)
    }

    /// The same from files that are in memory, one of them `bench.toml`.
    ///
    /// # Errors
    /// As for [`Bench::load`].
    pub fn from_files(files: &FilesInMemory) -> Result<Bench, Error> {
        let files = Files::Memory(files);
        let source = TomlSource::read(files, Path::new("bench.toml"))?;
        let document = source.parse()?;
        read_bench(files, &source, &source.root(&document), PathBuf::new())
    }

    /// The experiment with this name.
    pub fn experiment(&self, name: &str) -> Option<&Experiment> {
        self.experiments
            .iter()
            .find(|experiment| experiment.name == name)
    }
}

/// The sections of bench.toml.
pub(crate) const SECTIONS: [&str; 8] = [
    "bench",
    "known",
    "controller",
    "experiment",
    "calibration",
    "hardware",
    "bring_up",
    // Of other programs; nothing in it is read.
    "tool",
];

/// The bench.toml of a bench that is named by its folder or that file.
pub(crate) fn bench_file(path: &Path) -> Result<PathBuf, Error> {
    if path.is_dir() {
        return Ok(path.join("bench.toml"));
    }
    if path.exists() {
        return Ok(path.to_path_buf());
    }
    Err(Error::in_file(path, Problem::NoBench))
}

/// The folder of a file.
pub(crate) fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn read_bench(
    files: Files,
    source: &TomlSource,
    root: &Section,
    folder: PathBuf,
) -> Result<Bench, Error> {
    root.allow_only(&SECTIONS)?;
    let mut name = None;
    if let Some(section) = root.section("bench")? {
        section.allow_only(&keys::names(keys::BENCH, "bench"))?;
        name = section.text("name")?.map(|name| name.value);
    }
    let (known, computed) = Known::read(root.section("known")?.as_ref())?;
    let mut notes = Vec::new();
    if let (Some(stated), Some(computed)) = (known.gravity_torque, computed) {
        notes.push(format!(
            "gravity_torque = {stated} N m is used; masses and lengths give {computed:.6} N m"
        ));
    }
    let controller = root
        .section("controller")?
        .map(|section| read_controller(&section))
        .transpose()?;

    let hardware = Hardware::read(source, root)?;

    let sections = root.sections("experiment")?;
    if sections.is_empty() {
        return Err(root.error(Problem::NoExperiment));
    }
    // The whole of bench.toml is checked before the first log is opened.
    let mut plans: Vec<Plan> = Vec::new();
    for section in &sections {
        let plan = Plan::read(section, &folder)?;
        if let Some(first) = plans.iter().find(|p| p.name.value == plan.name.value) {
            return Err(source.error(
                plan.name.span,
                Problem::DuplicateExperiment {
                    name: plan.name.value,
                    first_line: source.line(&first.name.span),
                },
            ));
        }
        plans.push(plan);
    }
    let experiments = plans
        .into_iter()
        .zip(&sections)
        .map(|(plan, section)| plan.load(files, source, section))
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(Bench {
        own_effects: OwnEffect::all_of(files, &folder)?,
        name: name.unwrap_or_else(|| folder_name(&folder)),
        folder,
        known,
        controller,
        hardware,
        experiments,
        notes,
    })
}

fn folder_name(folder: &Path) -> String {
    folder
        .canonicalize()
        .ok()
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(
            || "bench".to_string(),
            |name| name.to_string_lossy().into_owned(),
        )
}

fn read_controller(section: &Section) -> Result<Controller, Error> {
    section.allow_only(&keys::names(keys::BENCH, "controller"))?;
    Ok(Controller {
        gains: section
            .required_three_numbers("gains", "gains = [-24.27, -2.13, -0.0226]")?
            .value,
        current_limit_a: section
            .required_positive_number("current_limit", "current_limit = 2.0 (A)")?,
        sample_time_s: section
            .required_positive_number("sample_time", "sample_time = 0.001 (s)")?,
    })
}

/// What bench.toml says about one experiment.
struct Plan {
    name: Located<String>,
    kind: Kind,
    file_key: Located<String>,
    file: PathBuf,
    columns: Vec<(Channel, Located<String>)>,
    units: Vec<(Channel, Located<f64>)>,
    scales: Vec<(Channel, Located<f64>)>,
    signs: Vec<(Channel, Located<f64>)>,
    offsets: Vec<(Channel, Located<f64>)>,
    held_current: Option<Located<f64>>,
    /// The current column is a command without unit.
    normalised: bool,
    current_meaning: CurrentMeaning,
    window: log::Window,
    time_step: Option<Located<f64>>,
    accept: Vec<String>,
}

/// The channels that a kind can use. The others stay in the file: a column that is nobody's input
/// cannot spoil the bench.
fn useful(kind: Kind) -> &'static [Channel] {
    match kind {
        Kind::FreeSwing => &[Channel::Time, Channel::Angle, Channel::Rate],
        Kind::SpinUp => &[
            Channel::Time,
            Channel::WheelSpeed,
            Channel::WheelAngle,
            Channel::Current,
        ],
        Kind::Balance | Kind::Driven => &Channel::ALL,
    }
}

/// What a kind cannot do without, beside time and current: one of these channels.
fn motion_needed(kind: Kind) -> (&'static [Channel], &'static str) {
    match kind {
        Kind::FreeSwing | Kind::Balance => (
            &[Channel::Angle, Channel::Rate],
            "the body's angle or its rate",
        ),
        Kind::SpinUp => (
            &[Channel::WheelSpeed, Channel::WheelAngle],
            "the wheel's speed",
        ),
        Kind::Driven => (
            &[Channel::Angle, Channel::WheelSpeed, Channel::WheelAngle],
            "the body's angle or the wheel's speed",
        ),
    }
}

impl Plan {
    fn read(section: &Section, folder: &Path) -> Result<Plan, Error> {
        section.allow_only(&keys::names(keys::BENCH, "experiment"))?;
        let name = section.required_text("name", "name = \"free swing 20 deg\"")?;
        let kind_name = section.required_text(
            "kind",
            "kind = \"free-swing\" (or spin-up, balance, driven)",
        )?;
        let kind = Kind::from_name(&kind_name.value).ok_or_else(|| {
            section.error_at(
                "kind",
                Problem::UnknownName {
                    what: "kind of experiment".to_string(),
                    name: kind_name.value.clone(),
                    names: Names::new(Kind::ALL.map(Kind::name)),
                },
            )
        })?;
        let file_key = section.required_text("file", "file = \"free-swing-20deg.csv\"")?;
        let file = folder.join(&file_key.value);

        let current_meaning = match section.text("current_meaning")? {
            None => CurrentMeaning::Command,
            Some(text) => match text.value.as_str() {
                "command" => CurrentMeaning::Command,
                "measured" => CurrentMeaning::Measured,
                _ => {
                    return Err(section.error_at(
                        "current_meaning",
                        Problem::UnknownName {
                            what: "current_meaning".to_string(),
                            name: text.value,
                            names: Names::new(["command", "measured"]),
                        },
                    ));
                }
            },
        };
        let from_s = section.number("from")?;
        let until_s = section.number("until")?;
        let time_step = section.positive_number("time_step")?;
        if let (Some(from), Some(until)) = (&from_s, &until_s)
            && from.value >= until.value
        {
            return Err(section.error_at(
                "until",
                Problem::WindowReversed {
                    from_s: from.value,
                    until_s: until.value,
                },
            ));
        }
        Ok(Plan {
            columns: by_channel(section, "columns", |table, key| {
                table.required_text(key, "the name of a column")
            })?,
            units: by_channel(section, "units", unit_scale)?,
            scales: by_channel(section, "scale", |table, key| {
                not_zero(table, key, "a factor other than 0")
            })?,
            signs: by_channel(section, "sign", |table, key| {
                not_zero(table, key, "1 or -1")
            })?,
            offsets: by_channel(section, "offset", |table, key| {
                require(table.number(key)?, table, key)
            })?,
            held_current: held_current(section, kind)?,
            normalised: is_normalised(section)?,
            window: log::Window {
                from_s: from_s.map(|from| from.value),
                until_s: until_s.map(|until| until.value),
                time_step_s: time_step.as_ref().map(|step| step.value),
                measured_current: current_meaning == CurrentMeaning::Measured,
            },
            time_step,
            accept: section
                .texts("accept")?
                .unwrap_or_default()
                .into_iter()
                .map(|finding| finding.value)
                .collect(),
            name,
            kind,
            file_key,
            file,
            current_meaning,
        })
    }

    fn load(
        self,
        files: Files,
        source: &TomlSource,
        section: &Section,
    ) -> Result<Experiment, Error> {
        let table = csv_table::open(files, &self.file).map_err(|error| match error.problem() {
            // The place to mend is where the file is named.
            Problem::NotFound | Problem::NotAFile { .. } => source.error(
                self.file_key.span.clone(),
                Problem::NoLog {
                    path: self.file.display().to_string(),
                    reason: error.problem().to_string(),
                },
            ),
            _ => error,
        })?;
        let uses = self.column_uses(source, section, &table)?;
        let of_file = self.units_of_file(&table, &uses);
        let log::SamplesOfLog {
            log: mut samples,
            beside,
            mut report,
        } = log::read(table, &uses, self.window)?;
        report.notes.extend(of_file);

        for (channel, sign) in &self.signs {
            if sign.value.abs() != 1.0 {
                report.notes.push(Note::SignIsAFactor {
                    channel: *channel,
                    factor: sign.value,
                });
            }
        }
        if self.normalised {
            report.notes.push(Note::NormalisedCommand);
        }
        if let Some(current) = &self.held_current
            && useful(self.kind).contains(&Channel::Current)
        {
            samples.current_a = Some(vec![current.value; samples.len()]);
        }
        if self.kind == Kind::SpinUp && samples.current_a.is_none() {
            report.notes.push(Note::CurrentNotRecorded);
        }
        self.check_upright(section, &mut samples, &mut report)?;
        let line = source.line(&self.name.span);
        Ok(Experiment {
            name: self.name.value,
            kind: self.kind,
            file: self.file,
            log: samples,
            beside,
            current_meaning: self.current_meaning,
            accept: self.accept,
            line,
            report,
        })
    }

    /// The units that are the file's own word, in notes.
    fn units_of_file(&self, table: &OpenTable, uses: &[ColumnUse]) -> Vec<Note> {
        let found = uses.iter().filter_map(|column| {
            let channel = column.channel;
            let (unit, scale) = unit_of_file(table, channel, &column.name)?;
            let is_news = find(&self.units, channel).is_none() && scale != 1.0;
            is_news.then_some(Note::UnitFromFile { channel, unit })
        });
        found.collect()
    }

    /// Which column each channel comes from; everything that is wrong with that is said here.
    fn column_uses(
        &self,
        source: &TomlSource,
        section: &Section,
        log: &OpenTable,
    ) -> Result<Vec<ColumnUse>, Error> {
        let present = log.columns();
        for (channel, column) in &self.columns {
            if !present.contains(&column.value) {
                return Err(source.error(
                    column.span.clone(),
                    Problem::MappedColumnMissing {
                        key: channel.key(),
                        column: column.value.clone(),
                        file: self.file_key.value.clone(),
                        names: Names::new(present),
                    },
                ));
            }
        }
        let column_of = |channel: Channel| -> Option<&str> {
            match find(&self.columns, channel) {
                Some(column) => Some(column.value.as_str()),
                None => present
                    .iter()
                    .map(String::as_str)
                    .find(|name| *name == channel.standard_name()),
            }
        };
        if let (Some(held), Some(column)) = (&self.held_current, column_of(Channel::Current)) {
            return Err(source.error(
                held.span.clone(),
                Problem::ConstantAndColumn {
                    value: held.value,
                    column: column.to_string(),
                    file: self.file_key.value.clone(),
                },
            ));
        }
        if let (Some(step), Some(column)) = (&self.time_step, column_of(Channel::Time)) {
            return Err(source.error(
                step.span.clone(),
                Problem::TimeStepAndColumn {
                    column: column.to_string(),
                    file: self.file_key.value.clone(),
                },
            ));
        }
        for (index, (channel, column)) in self.columns.iter().enumerate() {
            let mut before = self.columns[..index].iter();
            if let Some((other, _)) = before.find(|(_, other)| other.value == column.value) {
                return Err(source.error(
                    column.span.clone(),
                    Problem::ColumnMappedTwice {
                        column: column.value.clone(),
                        first: other.key(),
                        second: channel.key(),
                    },
                ));
            }
        }
        for (key, list) in [
            ("units", &self.units),
            ("scale", &self.scales),
            ("sign", &self.signs),
            ("offset", &self.offsets),
        ] {
            for (channel, located) in list {
                if column_of(*channel).is_none() {
                    let problem = Problem::NoColumnFor {
                        key: channel.key().to_string(),
                        present: present.to_vec(),
                    };
                    // The section is there: the entry came out of it.
                    return Err(match section.section(key)? {
                        Some(table) => table.error_at(channel.key(), problem),
                        None => source.error(located.span.clone(), problem),
                    });
                }
            }
        }

        let used = useful(self.kind);
        let uses: Vec<ColumnUse> = Channel::ALL
            .into_iter()
            .filter_map(|channel| {
                let name = column_of(channel)?.to_string();
                let stated = |list| find(list, channel).map(|one: &Located<f64>| one.value);
                let factor = |list| stated(list).unwrap_or(1.0);
                // bench.toml knows better than the file.
                let of_file = unit_of_file(log, channel, &name).map_or(1.0, |(_, scale)| scale);
                let unit = stated(&self.units).unwrap_or(of_file);
                Some(ColumnUse {
                    channel,
                    name,
                    scale: unit * factor(&self.scales) * factor(&self.signs),
                    is_beside: !used.contains(&channel),
                    offset: find(&self.offsets, channel).map_or(0.0, |offset| offset.value),
                })
            })
            .collect();
        let has = |channel: Channel| {
            let mut used = uses.iter().filter(|column| !column.is_beside);
            used.any(|column| column.channel == channel)
        };
        let missing = |channels: &[Channel], needs: &'static str, remark: &'static str| {
            let used: Vec<&str> = uses.iter().map(|column| column.name.as_str()).collect();
            let channel = channels[0];
            log.header_error(
                None,
                Problem::MissingColumn {
                    experiment: self.name.value.clone(),
                    kind: self.kind.name(),
                    needs,
                    present: present.to_vec(),
                    standard_names: channels.iter().map(|c| c.standard_name()).collect(),
                    key: channel.key(),
                    column: channel
                        .likely_column(present, &used)
                        .unwrap_or("its name there")
                        .to_string(),
                    remark: if log.has_header() {
                        remark
                    } else {
                        "; the file has no header line, so that its columns are numbered from 1"
                    },
                },
            )
        };
        if !has(Channel::Time) && self.time_step.is_none() {
            return Err(missing(
                &[Channel::Time],
                "the time",
                "; rows at equal times without a time column need time_step = 0.005 (s)",
            ));
        }
        let (channels, needs) = motion_needed(self.kind);
        if !channels.iter().any(|channel| has(*channel)) {
            return Err(missing(channels, needs, ""));
        }
        let needs_current = matches!(self.kind, Kind::Balance | Kind::Driven);
        if needs_current && !has(Channel::Current) && self.held_current.is_none() {
            return Err(missing(
                &[Channel::Current],
                "the motor current",
                "; a current that was held and not logged goes to constants = { current = 0.6 }",
            ));
        }
        Ok(uses)
    }

    /// Balance logs stay about upright, free swings about hanging: an angle that is counted from
    /// elsewhere would make nonsense of everything after it.
    fn check_upright(
        &self,
        section: &Section,
        log: &mut Log,
        report: &mut LoadReport,
    ) -> Result<(), Error> {
        let expected = match self.kind {
            Kind::Balance => PI,
            Kind::FreeSwing => 0.0,
            Kind::SpinUp | Kind::Driven => return Ok(()),
        };
        let Some(angle) = &mut log.angle_rad else {
            return Ok(());
        };
        let (Some(median_rad), Some(low), Some(high)) = (
            quantile(angle, 0.5),
            quantile(angle, 0.01),
            quantile(angle, 0.99),
        ) else {
            return Ok(());
        };
        let key = if find(&self.offsets, Channel::Angle).is_some() {
            "offset"
        } else {
            "file"
        };
        // About its equilibrium the body does not turn over. (In a free swing the check of the data says by
        // which factor the angle is too large.)
        let farthest_rad = (low - expected).abs().max((high - expected).abs());
        if self.kind == Kind::Balance && farthest_rad > 2.0 * TAU {
            return Err(section.error_at(
                key,
                Problem::AngleTooLarge {
                    kind: self.kind.name(),
                    farthest_rad,
                },
            ));
        }
        // A sensor within one turn may say −π for upright.
        let turns = ((expected - median_rad) / TAU).round();
        let added_rad = turns * TAU;
        if (median_rad + added_rad - expected).abs() > FRAC_PI_2 {
            let old = find(&self.offsets, Channel::Angle).map_or(0.0, |offset| offset.value);
            return Err(section.error_at(
                key,
                Problem::WrongUpright {
                    kind: self.kind.name(),
                    median_rad,
                    offset: old + ((expected - median_rad) / PI).round() * PI,
                },
            ));
        }
        if turns != 0.0 {
            for value in angle.iter_mut() {
                *value += added_rad;
            }
            report.notes.push(Note::AngleTurned { added_rad });
        }
        Ok(())
    }
}

/// The value below which this share of the finite values lies.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let index = ((finite.len() - 1) as f64 * share).round() as usize;
    Some(*finite.select_nth_unstable_by(index, f64::total_cmp).1)
}

fn find<T>(list: &[(Channel, T)], channel: Channel) -> Option<&T> {
    list.iter()
        .find(|(found, _)| *found == channel)
        .map(|(_, value)| value)
}

/// Reads a table whose keys are channels.
fn by_channel<T>(
    section: &Section,
    key: &str,
    read: impl Fn(&Section, &'static str) -> Result<T, Error>,
) -> Result<Vec<(Channel, T)>, Error> {
    let Some(table) = section.section(key)? else {
        return Ok(Vec::new());
    };
    table.allow_only(&Channel::ALL.map(Channel::key))?;
    Channel::ALL
        .into_iter()
        .filter(|channel| table.has(channel.key()))
        .map(|channel| Ok((channel, read(&table, channel.key())?)))
        .collect()
}

/// A number that is not zero.
fn not_zero(table: &Section, key: &'static str, must_be: &str) -> Result<Located<f64>, Error> {
    let number = require(table.number(key)?, table, key)?;
    if number.value == 0.0 {
        return Err(table.error_at(
            key,
            Problem::OutOfRange {
                key: key.to_string(),
                value: 0.0,
                must_be: must_be.to_string(),
            },
        ));
    }
    Ok(number)
}

/// Unwraps a value whose key is known to be there.
fn require<T>(value: Option<T>, table: &Section, key: &str) -> Result<T, Error> {
    value.ok_or_else(|| table.error(table.missing(key, "a number")))
}

fn unit_scale(table: &Section, key: &'static str) -> Result<Located<f64>, Error> {
    let name = table.required_text(key, "a unit")?;
    let units = Channel::from_key(key).map_or(&[][..], Channel::units);
    match units.iter().find(|(unit, _)| *unit == name.value) {
        Some((_, scale)) => Ok(Located {
            value: *scale,
            span: name.span,
        }),
        None => Err(table.error_at(
            key,
            Problem::UnknownName {
                what: format!("unit of {key}"),
                name: name.value,
                names: Names::new(units.iter().map(|(unit, _)| unit)),
            },
        )),
    }
}

/// The unit of a channel that the line of units of its file gives, and its factor to SI.
fn unit_of_file(table: &OpenTable, channel: Channel, column: &str) -> Option<(&'static str, f64)> {
    let unit = table.unit(column)?;
    channel
        .units()
        .iter()
        .find(|(name, _)| *name == unit)
        .copied()
}

/// Whether `units` says that the current is a command without unit.
fn is_normalised(section: &Section) -> Result<bool, Error> {
    let Some(table) = section.section("units")? else {
        return Ok(false);
    };
    let unit = table.text(Channel::Current.key())?;
    Ok(unit.is_some_and(|unit| unit.value == NORMALISED))
}

/// The held current of `constants`, A.
fn held_current(section: &Section, kind: Kind) -> Result<Option<Located<f64>>, Error> {
    let Some(table) = section.section("constants")? else {
        return Ok(None);
    };
    for key in table.keys() {
        if Channel::from_key(&key.value).is_some_and(|channel| channel != Channel::Current) {
            return Err(table.error_at(
                &key.value,
                Problem::NotAnInput {
                    key: key.value.clone(),
                },
            ));
        }
    }
    table.allow_only(&[Channel::Current.key()])?;
    let held = table.number(Channel::Current.key())?;
    if let Some(current) = &held
        && kind == Kind::FreeSwing
        && current.value != 0.0
    {
        return Err(table.error_at(
            Channel::Current.key(),
            Problem::ConstantWithoutInput { kind: kind.name() },
        ));
    }
    Ok(held)
}
