//! Work that takes a while, fails or is called off: what is said, and that nothing is left behind.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{bench::noise, flywheel, refused, stderr};

fn bench_of(folder: &Path, kind: &str, log: &str) {
    let toml = format!(
        "[bench]\nname = \"one log\"\n\n[known]\ntorque_constant = 0.0335\ngravity_torque = 0.245\n\n\
         [[experiment]]\nname = \"the log\"\nkind = \"{kind}\"\nfile = \"log.csv\"\n\
         accept = [\"current-sign\"]\n"
    );
    fs::write(folder.join("bench.toml"), toml).expect("written");
    fs::write(folder.join("log.csv"), log).expect("written");
}

/// A wheel that gains speed against its current: no inertia and no friction does that. (The check of the data finds
/// it, and is told to accept it.)
fn against_the_current() -> String {
    let mut log = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
    for sample in 0..800 {
        let time_s = 0.005 * sample as f64;
        let speed = -200.0 * (1.0 - (-0.5 * time_s).exp()) + noise(sample);
        writeln!(log, "{time_s:.3},{speed:.3},0.6").expect("memory");
    }
    log
}

#[test]
fn a_failed_fit_is_called_so_and_writes_no_model() {
    let folder = tempfile::tempdir().expect("a folder");
    bench_of(folder.path(), "spin-up", &against_the_current());
    let bench = folder.path().display().to_string();
    for command in ["identify", "diagnose"] {
        refused(
            [command, &bench],
            &["the fit has failed", "the log/wheel_speed", "sign"],
        );
    }
    refused(
        ["add", "wheel-coulomb-friction", "--bench", &bench],
        &["the fit has failed"],
    );
    let left: Vec<_> = fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

/// A swing of many samples, so that reading it takes some seconds in any build.
fn long_log() -> String {
    let mut log = "time_s,angle_rad\n".to_owned();
    for sample in 0..4_000_000 {
        let time_s = 0.001 * f64::from(sample);
        let angle = 0.3 * (10.3 * time_s).sin();
        writeln!(log, "{time_s:.3},{angle:.5}").expect("memory");
    }
    log
}

#[cfg(unix)]
#[test]
fn long_work_says_what_it_does_and_an_interrupt_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    bench_of(folder.path(), "free-swing", &long_log());
    let began = Instant::now();
    let child = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args(["identify", &folder.path().display().to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(Duration::from_millis(1500));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.expect("kill").success());
    let output = child.wait_with_output().expect("it ends");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(
        began.elapsed() < Duration::from_secs(20),
        "{:?}",
        began.elapsed()
    );
    assert!(message.contains(" s)"), "no progress: {message}");
    assert!(message.contains("called off"), "{message}");
    assert!(output.stdout.is_empty());
    let left = fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 2);
}

#[test]
fn what_is_done_at_once_says_nothing_on_the_way() {
    let output = flywheel(["--version"]);
    assert_eq!(stderr(&output), "");
}
