//! The failure of a command (exit code 2): bad input, with one clear message.

use std::fmt;
use std::io::IsTerminal;
use std::ops::Range;
use std::path::Path;

use crate::progress::CALLED_OFF;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

/// Bad input, a file that cannot be written, or a cancelled command.
pub struct Failure {
    message: String,
    /// The exit code.
    code: u8,
    /// The text of a file, and the range of bytes that the message is about.
    excerpt: Option<(String, Range<usize>)>,
}

impl Failure {
    /// A failure with this message.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure {
            message: message.into(),
            code: 2,
            excerpt: None,
        }
    }

    /// The exit code of the program.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// A failure that concerns this file.
    pub fn in_file(file: &Path, message: impl fmt::Display) -> Failure {
        Failure::new(format!("{}: {message}", file.display()))
    }

    /// Prints one message on standard error; on a terminal, with the affected lines of the file.
    pub fn print(&self) {
        match &self.excerpt {
            Some((text, span)) if std::io::stderr().is_terminal() => {
                anstream::eprintln!("{}", self.drawn(text, span.clone(), &Renderer::styled()));
            }
            _ => eprintln!("error: {}", crate::harmless(&self.message)),
        }
    }

    /// The message above the lines of the file, with the wrong part marked.
    fn drawn(&self, text: &str, span: Range<usize>, renderer: &Renderer) -> String {
        let mark = AnnotationKind::Primary.span(span).label("here");
        let title = Level::ERROR.primary_title(&self.message);
        renderer.render(&[title.element(Snippet::source(text).annotation(mark))])
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<bench_files::Error> for Failure {
    fn from(error: bench_files::Error) -> Failure {
        let excerpt = error.excerpt();
        Failure {
            message: error.to_string(),
            code: 2,
            excerpt: excerpt.map(|(text, span)| (text.to_string(), span)),
        }
    }
}

impl From<workbench::Error> for Failure {
    fn from(error: workbench::Error) -> Failure {
        use workbench::{Error, HardwareError};
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
            Error::Hardware {
                source: HardwareError::Missing { .. },
                ..
            } => Failure::new(format!("{error} with --preset thesis-bench")),
            Error::Cancelled(cancelled) => Failure {
                code: CALLED_OFF,
                ..Failure::new(cancelled.to_string())
            },
            Error::FailsUndamaged { .. } => {
                Failure::new(format!("{error}; flywheel prove on this folder says why"))
            }
            other => Failure::new(other.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_about_a_text_marks_the_place_under_its_line() {
        let text = "name = \"one\"\nkind = \"freeswing\"\n";
        let failure = Failure::new("bench.toml:2:8: unknown kind");
        let drawn = failure.drawn(text, 20..31, &Renderer::plain());
        let lines: Vec<&str> = drawn.lines().collect();
        assert_eq!(lines[0], "error: bench.toml:2:8: unknown kind");
        assert!(lines.contains(&"2 | kind = \"freeswing\""), "{drawn}");
        assert!(lines.contains(&"  |        ^^^^^^^^^^^ here"), "{drawn}");
    }
}
