//! Claims of the closed loop by the second checkers, small programs in Python that share nothing
//! with this one (`checker/second/`).

use std::fs;
use std::io::{Error, ErrorKind};
use std::process::{Command, Output, Stdio};

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;

/// Of `closed-loop-for-all-time`.
const FOR_ALL_TIME: &str = include_str!("../../second/closed_loop.py");

/// Of `loop-as-shipped` and `motion-kept-up`.
const AS_SHIPPED: &str = include_str!("../../second/loop_as_shipped.py");

/// Settles `closed-loop-for-all-time` by the second checker, if Python is installed.
pub fn by_python(emitted: &Emitted) -> ClaimOutcome {
    run(FOR_ALL_TIME, emitted)
}

/// Settles `loop-as-shipped` and `motion-kept-up` by the second checker, where Python is.
pub fn as_shipped_by_python(emitted: &Emitted) -> ClaimOutcome {
    run(AS_SHIPPED, emitted)
}

/// Runs a program on the certificate.
fn run(text: &str, emitted: &Emitted) -> ClaimOutcome {
    let run = || -> Result<Output, String> {
        let of_files = |error: Error| format!("a temporary folder cannot be written: {error}");
        let folder = tempfile::tempdir().map_err(of_files)?;
        let program = folder.path().join("second.py");
        let certificate = folder.path().join("certificate.json");
        fs::write(&program, text).map_err(of_files)?;
        fs::write(&certificate, &emitted.certificate).map_err(of_files)?;
        // `-I`: Python loads no module of the user in place of its own.
        let mut command = Command::new("python3");
        command.arg("-I").arg(&program).arg(&certificate);
        command
            .stdin(Stdio::null())
            .output()
            .map_err(|error| match error.kind() {
                ErrorKind::NotFound => "python3 is not installed".to_owned(),
                _ => format!("python3 cannot be started: {error}"),
            })
    };
    match run() {
        Err(why) => ClaimOutcome::NotRun(why),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            match output.status.code() {
                Some(0) => ClaimOutcome::Proved(said),
                Some(1) if !said.is_empty() => ClaimOutcome::Failed(said),
                // Its argument does not hold this module.
                Some(3) if !said.is_empty() => ClaimOutcome::NotRun(said),
                _ => ClaimOutcome::NotRun(format!("python3 cannot run it: {said}")),
            }
        }
    }
}
