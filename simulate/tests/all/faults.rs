//! The emitted controller under faults at random times, and for long without any.

use crate::bench::bench;
use crate::compiled::CompiledController;
use generated::constants::LIMITS;
use generated::{CURRENT_LIMIT, ZERO_CURRENT, duty};
use plant::Plant;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simulate::{Fault, Faulty, LawFailure, Push, RawController, RawLoop, RawSample, RawSensors};

/// `Status::Running` and the first that is a trip.
const RUNNING: u8 = 2;

const WHEEL_ENDS: [i32; 2] = [LIMITS.wheel_low, LIMITS.wheel_high];

fn on_bench(plant: &Plant<f64>, seed: u64) -> RawLoop<'_> {
    RawLoop {
        held_s: 0.5,
        ..RawLoop::new(plant, RawSensors::of_the_thesis().unwrap(), seed)
    }
}

/// Steps in a row at the largest current either way.
fn longest_at_full_current(duties: &[u16]) -> usize {
    let limit = generated::Current::from_bits(CURRENT_LIMIT.to_bits());
    let (top, bottom) = (duty(limit).0, duty(-limit).0);
    let mut longest = 0;
    let mut row = 0;
    for duty in duties {
        row = if *duty == top || *duty == bottom {
            row + 1
        } else {
            0
        };
        longest = longest.max(row);
    }
    longest
}

/// Whatever fails and whenever: the motor is at full current no longer than the fault may last, and
/// after a trip there is none at all.
#[test]
fn no_fault_drives_the_motor_blindly() {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let plant: Plant<f64> = bench(true);
    let mut tripped = 0;
    let runs = 270;
    for run in 0..runs {
        let fault = Fault::ALL[run % Fault::ALL.len()];
        let from_step = 500 + random.random_range(200..1500);
        let start_rad = random.random_range(-0.15..0.15);
        let mut controller = Faulty::new(CompiledController::new(), fault, from_step, WHEEL_ENDS);
        on_bench(&plant, run as u64)
            .run(start_rad, 5.0, &mut controller, false)
            .unwrap();
        let limit = match fault {
            Fault::GyroscopeFrozen => LIMITS.frozen_steps,
            Fault::GyroscopeClipped | Fault::AccelerometerClipped => LIMITS.clipped_steps,
            Fault::WheelLow | Fault::WheelHigh => LIMITS.wheel_steps,
            Fault::MissedTick => 0,
            Fault::BusDead => LIMITS.wheel_steps,
            // The body falls, which its angle tells; else the current's own limit.
            Fault::AccelerometerDead => LIMITS.rejected_steps,
            Fault::GyroscopeReversed => LIMITS.saturated_steps,
        };
        let full = longest_at_full_current(controller.duties());
        assert!(
            full <= limit as usize,
            "run {run}, {fault:?}: {full} steps at full current"
        );
        let statuses = controller.statuses();
        let end = statuses.iter().position(|status| *status > RUNNING);
        assert!(
            end.is_some(),
            "run {run}, {fault:?}: no trip in {} steps",
            statuses.len()
        );
        if let Some(end) = end {
            tripped += 1;
            let after = &controller.duties()[end..];
            assert!(
                after.iter().all(|duty| *duty == ZERO_CURRENT),
                "run {run}, {fault:?}: a current after the trip"
            );
        }
    }
    println!("{tripped} of {runs} runs tripped");
}

/// Ten minutes of balancing with a push every four seconds: no trip.
#[test]
fn pushes_do_not_trip() {
    let plant: Plant<f64> = bench(true);
    let mut random = ChaCha8Rng::seed_from_u64(42);
    let duration_s = 600.0;
    let pushes = (1..149)
        .map(|index| {
            let impulse = random.random_range(-3e-3..3e-3_f64);
            Push::of_impulse(4.0 * f64::from(index), impulse, 0.05_f64.copysign(impulse))
        })
        .collect();
    let on = RawLoop {
        pushes,
        ..on_bench(&plant, 7)
    };
    let mut controller = CompiledController::new();
    let trace = on.run(0.02, duration_s, &mut controller, false).unwrap();
    assert_eq!(trace.fell_at_s, None);
    assert_eq!(controller.status().unwrap(), RUNNING);
    let largest = trace
        .angle_rad
        .iter()
        .fold(0.0_f64, |most, angle| most.max(angle.abs()));
    println!("largest angle {:.2}°", largest.to_degrees());
}

/// Held near upright by a hand, with whatever noise, the controller is armed within two seconds.
#[test]
fn a_body_at_rest_is_armed_within_two_seconds() {
    let plant: Plant<f64> = bench(true);
    let mut random = ChaCha8Rng::seed_from_u64(43);
    for seed in 0..1000 {
        let mut controller = CompiledController::new();
        let start_rad = random.random_range(-0.2..0.2);
        let on = RawLoop {
            held_s: 2.0,
            ..on_bench(&plant, seed)
        };
        on.run(start_rad, 0.003, &mut controller, false).unwrap();
        assert_eq!(
            controller.status().unwrap(),
            RUNNING,
            "seed {seed}, {start_rad} rad"
        );
    }
}

/// A gyroscope whose bias has drifted by half a degree a second on each axis since its calibration:
/// the correction outruns it, and the body stands.
#[test]
fn a_drifted_gyroscope_does_not_fell_the_body() {
    let plant: Plant<f64> = bench(true);
    for signs in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]] {
        let mut sensors = RawSensors::of_the_thesis().unwrap();
        // 62.5 m°/s per count.
        sensors.gyro.bias_counts = nalgebra::Vector3::from(signs) * 8.0;
        let on = RawLoop {
            held_s: 2.0,
            ..RawLoop::new(&plant, sensors, 5)
        };
        let mut controller = CompiledController::new();
        let trace = on.run(0.0, 300.0, &mut controller, true).unwrap();
        assert_eq!(trace.fell_at_s, None, "{signs:?}");
        assert_eq!(controller.status().unwrap(), RUNNING, "{signs:?}");
        let errors = trace.angle_rad.iter().zip(&trace.measured_angle_rad);
        let worst = errors.skip(10_000).fold(0.0_f64, |worst, (truth, told)| {
            worst.max((truth - told).abs())
        });
        println!("{signs:?}: off by at most {:.3}°", worst.to_degrees());
        assert!(
            worst.to_degrees() < 1.0,
            "{signs:?}: {}°",
            worst.to_degrees()
        );
    }
}

/// A controller whose gyroscope drifts on every axis: from 0.5 °/s on by 1 °/s in ten minutes, beside a
/// random walk of 0.3 °/s in half an hour.
struct Drifting {
    controller: CompiledController,
    random: ChaCha8Rng,
    steps: u32,
    walk_deg_s: [f64; 3],
}

impl RawController for Drifting {
    fn reset(&mut self) {
        self.controller.reset();
        self.steps = 0;
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        self.controller.arm()
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.controller.fault()
    }

    fn status(&self) -> Result<u8, LawFailure> {
        self.controller.status()
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let time_s = f64::from(self.steps) * 1e-3;
        self.steps += 1;
        let mut drifted = *sample;
        // Uniform steps with the standard deviation of the walk's.
        let step = 0.3 / 1_800_000_f64.sqrt() * 3_f64.sqrt();
        for (reading, walk_deg_s) in drifted.gyro.iter_mut().zip(&mut self.walk_deg_s) {
            *walk_deg_s += self.random.random_range(-step..step);
            let drift_deg_s = 0.5 + time_s / 600.0 + *walk_deg_s;
            let counts = (drift_deg_s / 62.5e-3).round() as i16;
            *reading = reading.saturating_add(counts);
        }
        self.controller.step(&drifted)
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        self.controller.angle_rad()
    }
}

/// Half an hour with a gyroscope that drifts by more than three degrees a second: the drift is
/// followed, and the body stands.
#[test]
fn a_drifting_gyroscope_is_followed_for_half_an_hour() {
    let plant: Plant<f64> = bench(true);
    let mut controller = Drifting {
        controller: CompiledController::new(),
        random: ChaCha8Rng::seed_from_u64(44),
        steps: 0,
        walk_deg_s: [0.0; 3],
    };
    let trace = on_bench(&plant, 9)
        .run(0.0, 1800.0, &mut controller, true)
        .unwrap();
    assert_eq!(trace.fell_at_s, None);
    assert_eq!(controller.status().unwrap(), RUNNING);
    let errors = trace.angle_rad.iter().zip(&trace.measured_angle_rad);
    let worst = errors.skip(60_000).fold(0.0_f64, |worst, (truth, told)| {
        worst.max((truth - told).abs())
    });
    println!("off by at most {:.3}°", worst.to_degrees());
    assert!(worst.to_degrees() < 1.0, "{}°", worst.to_degrees());
}
