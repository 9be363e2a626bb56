//! Claim `closed-loop-for-all-time`, decided by the second checker: a small Python program that shares no code
//! with this one (`checker/second/closed_loop.py`).

use std::fs;
use std::process::{Command, Stdio};

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;

/// The program.
const PROGRAM: &str = include_str!("../../second/closed_loop.py");

/// Runs the second checker on the certificate, where Python is.
pub fn by_python(emitted: &Emitted) -> ClaimOutcome {
    let run = || -> std::io::Result<std::process::Output> {
        let folder = tempfile::tempdir()?;
        let program = folder.path().join("closed_loop.py");
        let certificate = folder.path().join("certificate.json");
        fs::write(&program, PROGRAM)?;
        fs::write(&certificate, &emitted.certificate)?;
        // -I: no module of the user's takes the place of one of Python's.
        let mut command = Command::new("python3");
        command.arg("-I").arg(&program).arg(&certificate);
        command.stdin(Stdio::null()).output()
    };
    match run() {
        Err(error) => ClaimOutcome::NotRun(format!("python3 is not installed: {error}")),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            match output.status.code() {
                Some(0) => ClaimOutcome::Proved(said),
                Some(1) if !said.is_empty() => ClaimOutcome::Failed(said),
                _ => ClaimOutcome::NotRun(format!("python3 cannot run it: {said}")),
            }
        }
    }
}
