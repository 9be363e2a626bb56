//! The closed loop against balance logs of an independent program: SciPy's integrator, its own
//! noise, pushes that are known but not logged.

use crate::bench::{BASE, COULOMB_TORQUE};
use design::zero_order_hold::zero_order_hold;
use nalgebra::DMatrix;
use plant::{EffectId, Kind, Model, Plant};
use simulate::overlay::MeasuredLog;
use simulate::{Actuator, ClosedLoop, ExactLaw, Motion, Push, Sensor, Sensors, overlay};
use std::path::{Path, PathBuf};

/// The simulated loop: standard deviation of the noise of angle (rad), rate and wheel speed (rad/s); time (s) and
/// torque (N m) of the pushes, which fall to 1/e in 0.05 s; gains.
const NOISE: [f64; 3] = [1.2e-3, 4e-3, 0.6];
const PUSHES: [(f64, f64); 4] = [(4.0, 0.02), (8.0, -0.03), (12.0, 0.035), (16.0, -0.02)];
const GAINS: [f64; 3] = [-24.267242, -2.129739, -0.02258758];

/// The balance log of a bench.
fn balance_log(bench: &str) -> PathBuf {
    let benches = Path::new(env!("FLYWHEEL_RECORDINGS")).join("hidden");
    benches.join(bench).join("balance.csv")
}

fn columns(path: &Path) -> [Vec<f64>; 5] {
    let mut columns: [Vec<f64>; 5] = Default::default();
    for row in csv::Reader::from_path(path).unwrap().records() {
        for (column, field) in columns.iter_mut().zip(&row.unwrap()) {
            column.push(field.parse().unwrap());
        }
    }
    columns
}

/// Simulates the log of a bench with these further effects; the rms differences of angle, rate and
/// wheel speed, each over the noise of its sensor.
fn differences(log: &Path, effects: &[(EffectId, f64)]) -> [f64; 3] {
    let [time_s, angle, rate, wheel_speed, _] = columns(log);
    let mut model = Model::base();
    let mut values = BASE.to_vec();
    // G from the masses and lengths of the bench.
    values[plant::GRAVITY_TORQUE] = 9.81 * (0.085 * 0.10604 + 0.079886 * 0.2);
    for (effect, value) in effects {
        model = model.with(*effect);
        values.push(*value);
    }
    let plant = Plant::new(&model, &values, Kind::Balance);
    let sensor = |noise_std| Sensor {
        noise_std,
        ..Sensor::PERFECT
    };
    let on = ClosedLoop {
        motion: Motion::Nonlinear(&plant),
        sensors: Sensors {
            angle: sensor(NOISE[0]),
            rate: sensor(NOISE[1]),
            wheel_speed: sensor(NOISE[2]),
        },
        actuator: Actuator {
            limit_a: 2.0,
            step_a: 0.0,
        },
        sample_time_s: 1e-3,
        computation_s: 0.0,
        pushes: PUSHES
            .map(|(time, torque)| Push::new(time, torque, 0.05))
            .to_vec(),
        seed: 3,
    };
    let mut law = ExactLaw {
        gains: GAINS.into(),
        limit_a: 2.0,
    };
    let log = MeasuredLog {
        time_s: &time_s,
        angle_rad: &angle,
        rate_rad_s: Some(&rate),
        wheel_speed_rad_s: Some(&wheel_speed),
        current_a: None,
    };
    let overlay = overlay(&log, &on, &mut law).unwrap();
    let ratio = |index: usize| overlay.channels[index].rms_difference / NOISE[index];
    [ratio(0), ratio(1), ratio(2)]
}

/// What the ratios must be where the model is right: two independent runs of y = x + v differ by
/// √2 of the spread of y, and noise v with covariance R makes the state of the loop spread with
/// P = (Ad − Bd K) P (Ad − Bd K)ᵀ + Bd K R Kᵀ Bdᵀ.
fn expected_ratios() -> [f64; 3] {
    let (model, values) = crate::bench::model(false);
    let linear = plant::linearise(&model, &values, std::f64::consts::PI, None).unwrap();
    let a = DMatrix::from_fn(3, 3, |row, column| linear.state[(row, column)]);
    let b = DMatrix::from_fn(3, 1, |row, _| linear.input[row]);
    let hold = zero_order_hold(&a, &b, 1e-3).unwrap();
    let gain = DMatrix::from_row_slice(1, 3, &GAINS);
    let closed = &hold.state - &hold.input * &gain;
    let current: f64 = GAINS
        .iter()
        .zip(NOISE)
        .map(|(k, noise)| (k * noise).powi(2))
        .sum();
    let drive = &hold.input * hold.input.transpose() * current;
    let mut spread = drive.clone();
    for _ in 0..20_000 {
        spread = &closed * spread * closed.transpose() + &drive;
    }
    std::array::from_fn(|i| (2.0 * (1.0 + spread[(i, i)] / NOISE[i].powi(2))).sqrt())
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_true_bench_explains_the_log_down_to_its_noise() {
    let expected = expected_ratios();
    for (name, effects) in [
        ("a-viscous-only", vec![]),
        (
            "b-dry-pivot",
            vec![(EffectId::BodyCoulombFriction, COULOMB_TORQUE)],
        ),
        (
            "d-dry-wheel",
            vec![(EffectId::WheelCoulombFriction, 1.2e-3)],
        ),
    ] {
        let ratios = differences(&balance_log(name), &effects);
        eprintln!("{name}: rms difference over noise {ratios:.3?}, expected {expected:.3?}");
        for (ratio, expected) in ratios.iter().zip(expected) {
            // Dry friction damps a little of what noise does; the loop forgets in 0.2 s, so 20 s
            // hold a hundred independent stretches of its slow part.
            assert!((ratio / expected - 1.0).abs() < 0.05, "{name}: {ratios:?}");
        }
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn a_bench_without_its_dry_wheel_does_not() {
    let ratios = differences(&balance_log("d-dry-wheel"), &[]);
    eprintln!("d-dry-wheel without its friction: {ratios:.3?}");
    assert!(ratios[2] > 2.0, "{ratios:?}");
}
