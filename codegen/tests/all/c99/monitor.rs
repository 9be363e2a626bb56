//! The monitor of the C, with the wheel speed that a firmware hands to it.

use std::process::Command;

use codegen::{EmissionOptions, EmittedCrate, MonitorSpec, generate_with};

use super::harnesses::{compile, rust_harness, written};
use super::{answers, difference};
use crate::{benches, thesis};

/// Whether the crate has a monitor.
pub fn has_monitor(emitted: &EmittedCrate) -> bool {
    emitted.file("src/monitor.rs").is_some()
}

/// What is other in the harnesses with a monitor: after each step it is asked, and what it says stands above the duty.
/// FIELD stands for the field of the wheel's sensor.
pub const IN_C: [(&str, &str); 2] = [
    (
        "uint8_t what;",
        "uint8_t what;\n    flywheel_monitor_t monitor;\n    flywheel_monitor_init(&monitor);",
    ),
    (
        "answer[2] = flywheel_angle(&controller.attitude);",
        "answer[2] = flywheel_angle(&controller.attitude);
        if (what == 4 || what == 5) {
            const uint8_t is_running = answer[1] == FLYWHEEL_RUNNING;
            const uint8_t allows = flywheel_monitor_allows(
                &monitor, is_running, answer[2], flywheel_rate(&controller.attitude),
                flywheel_wheel_speed(sample.FIELD), (uint16_t)answer[0]);
            answer[0] |= (int32_t)allows * INT32_C(0x10000);
        }",
    ),
];
pub const IN_RUST: [(&str, &str); 2] = [
    (
        "let mut bytes = ",
        "let mut monitor = generated::Monitor::new();\n    let mut bytes = ",
    ),
    (
        "let [w, x, y, z] = attitude",
        "let is_running = controller.status() == generated::Status::Running;
        let first: i32 = match bytes[0] {
            4 | 5 => {
                let (angle, rate) = (attitude.angle(), attitude.rate());
                let speed = wheel_speed(sample.FIELD);
                let duty = generated::Duty(first as u16);
                first | i32::from(monitor.allows(is_running, angle, rate, speed, duty)) << 16
            }
            _ => first,
        };
        let [w, x, y, z] = attitude",
    ),
];

/// Controller and monitor side by side, as a firmware runs them, for each sensor of the wheel.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn c_and_rust_watch_alike() {
    let options = EmissionOptions {
        monitor: Some(MonitorSpec {
            noise_std: [1e-3, 4e-3, 0.6],
        }),
        ..EmissionOptions::default()
    };
    let specs = [
        thesis::spec(),
        benches::with_driver(),
        benches::with_wheel_encoder(8),
    ];
    for (seed, spec) in (40..).zip(specs) {
        let emitted = generate_with(&spec, &options).expect("an emitted crate");
        let folder = tempfile::tempdir().expect("a folder");
        written(&emitted, folder.path());
        compile(folder.path(), "-O2").expect("no warning");
        let calls = 100_000;
        let rust = answers(&mut rust_harness(&emitted, folder.path()), seed, calls);
        assert_eq!(rust.len(), calls, "the harness in Rust has ended");
        let mut harness = Command::new(folder.path().join("harness"));
        let c = answers(&mut harness, seed, calls);
        assert_eq!(difference(&c, &rust), None, "seed {seed}");
        let running = || rust.iter().filter(|answer| answer[1] == 2);
        let allowed = running().filter(|answer| answer[0] >> 16 == 1).count();
        let refused = running().count() - allowed;
        assert!(
            allowed > 100 && refused > 100,
            "seed {seed}: {allowed} allowed, {refused} refused"
        );
    }
}
