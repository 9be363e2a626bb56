//! `flywheel lab [BENCH]`

use std::path::PathBuf;

use lab::{Lab, LabSettings};
use serde_json::json;

use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench to open: a folder with a bench.toml, or that file [default: the page asks]
    pub bench: Option<PathBuf>,
    /// Port on this machine [default: one that the system chooses]
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    /// Print the address instead of opening a browser
    #[arg(long)]
    pub no_open: bool,
}

/// Runs the command until it is interrupted.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let failed = |error: lab::Error| Failure::new(error.to_string());
    let lab = Lab::start(&LabSettings {
        bench: arguments.bench.clone(),
        port: arguments.port,
    })
    .map_err(failed)?;
    let opened = !arguments.no_open && lab.open_in_browser().is_ok();
    let how = if opened {
        format!(
            "The lab is open in the browser. If no browser appeared, open {}",
            lab.door().display()
        )
    } else {
        format!(
            "Open the lab in a browser of this machine\n  once:  {}\n  again: file://{}",
            lab.one_time_address(),
            lab.door().display()
        )
    };
    crate::print(&format!("{how}\nCtrl-C ends it.\n"))?;
    with_progress(|progress| lab.run(progress.cancelled)).map_err(failed)?;
    Report::new(String::new(), &json!(null))
}
