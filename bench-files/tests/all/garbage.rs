//! Arbitrary bytes in every file: an error or a result, never a panic, never memory out of
//! proportion.

use std::path::Path;

use bench_files::{Bench, CalibrationRecordings, ModelFile};
use proptest::prelude::*;

use crate::common::{Folder, one};

/// A healthy bench.toml with everything in it.
const BENCH: &str = r#"
[bench]
name = "my bench"
[known]
gravity = 9.81
torque_constant = 0.0335
body_mass = 0.2
[controller]
gains = [-24.267242, -2.129739, -0.02258758]
current_limit = 2.0
sample_time = 0.001
[[experiment]]
name = "one"
kind = "driven"
file = "log.csv"
columns = { time = "t", angle = "pend" }
units = { time = "ms", angle = "deg" }
sign = { angle = -1 }
offset = { angle = 3.14159265 }
constants = { current = 0.6 }
current_meaning = "measured"
from = 0.0
until = 60.0
"#;

const LOG: &str = "t,pend\n0,1.5\n10,2.5\n20,3e-1\n30,2\n40,1\n50,0\n";

const COUNTS: &str = "gx,gy,gz\n1,-2,32767\n4,5,-32768\n";

const MODEL: &str = r#"
[parameters.total_inertia]
value = 2.30344e-3
std = 1.2e-6
unit = "kg m2"
source = "free swing"
[parameters.wheel_inertia]
value = 1.36e-4
std = 1e-7
[correlation]
parameters = ["wheel_inertia", "total_inertia"]
matrix = [[1.0, -0.3], [-0.3, 1.0]]
[effects]
present = ["body-viscous-friction", "body-coulomb-friction"]
[design]
sample_time = 0.001
state_weights = [25.0, 0.5, 5e-4]
current_weight = 1.0
current_limit = 2.0
friction_linearisation_speed = 0.08
[tool.other]
tool = "its own"
[calibration.wheel_speed]
slope = 0.9
slope_std = 1e-5
offset = -690.5
offset_std = 1e-2
[calibration.mounting]
axis = [0.0, 0.0, 1.0]
axis_std_rad = 1e-4
angle = 2.3
angle_std = 1e-3
"#;

/// A healthy text with a few bytes changed, taken out, put in or doubled: reaches far deeper than
/// bytes at random.
fn damaged(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let change = (0..text.len(), 0..5_usize, any::<u8>(), 1..40_usize);
    proptest::collection::vec(change, 1..8).prop_map(move |changes| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, how, byte, length) in changes {
            let at = at.min(bytes.len().saturating_sub(1));
            let end = (at + length).min(bytes.len());
            match how {
                0 if !bytes.is_empty() => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 => drop(bytes.drain(at..end)),
                3 => {
                    let part = bytes[at..end].to_vec();
                    bytes.splice(at..at, part);
                }
                _ => bytes.truncate(at),
            }
        }
        bytes
    })
}

fn any_bytes() -> impl Strategy<Value = Vec<u8>> {
    proptest::collection::vec(any::<u8>(), 0..2000)
}

/// Loads a bench and checks what every loaded bench promises.
fn load(bench: &[u8], log: &[u8]) {
    let folder = Folder::new();
    folder.write("bench.toml", bench);
    folder.write("log.csv", log);
    let result = Bench::load(folder.path());
    match result {
        Err(error) => {
            let message = error.to_string();
            assert!(
                message.contains("bench.toml") || message.contains("log.csv"),
                "{message}"
            );
            assert!(!message.contains(char::is_control), "{message:?}");
            assert!(message.len() < 8000, "{} characters", message.len());
        }
        Ok(bench) => {
            for experiment in &bench.experiments {
                let log = &experiment.log;
                assert!(log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
                assert!(log.time_s.iter().all(|t| t.is_finite()));
                for channel in bench_files::Channel::ALL {
                    if let Some(samples) = log.channel(channel) {
                        assert_eq!(samples.len(), log.len());
                    }
                }
                if let Some(current) = &log.current_a {
                    assert!(current.iter().all(|i| i.is_finite()));
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_bench(bytes in damaged(BENCH)) {
        load(&bytes, LOG.as_bytes());
    }

    #[test]
    fn a_damaged_log(bytes in damaged(LOG)) {
        load(BENCH.as_bytes(), &bytes);
    }

    #[test]
    fn bytes_for_a_bench(bytes in any_bytes()) {
        load(&bytes, LOG.as_bytes());
    }

    #[test]
    fn bytes_for_a_log(bytes in any_bytes()) {
        load(BENCH.as_bytes(), &bytes);
    }

    #[test]
    fn numbers_for_a_log(rows in proptest::collection::vec((any::<f64>(), any::<f64>()), 0..60)) {
        let mut rows = rows;
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut log = "time_s,angle_rad\n".to_string();
        for (time, angle) in rows {
            log.push_str(&format!("{time:e},{angle:e}\n"));
        }
        load(one("free-swing", "").as_bytes(), log.as_bytes());
    }

    #[test]
    fn damaged_recordings(bytes in damaged(crate::calibration::TOML), counts in damaged(COUNTS)) {
        for (toml, still) in [(&bytes[..], COUNTS.as_bytes()), (crate::calibration::TOML.as_bytes(), &counts[..])] {
            let folder = crate::calibration::folder("");
            folder.write("bench.toml", toml);
            folder.write("still.csv", still);
            if let Err(error) = CalibrationRecordings::load(folder.path()) {
                assert!(!error.to_string().contains(char::is_control), "{error:?}");
            }
        }
    }

    #[test]
    fn a_damaged_model(bytes in damaged(MODEL)) {
        check_model(&bytes);
    }

    #[test]
    fn bytes_for_a_model(bytes in any_bytes()) {
        check_model(&bytes);
    }
}

/// A model that parses is written so that it reads back equal.
fn check_model(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        let folder = Folder::new();
        let path = folder.write("model.toml", bytes);
        assert!(ModelFile::read(&path).is_err());
        return;
    };
    let path = Path::new("model.toml");
    match ModelFile::parse(text, path) {
        Err(error) => assert!(!error.to_string().contains(char::is_control), "{error}"),
        Ok(model) => {
            let written = model.to_toml();
            let again = ModelFile::parse(&written, path)
                .unwrap_or_else(|error| panic!("{error}\nin\n{written}"));
            assert_eq!(model, again, "{written}");
        }
    }
}

/// Nesting as deep as a file can hold must not exhaust the stack.
#[test]
fn deep_nesting() {
    for open in ["[", "{a=", "a.", "[[a."] {
        for prefix in ["x = ", ""] {
            let text = prefix.to_string() + &open.repeat(200_000);
            assert!(ModelFile::parse(&text, Path::new("model.toml")).is_err());
        }
    }
}

#[test]
fn the_healthy_ones_are_healthy() {
    let folder = Folder::bench(BENCH, LOG);
    if let Err(error) = Bench::load(folder.path()) {
        panic!("{error}");
    }
    if let Err(error) = ModelFile::parse(MODEL, Path::new("model.toml")) {
        panic!("{error}");
    }
}
