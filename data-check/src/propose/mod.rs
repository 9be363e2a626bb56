//! A proposed bench.toml for files of which only the columns are known.
//!
//! Names and units of the columns give a first proposal. The check of the data then shows what is impossible in it, and
//! by which factor, and the proposal is corrected until nothing is refused. An open question becomes a
//! comment that says what to decide.

mod choices;
mod columns;
mod kind;
mod mend;
mod text;

use std::path::{Path, PathBuf};

use bench_files::{Bench, Channel, Error, FilesInMemory, Table};
use plant::Kind;
use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::slips::short;
use crate::thresholds::propose::JUMPS;
use crate::view::median;
pub use choices::{Choices, ColumnChoice, Corrections, units_of};
use columns::Mapped;
use mend::mend;

/// Largest number of rows of a file that are read: minutes of a fast log.
const MOST_ROWS: usize = 200_000;
/// Largest number of corrections of a proposal.
const ROUNDS: usize = 6;

/// A proposed bench.toml.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// The whole text.
    pub text: String,
    /// The proposal for each file.
    pub experiments: Vec<ProposedExperiment>,
    /// The findings of the check on the proposed bench; empty if the bench cannot be read yet.
    pub findings: Vec<Finding>,
    /// The reason why the bench cannot be read yet; `None` if it can.
    pub open: Option<String>,
}

/// The proposal for one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProposedExperiment {
    /// The file, as bench.toml names it.
    pub file: String,
    /// Its name.
    pub name: String,
    /// The kind of experiment.
    pub kind: String,
    /// The reasons, as sentences.
    pub reasons: Vec<String>,
    /// The questions that the user must decide, as sentences.
    pub questions: Vec<String>,
    /// The same in parts, to be corrected: see [`propose_with`].
    pub choices: Choices,
    /// The columns of the file.
    pub column_names: Vec<String>,
}

/// A proposed experiment that is still being corrected.
struct Draft {
    name: String,
    file: String,
    kind: Kind,
    kind_reason: String,
    mapped: Vec<Mapped>,
    signs: Vec<(Channel, String)>,
    offset_rad: Option<(f64, String)>,
    held_current_a: Option<(f64, String)>,
    from_s: Option<(f64, String)>,
    until_s: Option<f64>,
    time_step_s: Option<f64>,
    questions: Vec<String>,
    unused: Vec<String>,
    column_names: Vec<String>,
    /// Whether the user has decided about this experiment. A finding is then reported and not corrected.
    decided: bool,
}

/// Proposes a bench.toml for these files in `folder`. Writes no file.
///
/// # Errors
/// If a file cannot be read, does not hold a table, or has a fault that no bench.toml mends: a word among its numbers,
/// a time that goes backwards, too few samples.
pub fn propose(folder: &Path, files: &[PathBuf]) -> Result<Proposal, Error> {
    let proposed = proposed(folder, files, &Corrections::default())?;
    match proposed.unread {
        Some(error) if error.problem().is_in_the_log() => Err(error),
        _ => Ok(proposed.proposal),
    }
}

/// As [`propose`], with the corrections of a user. The second value lists the corrections that make no sense, one
/// sentence each; the file that such a correction concerns keeps its proposal. A fault in a log is no error here: it
/// stands in [`Proposal::open`], because another choice may leave the faulty column out.
///
/// # Errors
/// If a file cannot be read, or does not hold a table.
pub fn propose_with(
    folder: &Path,
    files: &[PathBuf],
    corrections: &Corrections,
) -> Result<(Proposal, Vec<String>), Error> {
    let proposed = proposed(folder, files, corrections)?;
    Ok((proposed.proposal, proposed.refused))
}

/// A proposal with what is wrong about it.
struct Proposed {
    proposal: Proposal,
    /// The corrections that make no sense.
    refused: Vec<String>,
    /// Why the proposed bench cannot be read.
    unread: Option<Error>,
}

fn proposed(
    folder: &Path,
    files: &[PathBuf],
    corrections: &Corrections,
) -> Result<Proposed, Error> {
    let mut refused = vec![];
    let mut drafts: Vec<Draft> = vec![];
    let mut in_memory = FilesInMemory::default();
    for path in files {
        let table = Table::read(path, MOST_ROWS)?;
        let file = name_in(folder, path);
        if let Ok(bytes) = std::fs::read(path) {
            in_memory.insert(&file, bytes);
        }
        let stem = path
            .file_stem()
            .map_or("log".into(), |stem| stem.to_string_lossy());
        let mut name = stem.replace(['_', '"', '\\'], " ");
        while drafts.iter().any(|draft| draft.name == name) {
            name.push_str(" again");
        }
        let mut draft = draft(name, file, &table);
        if let Some(choices) = corrections.files.get(&draft.file)
            && let Err(reason) = draft.choose(choices, &table)
        {
            refused.push(reason);
        }
        drafts.push(draft);
    }
    let bench_name = folder.file_name().map_or_else(
        || "bench".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    );
    let mut findings = vec![];
    let mut unread = None;
    for _ in 0..ROUNDS {
        let toml = text::bench_toml(&bench_name, &corrections.known, &drafts);
        in_memory.insert("bench.toml", toml.as_str());
        match Bench::from_files(&in_memory) {
            Ok(bench) => findings = crate::check(&bench),
            Err(error) => {
                findings.clear();
                unread = Some(error);
                break;
            }
        }
        let mut mended = false;
        // One sign an experiment in each round: where one column has the wrong sign, several comparisons say so, and the
        // first remedy may answer them all.
        let mut turned: Vec<&Option<String>> = vec![];
        for finding in &findings {
            let is_sign = finding.factor == Some(-1.0);
            if is_sign && turned.contains(&&finding.experiment) {
                continue;
            }
            let is_mended = mend(&mut drafts, finding);
            if is_sign && is_mended {
                turned.push(&finding.experiment);
            }
            mended |= is_mended;
        }
        if !mended {
            break;
        }
    }
    let proposal = Proposal {
        text: text::bench_toml(&bench_name, &corrections.known, &drafts),
        experiments: drafts.iter().map(Draft::told).collect(),
        findings,
        open: unread.as_ref().map(Error::to_string),
    };
    Ok(Proposed {
        proposal,
        refused,
        unread,
    })
}

/// A path as bench.toml in `folder` would name it.
fn name_in(folder: &Path, path: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let (folder, path) = (whole(folder), whole(path));
    let inside = path.strip_prefix(&folder).map(Path::to_path_buf);
    inside.unwrap_or(path).to_string_lossy().into_owned()
}

fn draft(name: String, file: String, table: &Table) -> Draft {
    let mut mapped = columns::mapped(table);
    for angle in &mut mapped {
        if matches!(angle.channel, Channel::Angle | Channel::WheelAngle) {
            turn_of_360(angle, &table.columns[angle.index]);
        }
    }
    let mut questions = vec![];
    let time = mapped.iter().position(|one| one.channel == Channel::Time);
    match time {
        Some(at) => {
            let values = &table.columns[mapped[at].index];
            time_unit(&mut mapped[at], values, &mut questions)
        }
        None => {
            let index = (0..table.names.len()).find(|k| columns::is_index(&table.columns[*k]));
            questions.push(match index {
                Some(index) => format!(
                    "column \"{}\" counts the lines: is it an index (then time_step = seconds from line to \
                     line), or milliseconds (then columns = {{ time = \"{}\" }}, units = {{ time = \"ms\" }})?",
                    table.names[index], table.names[index]
                ),
                None => "no column is the time: columns = { time = … }, or time_step = seconds from line to line"
                    .to_owned(),
            });
        }
    }
    if !table.has_header {
        questions.push(format!(
            "the file has no header line: say which of its {} columns is what, columns = {{ time = \"1\", \
             angle = \"2\" }}",
            table.names.len()
        ));
    }
    let guess = kind::guess(table, &mapped);
    if guess.held_current_a.is_some() {
        mapped.retain(|one| one.channel != Channel::Current);
    }
    let unused = (0..table.names.len())
        .filter(|index| !mapped.iter().any(|one| one.index == *index))
        .map(|index| table.names[index].clone())
        .collect();
    questions.extend(guess.questions);
    Draft {
        name,
        file,
        kind: guess.kind,
        kind_reason: guess.reason,
        signs: vec![],
        offset_rad: guess.offset_rad,
        held_current_a: guess.held_current_a,
        from_s: None,
        until_s: None,
        time_step_s: None,
        questions,
        unused,
        mapped,
        column_names: table.names.clone(),
        decided: false,
    }
}

/// The unit of an angle that has no stated unit and starts again after 360. No other quantity jumps by 360 several
/// times.
fn turn_of_360(angle: &mut Mapped, values: &[f64]) {
    if angle.unit.is_some() {
        return;
    }
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let (near, far) = steps
        .filter(|step| *step > 180.0)
        .partition::<Vec<f64>, _>(|step| (step / 360.0 - 1.0).abs() < 0.1);
    if near.len() >= JUMPS && far.is_empty() {
        angle.unit = Some("deg");
        angle
            .reason
            .push_str(&format!("; it jumps {} times by 360: deg", near.len()));
    }
}

/// The unit of a time column without a stated unit, from its usual interval: nobody samples a pendulum once per second.
fn time_unit(time: &mut Mapped, values: &[f64], questions: &mut Vec<String>) {
    if time.unit.is_some() {
        return;
    }
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = median(steps).unwrap_or(0.0);
    let unit = match step {
        step if step < 0.5 => "s",
        step if step < 500.0 => "ms",
        step if step < 5e5 => "us",
        _ => "ns",
    };
    time.unit = Some(unit);
    let reason = format!("; its steps of {} are {unit}", short(step));
    time.reason.push_str(&reason);
    if columns::is_index(values) {
        questions.push(format!(
            "the steps of \"{}\" are 1: if it counts lines and not milliseconds, take it out and state time_step",
            time.column
        ));
    }
}

impl Draft {
    fn told(&self) -> ProposedExperiment {
        let mut reasons = vec![format!("{}: {}", self.kind.name(), self.kind_reason)];
        reasons.extend(self.mapped.iter().map(|one| {
            format!(
                "{} is \"{}\": {}",
                one.channel.key(),
                one.column,
                one.reason
            )
        }));
        let more = [
            self.offset_rad.as_ref().map(|(_, reason)| reason),
            self.held_current_a.as_ref().map(|(_, reason)| reason),
            self.from_s.as_ref().map(|(_, reason)| reason),
        ];
        reasons.extend(more.into_iter().flatten().cloned());
        ProposedExperiment {
            file: self.file.clone(),
            name: self.name.clone(),
            kind: self.kind.name().to_owned(),
            reasons,
            questions: self.questions.clone(),
            choices: self.choices(),
            column_names: self.column_names.clone(),
        }
    }
}
