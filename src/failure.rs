//! Why a command ends with exit code 2: bad input, with one clear message.

use std::fmt;
use std::io::IsTerminal;
use std::path::Path;

use miette::{Diagnostic, GraphicalReportHandler};

/// Bad input, or a file that cannot be written.
pub struct Failure(Box<dyn Diagnostic + Send + Sync>);

/// A message that belongs to no line of a file.
#[derive(Debug)]
struct Message(String);

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Message {}
impl Diagnostic for Message {}

impl Failure {
    /// A failure with this message.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure(Box::new(Message(message.into())))
    }

    /// A failure that concerns this file.
    pub fn in_file(file: &Path, message: impl fmt::Display) -> Failure {
        Failure::new(format!("{}: {message}", file.display()))
    }

    /// One message on standard error; on a terminal with the lines of the file that it is about.
    pub fn print(&self) {
        if std::io::stderr().is_terminal() && self.0.source_code().is_some() {
            let mut text = String::new();
            let drawn = GraphicalReportHandler::new().render_report(&mut text, self.0.as_ref());
            if drawn.is_ok() {
                eprint!("{text}");
                return;
            }
        }
        eprintln!("error: {}", self.0);
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<bench_files::Error> for Failure {
    fn from(error: bench_files::Error) -> Failure {
        Failure(Box::new(error))
    }
}

impl From<workbench::Error> for Failure {
    fn from(error: workbench::Error) -> Failure {
        use workbench::Error;
        let identify = |bench: &Path| format!("flywheel identify {}", bench.display());
        match error {
            Error::File(error) => error.into(),
            Error::NoModel { model, bench } => Failure::in_file(
                &model,
                format!("there is no model yet; make one with: {}", identify(&bench)),
            ),
            Error::ParameterUnit { ref bench, .. } | Error::ParameterMissing { ref bench, .. } => {
                Failure::new(format!("{error}; run: {}", identify(bench)))
            }
            Error::FailsUndamaged { .. } => Failure::new(format!("{error}; see flywheel prove")),
            other => Failure::new(other.to_string()),
        }
    }
}
