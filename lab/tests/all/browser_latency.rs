//! How quickly the curve follows a hand: measured alone, on an idle machine. Other tests do not depend on time.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::browser::{move_slider, settled};
use crate::running::Running;
use crate::webdriver::Browser;

/// Moves of a slider that are measured.
const MOVES: usize = 100;
/// Bound of 95 % of the moves on the demonstration bench in headless chromium, ms. Beyond a tenth of a second a hand no
/// longer feels that it moves the curve.
const BOUND_MS: f64 = 100.0;

/// Times from the move of a slider to the picture drawn anew, ms, in rising order.
fn moves(folder: &Path, slider: &str) -> Vec<f64> {
    let lab = Running::start(Some(folder));
    let browser = Browser::start(1280, 900);
    browser.go(&lab.once);
    browser.wait_for("document.body.dataset.ready");
    settled(&browser, 1);
    let step = |index: usize| if index % 20 < 10 { 3 } else { -3 };
    let mut times: Vec<f64> = (0..MOVES)
        .map(|index| move_slider(&browser, slider, step(index)))
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

/// A bench of free swings of 100 s at 1 kHz: the linear pendulum with viscous friction, each from another angle, with the
/// steps of an encoder of 4096 lines.
fn long_swings(folder: &Path, count: usize) {
    const ENCODER_STEP_RAD: f64 = std::f64::consts::TAU / 16_384.0;
    let mut bench =
        "[bench]\nname = \"long swings\"\n\n[known]\ngravity_torque = 0.238383\n".to_owned();
    for number in 0..count {
        let amplitude_rad = 0.15 + 0.01 * number as f64;
        let mut log = "time_s,angle_rad\n".to_owned();
        for sample in 0..100_000 {
            let time_s = f64::from(sample) * 1e-3;
            let angle_rad = amplitude_rad * (-0.02 * time_s).exp() * (7.05 * time_s).cos();
            let seen_rad = (angle_rad / ENCODER_STEP_RAD).round() * ENCODER_STEP_RAD;
            let _ = writeln!(log, "{time_s:.3},{seen_rad:.6}");
        }
        fs::write(folder.join(format!("{number}.csv")), log).expect("a log");
        let _ = writeln!(
            bench,
            "\n[[experiment]]\nname = \"swing {number}\"\nkind = \"free-swing\"\nfile = \"{number}.csv\""
        );
    }
    fs::write(folder.join("bench.toml"), bench).expect("a bench");
}

/// The demonstration bench (13 458 samples), one log of 100 000 samples, and ten of them. Only the visible experiment is
/// simulated while the hand moves: ten logs are as quick as one.
#[test]
#[ignore = "run apart: it measures times, on an idle machine: --ignored --nocapture the_curve_follows_the_hand"]
fn the_curve_follows_the_hand() {
    let demonstration = tempfile::tempdir().expect("a folder");
    for (name, text) in demo::FILES {
        fs::write(demonstration.path().join(name), text).expect("a file");
    }
    let [one, ten] = [1, 10].map(|count| {
        let folder = tempfile::tempdir().expect("a folder");
        long_swings(folder.path(), count);
        folder
    });
    let measured = [
        (
            "demonstration bench",
            demonstration.path(),
            "gravity_torque",
        ),
        ("one log of 100 000 samples", one.path(), "total_inertia"),
        ("ten logs of 100 000 samples", ten.path(), "total_inertia"),
    ]
    .map(|(name, folder, slider)| {
        let times = moves(folder, slider);
        let (median, most) = (times[MOVES / 2], times[MOVES * 95 / 100 - 1]);
        println!("{name}: slider to picture: median {median:.0} ms, 95 % {most:.0} ms");
        most
    });
    assert!(measured[0] < BOUND_MS, "{measured:?}");
}
