//! `flywheel demo`

use std::path::{Path, PathBuf};
use std::time::Instant;

use ::identify::Record;
use bench_files::ModelFile;
use plant::Model;
use serde::Serialize;
use serde_json::Value;

use crate::bench_folder::BenchFolder;
use crate::cli::{BenchFiles, Output};
use crate::commands::{design, diagnose, generate, identify, simulate};
use crate::diagnosed::DiagnosisJson;
use crate::failure::Failure;
use crate::fitted::Fitted;
use crate::progress::while_doing;
use crate::report::Report;
use crate::report::numbers::{significant, with_prefix, with_uncertainty};
use crate::report::table::{Align, Table};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for everything that the demonstration writes
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct DemoJson {
    bench: PathBuf,
    model: PathBuf,
    controller: PathBuf,
    diagnosis: DiagnosisJson,
    design: Value,
    generated: Value,
    closed_loop: Value,
    figures: Vec<PathBuf>,
    seconds: f64,
}

/// Runs the command: what a user would do with a bench of their own, step by step.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let began = Instant::now();
    let out = &arguments.out;
    let quiet = || Output { json: None };

    let bench_path = out.join("demo");
    write_bench(&bench_path)?;
    let folder = BenchFolder::load(
        &bench_path,
        &BenchFiles {
            model: None,
            out: Some(out.join("figures")),
        },
    )?;
    let samples: usize = folder.setup.records.iter().map(Record::len).sum();
    let mut text = format!(
        "The demonstration bench: simulated, with noise; its pivot has dry friction of\n\
         {} that the base model lacks.\n\n\
         1  Measurements, as a user would have them: {} experiments, {samples} samples\n   {}\n",
        with_prefix(demo::COULOMB_TORQUE_NM, "N m"),
        folder.setup.records.len(),
        bench_path.display(),
    );

    let (identified, diagnosed) = diagnose::diagnose(&folder, &Model::base())?;
    let base = while_doing("drawing the base model", || {
        Fitted::from_identification(&folder, identified)
    });
    let before = base.figures_in(&out.join("figures").join("base-model"))?;
    text.push_str(&format!(
        "\n2  flywheel identify: the base model, viscous friction alone. The misfit shows:\n{}",
        indented(&base.error_table())
    ));

    text.push_str(&format!(
        "\n3  flywheel diagnose --apply: what is missing?\n   {}\n{}{}",
        diagnosed.sentence(),
        indented(&diagnosed.staircase_table()),
        indented(&suspects(&diagnosed.json(Vec::new())))
    ));
    identify::save(&folder, ModelFile::default(), &diagnosed.last)?;
    let after = while_doing("drawing the diagnosis", || diagnosed.figures())?;
    let model = folder.model_path.clone();

    let designed = design::run(&design::Arguments {
        model: model.clone(),
        out: Some(out.join("figures")),
        output: quiet(),
    })?;
    let controller = out.join("controller");
    let generated = generate::run(&generate::Arguments {
        model: model.clone(),
        out: controller.clone(),
        check: false,
        output: quiet(),
    })?;
    let closed_loop = simulate::run(&simulate::Arguments {
        model: model.clone(),
        bench: Some(bench_path.clone()),
        seed: 1,
        out: Some(out.join("figures")),
        output: quiet(),
    })?;
    text.push_str(&design_text(designed.value()));
    text.push_str(&format!(
        "\n5  flywheel generate: the controller as a no_std crate in fixed point\n   {}\n   {}\n",
        controller.join("src").join("control.rs").display(),
        controller.join("certificate.json").display(),
    ));
    text.push_str(&closed_loop_text(closed_loop.value()));

    let mut figures = before;
    figures.extend(after);
    for report in [&designed, &closed_loop] {
        figures.extend(svg_paths(report.value()));
    }
    text.push_str(&format!(
        "\nModel\n  {}\nFigures (all {} in {})\n",
        model.display(),
        figures.len(),
        out.join("figures").display()
    ));
    let told = ["free-swing-20-deg", "staircase", "suspects", "half-minute"];
    for path in &figures {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if told.iter().any(|part| name.contains(part)) && !name.starts_with("where") {
            text.push_str(&format!("  {}\n", path.display()));
        }
    }
    let seconds = began.elapsed().as_secs_f64();
    text.push_str(&format!("\nDone in {seconds:.1} s\n"));
    Report::new(
        text,
        &DemoJson {
            bench: bench_path,
            model,
            controller,
            diagnosis: diagnosed.json(Vec::new()),
            design: designed.value().clone(),
            generated: generated.value().clone(),
            closed_loop: closed_loop.value().clone(),
            figures,
            seconds,
        },
    )
}

fn write_bench(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::in_file(folder, format!("cannot make the folder: {error}")))?;
    for (name, content) in demo::FILES {
        bench_files::write_atomically(&folder.join(name), content.as_bytes())?;
    }
    Ok(())
}

/// A section that stands under a numbered step.
fn indented(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(|line| format!("   {line}\n")).collect()
}

fn suspects(diagnosis: &DiagnosisJson) -> String {
    let mut text = String::new();
    for suspect in diagnosis.likely_suspects() {
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

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn design_text(design: &Value) -> String {
    let gains: Vec<String> = (0..3)
        .map(|index| significant(number(&design["gains"][index]), 6))
        .collect();
    format!(
        "\n4  flywheel design: linear-quadratic law every {} s\n   u = −K x, K = ({}); recovers from \
         {:.1}° at most\n",
        number(&design["sample_time_s"]),
        gains.join(", "),
        number(&design["recovery_angle_rad"]).to_degrees(),
    )
}

fn closed_loop_text(closed_loop: &Value) -> String {
    let mut table = Table::new(&[
        ("run on the nonlinear bench", Align::Left),
        ("largest angle", Align::Right),
        ("fixed point − float, angle", Align::Right),
        ("current", Align::Right),
        ("", Align::Left),
    ]);
    let runs = closed_loop["runs"]
        .as_array()
        .map_or(&[][..], Vec::as_slice);
    for run in runs {
        table.row([
            run["scenario"].as_str().unwrap_or_default().to_owned(),
            format!("{:.2}°", number(&run["largest_angle_rad"]).to_degrees()),
            with_prefix(number(&run["difference_angle_rad"]), "rad"),
            with_prefix(number(&run["difference_current_a"]), "A"),
            if run["fell"] == Value::Bool(true) {
                "FELL".to_owned()
            } else {
                "stands".to_owned()
            },
        ]);
    }
    format!(
        "\n6  flywheel simulate: the emitted law, run from its source, beside the law in floating \
         point\n{}",
        indented(&table.text())
    )
}

/// The figures that a command reports, whatever it calls them.
fn svg_paths(report: &Value) -> Vec<PathBuf> {
    ["figures", "files"]
        .iter()
        .filter_map(|key| report[*key].as_array())
        .flatten()
        .filter_map(Value::as_str)
        .filter(|path| path.ends_with(".svg"))
        .map(PathBuf::from)
        .collect()
}
