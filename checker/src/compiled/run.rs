//! Builds and runs the crate in an empty folder, with a manifest of the checker.
//!
//! The surroundings have no influence, see [`crate::compiled::surroundings`]; the folder is a workspace of its own.

use std::fs;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::compiled::harness::{CRATE, Harness};
use crate::compiled::points::Point;
use crate::compiled::surroundings::{cargo, in_the_way};
use crate::language::emitted::Emitted;

/// The reason why there is no comparison, or its negative result.
#[derive(Debug)]
pub enum RunFailure {
    /// A required tool is missing, or a step took longer than is waited for.
    NotRun(String),
    /// The crate does not compile, or computes other words.
    Differs(String),
}

/// Time limit of each build, and of the run.
const PATIENCE: Duration = Duration::from_secs(300);
/// Time between two looks whether a command has ended.
const POLL: Duration = Duration::from_millis(20);

/// Compiles the sources and compares every point; returns their number.
///
/// # Errors
/// [`RunFailure`].
pub fn compare(
    emitted: &Emitted,
    fixed_version: &str,
    harness: &Harness,
    points: &[Point],
    name_of: impl Fn(usize) -> String,
) -> Result<usize, RunFailure> {
    let not_run = |what: &str| {
        let what = what.to_owned();
        move |error: io::Error| RunFailure::NotRun(format!("{what}: {error}"))
    };
    let folder = tempfile::tempdir().map_err(not_run("a temporary folder"))?;
    let root = folder.path();
    if let Some(path) = in_the_way(root) {
        return Err(RunFailure::NotRun(format!(
            "{path} would count for a build in {}",
            root.display()
        )));
    }
    write_crate(root, emitted, harness).map_err(not_run("writing the crate"))?;
    build(root, fixed_version)?;

    let mut input = String::new();
    for point in points {
        input.push_str(&point.call.to_string());
        for word in &point.arguments {
            input.push(' ');
            input.push_str(&word.to_string());
        }
        input.push('\n');
    }
    let (given, found) = (root.join("points"), root.join("words"));
    fs::write(&given, input).map_err(not_run("writing the points"))?;
    let files = fs::File::open(&given)
        .and_then(|given| Ok((given, fs::File::create(&found)?)))
        .map_err(not_run("the points"))?;
    let program = root.join("target/debug/run");
    let mut command = Command::new(program);
    command.stdin(files.0).stdout(files.1).stderr(Stdio::null());
    if !finished(command, "the run of the compiled crate", PATIENCE)? {
        return Err(RunFailure::Differs(
            "the compiled crate ended before all points were computed".to_owned(),
        ));
    }
    let text = fs::read_to_string(&found).map_err(not_run("reading the words"))?;
    let mut lines = text.lines();
    for point in points {
        let words = lines.next().unwrap_or("nothing");
        let expected: Vec<String> = point.expected.iter().map(ToString::to_string).collect();
        if words != expected.join(" ") {
            return Err(RunFailure::Differs(format!(
                "{} of {:?} is {words} as compiled, {} as read",
                name_of(point.call),
                point.arguments,
                expected.join(" ")
            )));
        }
    }
    Ok(points.len())
}

fn write_crate(root: &Path, emitted: &Emitted, harness: &Harness) -> io::Result<()> {
    fs::write(root.join("run.rs"), &harness.text)?;
    fs::create_dir(root.join("src"))?;
    for (path, text) in &emitted.sources {
        fs::write(root.join(path), text)?;
    }
    Ok(())
}

/// The manifest. From version 2.7 on, `half` needs a procedural macro and `syn`, which take more time to build than all
/// the rest; `fixed` is content with an older version, which need not be on this machine.
fn write_manifest(root: &Path, fixed_version: &str, with_older_half: bool) -> io::Result<()> {
    let half = if with_older_half {
        "half = { version = \">=2.4, <2.7\", default-features = false }\n"
    } else {
        ""
    };
    let manifest = format!(
        "[package]\nname = \"{CRATE}\"\nversion = \"0.0.0\"\nedition = \"2024\"\npublish = false\n\
         autobins = false\nautoexamples = false\nautotests = false\nautobenches = false\nbuild = false\n\n\
         [lib]\npath = \"src/lib.rs\"\n\n[[bin]]\nname = \"run\"\npath = \"run.rs\"\n\n\
         [dependencies]\nfixed = {{ version = \"{fixed_version}\", default-features = false }}\n{half}\n\
         [profile.dev]\noverflow-checks = true\ndebug = false\nincremental = false\n\n[workspace]\n"
    );
    fs::write(root.join("Cargo.toml"), manifest)
}

/// Builds `fixed` alone first: if it is missing, that is not a fault of the emitted crate.
fn build(root: &Path, fixed_version: &str) -> Result<(), RunFailure> {
    let log = root.join("log");
    let run = |arguments: &[&str], what: &str| -> Result<bool, RunFailure> {
        let file = fs::File::create(&log)
            .map_err(|error| RunFailure::NotRun(format!("{}: {error}", log.display())))?;
        let mut command = cargo(root);
        command
            .args(arguments)
            .args(["--offline", "--quiet", "--color", "never"])
            .stdout(Stdio::null())
            .stderr(file);
        finished(command, what, PATIENCE)
    };
    let said = || {
        let text = fs::read_to_string(&log).unwrap_or_default();
        let first = text.lines().find(|line| line.starts_with("error"));
        first.unwrap_or("no reason given").to_owned()
    };
    let mut is_built = false;
    for with_older_half in [true, false] {
        write_manifest(root, fixed_version, with_older_half).map_err(|error| {
            RunFailure::NotRun(format!("writing the crate's manifest: {error}"))
        })?;
        is_built = run(
            &["build", "--package", "fixed"],
            "the build of the crate `fixed`",
        )?;
        if is_built {
            break;
        }
    }
    if !is_built {
        return Err(RunFailure::NotRun(format!(
            "the crate `fixed` does not build offline: {}",
            said()
        )));
    }
    if !run(&["build"], "the build of the emitted crate")? {
        return Err(RunFailure::Differs(format!(
            "rustc does not compile it: {}",
            said()
        )));
    }
    Ok(())
}

/// Runs a command to its end; returns whether it succeeded. `what` is its name in a reason.
///
/// # Errors
/// [`RunFailure::NotRun`] if it cannot be started, or takes longer than `patience`; it is then ended.
fn finished(mut command: Command, what: &str, patience: Duration) -> Result<bool, RunFailure> {
    let not_run = |why: String| RunFailure::NotRun(format!("{what} {why}"));
    let mut child = command.spawn().map_err(|error| {
        let program = command.get_program().to_string_lossy().into_owned();
        not_run(match error.kind() {
            io::ErrorKind::NotFound => format!("needs {program}, which is not installed"),
            _ => format!("could not start {program}: {error}"),
        })
    })?;
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(status.success()),
            Ok(None) if start.elapsed() <= patience => thread::sleep(POLL),
            Ok(None) => {
                // It may have ended by itself in between; the time is over all the same.
                let _ = child.kill();
                let _ = child.wait();
                return Err(not_run(format!(
                    "took longer than {} s, the time that is allowed",
                    patience.as_secs()
                )));
            }
            Err(error) => return Err(not_run(format!("could not be watched: {error}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reason(found: Result<bool, RunFailure>) -> String {
        match found {
            Err(RunFailure::NotRun(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    /// The reason tells a machine that is too slow from one without the tool.
    #[test]
    fn a_run_out_of_time_is_not_a_missing_tool() {
        let mut slow = Command::new("sleep");
        slow.arg("60");
        let slow = reason(finished(slow, "the build", Duration::ZERO));
        assert_eq!(
            slow,
            "the build took longer than 0 s, the time that is allowed"
        );
        let absent = Command::new("no-such-tool");
        let absent = reason(finished(absent, "the build", Duration::ZERO));
        assert_eq!(
            absent,
            "the build needs no-such-tool, which is not installed"
        );
        let mut done = Command::new("sleep");
        done.arg("0");
        assert!(finished(done, "the build", PATIENCE).expect("it ends"));
    }
}
