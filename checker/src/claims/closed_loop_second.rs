//! Claims of the closed loop by the second checkers, small programs in Python that share nothing
//! with this one (`checker/second/`).

use std::fs;
use std::io::{Error, ErrorKind};
use std::process::{Command, Output, Stdio};

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;

/// A program, and the modules that it reads beside itself.
struct Second {
    text: &'static str,
    modules: &'static [(&'static str, &'static str)],
}

/// Of `closed-loop-for-all-time`, with an ellipsoid.
const FOR_ALL_TIME: Second = Second {
    text: include_str!("../../second/closed_loop.py"),
    modules: &[],
};

/// What the two programs about starts at rest share.
const MOTION: &[(&str, &str)] = &[
    ("motion.py", include_str!("../../second/motion.py")),
    ("closing.py", include_str!("../../second/closing.py")),
];

/// Of `loop-as-shipped` and `motion-kept-up`.
const AS_SHIPPED: Second = Second {
    text: include_str!("../../second/loop_as_shipped.py"),
    modules: MOTION,
};

/// Of `closed-loop-for-all-time` and `region-of-attraction` from rest.
const FROM_REST: Second = Second {
    text: include_str!("../../second/loop_from_rest.py"),
    modules: MOTION,
};

/// Settles `closed-loop-for-all-time` by the second checker, if Python is installed.
pub fn by_python(emitted: &Emitted) -> ClaimOutcome {
    run(&FOR_ALL_TIME, emitted)
}

/// Settles `loop-as-shipped` and `motion-kept-up` by the second checker, where Python is.
pub fn as_shipped_by_python(emitted: &Emitted) -> ClaimOutcome {
    run(&AS_SHIPPED, emitted)
}

/// Settles `closed-loop-for-all-time` and `region-of-attraction` from rest by the second checker, where Python is.
pub fn from_rest_by_python(emitted: &Emitted) -> (ClaimOutcome, ClaimOutcome) {
    match run(&FROM_REST, emitted) {
        // A line for each claim.
        ClaimOutcome::Proved(said) => match said.split_once('\n') {
            Some((for_all_time, region)) => (
                ClaimOutcome::Proved(for_all_time.trim().to_owned()),
                ClaimOutcome::Proved(region.trim().to_owned()),
            ),
            None => {
                let odd = ClaimOutcome::NotRun(format!("python3 says in one line: {said}"));
                (odd.clone(), odd)
            }
        },
        other => (other.clone(), other),
    }
}

/// Runs a program on the certificate.
fn run(second: &Second, emitted: &Emitted) -> ClaimOutcome {
    let run = || -> Result<Output, String> {
        let of_files = |error: Error| format!("a temporary folder cannot be written: {error}");
        let folder = tempfile::tempdir().map_err(of_files)?;
        let program = folder.path().join("second.py");
        let certificate = folder.path().join("certificate.json");
        fs::write(&program, second.text).map_err(of_files)?;
        for (name, text) in second.modules {
            fs::write(folder.path().join(name), text).map_err(of_files)?;
        }
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
