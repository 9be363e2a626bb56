//! `flywheel demo`

use std::path::PathBuf;
use std::time::Instant;

use bench_files::ModelFile;
use serde::Serialize;
use workbench::numbers::{degrees, significant, with_prefix, with_uncertainty};
use workbench::{
    DesignReport, DiagnosisReport, GeneratedController, OutputFile, Session, SimulationReport,
    SimulationSettings,
};

use crate::arguments::{JsonOutput, save_model};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::table::{Align, Table};
use crate::report::{Report, listed, write_files};
use crate::views::{comparison, diagnosis};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for everything that the demonstration writes
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    #[command(flatten)]
    pub output: JsonOutput,
}

#[derive(Serialize)]
struct Demonstration<'a> {
    bench: PathBuf,
    model: PathBuf,
    controller: PathBuf,
    diagnosis: &'a DiagnosisReport,
    design: &'a DesignReport,
    generated: &'a GeneratedController,
    closed_loop: &'a SimulationReport,
    figures: Vec<PathBuf>,
    seconds: f64,
}

/// Runs the command: what a user would do with a bench of their own, step by step.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let began = Instant::now();
    let out = &arguments.out;
    let bench_path = out.join("demo");
    let figure_folder = out.join("figures");
    let controller_path = out.join("controller");

    let files = demo::FILES.map(|(name, text)| OutputFile {
        name: name.to_owned(),
        text: text.to_owned(),
    });
    write_files(&bench_path, &files)?;
    let mut session = Session::open(&bench_path)?;
    // The model of an earlier demonstration is not used.
    session.set_model(ModelFile::new());

    let (base, report, designed, controller, closed_loop) = with_progress(|progress| {
        let base = session.identify(progress)?;
        let report = session.diagnose(progress)?;
        session.apply(&report);
        let designed = session.design()?;
        let settings = SimulationSettings {
            bench: Some(session.bench()),
            ..Default::default()
        };
        let closed_loop = designed.simulate(&settings, progress)?;
        Ok::<_, workbench::Error>((
            base,
            report,
            designed.report()?,
            designed.generate(None)?,
            closed_loop,
        ))
    })?;
    save_model(&session)?;
    controller.write(&controller_path)?;
    let mut drawings = report.drawings()?;
    drawings.extend(designed.drawings()?);
    drawings.extend(closed_loop.files()?);
    let mut figures = write_files(&figure_folder.join("base-model"), &base.drawings()?)?;
    let written = write_files(&figure_folder, &drawings)?;
    let is_figure = |path: &PathBuf| path.extension().is_some_and(|end| end == "svg");
    figures.extend(written.into_iter().filter(is_figure));

    let mut text = format!(
        "The demonstration bench: simulated, with noise; its pivot has dry friction of\n\
         {} that the base model lacks.\n\n\
         1  Measurements, as a user would have them: {} experiments, {} samples\n   {}\n",
        with_prefix(demo::COULOMB_TORQUE_NM, "N m"),
        base.experiments.len(),
        base.samples(),
        bench_path.display(),
    );
    text.push_str(&format!(
        "\n2  flywheel identify: the base model, viscous friction alone. The misfit shows:\n{}",
        indented(&comparison::error_table(&base))
    ));
    text.push_str(&format!(
        "\n3  flywheel diagnose --apply: what is missing?\n   {}\n{}{}",
        report.sentence,
        indented(&diagnosis::staircase_table(&report)),
        indented(&suspects(&report))
    ));
    text.push_str(&design_text(&designed));
    text.push_str(&format!(
        "\n5  flywheel generate: the controller as a no_std crate in fixed point\n   {}\n   {}\n",
        controller_path.join("src").join("control.rs").display(),
        controller_path.join("certificate.json").display(),
    ));
    text.push_str(&closed_loop_text(&closed_loop));
    text.push_str(&format!(
        "\nModel\n  {}\nFigures (all {} in {})\n",
        session.model_path().display(),
        figures.len(),
        figure_folder.display()
    ));
    text.push_str(&listed(&told(&figures)));
    let seconds = began.elapsed().as_secs_f64();
    text.push_str(&format!("\nDone in {seconds:.1} s\n"));
    Report::new(
        text,
        &Demonstration {
            bench: bench_path,
            model: session.model_path().to_path_buf(),
            controller: controller_path,
            diagnosis: &report,
            design: &designed,
            generated: &controller,
            closed_loop: &closed_loop,
            figures,
            seconds,
        },
    )
}

/// The most instructive figures, which the text lists by name.
fn told(figures: &[PathBuf]) -> Vec<PathBuf> {
    let parts = ["free-swing-20-deg", "staircase", "suspects", "half-minute"];
    let is_told = |path: &&PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        parts.iter().any(|part| name.contains(part)) && !name.starts_with("where")
    };
    figures.iter().filter(is_told).cloned().collect()
}

/// A section that stands under a numbered step.
fn indented(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(|line| format!("   {line}\n")).collect()
}

fn suspects(report: &DiagnosisReport) -> String {
    let mut text = String::new();
    for suspect in report.likely_suspects() {
        text.push_str(&format!("{}: {}\n", suspect.effect, suspect.fingerprint));
        for parameter in &suspect.parameters {
            text.push_str(&format!(
                "  {} = {} {}\n",
                parameter.name,
                with_uncertainty(parameter.value, parameter.std),
                parameter.unit
            ));
        }
    }
    text
}

fn design_text(designed: &DesignReport) -> String {
    format!(
        "\n4  flywheel design: linear-quadratic law every {} s\n   u = −K x, K = ({}); the largest \
         current holds the body at up to {}\n",
        designed.sample_time_s,
        designed.gains.map(|gain| significant(gain, 6)).join(", "),
        degrees(designed.recovery_angle_rad),
    )
}

fn closed_loop_text(closed_loop: &SimulationReport) -> String {
    let mut table = Table::new(&[
        ("run on the nonlinear bench", Align::Left),
        ("largest angle", Align::Right),
        ("fixed point − float, angle", Align::Right),
        ("current", Align::Right),
        ("", Align::Left),
    ]);
    for run in &closed_loop.runs {
        table.row([
            run.scenario.clone(),
            degrees(run.largest_angle_rad),
            with_prefix(run.difference_angle_rad, "rad"),
            with_prefix(run.difference_current_a, "A"),
            if run.fell { "FELL" } else { "stands" }.to_owned(),
        ]);
    }
    format!(
        "\n6  flywheel simulate: the emitted law, run from its source, beside the law in floating \
         point\n{}",
        indented(&table.text())
    )
}
