//! A wheel whose angle was logged in place of its speed.

use std::f64::consts::TAU;
use std::fs;

use bench_files::Bench;
use identify::{Output, Record};

/// The angle is the encoder's, also where a log begins; the speed that is computed from it has the noise that its
/// rounding makes of it, whatever the wheel has turned.
#[test]
fn an_encoder_gives_the_angle_and_the_noise_of_the_speed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (step_rad, interval_s) = (TAU / 4096.0, 0.005);
    let mut text = "time_s,wheel_angle_rad,current_A\n".to_owned();
    for k in 0..1200 {
        let time_s = interval_s * f64::from(k);
        let angle_rad = 2.0 + 5.0 * time_s + 4.0 * time_s * time_s;
        let counts = (angle_rad / step_rad).round();
        text.push_str(&format!("{time_s:.3},{:.6},0.1\n", counts * step_rad % TAU));
    }
    fs::write(folder.path().join("log.csv"), text).expect("written");
    let toml = "[[experiment]]\nname = \"a\"\nkind = \"spin-up\"\nfile = \"log.csv\"\n";
    fs::write(folder.path().join("bench.toml"), toml).expect("written");
    let bench = Bench::load(folder.path()).expect("a bench");
    let record = Record::from_experiment(&bench.experiments[0]);

    let angles_rad = record.wheel_angles();
    assert!((angles_rad[0] - 2.0).abs() < step_rad);
    let last_s = record.time_s[angles_rad.len() - 1];
    let turned_rad = 2.0 + 5.0 * last_s + 4.0 * last_s * last_s;
    assert!((angles_rad[angles_rad.len() - 1] - turned_rad).abs() < step_rad);
    let angle_noise_rad = record.wheel_angle_noise_rad().expect("measured");
    let rounding_rad = step_rad / 12f64.sqrt();
    assert!((angle_noise_rad / rounding_rad - 1.0).abs() < 0.1);
    let speed = record.channel(Output::WheelSpeed).expect("a speed");
    let expected = rounding_rad * 2f64.sqrt() / (2.0 * interval_s);
    assert!((speed.noise_std / expected - 1.0).abs() < 0.1);
}
