//! All claims about an emitted crate, each by every engine that can settle it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use serde::Serialize;

use crate::certificate::claims::{Claim, claim};
use crate::certificate::reader::{Certificate, CertificateError};
use crate::claims::bias_observer_stable;
use crate::claims::certificate_consistent;
use crate::claims::closed_loop_for_all_time;
use crate::claims::control_law::{ControlLaw, LawError};
use crate::claims::filter_accurate;
use crate::claims::filter_exact;
use crate::claims::filter_length;
use crate::claims::filter_total;
use crate::claims::hardware_words;
use crate::claims::region_of_attraction;
use crate::claims::stable_for_parameters::{self, RegionFailure};
use crate::domains::smt::{self, Answer};
use crate::exact::rational::rounded_up;
use crate::language::module::{Module, ReadError, sources};
use crate::program::place::SourceError;

/// What came of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Shown for the whole domain; with what was found.
    Proved(String),
    /// Held in so many cases.
    Tested(usize),
    /// Not looked at, and why.
    NotRun(String),
    /// Does not hold, or could not be shown.
    Failed(String),
}

impl Outcome {
    /// The word of the contract: `proved`, `tested`, `not run`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            Outcome::Proved(_) => "proved",
            Outcome::Tested(_) => "tested",
            Outcome::NotRun(_) => "not run",
            Outcome::Failed(_) => "failed",
        }
    }

    /// What is said beside the word.
    pub fn detail(&self) -> String {
        match self {
            Outcome::Proved(text) | Outcome::NotRun(text) | Outcome::Failed(text) => text.clone(),
            Outcome::Tested(cases) => format!("{cases} cases"),
        }
    }
}

/// One claim, settled by one engine.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimResult {
    /// Identifier.
    pub id: String,
    /// One sentence.
    pub statement: String,
    /// By what means.
    pub engine: &'static str,
    /// For which inputs.
    pub domain: String,
    /// What is assumed; empty if nothing.
    pub assumptions: String,
    /// What came of it.
    pub outcome: Outcome,
    /// Time that it took (s).
    pub seconds: f64,
}

/// The row of a [`ClaimResult`] in JSON.
#[derive(Serialize)]
struct Row<'a> {
    id: &'a str,
    statement: &'a str,
    engine: &'a str,
    domain: &'a str,
    assumptions: &'a str,
    result: &'a str,
    detail: String,
    seconds: f64,
}

impl Serialize for ClaimResult {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Row {
            id: &self.id,
            statement: &self.statement,
            engine: self.engine,
            domain: &self.domain,
            assumptions: &self.assumptions,
            result: self.outcome.word(),
            detail: self.outcome.detail(),
            seconds: self.seconds,
        }
        .serialize(serializer)
    }
}

/// Interval and affine analysis of the source.
pub const INTERVALS: &str = "intervals of the source";
/// Rational arithmetic on the certificate.
pub const EXACT: &str = "exact arithmetic";
/// The interpreter on random inputs.
pub const RANDOM: &str = "random runs of the source";
/// z3.
pub const SMT: &str = "z3";
/// Kani.
pub const KANI: &str = "Kani";
/// Reading the source.
pub const READER: &str = "reader of the source";

/// Which engines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Random runs of each kind.
    pub cases: usize,
    /// Seed of the random runs.
    pub seed: u64,
    /// Whether z3 is asked, where there is one.
    pub smt: bool,
    /// Whether Kani runs, where it is installed (minutes).
    pub kani: bool,
    /// Whether the bounds of the closed loop are computed (a fraction of a second).
    pub closed_loop: bool,
    /// Whether the ranges of the filter are shown (minutes where they cannot be).
    pub filter_ranges: bool,
    /// Whether the quaternion's length is bounded (seconds); it needs the ranges.
    pub filter_length: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            cases: 20_000,
            seed: 1,
            smt: true,
            kani: true,
            closed_loop: true,
            filter_ranges: true,
            filter_length: true,
        }
    }
}

/// Why there is nothing to prove.
#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    /// The folder cannot be read.
    #[error("{0}")]
    Read(ReadError),
    /// The certificate cannot be read.
    #[error("{0}")]
    Certificate(CertificateError),
    /// A file of every emitted crate is not there.
    #[error("{} is no emitted crate: there is no {missing} in it; flywheel generate writes one", folder.display())]
    NoCrate {
        /// The folder.
        folder: PathBuf,
        /// What is missing.
        missing: &'static str,
    },
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// An emitted crate as text: everything that is looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Emitted {
    /// `src/*.rs`, by path.
    pub sources: Vec<(String, String)>,
    /// `Cargo.toml`.
    pub cargo: String,
    /// `certificate.json`.
    pub certificate: String,
    /// What else lies there that would be compiled or run with the crate.
    pub strays: Vec<String>,
}

impl Emitted {
    /// Reads an emitted crate; nothing else of the project has to be there.
    ///
    /// # Errors
    /// [`ProveError`] with the file.
    pub fn read(directory: &Path) -> Result<Emitted, ProveError> {
        let text = |name: &'static str| {
            let path = directory.join(name);
            fs::read_to_string(&path).map_err(|source| {
                if source.kind() == std::io::ErrorKind::NotFound && directory.is_dir() {
                    let folder = directory.to_owned();
                    let missing = name;
                    return ProveError::NoCrate { folder, missing };
                }
                ProveError::Io { path, source }
            })
        };
        Ok(Emitted {
            certificate: text("certificate.json")?,
            cargo: text("Cargo.toml")?,
            sources: sources(directory).map_err(ProveError::Read)?,
            strays: strays(directory)?,
        })
    }

    /// Nothing is built but the sources, with nothing but `fixed`.
    fn check_surroundings(&self) -> Result<(), String> {
        if let Some(stray) = self.strays.first() {
            return Err(format!("{stray} does not belong to an emitted crate"));
        }
        if !self.sources.iter().any(|(path, _)| path == "src/lib.rs") {
            return Err("there is no src/lib.rs".to_owned());
        }
        check_cargo(&self.cargo)
    }

    pub(crate) fn module(&self) -> Result<Module, SourceError> {
        let borrowed: Vec<_> = self
            .sources
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str()))
            .collect();
        Module::parse(&borrowed)
    }

    fn files(&self) -> Vec<String> {
        let sources = self.sources.iter().map(|(path, _)| path.clone());
        sources.chain(["Cargo.toml".to_owned()]).collect()
    }
}

/// Files that Cargo would pick up beside the sources, and whatever in `src` is no file of Rust.
fn strays(directory: &Path) -> Result<Vec<String>, ProveError> {
    let picked_up = ["build.rs", ".cargo"];
    let mut strays: Vec<String> = picked_up
        .into_iter()
        .filter(|name| directory.join(name).exists())
        .map(str::to_owned)
        .collect();
    let path = directory.join("src");
    let io = |source| ProveError::Io {
        path: path.clone(),
        source,
    };
    for entry in fs::read_dir(&path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let is_source = entry.path().extension().is_some_and(|e| e == "rs")
            && entry.file_type().map_err(io)?.is_file();
        if !is_source {
            strays.push(format!("src/{}", entry.file_name().to_string_lossy()));
        }
    }
    strays.sort();
    Ok(strays)
}

/// Settles every claim about the crate in `directory`.
///
/// # Errors
/// [`ProveError`] where the folder holds no emitted crate. Source or numbers that do not hold up
/// are no error but a failed claim.
pub fn prove(directory: &Path, settings: &Settings) -> Result<Vec<ClaimResult>, ProveError> {
    let emitted = Emitted::read(directory)?;
    let certificate = Certificate::parse(&emitted.certificate).map_err(ProveError::Certificate)?;
    let mut results = settle(&emitted, &certificate, settings);
    results.extend(kani(directory, settings));
    Ok(results)
}

/// Collects rows.
struct Table(Vec<ClaimResult>);

impl Table {
    fn add(&mut self, id: &str, engine: &'static str, settle: impl FnOnce() -> Outcome) {
        let start = Instant::now();
        let outcome = settle();
        self.row(id, engine, outcome, start.elapsed().as_secs_f64());
    }

    fn row(&mut self, id: &str, engine: &'static str, outcome: Outcome, seconds: f64) {
        let known: Option<&Claim> = claim(id);
        self.0.push(ClaimResult {
            id: id.to_owned(),
            statement: known.map_or("", |claim| claim.statement).to_owned(),
            engine,
            domain: known.map_or("", |claim| claim.domain).to_owned(),
            assumptions: known.map_or("", |claim| claim.assumptions).to_owned(),
            outcome,
            seconds,
        });
    }
}

fn of(result: Result<String, String>) -> Outcome {
    match result {
        Ok(text) => Outcome::Proved(text),
        Err(why) => Outcome::Failed(why),
    }
}

fn tested(result: Result<usize, String>) -> Outcome {
    match result {
        Ok(cases) => Outcome::Tested(cases),
        Err(why) => Outcome::Failed(why),
    }
}

/// Settles every claim but those that need Kani.
pub fn settle(
    emitted: &Emitted,
    certificate: &Certificate,
    settings: &Settings,
) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new());
    let start = Instant::now();
    let module = match emitted.module() {
        Ok(module) => module,
        Err(error) => {
            let outcome = Outcome::Failed(error.to_string());
            table.row(
                "source-understood",
                READER,
                outcome,
                start.elapsed().as_secs_f64(),
            );
            return table.0;
        }
    };
    let functions = module.declarations().functions.len();
    let understood = emitted
        .check_surroundings()
        .map(|()| format!("{functions} functions in {} files", emitted.sources.len()));
    table.row(
        "source-understood",
        READER,
        of(understood),
        start.elapsed().as_secs_f64(),
    );

    let start = Instant::now();
    let law = ControlLaw::read(&module);
    let seconds = start.elapsed().as_secs_f64();
    let total = match &law {
        Err(error @ (LawError::Finding(_) | LawError::BeyondLimit(..) | LawError::Missing)) => {
            Outcome::Failed(error.to_string())
        }
        _ => Outcome::Proved("no operation leaves its type".to_owned()),
    };
    table.row("control-total", INTERVALS, total, seconds);
    let law = match law {
        Ok(law) => law,
        Err(error) => {
            let outcome = Outcome::Failed(error.to_string());
            table.row("control-accurate", INTERVALS, outcome, seconds);
            return table.0;
        }
    };
    control_claims(&mut table, &module, certificate, &law, settings);
    filter_claims(&mut table, &module, certificate, settings);
    table.add("certificate-consistent", EXACT, || {
        of(
            certificate_consistent::check(certificate, &module, &law, &emitted.files())
                .map(|()| "every field".to_owned()),
        )
    });
    table.add("hardware-words", EXACT, || {
        of(hardware_words::check(certificate, &module, &law).map(|()| "every word".to_owned()))
    });
    loop_claims(&mut table, &module, certificate, &law, settings);
    table.0
}

/// The crate depends on nothing but `fixed`, runs nothing while it is built, and forbids unsafe:
/// every line is one of those that an emitted manifest may hold.
fn check_cargo(text: &str) -> Result<(), String> {
    let mut section = "";
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let is_known = match section {
            _ if line.starts_with('[') => {
                section = line;
                ["[package]", "[dependencies]", "[lints.rust]"].contains(&line)
            }
            "[package]" => [
                "name",
                "version",
                "edition",
                "description",
                "license",
                "publish",
            ]
            .iter()
            .any(|key| {
                let rest = line.strip_prefix(key).map(str::trim_start);
                rest.is_some_and(|rest| rest.starts_with('='))
            }),
            "[dependencies]" => is_fixed(line),
            "[lints.rust]" => [
                FORBIDS_UNSAFE,
                "missing_docs = \"warn\"",
                "unexpected_cfgs = { level = \"warn\", check-cfg = ['cfg(kani)'] }",
            ]
            .contains(&line),
            _ => false,
        };
        if !is_known {
            return Err(format!("Cargo.toml holds `{line}`"));
        }
        found.push(line);
    }
    for needed in ["edition = \"2024\"", FORBIDS_UNSAFE] {
        if !found.contains(&needed) {
            return Err(format!("Cargo.toml does not say `{needed}`"));
        }
    }
    Ok(())
}

const FORBIDS_UNSAFE: &str = "unsafe_code = \"forbid\"";

/// `fixed` of crates.io, version 1, without its default features.
fn is_fixed(line: &str) -> bool {
    line.strip_prefix("fixed = { version = \"1.")
        .and_then(|rest| rest.strip_suffix("\", default-features = false }"))
        .is_some_and(|version| version.chars().all(|c| c.is_ascii_digit() || c == '.'))
}

fn control_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    law: &ControlLaw,
    settings: &Settings,
) {
    let half_unit = law.unit() * crate::exact::rational::half();
    table.add("control-accurate", INTERVALS, || {
        let bound = rounded_up(&law.rounding, 4);
        let gains_agree = certificate
            .constants
            .iter()
            .zip(&law.gains)
            .all(|(c, gain)| {
                let word = crate::exact::rational::integer(c.raw.into());
                let bits = crate::claims::control_law::exponent(c.fraction_bits);
                word * crate::exact::rational::power_of_two(-bits) == *gain
            });
        if law.rounding > half_unit {
            Outcome::Failed(format!("off by up to {bound} A, more than half a unit"))
        } else if !gains_agree {
            Outcome::Failed("the gains of the source are not those of the certificate".to_owned())
        } else {
            Outcome::Proved(format!("{bound} A"))
        }
    });
    table.add("control-accurate-real-gains", EXACT, || {
        let (bound, _) = certificate_consistent::derived(certificate, law);
        if bound <= certificate.bounds.real_gains.value {
            Outcome::Proved(format!("{} A", rounded_up(&bound, 4)))
        } else {
            Outcome::Failed(format!(
                "{} A, stated are {}",
                rounded_up(&bound, 4),
                certificate.bounds.real_gains
            ))
        }
    });
    table.add("control-monotone", INTERVALS, || {
        // A linear form, rounded down and clamped, is monotone in each argument; that the source
        // is one, ControlLaw::read has shown.
        Outcome::Proved("a linear form, rounded down and clamped".to_owned())
    });
    table.add("control-accurate", RANDOM, || {
        tested(filter_accurate::control(
            module,
            certificate,
            settings.cases,
            settings.seed,
        ))
    });

    let Some(program) = module.function("control") else {
        return;
    };
    let is_available = settings.smt && smt::is_available();
    let mut ask = |id: &str, question: &dyn Fn() -> Answer| {
        table.add(id, SMT, || {
            if !is_available {
                let why = if settings.smt {
                    "z3 is not installed"
                } else {
                    "switched off"
                };
                return Outcome::NotRun(why.to_owned());
            }
            match question() {
                Answer::Proved => Outcome::Proved("no counterexample".to_owned()),
                Answer::Refuted(model) => Outcome::Failed(format!("counterexample: {model}")),
                Answer::Unknown(why) => Outcome::NotRun(why),
            }
        });
    };
    let limit = match module.constant("control", "CURRENT_LIMIT") {
        Some([word]) => *word,
        _ => 0,
    };
    ask("control-total", &|| smt::total(program, limit));
    ask("control-accurate", &|| smt::accurate(program, certificate));
    ask("control-monotone", &|| {
        (0..3)
            .map(|state| smt::monotone(program, certificate, state))
            .find(|answer| *answer != Answer::Proved)
            .unwrap_or(Answer::Proved)
    });
}

/// What is shown of the filter for every word.
fn range_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    settings: &Settings,
) {
    let start = Instant::now();
    let primitives = filter_total::primitives(module);
    let contracts = filter_total::proved(&primitives);
    let failed: Vec<String> = primitives
        .iter()
        .filter(|primitive| !primitive.contract.is_partial)
        .filter_map(|primitive| {
            let why = primitive.proof.as_ref().err()?;
            Some(format!("{}: {why}", primitive.name))
        })
        .collect();
    let in_place = primitives.iter().filter(|p| p.contract.is_partial).count();
    let boxes: usize = primitives
        .iter()
        .filter_map(|p| p.proof.as_ref().ok())
        .sum();
    let outcome = if primitives.is_empty() {
        Outcome::Failed("no function of the source states a contract".to_owned())
    } else if failed.is_empty() {
        Outcome::Proved(format!(
            "{} contracts over {boxes} boxes, {in_place} more in place",
            primitives.len() - in_place
        ))
    } else {
        Outcome::Failed(failed.join("; "))
    };
    table.row(
        "primitives",
        INTERVALS,
        outcome,
        start.elapsed().as_secs_f64(),
    );
    table.add("filter-total", INTERVALS, || {
        of(filter_total::check_filter(module, &contracts)
            .map(|()| "the invariant is kept".to_owned()))
    });
    if settings.filter_length {
        table.add("filter-length", EXACT, || {
            of(filter_length::check(module, &contracts).map(|lengths| {
                format!(
                    "squared length after a step: {}; after an alignment: {}",
                    filter_length::distances(&lengths.after_step),
                    filter_length::distances(&lengths.after_alignment)
                )
            }))
        });
    }
    table.add("step-total", INTERVALS, || {
        let drive = &certificate.drive;
        let low = drive
            .duty_zero
            .saturating_sub(drive.duty_max.saturating_sub(drive.duty_zero));
        let checked =
            filter_total::check_step(module, &contracts, low, drive.duty_zero, drive.duty_max);
        of(checked.map(|()| format!("duty within {low} to {}", drive.duty_max)))
    });
}

fn filter_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    settings: &Settings,
) {
    if settings.filter_ranges {
        range_claims(table, module, certificate, settings);
    }
    let fewer = (settings.cases / 10).max(1);
    table.add("filter-accurate", RANDOM, || {
        tested(filter_accurate::filter(module, fewer, settings.seed))
    });
    table.add("filter-exact", RANDOM, || {
        tested(filter_exact::run(module, fewer, settings.seed))
    });
    table.add("step-total", RANDOM, || {
        let runs = filter_accurate::step(module, certificate, fewer, settings.seed);
        tested(runs.and_then(|runs| {
            let more = filter_accurate::bias_observer(module, fewer, settings.seed)?;
            let parts = filter_accurate::composition(module, fewer, settings.seed)?;
            Ok(runs + more + parts)
        }))
    });
    table.add("primitives", RANDOM, || {
        tested(filter_accurate::primitives(module, fewer, settings.seed))
    });
}

fn loop_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    law: &ControlLaw,
    settings: &Settings,
) {
    table.add("closed-loop-stable", EXACT, || {
        of(stable_for_parameters::check_stable(certificate, law)
            .map(|()| "Hurwitz' criterion".to_owned()))
    });
    table.add("bias-observer-stable", EXACT, || {
        of(
            bias_observer_stable::check_loop(certificate, module, law).map(|rest| match rest {
                Some((left, speed)) => format!(
                    "{} of a bias is left; the wheel turns with {} rad/s for each rad of bias",
                    rounded_up(&left, 2),
                    rounded_up(&speed, 2)
                ),
                None => "there is no observer: its words are zero".to_owned(),
            }),
        )
    });
    let mut found = None;
    table.add("closed-loop-for-all-time", EXACT, || {
        if !settings.closed_loop {
            return Outcome::NotRun("switched off".to_owned());
        }
        let Some(stated) = &certificate.closed_loop else {
            return Outcome::NotRun(
                "the certificate states none: no set was found that the perturbations cannot leave, or the module has an observer of the angle's bias, which the bound does not include"
                    .to_owned(),
            );
        };
        let checked = closed_loop_for_all_time::check(certificate, stated, law);
        found = checked.as_ref().ok().cloned();
        of(checked.map(|bounds| {
            let parts: Vec<_> = bounds
                .cases
                .iter()
                .map(|case| {
                    format!(
                        "{}: {} rad, {} rad/s, {} rad/s, {} A",
                        case.name,
                        rounded_up(&case.states[0], 3),
                        rounded_up(&case.states[1], 3),
                        rounded_up(&case.states[2], 3),
                        rounded_up(&case.command, 3)
                    )
                })
                .collect();
            parts.join("; ")
        }))
    });
    table.add("region-of-attraction", EXACT, || {
        let (Some(stated), Some(bounds)) = (&certificate.closed_loop, &found) else {
            return Outcome::NotRun("it needs closed-loop-for-all-time".to_owned());
        };
        match region_of_attraction::check(certificate, stated, bounds, law) {
            Ok(region) => Outcome::Proved(format!(
                "from {} of the ellipsoid (up to {} rad, {} rad/s, {} rad/s) into {} of it",
                rounded_up(&region.outer, 3),
                rounded_up(&region.extents[0], 3),
                rounded_up(&region.extents[1], 3),
                rounded_up(&region.extents[2], 3),
                rounded_up(&region.inner, 3)
            )),
            Err(why) => Outcome::NotRun(why),
        }
    });
    table.add(
        "stable-for-parameters",
        EXACT,
        || match stable_for_parameters::check_region(certificate, law) {
            Ok(region) if region.uncertain.is_empty() => {
                Outcome::Proved("no standard error is stated: the parameters themselves".to_owned())
            }
            Ok(region) => {
                let list: Vec<_> = region
                    .uncertain
                    .iter()
                    .map(|(name, radius)| format!("{name} ± {radius}"))
                    .collect();
                Outcome::Proved(format!("{} in {} boxes", list.join(", "), region.boxes))
            }
            Err(RegionFailure::NotStated(why)) => Outcome::NotRun(why),
            Err(RegionFailure::Fails(why)) => Outcome::Failed(why),
        },
    );
}

/// The harnesses of the crate `verify` beside `directory`, where Kani is installed.
fn kani(directory: &Path, settings: &Settings) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new());
    let not_run = |table: &mut Table, why: &str| {
        for id in [
            "control-total",
            "control-accurate",
            "filter-total",
            "step-total",
        ] {
            table.row(id, KANI, Outcome::NotRun(why.to_owned()), 0.0);
        }
    };
    if !settings.kani {
        not_run(&mut table, "switched off");
        return table.0;
    }
    let is_installed = Command::new("cargo")
        .args(["kani", "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !is_installed {
        not_run(&mut table, "cargo kani is not installed");
        return table.0;
    }
    let manifest = directory.join("../verify/Cargo.toml");
    if !manifest.is_file() {
        not_run(
            &mut table,
            "the harnesses (crate verify) are not beside the folder",
        );
        return table.0;
    }
    let output = Command::new("cargo")
        .arg("kani")
        .arg("--manifest-path")
        .arg(&manifest)
        .output();
    match output {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let rows = kani_rows(&text);
            if rows.is_empty() {
                let lines = String::from_utf8_lossy(&output.stderr).into_owned();
                let last = lines.lines().last().unwrap_or("no harness ran");
                not_run(&mut table, &format!("cargo kani: {last}"));
            }
            for (id, outcome, seconds) in rows {
                table.row(&id, KANI, outcome, seconds);
            }
        }
        Err(error) => not_run(&mut table, &format!("cargo kani: {error}")),
    }
    table.0
}

/// Harness by harness what Kani printed.
fn kani_rows(text: &str) -> Vec<(String, Outcome, f64)> {
    let mut rows = Vec::new();
    let mut name = String::new();
    let mut outcome = None;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("Checking harness ") {
            let harness = rest.trim_end_matches("...");
            name = harness
                .rsplit("::")
                .next()
                .unwrap_or(harness)
                .replace('_', "-");
        } else if let Some(verdict) = line.strip_prefix("VERIFICATION:- ") {
            outcome = Some(if verdict.starts_with("SUCCESSFUL") {
                Outcome::Proved("every check of the harness".to_owned())
            } else {
                Outcome::Failed(format!("Kani: {verdict}"))
            });
        } else if let Some(time) = line.strip_prefix("Verification Time: ")
            && let Some(outcome) = outcome.take()
        {
            let seconds = time.trim_end_matches('s').parse().unwrap_or(0.0);
            rows.push((name.clone(), outcome, seconds));
        }
    }
    rows
}

/// Whether no claim failed.
pub fn passed(results: &[ClaimResult]) -> bool {
    results
        .iter()
        .all(|result| !matches!(result.outcome, Outcome::Failed(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kani_output_is_read() {
        let text = "Checking harness proofs::control_total...\nVERIFICATION:- SUCCESSFUL\n\
                    Verification Time: 2.25s\nChecking harness proofs::control_accurate...\n\
                    VERIFICATION:- FAILED\nVerification Time: 20s\n";
        let rows = kani_rows(text);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].0, "control-total");
        assert!(matches!(rows[0].1, Outcome::Proved(_)) && rows[0].2 == 2.25);
        assert!(matches!(rows[1].1, Outcome::Failed(_)));
    }

    #[test]
    fn dependencies_are_looked_at() {
        let good = "[package]\nname = \"x\"\nedition = \"2024\"\n[lints.rust]\nunsafe_code = \"forbid\"\n[dependencies]\nfixed = { version = \"1.31\", default-features = false }\n";
        assert_eq!(check_cargo(good), Ok(()));
        for bad in [
            "libm = \"0.2\"",
            "fixed = { path = \"../evil\", default-features = false }",
            "fixed = { version = \"1.31\", default-features = false, package = \"evil\" }",
            "fixed = { version = \"1.31\", default-features = false, features = [\"std\"] }",
            "[build-dependencies]",
            "[features]",
            "[lib]",
            "fixed = \"1\"",
        ] {
            assert!(check_cargo(&format!("{good}{bad}\n")).is_err(), "{bad}");
        }
        for bad in ["lib.path = \"evil.rs\"", "dependencies.evil = \"1\""] {
            assert!(check_cargo(&format!("{bad}\n{good}")).is_err(), "{bad}");
        }
        for (from, to) in [
            ("\"forbid\"", "\"allow\""),
            ("\"2024\"", "\"2018\""),
            ("name =", "build = \"evil.rs\"\nname ="),
            ("unsafe_code", "missing_docs"),
        ] {
            assert!(check_cargo(&good.replace(from, to)).is_err(), "{to}");
        }
    }
}
