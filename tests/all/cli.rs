//! The command line from outside: what a user types, sees and finds on disk.

#[path = "cli/made_bench.rs"]
mod bench;
#[path = "cli/calibrate.rs"]
mod calibrate;
#[path = "cli/chain.rs"]
mod chain;
#[path = "cli/data.rs"]
mod data;
#[path = "cli/demo.rs"]
mod demo;
#[path = "cli/design.rs"]
mod design;
#[path = "cli/diagnose.rs"]
mod diagnose;
#[path = "cli/long_work.rs"]
mod long_work;
#[path = "cli/prove.rs"]
mod prove;
#[path = "cli/thesis.rs"]
mod thesis;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn flywheel<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs a command that must succeed and returns its text.
fn done<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> String {
    let output = flywheel(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_only_progress(&stderr(&output));
    stdout(&output)
}

/// Nothing on standard error but what long work says on its way: "fitting … (3 s)".
fn assert_only_progress(errors: &str) {
    for line in errors.lines() {
        assert!(line.ends_with(" s)"), "on standard error: {errors}");
    }
}

fn json_of<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Value {
    serde_json::from_str(&done(arguments)).expect("JSON on standard output")
}

/// Runs a command that must refuse its input: exit code 2, one message that holds all parts.
fn refused<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>, parts: &[&str]) {
    let output = flywheel(arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(stdout(&output), "", "nothing on standard output");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

fn parameter(json: &Value, name: &str) -> (f64, Option<f64>) {
    let list = json["parameters"].as_array().expect("parameters");
    let found = list
        .iter()
        .find(|parameter| parameter["name"] == name)
        .unwrap_or_else(|| panic!("no {name} in {list:?}"));
    (
        found["value"].as_f64().expect("a value"),
        found["std"].as_f64(),
    )
}

/// Every file below a folder with its bytes.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).expect("list") {
        let path = entry.expect("entry").path();
        if path.is_dir() {
            all.extend(contents(&path));
        } else {
            let bytes = fs::read(&path).expect("read");
            all.push((path, bytes));
        }
    }
    all.sort();
    all
}

#[test]
fn bad_input_is_refused_with_one_message() {
    let folder = tempfile::tempdir().expect("folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(
        path("bench.toml"),
        "[[experiment]]\nname = \"one\"\nkind = \"freeswing\"\nfile = \"log.csv\"\n",
    )
    .expect("write");
    let bench = folder.path().display().to_string();
    refused(
        ["identify", &bench],
        &["bench.toml:3:8", "\"freeswing\"", "free-swing"],
    );

    fs::write(
        path("bench.toml"),
        "[[experiment]]\nname = \"one\"\nkind = \"free-swing\"\nfile = \"log.csv\"\n",
    )
    .expect("write");
    fs::write(path("log.csv"), "time_s,angle_rad\n0,0.1\n0.1,NaN\n").expect("write");
    refused(
        ["identify", &bench],
        &["log.csv:3", "angle_rad", "not a finite number"],
    );
    refused(["compare", &bench], &["log.csv:3"]);
    assert!(
        !folder.path().join("model.toml").exists(),
        "nothing is written"
    );

    let swing: String = (0..200)
        .map(|i| {
            format!(
                "{},{}\n",
                0.01 * f64::from(i),
                0.3 * (0.1 * f64::from(i)).cos()
            )
        })
        .collect();
    fs::write(path("log.csv"), format!("time_s,angle_rad\n{swing}")).expect("write");
    refused(
        ["compare", &bench],
        &["model.toml", "no model yet", "flywheel identify"],
    );
    refused(
        ["remove", "angle-offset", "--bench", &bench],
        &["model.toml", "no model yet"],
    );
    refused(
        ["identify", &path("nowhere")],
        &["nowhere", "no such bench"],
    );
    refused(
        ["lab", "--no-open", &path("nowhere")],
        &["nowhere", "bench"],
    );
    refused(
        ["design", &path("nowhere.toml")],
        &["nowhere.toml", "no such file"],
    );
    refused(
        ["generate", &path("bench.toml"), "--out", &path("out")],
        &["bench.toml:1:", "unknown key"],
    );
    refused(
        ["add", "body-coulomb-fricton", "--bench", &bench],
        &["body-coulomb-fricton", "body-coulomb-friction"],
    );
    refused(["identify"], &["<BENCH>"]);
    refused(["identfy", &bench], &["identfy", "identify"]);
    refused(
        ["identify", &bench, "--model", &path("log.csv/model.toml")],
        &["log.csv/model.toml", "cannot be read", "directory"],
    );
    assert!(!folder.path().join("out").exists(), "nothing is written");

    // A design that the numbers do not allow names the file and the cure.
    let thesis = fs::read_to_string(models().join("thesis-4.4.toml")).expect("thesis");
    let cases = [
        (
            "sample_time = 0.001",
            "sample_time = 0.5",
            "0.5 s is too long",
        ),
        ("value = 2.30344e-3", "value = 1.0e-4", "inertia"),
        (
            "current_limit = 2.0",
            "current_limit = 3.0",
            "current limit 3 A",
        ),
    ];
    for (from, to, part) in cases {
        fs::write(path("other.toml"), thesis.replace(from, to)).expect("write");
        refused(
            ["generate", &path("other.toml"), "--out", &path("out")],
            &["other.toml", part],
        );
    }
    assert!(!folder.path().join("out").exists(), "nothing is written");
}

/// JSON to a file leaves the text on standard output, and the two say the same.
#[test]
fn json_to_a_file() {
    let folder = tempfile::tempdir().expect("folder");
    let json = folder.path().join("design.json");
    let text = done([
        "design".as_ref(),
        models().join("thesis-3.5.3.toml").as_os_str(),
        "--out".as_ref(),
        folder.path().as_os_str(),
        "--json".as_ref(),
        json.as_os_str(),
    ]);
    assert!(text.starts_with("thesis-3.5.3: "), "{text}");
    let json: Value =
        serde_json::from_str(&fs::read_to_string(json).expect("written")).expect("JSON");
    for key in [
        "A",
        "B",
        "Ad",
        "Bd",
        "gains",
        "open_loop_poles",
        "closed_loop_poles",
        "controllability_rank",
        "observability_rank",
        "recovery_angle_rad",
        "dare_residual",
    ] {
        assert!(!json[key].is_null(), "{key}");
    }
}

#[test]
fn help_names_every_command() {
    let text = done(["--help"]);
    for command in [
        "identify",
        "compare",
        "add",
        "remove",
        "calibrate",
        "design",
        "simulate",
        "generate",
    ] {
        assert!(text.contains(command), "{command}");
        assert!(done([command, "--help"]).contains("--json"), "{command}");
    }
}
