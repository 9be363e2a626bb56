//! The command line: from measurements of a reaction-wheel pendulum to a verified fixed-point
//! controller. One file per command in `commands/`: its arguments, one call of the library
//! `workbench`, and a view of the result (`views/`).

mod arguments;
mod cli;
mod commands;
mod failure;
mod progress;
mod report;
mod views;

use std::io::Write;
use std::panic;
use std::process::ExitCode;

use clap::Parser;

use crate::arguments::JsonOutput;
use crate::cli::Cli;
use crate::failure::Failure;
use crate::report::Report;

fn main() -> ExitCode {
    // A panic is a fault of this program; the user gets one line, not a backtrace.
    panic::set_hook(Box::new(|bug| {
        let place = bug
            .location()
            .map_or(String::new(), |place| format!(" at {place}"));
        eprintln!("error: internal error{place}: this is a bug in flywheel, please report it");
    }));
    let cli = Cli::parse();
    progress::heed_interrupts();
    match panic::catch_unwind(|| run(&cli)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            failure.print();
            ExitCode::from(failure.code())
        }
        Err(_) => ExitCode::from(2),
    }
}

fn run(cli: &Cli) -> Result<ExitCode, Failure> {
    if cli.all {
        report::table::show_all();
    }
    // Found before the computing, and not after it.
    if let Some(path) = cli.command.output().json_file() {
        bench_files::can_write(path)?;
    }
    let report = cli.command.run()?;
    deliver(&report, cli.command.output())?;
    Ok(ExitCode::from(report.code))
}

/// Prints the text, or writes the JSON; with `--json -`, the JSON replaces the text.
fn deliver(report: &Report, output: &JsonOutput) -> Result<(), Failure> {
    match (output.json.as_deref(), output.json_file()) {
        (Some(_), None) => print(&report.json),
        (_, Some(path)) => {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder).map_err(|error| {
                    Failure::in_file(folder, format!("cannot create the folder: {error}"))
                })?;
            }
            bench_files::write_atomically(path, report.json.as_bytes())?;
            print(&harmless(&report.text))
        }
        (None, None) => print(&harmless(&report.text)),
    }
}

/// A text without control characters, which names in files may contain and a terminal would execute.
fn harmless(text: &str) -> String {
    let shown = |c: char| {
        if c.is_control() && c != '\n' {
            '\u{fffd}'
        } else {
            c
        }
    };
    text.chars().map(shown).collect()
}

fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        // The reader has closed the pipe (`flywheel … | head`).
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::new(format!(
            "cannot write to standard output: {error}"
        ))),
        Ok(()) => Ok(()),
    }
}
