//! The same way with an encoder on the pivot in place of gyroscope and accelerometer, over a line that loses bytes, flips
//! bits, cuts frames in half, and is unplugged.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::hand::{Scene, Truth};
use super::line::{Faults, SimulatedBench, UPRIGHT_COUNT};
use super::{BENCH, done, firmware, folder_with, json, parameter, recorded};

/// A count of the encoder, rad.
const COUNT_RAD: f64 = TAU / 4096.0;

/// A text with an AS5600 on the pivot in place of the inertial sensors.
fn with_encoder(text: &str) -> String {
    let mut kept = String::new();
    let mut is_dropped = false;
    for line in text.lines() {
        if line.starts_with('[') {
            let inertial = ["gyroscope", "accelerometer", "magnetometer", "angle"];
            is_dropped = inertial
                .map(|name| format!("[hardware.{name}]"))
                .contains(&line.to_owned());
        }
        if !is_dropped {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    format!(
        "{kept}\n[hardware.angle]\nkind = \"encoder\"\npart = \"AS5600\"\nzero = {UPRIGHT_COUNT}\n"
    )
}

/// The firmware with the thesis' controller for an encoder on the pivot: compiled once for all tests.
fn compiled() -> &'static PathBuf {
    static PROGRAM: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, program) = PROGRAM.get_or_init(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = tempfile::tempdir().expect("a folder");
        let thesis = fs::read_to_string(root.join("models/thesis-4.4.toml")).expect("a model");
        let model = folder.path().join("model.toml");
        fs::write(&model, with_encoder(&thesis)).expect("written");
        let out = folder.path().join("module");
        let [model, place] = [&model, &out].map(|path| path.to_str().expect("a path"));
        done(&["generate", model, "--out", place]);
        let program = firmware::compiled(&out, "pivot", "pivot-encoder");
        (folder, program)
    });
    program
}

/// The folder of a bench with the encoder that has no log yet.
pub fn folder() -> tempfile::TempDir {
    folder_with(&with_encoder(BENCH))
}

/// The numbers of a log, row by row.
fn rows(log: &serde_json::Value) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(log["file"].as_str().expect("a file")).expect("the log");
    let cells = |line: &str| line.split(',').map(|cell| cell.parse().ok()).collect();
    text.lines().filter_map(cells).collect()
}

/// More frames than the counter of 16 bits has numbers: no row is lost or doubled where it begins again, and what the line
/// damaged is counted. The log identifies the body.
#[test]
fn a_long_swing_over_a_bad_line_is_whole() {
    let folder = folder();
    let faults = Faults {
        damaged: 0.004,
        lost: 0.003,
        cut: 0.002,
        seed: 20_261_130,
    };
    println!("seed {}", faults.seed);
    let truth = Truth::with_dry_friction();
    let on = SimulatedBench::start(compiled(), &truth, faults);
    on.scene(Scene::Swing { from_rad: 0.6 });
    let swing = ["--experiment", "free-swing", "--seconds", "70"];
    let record = recorded(folder.path(), &on, &swing);
    drop(on);
    let log = &record["logs"][0];
    assert_eq!(log["end"], "complete", "{log}");
    let lost = log["lost_frames"].as_f64().expect("lost");
    let rows = rows(log);
    assert!(rows.len() > 65_536, "{log}");
    // 70 s at 1000 frames a second.
    assert!((rows.len() as f64 + lost - 70_001.0).abs() <= 3.0, "{log}");
    // A frame that is cut takes the next one with it. Five standard errors of as many pairs, and what comes together.
    let share = faults.damaged + faults.lost + 2.0 * faults.cut;
    let expected = share * 70_000.0;
    let error = 5.0 * f64::sqrt(2.0 * expected) + share * expected;
    assert!(
        (lost - expected).abs() < error,
        "{lost} lost, {expected} expected"
    );
    // Every row stands at its time, also behind a gap, and no angle is one of a damaged frame: beside the noise
    // of the encoder, a half count at one standard deviation, the body turns by at most
    // the rate at which it passes the lowest point, 0.6 rad times its natural frequency.
    let fastest_rad_s = 0.6 * f64::sqrt(truth.gravity_torque / truth.total_inertia);
    for two in rows.windows(2) {
        let steps = (two[1][0] - two[0][0]) * 1e3;
        assert!(
            steps > 0.5 && (steps - steps.round()).abs() < 1e-6,
            "{two:?}"
        );
        let turn = (two[1][1] - two[0][1]).abs();
        assert!(
            turn <= fastest_rad_s * 1e-3 * steps + 5.0 * COUNT_RAD,
            "{two:?}"
        );
    }
    // It hangs at zero.
    let last = rows.last().expect("rows")[1];
    assert!(last.abs() < PI / 4.0, "{last}");

    let place = folder.path().to_str().expect("a path");
    let fitted = json(&["identify", place]);
    let (found, std) = parameter(&fitted, "total_inertia");
    println!(
        "total inertia: {found} ± {std}, true {}",
        truth.total_inertia
    );
    // The base model has no dry friction, and friction changes the frequency by its damping's square alone.
    assert!(
        (found / truth.total_inertia - 1.0).abs() < 0.02,
        "{found} ± {std}"
    );
}

/// The plug is pulled while the wheel is driven: the record ends and is kept, and the firmware switches the motor off by
/// itself (`line.rs` looks at its duty). Plugged in again, the next record begins by itself.
#[test]
fn a_line_that_is_unplugged_ends_the_record_and_can_be_plugged_in_again() {
    let folder = folder();
    let on = SimulatedBench::start(compiled(), &Truth::with_dry_friction(), Faults::NONE);
    on.scene(Scene::UnpluggedAfter { seconds: 2.0 });
    let spin_up = [
        "--experiment",
        "spin-up",
        "--current",
        "0.1",
        "--seconds",
        "5",
    ];
    let record = recorded(folder.path(), &on, &spin_up);
    let log = &record["logs"][0];
    assert_eq!(log["end"], "silent", "{log}");
    let kept = rows(log).len();
    assert!((1_500..2_100).contains(&kept), "{kept} rows");
    on.scene(Scene::Clamped);
    let record = recorded(folder.path(), &on, &["--experiment", "current-step"]);
    assert_eq!(record["logs"][0]["end"], "complete", "{record}");
}

/// The encoder's controller is armed, balances on the bench with dry friction, and its log has the states that it saw.
#[test]
fn the_controller_for_an_encoder_balances_and_is_recorded() {
    let folder = folder();
    let on = SimulatedBench::start(compiled(), &Truth::with_dry_friction(), Faults::NONE);
    on.scene(Scene::Upright { from_rad: 0.05 });
    let record = recorded(
        folder.path(),
        &on,
        &["--experiment", "balance", "--seconds", "5"],
    );
    let log = &record["logs"][0];
    assert_eq!(log["end"], "complete", "{record}");
    let rows = rows(log);
    // In the last second within 2°, by counts of 0.09°.
    let last = &rows[rows.len() - 1_000..];
    assert!(
        last.iter().all(|row| (row[1] - PI).abs() < 0.035),
        "{:?}",
        last.last()
    );
    for row in last {
        let counts = (row[1] - PI) / COUNT_RAD;
        assert!((counts - counts.round()).abs() < 1e-3, "{row:?}");
    }
}
