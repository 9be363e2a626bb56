//! The monitor: silent for every motion of the model within its uncertainty, and the same in C.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use codegen::helpers::motion::{Motion, MotionLimits, NO_DIFFERENCE, agrees, compared};
use codegen::monitor::{MonitorNumbers, derive};
use codegen::spec::{ModelParameter, ModuleSpec};
use codegen::{
    EmissionOptions, EmittedCrate, MonitorSpec, Refusal, c99, control, generate, generate_with,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::benches::{with_voltage, with_wheel_encoder};
use crate::c99::harnesses::WARNINGS;
use crate::thesis;

const NOISE: MonitorSpec = MonitorSpec {
    noise_std: [1e-3, 4e-3, 0.6],
};

fn monitored(spec: &ModuleSpec) -> Result<EmittedCrate, Refusal> {
    let options = EmissionOptions {
        monitor: Some(NOISE),
        ..EmissionOptions::default()
    };
    generate_with(spec, &options)
}

fn numbers(spec: &ModuleSpec) -> MonitorNumbers {
    derive(spec, &control::derive(spec).unwrap(), &NOISE).unwrap()
}

/// Golden numbers from the equations of the module's documentation, by hand.
#[test]
fn the_limits_of_the_thesis_bench() {
    let found = numbers(&thesis::spec());
    // 0.1 s is nearest to 2^7 steps.
    assert_eq!(found.words.leak, 7);
    // sqrt(113.116) times 15.4569 * 2 / 113.116.
    assert!(
        (found.push_rad_s - 2.906_6).abs() < 1e-3,
        "{}",
        found.push_rad_s
    );
    // Half a count: 0.5454 mrad/s, 0.4467 rad/s.
    assert!(
        (found.errors[1] - 0.032_545).abs() < 1e-5,
        "{:?}",
        found.errors
    );
    assert!(
        (found.errors[2] - 5.246_7).abs() < 1e-3,
        "{:?}",
        found.errors
    );
    // 2 (0.0325 + 5.2467), 128 * 1.287e-4 * 5.2467, and 0.24608 * 4 A, and 0.01.
    let wheel = 2.0 * 5.279_2 + 128.0 * 1.287e-4 * 5.246_7 + 0.246_08 * 4.0 + 0.01;
    assert!(
        (found.wheel_limit_rad_s - wheel).abs() < 0.01,
        "{} {wheel}",
        found.wheel_limit_rad_s
    );
    assert!(found.body_limit_rad_s > found.push_rad_s && found.body_limit_rad_s < 5.0);
}

/// A bench whose parameters, sensors and torques are off as far as the monitor allows, each at an end of its range or
/// anywhere within, under the designed law and one push: always allowed.
#[test]
fn every_motion_within_the_uncertainty_is_allowed() {
    allows_every_motion(&thesis::spec(), None);
}

/// The same with a speed that is the turn of an encoder over its window.
#[test]
fn every_motion_with_an_encoder_on_the_wheel_is_allowed() {
    for window in [1, 8, 16] {
        allows_every_motion(&with_wheel_encoder(window), Some(window as usize));
    }
}

/// A wheel that does not answer is noticed all the same, with the law's largest current within the memory of the sums.
#[test]
fn a_dead_motor_is_noticed_through_an_encoder() {
    let mut limits = Vec::new();
    for window in [1, 8, 16] {
        let spec = with_wheel_encoder(window);
        let words = numbers(&spec).words;
        let duty = (spec.current_limit_a / spec.drive.amperes_per_count) as i32;
        let still = |duty: i32| Motion {
            angle: 0,
            rate: 0,
            wheel_speed: 0,
            duty,
        };
        let mut sums = NO_DIFFERENCE;
        let mut noticed = None;
        for step in 0..5 << words.leak {
            sums = compared(&sums, &still(duty), &still(duty), &words);
            if !agrees(&sums, &words) {
                noticed = Some(step);
                break;
            }
        }
        println!("a window of {window}: noticed after {noticed:?} steps");
        limits.push(noticed.expect("noticed"));
    }
    // The longer the window, the later.
    assert!(limits.is_sorted(), "{limits:?}");
}

/// An encoder whose window leaves room for a wheel that does not answer: the voltage of a drive brakes and drives it by so much
/// that its speed over the window may be far off.
#[test]
fn a_window_that_hides_everything_is_refused() {
    let Err(Refusal::Monitor { reason }) = monitored(&with_voltage(with_wheel_encoder(16))) else {
        panic!("a monitor that notices nothing");
    };
    assert!(reason.contains("window"), "{reason}");
}

/// Many runs of the bench, with the window of an encoder on the wheel where it has one: every motion is allowed.
fn allows_every_motion(spec: &ModuleSpec, window: Option<usize>) {
    let law = control::derive(spec).unwrap();
    let found = numbers(spec);
    let words = found.words;
    let bits = [0, 1, 2].map(|i| f64::from(law.terms[i].input.format.fraction_bits).exp2());
    let (mut closest, mut steps) = (0.0_f64, 0);
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut share = |most: f64| {
            if random.random_range(0..2) == 0 {
                most * f64::from(random.random_range(0..2) * 2 - 1)
            } else {
                random.random_range(-most..most)
            }
        };
        // Each parameter without a standard error by 10 %, gravity by three of its standard errors.
        let whole = 2.30344e-3 * (1.0 + share(0.1));
        let wheel = 1.36125e-4 * (1.0 + share(0.1));
        let gravity = 0.245158 * (1.0 + share(1e-5));
        let torque = 0.0335 * (1.0 + share(0.1));
        let friction = 1.75204e-5 * (1.0 + share(0.1));
        let late = usize::from(share(1.0) > 0.0) + usize::from(share(1.0) > 0.0);
        let push_at = 200 + (share(100.0) + 100.0) as usize;
        let push = found.push_rad_s * share(0.5);
        let offset = share(0.02);
        let inertia = whole - wheel;
        let mut state = [share(0.03), 0.0, share(20.0)];
        let mut sent = vec![0.0; 3];
        let mut sums = NO_DIFFERENCE;
        let mut last: Option<Motion> = None;
        let mut turned = 0.0;
        let mut counts = std::collections::VecDeque::from(vec![0.0; window.unwrap_or(0) + 1]);
        let speed_before = state[2];
        for step in 0..800 {
            let mut noise = found.errors.map(&mut share);
            let mut speed = state[2];
            if let Some(window) = window {
                // It turns as it did before the controller was armed.
                if step == 0 {
                    for (back, count) in (0..=window).rev().zip(&mut counts) {
                        *count = -(back as f64) * spec.sample_time_s * speed_before;
                    }
                } else {
                    counts.pop_front();
                    counts.push_back(turned);
                }
                let angle = std::f64::consts::TAU / 4096.0;
                let rounded = |turn: f64| (turn / angle).round() * angle;
                let turn = rounded(counts[window]) - rounded(counts[0]);
                speed = turn / (window as f64 * spec.sample_time_s);
                noise[2] = share(8.0 * NOISE.noise_std[2]);
            }
            // The angle's error is a bias and noise; neither is beyond its share.
            let angle = state[0] + offset + noise[0] * 8e-3 / found.errors[0];
            let measured = [angle, state[1] + noise[1], speed + noise[2]];
            let current: f64 = (0..3).map(|i| -spec.gains[i] * measured[i]).sum();
            let duty = (current.clamp(-2.0, 2.0) / spec.drive.amperes_per_count).round();
            let word = |i: usize| (measured[i] * bits[i]).round() as i32;
            let motion = Motion {
                angle: word(0),
                rate: word(1),
                wheel_speed: word(2),
                duty: duty as i32,
            };
            if let Some(before) = last {
                sums = compared(&sums, &before, &motion, &words);
            }
            last = Some(motion);
            assert!(agrees(&sums, &words), "seed {seed}, step {step}: {sums:?}");
            let used =
                f64::from(sums.wheel.abs()) / f64::from(words.wheel_limit + sums.wheel_width);
            closest = closest.max(used);
            steps += 1;
            sent.push(duty * spec.drive.amperes_per_count);
            let flowing = sent[sent.len() - 1 - late];
            // Dry friction of the pivot, of any course up to its torque.
            let dry = share(4.485e-4);
            for _ in 0..10 {
                let dt = spec.sample_time_s / 10.0;
                let on_wheel = torque * flowing - friction * state[2];
                let body =
                    (gravity * state[0].sin() - 2.12e-5 * state[1] + dry - on_wheel) / inertia;
                state[0] += dt * state[1];
                state[1] += dt * body;
                turned += dt * state[2];
                state[2] += dt * (on_wheel / wheel - body);
            }
            if step == push_at {
                // On the body alone: the wheel's own speed stays.
                state[1] += push;
                state[2] -= push;
            }
            if state[0].abs() > 0.5 {
                break;
            }
        }
    }
    println!("{steps} steps, the wheel's sum at most at {closest:.2} of its limit");
    assert!(steps > 20_000, "{steps}");
}

/// What has no bound is refused by name.
#[test]
fn a_model_without_bounds_is_refused() {
    let with = |name: &str, value: f64| {
        let mut spec = thesis::spec();
        spec.parameters.push(ModelParameter {
            name: name.to_owned(),
            value,
            std: None,
            unit: String::new(),
        });
        monitored(&spec)
    };
    assert!(with("cogging_torque", 1e-4).is_ok());
    let Err(Refusal::Monitor { reason }) = with("motor_lag", 1e-3) else {
        panic!("a motor lag");
    };
    assert!(reason.contains("motor_lag"), "{reason}");
    let mut spec = thesis::spec();
    spec.parameters.retain(|p| p.name != "wheel_inertia");
    assert!(monitored(&spec).is_err());
}

/// A monitor adds three files, a line in the list of modules and its part of the certificate, and changes no other file.
#[test]
fn only_asked_for() {
    let plain = generate(&thesis::spec()).unwrap();
    let monitored = monitored(&thesis::spec()).unwrap();
    let mut added = Vec::new();
    for file in &monitored.files {
        match plain.file(&file.path) {
            None => added.push(file.path.as_str()),
            Some(text) if text == file.contents => {}
            Some(_) => assert!(
                ["src/lib.rs", "certificate.json"].contains(&file.path.as_str()),
                "{}",
                file.path
            ),
        }
    }
    added.sort_unstable();
    assert_eq!(
        added,
        ["src/monitor.rs", "src/monitor_words.rs", "src/motion.rs"]
    );
    assert!(!plain.file("certificate.json").unwrap().contains("monitor"));
}

/// One call of the emitted C: whether the controller runs, three words, the duty.
type Call = (bool, [i32; 3], u16);

/// What the Rust answers.
fn answers(calls: &[Call], limits: &MotionLimits, zero: u16) -> Vec<bool> {
    let mut sums = NO_DIFFERENCE;
    let mut last: Option<Motion> = None;
    calls
        .iter()
        .map(|&(is_running, [angle, rate, wheel_speed], duty)| {
            let motion = Motion {
                angle,
                rate,
                wheel_speed,
                duty: i32::from(duty) - i32::from(zero),
            };
            sums = match last {
                Some(before) if is_running => compared(&sums, &before, &motion, limits),
                _ => NO_DIFFERENCE,
            };
            last = is_running.then_some(motion);
            agrees(&sums, limits)
        })
        .collect()
}

const MAIN: &str = r#"#include <stdio.h>
#include "flywheel.h"
int main(void) {
    flywheel_monitor_t monitor;
    long running, angle, rate, speed, duty;
    flywheel_monitor_init(&monitor);
    while (scanf("%ld %ld %ld %ld %ld", &running, &angle, &rate, &speed, &duty) == 5) {
        int allowed = flywheel_monitor_allows(&monitor, running != 0, (int32_t)angle, (int32_t)rate,
                                              (int32_t)speed, (uint16_t)duty);
        printf("%d\n", allowed ? 1 : 0);
    }
    return 0;
}
"#;

#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn the_c_says_the_same() {
    let spec = thesis::spec();
    let emitted = c99::emit(&monitored(&spec).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    emitted.write(folder.path()).unwrap();
    let source = folder.path().join("src");
    fs::write(source.join("main.c"), MAIN).unwrap();
    let output = Command::new("gcc")
        .current_dir(&source)
        .args(WARNINGS)
        .arg("-O1")
        .args(["-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"])
        .args(["-o", "../monitor", "flywheel.c", "main.c"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");

    let seed = 71;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // A walk near upright, on which the monitor is now and then at its limits, with leaps of any size.
    let mut words = [0_i32; 3];
    let calls: Vec<Call> = (0..200_000)
        .map(|_| {
            for (word, most) in words.iter_mut().zip([1 << 18, 1 << 20, 1 << 22]) {
                *word = word.wrapping_add(random.random_range(-most..most));
                if random.random_range(0..500) == 0 {
                    *word = random.random::<i32>() >> random.random_range(0..32);
                }
            }
            (random.random_range(0..300) > 0, words, random.random())
        })
        .collect();
    let wanted = answers(&calls, &numbers(&spec).words, spec.drive.duty_zero);
    let refused = wanted.iter().filter(|allowed| !**allowed).count();
    assert!(
        refused > 100 && refused < calls.len() - 100,
        "{refused} of {}",
        calls.len()
    );

    let mut child = Command::new(folder.path().join("monitor"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let text: String = calls
        .iter()
        .map(|(is_running, [a, r, s], duty)| {
            format!("{} {a} {r} {s} {duty}\n", i32::from(*is_running))
        })
        .collect();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "an operation without meaning");
    let found: Vec<bool> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| line == "1")
        .collect();
    let differs = found.iter().zip(&wanted).position(|(c, rust)| c != rust);
    assert_eq!((found.len(), differs), (wanted.len(), None), "seed {seed}");
}
