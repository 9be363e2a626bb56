//! `flywheel report BENCH`

use std::path::PathBuf;

use serde_json::json;
use workbench::Session;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    /// The model of the bench [default: BENCH/model.toml]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Where the report goes [default: BENCH/report.html]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command. The model is that of model.toml; the bench is not changed.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let mut session = Session::open_with_model(&arguments.bench, arguments.model.as_deref())?;
    let beside = || session.bench().folder.join("report.html");
    let path = arguments.out.clone().unwrap_or_else(beside);
    bench_files::can_write(&path)?;
    let html = with_progress(|progress| lab::report_of(&mut session, progress))?;
    bench_files::write_atomically(&path, html.as_bytes())?;
    Report::new(
        format!("Written: {}\n", path.display()),
        &json!({"report": path}),
    )
}
