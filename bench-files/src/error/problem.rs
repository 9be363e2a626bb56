//! What can be wrong with a file, each with its message.

use super::names::{Names, list};
use crate::numbers::number;

/// What is wrong. Its text says what was found and what would be right.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    // --- any file ---------------------------------------------------------------------------
    /// There is no such file.
    #[error("there is no such file")]
    NotFound,
    /// The path names a folder, a device or a pipe.
    #[error("this is {found}, not a file")]
    NotAFile {
        /// What it is.
        found: &'static str,
    },
    /// The path names neither a folder nor a bench.toml.
    #[error("there is no such bench; a bench is a folder that holds a bench.toml, or that file")]
    NoBench,
    /// The system cannot read the file.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// The system cannot write the file.
    #[error("cannot be written: {0}")]
    Unwritable(String),
    /// The file is larger than this program reads.
    #[error("the file has {bytes} bytes, the limit is {limit}; {advice}")]
    TooLarge {
        /// Size of the file.
        bytes: u64,
        /// Largest size that is read.
        limit: u64,
        /// What to do.
        advice: &'static str,
    },
    /// The bytes are not UTF-8.
    #[error("the text is not UTF-8 (from byte {byte} of the file on); save it with that encoding")]
    NotUtf8 {
        /// Offset of the first byte that is wrong, counted from 0.
        byte: u64,
    },

    /// The file is no text, or no table.
    #[error("this is {what}, and no table of numbers as text: {advice}")]
    NoTable {
        /// What it is.
        what: &'static str,
        /// How a table is made of it.
        advice: &'static str,
    },

    // --- TOML -------------------------------------------------------------------------------
    /// The text is not TOML.
    #[error("this is not TOML: {0}")]
    TomlSyntax(String),
    /// A key that this program does not know.
    #[error("unknown key \"{key}\" in {section}; {}", .names.advice(.key))]
    UnknownKey {
        /// The key.
        key: String,
        /// The section with the key.
        section: String,
        /// The known keys of that section.
        names: Names,
    },
    /// A key that another kind of the same part has.
    #[error(
        "\"{key}\" belongs to kind = \"{belongs_to}\", and here {section} is of kind = \"{kind}\""
    )]
    KeyOfOtherKind {
        /// The key.
        key: String,
        /// The section with the key.
        section: String,
        /// The kind that has the key.
        belongs_to: &'static str,
        /// The kind that is stated.
        kind: &'static str,
    },
    /// A part whose data sheet is not known here.
    #[error("no data for the part \"{name}\"; leave part out and give {instead}; {}", .names.advice(.name))]
    NoDataForPart {
        /// The part.
        name: String,
        /// The keys that the data would have given.
        instead: &'static str,
        /// The parts that are known in this place.
        names: Names,
    },
    /// A required key is missing.
    #[error("{section} lacks \"{key}\"; it needs for example {example}")]
    MissingKey {
        /// The section.
        section: String,
        /// The key.
        key: String,
        /// A correct line as an example.
        example: &'static str,
    },
    /// A value of the wrong type.
    #[error("\"{key}\" must be {expected}, this is {found}")]
    WrongType {
        /// The key.
        key: String,
        /// What would be right.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A number outside its range.
    #[error("\"{key}\" is {value}; it must be {must_be}")]
    OutOfRange {
        /// The key.
        key: String,
        /// The number.
        value: f64,
        /// The range in words.
        must_be: String,
    },
    /// Axes that are not the three of the body.
    #[error(
        "\"axes\" must name each of \"x\", \"y\", \"z\" once, \"-y\" for one that is reversed, for example [\"x\", \"-y\", \"-z\"]"
    )]
    NotAxes,
    /// The sensor's orientation is stated twice.
    #[error("\"axes\" and \"rotation\" state the same thing; leave one of them out")]
    AxesAndRotation,
    /// A matrix that stretches or shears.
    #[error("\"rotation\" is not a rotation: its rows must be perpendicular and of length one")]
    NotARotation,
    /// A mirrored sensor.
    #[error(
        "\"{key}\" is left-handed: no orientation of a sensor is a mirror image; reverse one more axis or one less"
    )]
    LeftHanded {
        /// The key.
        key: &'static str,
    },
    /// A name that is not in a fixed list.
    #[error("unknown {what} \"{name}\"; {}", .names.advice(.name))]
    UnknownName {
        /// What is named: a kind, a unit of the angle, an effect, …
        what: String,
        /// The name.
        name: String,
        /// The names that are known.
        names: Names,
    },
    /// A bench without experiments.
    #[error(
        "the bench has no experiment; add [[experiment]] with name, kind (free-swing, spin-up, balance or driven) and file"
    )]
    NoExperiment,
    /// The file of an experiment does not exist.
    #[error("cannot read the log {path}: {reason}; file is named relative to the bench's folder")]
    NoLog {
        /// Where it was looked for.
        path: String,
        /// Why it cannot be read.
        reason: String,
    },
    /// Two experiments with the same name.
    #[error(
        "another experiment already has the name \"{name}\" (line {first_line}); reports distinguish experiments by name, choose another"
    )]
    DuplicateExperiment {
        /// The name.
        name: String,
        /// Line of the first use.
        first_line: usize,
    },
    /// The stated gravity torque contradicts masses and lengths.
    #[error(
        "gravity_torque = {stated_n_m} N m contradicts the masses and lengths, which give {} N m; correct one of them or leave one out",
        number(*computed_n_m)
    )]
    GravityTorqueContradiction {
        /// As stated, N m.
        stated_n_m: f64,
        /// g (k m_w + l m_b), N m.
        computed_n_m: f64,
    },
    /// Masses and lengths with which the hanging position is not an equilibrium.
    #[error(
        "with these masses and lengths the gravity torque is {} N m: the bench would not hang; pivot_to_com is positive towards the wheel",
        number(*torque_n_m)
    )]
    HangsUpsideDown {
        /// g (k m_w + l m_b), N m.
        torque_n_m: f64,
    },
    /// The window of an experiment is empty.
    #[error("until = {until_s} must lie after from = {from_s} (seconds of the log)")]
    WindowReversed {
        /// Start of the window, s.
        from_s: f64,
        /// End of the window, s.
        until_s: f64,
    },
    /// A held value for a channel that is not an input.
    #[error(
        "\"{key}\" cannot stand under constants; only the current can be held constant, for example constants = {{ current = 0.6 }}"
    )]
    NotAnInput {
        /// The channel's key.
        key: String,
    },
    /// A held value for a channel that the file has.
    #[error(
        "the current is held at {value} A here, but {file} has a column \"{column}\" for it; keep one of the two"
    )]
    ConstantAndColumn {
        /// The held value, A.
        value: f64,
        /// The column.
        column: String,
        /// The log.
        file: String,
    },
    /// A time step beside a time column.
    #[error(
        "time_step is for files without a time column, but {file} has the column \"{column}\"; keep one of the two"
    )]
    TimeStepAndColumn {
        /// The column.
        column: String,
        /// The log.
        file: String,
    },
    /// One column for two channels.
    #[error(
        "{second} is mapped to \"{column}\", and so is {first}; one column can be one channel only"
    )]
    ColumnMappedTwice {
        /// The column.
        column: String,
        /// The channel that has it first.
        first: &'static str,
        /// The channel that has it too.
        second: &'static str,
    },
    /// A held current in an experiment that has none.
    #[error("a {kind} experiment has no current (the wheel is locked to the body); take it out")]
    ConstantWithoutInput {
        /// The kind.
        kind: &'static str,
    },
    /// A unit, sign or offset for a channel that has no column.
    #[error(
        "\"{key}\" is given here, but the log has no column for it; map one with columns = {{ {key} = \"…\" }}, the file has {}",
        list(.present)
    )]
    NoColumnFor {
        /// The channel's key.
        key: String,
        /// The columns of the file.
        present: Vec<String>,
    },

    /// An entry of `[calibration]` that needs another one.
    #[error("\"{key}\" needs \"{missing}\" beside it, for example {example}")]
    NeedsBeside {
        /// The entry.
        key: &'static str,
        /// What is missing.
        missing: &'static str,
        /// A line that would be right.
        example: &'static str,
    },
    /// A recording without a required column.
    #[error("there is no column \"{column}\" for {key}; {} (other names go to columns = {{ {key} = \"…\" }} under [calibration])", .names.advice(.column))]
    MissingRecordingColumn {
        /// What the column holds.
        key: String,
        /// The name that was looked for.
        column: String,
        /// The columns of the file.
        names: Names,
    },
    /// A recording of [bring_up] lacks a column.
    #[error("there is no column \"{column}\"; a recording of [bring_up] has gx, gy, gz, ax, ay, az, wheel, duty and time_s (with an encoder on the pivot body in place of the first six); {}", .names.advice(.column))]
    MissingBringUpColumn {
        /// The column.
        column: String,
        /// The columns of the file.
        names: Names,
    },
    /// A recording that is too short to show anything.
    #[error("the recording has {rows} rows; a recording of [bring_up] needs at least {least}")]
    ShortRecording {
        /// Its rows.
        rows: usize,
        /// As many as are needed.
        least: usize,
    },
    /// A raw count that does not fit into a 16-bit register.
    #[error(
        "{value} is not a raw count; whole numbers from -32768 to 32767 are needed, as the sensor's registers hold them"
    )]
    NotACount {
        /// What stands there.
        value: f64,
    },

    // --- model.toml ---------------------------------------------------------------------------
    /// A parameter that the model needs is missing.
    #[error(
        "lacks [parameters.{name}], which {needed_by} needs: {meaning}; give it a value in {unit}"
    )]
    MissingParameter {
        /// Its name.
        name: &'static str,
        /// Its unit.
        unit: &'static str,
        /// What it is.
        meaning: &'static str,
        /// What needs it.
        needed_by: String,
    },
    /// A unit that is not the SI unit of the parameter.
    #[error(
        "{name} has the unit \"{si}\", this is \"{unit}\"; convert the value, or leave the unit out"
    )]
    UnitNotSi {
        /// The parameter.
        name: String,
        /// The unit given.
        unit: String,
        /// The SI unit.
        si: &'static str,
    },
    /// One effect twice, or two of which one contains the other.
    #[error("\"{effect}\" cannot be used together with \"{other}\": {}; remove one", if .effect == .other { "it is already listed" } else { "one contains the other" })]
    EffectTwice {
        /// The second.
        effect: &'static str,
        /// The first.
        other: &'static str,
    },

    /// A provisional effect that is not in the model.
    #[error("\"{effect}\" is provisional but not present; add it to `present`, or remove it here")]
    ProvisionalAbsent {
        /// The effect.
        effect: &'static str,
    },

    /// A parameter that the correlations name twice.
    #[error("\"{name}\" is already in this list; list every parameter once")]
    CorrelatedTwice {
        /// The parameter.
        name: String,
    },

    /// A user's formula, or its definition, is wrong.
    #[error("{0}")]
    Formula(String),
    /// A learned curve that is none.
    #[error("{0}")]
    Curve(String),

    // --- logs -------------------------------------------------------------------------------
    /// The file is empty, or has only blank lines and comments.
    #[error("the file is empty; a log is a CSV with a header line and one sample a line")]
    EmptyLog,
    /// No column of the file holds numbers.
    #[error(
        "no column of the file holds numbers; a log is a CSV with a header line and one sample a line"
    )]
    NoNumbers,
    /// A number that can be read in two ways.
    #[error(
        "\"{cell}\" is {first} if the comma is a decimal mark, but {second} if it separates thousands; write it without a comma"
    )]
    TwoReadings {
        /// The cell.
        cell: String,
        /// With decimals.
        first: String,
        /// With thousands.
        second: String,
    },
    /// A mapped column is not in the file.
    #[error(
        "columns maps {key} to \"{column}\", which {file} does not have; {}",
        .names.advice(.column)
    )]
    MappedColumnMissing {
        /// The channel's key.
        key: &'static str,
        /// The column.
        column: String,
        /// The log.
        file: String,
        /// The columns of the file.
        names: Names,
    },
    /// The kind needs a channel that the file does not have.
    #[error(
        "experiment \"{experiment}\" ({kind}) needs {needs}, but the file has the columns {}; name the column {} or map it in bench.toml: columns = {{ {key} = \"{column}\" }}{remark}",
        list(.present), .standard_names.join(" or ")
    )]
    MissingColumn {
        /// Name of the experiment.
        experiment: String,
        /// Its kind.
        kind: &'static str,
        /// What the kind needs, in words.
        needs: &'static str,
        /// The columns of the file.
        present: Vec<String>,
        /// The standard names that would be found.
        standard_names: Vec<&'static str>,
        /// The key of the example.
        key: &'static str,
        /// The column of the example.
        column: String,
        /// What else would do.
        remark: &'static str,
    },
    /// Two columns have the requested name.
    #[error("the header has this name {times} times; give every column its own name")]
    DuplicateColumn {
        /// How often.
        times: usize,
    },
    /// A line has more or fewer cells than the header.
    #[error(
        "this line has {found} {}, but the header has {expected}; every line needs {expected}{}",
        if *found == 1 { "cell" } else { "cells" },
        if hint.is_empty() && *found == 2 * *expected { " (decimal commas need another separator, or quotation marks about each number)" } else { hint }
    )]
    RaggedRow {
        /// Cells of the header.
        expected: u64,
        /// Cells of the line.
        found: u64,
        /// What the line looks like.
        hint: &'static str,
    },
    /// An empty cell in a column that is used.
    #[error(
        "the cell is empty; every sample needs a number here: leave the line out, or the whole column where its sensor is slower than the others"
    )]
    EmptyCell,
    /// A cell is not a number.
    #[error("\"{cell}\" is not a number; write it like -0.0125 or 1.25e-2{hint}")]
    NotANumber {
        /// The cell, shortened.
        cell: String,
        /// A further hint.
        hint: &'static str,
    },
    /// A cell carries a unit that the column cannot have, or that the other cells do not have.
    #[error(
        "\"{cell}\" is at odds with the unit of {key}: all cells of a column need one unit that this channel can have; write numbers alone, and the unit once, in units = {{ {key} = … }}"
    )]
    UnitInCell {
        /// The cell, shortened.
        cell: String,
        /// The channel's key.
        key: &'static str,
    },
    /// NaN or infinity.
    #[error(
        "\"{cell}\" is not a finite number; leave the line out, or choose from and until so that it is not used"
    )]
    NotFinite {
        /// The cell.
        cell: String,
    },
    /// Time goes backwards.
    #[error(
        "time goes backwards, from {before_s} s to {after_s} s; lines must be in order of time, and a log that was started again must be cut into two files{hint}"
    )]
    TimeBackwards {
        /// Time of the line before, s.
        before_s: f64,
        /// Time of this line, s.
        after_s: f64,
        /// What the step looks like.
        hint: String,
    },
    /// Most lines repeat the time of the line before.
    #[error(
        "{merged} of {rows} lines repeat the time of the line before: the time column is too coarse or not the time; log it with more digits"
    )]
    TimeTooCoarse {
        /// Lines that repeat.
        merged: usize,
        /// Lines in the window.
        rows: usize,
    },
    /// The log has more lines than this program reads.
    #[error(
        "the log has more than {limit} samples; log at a lower rate or cut it into several files"
    )]
    TooManySamples {
        /// The limit.
        limit: usize,
    },
    /// A line is too long.
    #[error(
        "the line is longer than {limit} bytes; this is not a CSV log, or a quotation mark is not closed"
    )]
    LineTooLong {
        /// The limit.
        limit: usize,
    },
    /// Too few samples in the window.
    #[error("only {found} samples lie in the window; at least {needed} are needed{remark}")]
    TooFewSamples {
        /// Samples in the window.
        found: usize,
        /// Samples that are needed.
        needed: usize,
        /// The times that the file covers.
        remark: String,
    },
    /// The angle is not counted from the hanging position.
    #[error(
        "in this {kind} log the angle stays about {median_rad:.2} rad; a {kind} log needs hanging at 0 and upright at pi (3.1416). {}If its zero is elsewhere, set offset = {{ angle = {offset:.8} }} at the experiment",
        if *has_unit { "" } else { "If the file has degrees, set units = { angle = \"deg\" }. " }
    )]
    WrongUpright {
        /// Name of the kind.
        kind: &'static str,
        /// Median of the angle, rad.
        median_rad: f64,
        /// Whether bench.toml states the angle's unit.
        has_unit: bool,
        /// The offset that would probably be right, rad.
        offset: f64,
    },
    /// The angle covers several turns.
    #[error(
        "in this {kind} log the angle goes {farthest_rad:.1} rad away from its equilibrium, more than two turns; if the column is in degrees, set units = {{ angle = \"deg\" }} at the experiment"
    )]
    AngleTooLarge {
        /// Name of the kind.
        kind: &'static str,
        /// How far, rad.
        farthest_rad: f64,
    },
}

impl Problem {
    /// Whether the text of a log is at fault, so that no choice in bench.toml (another column, unit or kind) mends it.
    pub fn is_in_the_log(&self) -> bool {
        matches!(
            self,
            Problem::NotFound
                | Problem::NotAFile { .. }
                | Problem::Unreadable(_)
                | Problem::TooLarge { .. }
                | Problem::NotUtf8 { .. }
                | Problem::NoTable { .. }
                | Problem::EmptyLog
                | Problem::TwoReadings { .. }
                | Problem::DuplicateColumn { .. }
                | Problem::RaggedRow { .. }
                | Problem::EmptyCell
                | Problem::NotANumber { .. }
                | Problem::UnitInCell { .. }
                | Problem::NotFinite { .. }
                | Problem::TimeBackwards { .. }
                | Problem::TimeTooCoarse { .. }
                | Problem::TooManySamples { .. }
                | Problem::LineTooLong { .. }
                | Problem::TooFewSamples { .. }
                | Problem::NoNumbers
        )
    }
}
