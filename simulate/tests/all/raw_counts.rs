//! The emitted step from raw counts to duty, compiled and from its source, on the nonlinear bench.

use crate::bench::{BASE, bench};
use crate::compiled::CompiledController;
use checker::Module;
use plant::Plant;
use simulate::scenario::Scale;
use simulate::{InterpretedController, LoopTrace, RawLoop, RawSensors, Scenario};
use std::path::Path;

const SEEDS: [u64; 3] = [11, 12, 13];

fn scale() -> Scale {
    Scale::new(&BASE, 2.0).unwrap()
}

fn on_thesis_hardware(plant: &Plant<f64>, seed: u64) -> RawLoop<'_> {
    RawLoop::new(plant, RawSensors::of_the_thesis().unwrap(), seed)
}

/// Largest |values| from `from_s` on.
fn largest(trace: &LoopTrace, values: &[f64], from_s: f64) -> f64 {
    trace
        .time_s
        .iter()
        .zip(values)
        .filter(|(time_s, _)| **time_s >= from_s)
        .fold(0.0, |most, (_, value)| value.abs().max(most))
}

fn rms_difference(left: &[f64], right: &[f64]) -> f64 {
    let sum: f64 = left
        .iter()
        .zip(right)
        .map(|(left, right)| (left - right).powi(2))
        .sum();
    (sum / left.len() as f64).sqrt()
}

#[test]
fn balances_for_half_a_minute() {
    for with_coulomb in [false, true] {
        let plant: Plant<f64> = bench(with_coulomb);
        for seed in SEEDS {
            let on = on_thesis_hardware(&plant, seed);
            let trace = on
                .run(0.0, 30.0, &mut CompiledController::new(), false)
                .unwrap();
            assert_eq!(trace.fell_at_s, None, "seed {seed}");
            let angle = largest(&trace, &trace.angle_rad, 0.0).to_degrees();
            let wheel = largest(&trace, &trace.wheel_speed_rad_s, 0.0);
            let current = largest(&trace, &trace.current_a, 0.0);
            let error = rms_difference(&trace.angle_rad, &trace.measured_angle_rad).to_degrees();
            println!(
                "seed {seed}, Coulomb {with_coulomb}: within {angle:.3}°, wheel {wheel:.1} rad/s, \
                 {current:.2} A, filter off by {error:.3}° RMS"
            );
            // A bias of 1 mg changes the measured angle by 0.06°; the filter's start from noisy readings and sticking
            // friction add as much again.
            assert!(angle < 0.5, "seed {seed}: {angle}°");
            assert!(error < 0.2, "seed {seed}: {error}°");
            assert!(current < 2.0, "seed {seed}: {current} A");
        }
    }
}

/// From raw counts, as with ideal sensors, the body returns to upright after every push of the half minute.
#[test]
fn answers_the_pushes_of_the_thesis() {
    let scenario = Scenario::half_minute(&scale());
    for with_coulomb in [false, true] {
        let plant = bench(with_coulomb);
        for seed in SEEDS {
            let on = RawLoop {
                pushes: scenario.pushes.clone(),
                ..on_thesis_hardware(&plant, seed)
            };
            let start = simulate::sensors::from_upright_rad(scenario.start.angle_rad);
            let trace = on
                .run(
                    start,
                    scenario.duration_s,
                    &mut CompiledController::new(),
                    false,
                )
                .unwrap();
            assert_eq!(trace.fell_at_s, None, "seed {seed}");
            let pushed = largest(&trace, &trace.angle_rad, 4.0).to_degrees();
            let mut calm = 0.0_f64;
            for (time_s, angle) in trace.time_s.iter().zip(&trace.angle_rad) {
                let is_calm = [
                    3.0..4.8,
                    7.5..9.8,
                    12.5..14.8,
                    17.5..19.8,
                    24.5..25.8,
                    28.5..31.0,
                ]
                .iter()
                .any(|range| range.contains(time_s));
                if is_calm {
                    calm = calm.max(angle.abs().to_degrees());
                }
            }
            println!(
                "seed {seed}, Coulomb {with_coulomb}: pushed to {pushed:.2}°, calm within {calm:.2}°"
            );
            assert!(pushed > 1.0, "the pushes act: {pushed}°");
            assert!(calm < 0.5, "seed {seed}: {calm}°");
        }
    }
}

/// The emitted step recovers from nearly the largest angle that the current allows.
#[test]
fn recovers_nearly_to_the_current_limit() {
    let scale = scale();
    for with_coulomb in [false, true] {
        let plant = bench(with_coulomb);
        for seed in SEEDS {
            let on = on_thesis_hardware(&plant, seed);
            let mut controller = CompiledController::new();
            let found = on
                .largest_recoverable_angle(&scale, &mut controller, 1e-4)
                .unwrap();
            println!(
                "seed {seed}, Coulomb {with_coulomb}: recovers from {:.2}°, not from {:.2}°; \
                 asin(τ u/G) = {:.2}°",
                found.recovered_rad.to_degrees(),
                found.lost_rad.to_degrees(),
                found.limit_rad.to_degrees()
            );
            assert!(found.recovered_rad < found.limit_rad);
            assert!(found.recovered_rad.to_degrees() > 15.0, "seed {seed}");
            // A start on the other side, where the sensors' biases have the opposite effect.
            let other_side = on
                .run(-15_f64.to_radians(), 10.0, &mut controller, true)
                .unwrap();
            assert_eq!(other_side.fell_at_s, None, "seed {seed}");
            let end = other_side.angle_rad[other_side.len() - 1];
            assert!(end.to_degrees().abs() < 0.5, "seed {seed}: ends at {end}");
        }
    }
}

/// The interpreter runs the whole step of an emitted crate bit for bit.
#[test]
fn from_source_and_compiled_are_one() {
    let plant = bench(true);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    let module = Module::read(&folder).unwrap();
    let mut from_source = InterpretedController::new(&module).unwrap();
    let on = RawLoop {
        held_s: 0.1,
        ..on_thesis_hardware(&plant, 7)
    };
    let compiled = on
        .run(0.1, 2.0, &mut CompiledController::new(), false)
        .unwrap();
    let interpreted = on.run(0.1, 2.0, &mut from_source, false).unwrap();
    assert_eq!(compiled, interpreted);
    let other = Module::parse(&[(
        "src/lib.rs",
        "#![no_std]\n#![forbid(unsafe_code)]\npub fn other(a: i32) -> i32 { a }\n",
    )])
    .unwrap();
    assert!(InterpretedController::new(&other).is_err());
}

/// If the body is released before a window of quiet samples has set the attitude, it falls without a current. If it is
/// held for a third of a second, it comes up from a small tilt.
#[test]
fn the_attitude_is_known_before_the_motor_is_driven() {
    let plant = bench(true);
    for (held_s, stands) in [(0.0, false), (0.1, false), (0.33, true)] {
        let on = RawLoop {
            held_s,
            ..on_thesis_hardware(&plant, 3)
        };
        let start_rad = 5_f64.to_radians();
        let trace = on
            .run(start_rad, 10.0, &mut CompiledController::new(), true)
            .unwrap();
        assert_eq!(trace.fell_at_s.is_none(), stands, "held for {held_s} s");
        let current = largest(&trace, &trace.current_a, 0.0);
        assert_eq!(current > 1e-3, stands, "held for {held_s} s: {current} A");
    }
}
