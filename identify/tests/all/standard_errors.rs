//! Standard errors mean what they say.

use crate::common::{fitted, parameter, short_bench};
use crate::simulated::{Now, Physics, VALUES, coast_down, free_swing, problem, simulate, spin_up};
use plant::EffectId;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

#[test]
fn the_truth_lies_within_two_standard_errors_as_often_as_it_should() {
    let names = [
        ("total_inertia", VALUES[0]),
        ("wheel_inertia", VALUES[1]),
        ("body_viscous_friction", VALUES[4]),
        ("wheel_viscous_friction", VALUES[5]),
    ];
    let seeds = 2000..2150u64;
    let errors: Vec<[f64; 4]> = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let found = fitted(&problem(short_bench(&Physics::base(), seed)), &[]);
            names.map(|(name, truth)| {
                let (value, std) = parameter(&found, name);
                if name.ends_with("inertia") {
                    let relative = value / truth - 1.0;
                    assert!(relative.abs() < 5e-3, "seed {seed} {name}: {relative}");
                }
                (value - truth) / std
            })
        })
        .collect();
    let mut inside = 0;
    for (index, (name, _)) in names.iter().enumerate() {
        let own = errors.iter().filter(|e| e[index].abs() < 2.0).count();
        let rms =
            (errors.iter().map(|e| e[index].powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        let mean = errors.iter().map(|e| e[index]).sum::<f64>() / errors.len() as f64;
        eprintln!(
            "{name}: {own} of {} within two, mean {mean:.2} rms {rms:.2}",
            errors.len()
        );
        inside += own;
    }
    let rate = inside as f64 / (4 * errors.len()) as f64;
    eprintln!("coverage {rate}");
    assert!((0.92..=0.98).contains(&rate), "{rate}, seeds {seeds:?}");
}

/// The wheel integrates the noise of the recorded current to a random walk that no residual shows: without
/// it in the standard errors, dry friction of the wheel lies outside two of them every other time.
#[test]
fn the_noise_of_the_recorded_current_is_in_the_standard_errors() {
    let dry = |now: &Now| -6e-4 * now.wheel_speed.tanh();
    let physics = Physics {
        on_wheel: &dry,
        ..Physics::base()
    };
    let seeds = 2600..2640u64;
    let inside: usize = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let forward = |_: f64| 0.6;
            let records = [
                spin_up("spin-up 0.6 A", &forward, 5.0),
                coast_down("coast-down"),
                free_swing("free swing 20 deg", 20f64.to_radians(), 8.0),
            ]
            .iter()
            .map(|experiment| simulate(&physics, experiment, &mut rng))
            .collect();
            let found = fitted(&problem(records), &[EffectId::WheelCoulombFriction]);
            let (value, std) = parameter(&found, "wheel_coulomb_torque");
            usize::from((value - 6e-4).abs() < 2.0 * std)
        })
        .sum();
    eprintln!("{inside} of 40 within two");
    // 95.4 % of 40, less three binomial standard deviations.
    assert!(inside >= 35, "{inside} of 40, seeds {seeds:?}");
}

/// A real bearing sticks; the model's passes through zero speed over 1 rad/s, near which a balancing wheel
/// lives. The standard errors know of it.
#[test]
fn that_a_real_joint_sticks_is_in_the_standard_errors() {
    let truth = 1.2e-3;
    let sticks = |now: &Now| -truth * (now.wheel_speed / 0.05).tanh();
    let physics = Physics {
        on_wheel: &sticks,
        ..Physics::base()
    };
    let seeds = 2700..2720u64;
    let errors: Vec<f64> = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let problem = problem(short_bench(&physics, seed));
            let found = fitted(&problem, &[EffectId::WheelCoulombFriction]);
            let (value, std) = parameter(&found, "wheel_coulomb_torque");
            (value - truth) / std
        })
        .collect();
    eprintln!("errors in standard errors {errors:.2?}");
    // Stick is one standard error of the model, beside which the noise of these logs is small.
    for error in errors {
        assert!(
            (0.3..2.0).contains(&error.abs()),
            "{error}, seeds {seeds:?}"
        );
    }
}
