//! From bench to bench: the firmware's loop, compiled with an emitted module, around a simulated
//! pendulum at the other end of a pseudo-terminal. The program records it, identifies, diagnoses,
//! designs and generates; the firmware is compiled with the new module, which then balances.

mod arduino;
mod c_loop;
mod firmware;
mod hand;
mod line;
mod pivot;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hand::{Scene, Truth};
use line::{Faults, SimulatedBench};

/// The knowledge of a person before anything is recorded: data sheets and a balance.
const BENCH: &str = r#"# A bench on the table.
[bench]
name = "on the table"

[known]                 # weighed and measured
gravity        = 9.81
torque_constant = 0.0335
gravity_torque = 0.2451580

[hardware.gyroscope]
part = "FXAS21002"
axes = ["x", "y", "z"]

[hardware.accelerometer]
part = "FXOS8700"
axes = ["x", "y", "z"]

[hardware.wheel_speed]
kind = "converter"      # ADS1015 at the drive's speed output
slope = 0.893372608506227
offset = -690.5744251365963
low = 0
high = 1546

[hardware.angle]
kind = "inertial"

[hardware.drive]
part = "ESCON 24/2"
kind = "current"
amperes_per_count = 8.392462043183033e-05
"#;

fn flywheel(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Runs the program; it must succeed. Its text.
fn done(arguments: &[&str]) -> String {
    let output = flywheel(arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{arguments:?}\n{text}\n{message}"
    );
    text
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let mut all = arguments.to_vec();
    all.extend(["--json", "-"]);
    serde_json::from_str(&done(&all)).expect("JSON")
}

fn parameter(report: &serde_json::Value, name: &str) -> (f64, f64) {
    let parameters = report["parameters"].as_array().expect("parameters");
    let found = parameters
        .iter()
        .find(|one| one["name"] == name)
        .unwrap_or_else(|| panic!("no {name}"));
    (
        found["value"].as_f64().expect("a value"),
        found["std"].as_f64().expect("an error"),
    )
}

/// The folder of a bench that has no log yet.
fn bench_folder() -> tempfile::TempDir {
    folder_with(BENCH)
}

/// The same with this bench.toml.
fn folder_with(bench: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("bench.toml"), bench).expect("written");
    folder
}

fn recorded(bench: &Path, on: &SimulatedBench, more: &[&str]) -> serde_json::Value {
    let bench = bench.to_str().expect("a path");
    let port = on.port();
    let mut arguments = vec!["record", bench, "--port", &port];
    arguments.extend(more);
    json(&arguments)
}

#[test]
fn what_is_recorded_becomes_the_controller_that_balances() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let first = firmware::compiled(&root.join("generated"), "first", "");
    from_bench_to_bench(&first, |model, out| {
        let [model, place] = [model, out].map(|path| path.to_str().expect("a path"));
        done(&["generate", model, "--out", place]);
        firmware::compiled(out, "second", "")
    });
}

/// The whole way, from a program that runs the thesis' controller; `again` makes one that runs the controller of a model, in
/// a folder.
fn from_bench_to_bench(first: &Path, again: impl Fn(&Path, &Path) -> PathBuf) {
    let folder = bench_folder();
    let bench = folder.path();
    let place = bench.to_str().expect("a path");
    let truth = Truth::with_dry_friction();
    // One frame in a hundred is damaged, one in two hundred lost.
    let faults = Faults {
        damaged: 0.01,
        lost: 0.005,
        cut: 0.0,
        seed: 20_261_129,
    };
    let on = SimulatedBench::start(first, &truth, faults);
    println!("seed {}", faults.seed);

    on.scene(Scene::Swing { from_rad: 0.6 });
    let thinned = ["--every", "10"];
    let log = recorded(
        bench,
        &on,
        &[
            &[
                "--experiment",
                "free-swing",
                "--seconds",
                "30",
                "--name",
                "free swing 34 deg",
            ][..],
            &thinned,
        ]
        .concat(),
    );
    let swing = &log["logs"][0];
    let rows = swing["rows"].as_f64().expect("rows");
    let lost = swing["lost_frames"].as_f64().expect("lost");
    // 30 s at 100 frames a second. Of them 1.5 % do not arrive: binomial, within five standard errors.
    assert!((rows + lost - 3001.0).abs() <= 3.0, "{swing}");
    let expected = 0.015 * 3000.0;
    assert!(
        (lost - expected).abs() < 5.0 * f64::sqrt(expected),
        "{swing}"
    );
    assert!(swing["from_s"].as_f64().expect("a beginning") > 1.0);

    on.scene(Scene::Swing { from_rad: 0.25 });
    recorded(
        bench,
        &on,
        &[
            &[
                "--experiment",
                "free-swing",
                "--seconds",
                "20",
                "--name",
                "free swing 14 deg",
            ][..],
            &thinned,
        ]
        .concat(),
    );
    on.scene(Scene::Clamped);
    let spin_ups = recorded(
        bench,
        &on,
        &[
            &[
                "--experiment",
                "spin-up",
                "--current",
                "0.2,0.4,-0.4",
                "--seconds",
                "5",
            ][..],
            &thinned,
        ]
        .concat(),
    );
    assert_eq!(
        spin_ups["logs"].as_array().map(Vec::len),
        Some(3),
        "{spin_ups}"
    );
    recorded(
        bench,
        &on,
        &[
            &[
                "--experiment",
                "coast-down",
                "--current",
                "0.4",
                "--seconds",
                "15",
            ][..],
            &thinned,
        ]
        .concat(),
    );
    on.scene(Scene::Upright { from_rad: 0.05 });
    let balance = recorded(bench, &on, &["--experiment", "balance", "--seconds", "5"]);
    assert_eq!(balance["logs"][0]["end"], "complete", "{balance}");
    drop(on);

    // The file keeps its comments and has six entries more.
    let text = fs::read_to_string(bench.join("bench.toml")).expect("bench.toml");
    assert!(text.starts_with(BENCH), "{text}");
    assert_eq!(text.matches("[[experiment]]").count(), 7);

    // The base model lacks the dry friction of the pivot; the diagnosis finds it.
    let base = json(&["identify", place]);
    println!("base model: {}", base["fit_percent"]);
    let diagnosis = json(&["diagnose", place, "--apply"]);
    println!("{}", diagnosis["verdict"]);
    let steps = diagnosis["steps"].to_string();
    assert!(steps.contains("body-coulomb-friction"), "{steps}");
    let fitted = json(&["compare", place]);
    for (name, value) in [
        ("total_inertia", truth.total_inertia),
        ("wheel_inertia", truth.wheel_inertia),
        ("body_coulomb_torque", truth.body_coulomb_torque),
    ] {
        let (found, std) = parameter(&fitted, name);
        println!("{name}: {found} ± {std}, true {value}");
        // The sensors' delay and the filter's errors are no noise: two per cent beside five standard errors.
        assert!(
            (found - value).abs() < 5.0 * std + 0.02 * value,
            "{name}: {found} ± {std}"
        );
    }

    // The controller of the identified model, compiled into the firmware, on the same bench.
    let model = bench.join("model.toml");
    done(&["design", model.to_str().expect("a path")]);
    let out = bench.join("controller");
    let second = again(&model, &out);
    let on = SimulatedBench::start(&second, &truth, Faults::NONE);
    on.scene(Scene::Upright { from_rad: 0.08 });
    let balance = recorded(
        bench,
        &on,
        &[
            "--experiment",
            "balance",
            "--seconds",
            "8",
            "--module",
            out.to_str().expect("a path"),
        ],
    );
    let log = &balance["logs"][0];
    assert_eq!(log["end"], "complete", "{balance}");
    assert_eq!(log["lost_frames"], 0, "{balance}");
    // The body stands upright: in the last second within 2°, which dry friction and the accelerometer's noise explain,
    // and with a wheel speed far from the end of its range.
    let text = fs::read_to_string(log["file"].as_str().expect("a file")).expect("the log");
    let last: Vec<[f64; 2]> = text
        .lines()
        .skip(7_000)
        .map(|line| {
            let cells: Vec<f64> = line
                .split(',')
                .filter_map(|cell| cell.parse().ok())
                .collect();
            [cells[1] - std::f64::consts::PI, cells[3]]
        })
        .collect();
    assert!(last.len() > 500);
    assert!(
        last.iter()
            .all(|[angle, wheel]| angle.abs() < 0.035 && wheel.abs() < 300.0)
    );
}

#[test]
fn a_controller_that_trips_ends_the_record_and_what_was_recorded_stays() {
    let folder = bench_folder();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let module = firmware::compiled(&root.join("generated"), "tripping", "");
    let on = SimulatedBench::start(&module, &Truth::with_dry_friction(), Faults::NONE);
    // The clamped body does not move, so the law's current stays at its limit, or the wheel runs away.
    on.scene(Scene::BusFailsAfter { seconds: 2.0 });
    let record = recorded(
        folder.path(),
        &on,
        &[
            "--experiment",
            "spin-up",
            "--current",
            "0.1",
            "--seconds",
            "5",
        ],
    );
    let log = &record["logs"][0];
    assert_eq!(log["end"], serde_json::json!({"not-running": 9}), "{log}");
    assert!(log["rows"].as_u64().expect("rows") > 1_000, "{log}");
    assert!(Path::new(log["file"].as_str().expect("a file")).is_file());
    // The next record begins anew, by itself.
    on.scene(Scene::Clamped);
    let record = recorded(folder.path(), &on, &["--experiment", "current-step"]);
    assert_eq!(record["logs"][0]["end"], "complete", "{record}");
    let text = fs::read_to_string(folder.path().join("bench.toml")).expect("bench.toml");
    assert!(
        text.contains("[bring_up]\ncurrent_step = \"current-step.csv\""),
        "{text}"
    );
}

#[test]
fn what_cannot_be_recorded_is_one_message() {
    let folder = bench_folder();
    let bench = folder.path().to_str().expect("a path");
    let refused = |arguments: &[&str], words: &str| {
        let output = flywheel(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let errors: Vec<&str> = message
            .lines()
            .filter(|line| line.starts_with("error: "))
            .collect();
        assert_eq!(errors.len(), 1, "{message}");
        assert!(errors[0].contains(words), "{message}");
    };
    let nowhere = folder.path().join("no-such-device");
    let port = nowhere.to_str().expect("a path");
    let record = |more: &[&'static str]| [&["record", bench, "--port", port][..], more].concat();
    refused(
        &record(&["--experiment", "hanging"]),
        "no-such-device: cannot be opened",
    );
    refused(
        &record(&["--experiment", "spin-up", "--current", "50"]),
        "a current of 50 A cannot be driven; state a current within ±2.2 A",
    );
    refused(
        &record(&["--experiment", "free-swing", "--current", "0.1"]),
        "free-swing takes no current",
    );
    refused(
        &record(&["--experiment", "free-swing", "--seconds", "-1"]),
        "state a length in s greater than zero",
    );
    let text = fs::read_to_string(folder.path().join("bench.toml")).expect("bench.toml");
    assert_eq!(text, BENCH);
}
