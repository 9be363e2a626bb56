//! Logs that are far denser than their motion, as averages.

use crate::common::parameter;
use crate::simulated::{
    Experiment, NOISE, PUSHES, Physics, VALUES, balance, free_swing, simulate, spin_up,
};
use identify::{FitProblem, Record, identify};
use plant::{Kind, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The parameters that averages give are those of the bench within their standard errors, and what they leave is the
/// noise of the averages: the mean over a block is not taken for its middle, and no charge is lost.
#[test]
fn averages_give_the_same_parameters_and_leave_their_own_noise() {
    // The noise of a recorded command moves the model: that is no matter of averages.
    let [angle, rate, speed, _] = NOISE;
    let physics = Physics {
        noise: [angle, rate, speed, 0.0],
        ..Physics::base()
    };
    let square = |t: f64| if (t / 1.5) as i64 % 2 == 0 { 0.4 } else { -0.4 };
    let steps = |t: f64| [0.3, 0.6, 0.2, -0.4, -0.8, 0.5][(t / 5.0) as usize % 6];
    let step_s = 0.001;
    let experiments = [
        Experiment {
            step_s,
            ..spin_up("steps", &steps, 30.0)
        },
        Experiment {
            step_s,
            ..free_swing("swing", 0.9, 40.0)
        },
        Experiment {
            step_s,
            kind: Kind::Driven,
            ..spin_up("driven", &square, 40.0)
        },
        Experiment {
            step_s,
            ..balance("balance", &PUSHES)
        },
    ];
    for experiment in &experiments {
        for seed in 0..2 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let dense = simulate(&physics, experiment, &mut rng);
            let block = if experiment.kind == Kind::Balance {
                4
            } else {
                10
            };
            let averaged = dense.averaged(block);
            let known = [None, None, Some(VALUES[2]), Some(VALUES[3])];
            let problem = |record: Record| {
                FitProblem::from_records(vec![record], known, Default::default()).expect("a record")
            };
            for (what, record) in [("dense", dense), ("averages", averaged)] {
                let record_again = record.clone();
                let Ok(found) = identify(&problem(record), &Model::base(), None) else {
                    panic!("{}, {what}, seed {seed}: no fit", experiment.name);
                };
                for (name, truth) in [
                    ("total_inertia", VALUES[0]),
                    ("wheel_inertia", VALUES[1]),
                    ("body_viscous_friction", VALUES[4]),
                    ("wheel_viscous_friction", VALUES[5]),
                ] {
                    // What the log does not show has no standard error.
                    let (value, std) = parameter(&found, name);
                    let sigmas = (value - truth).abs() / std;
                    let is_exact = (value / truth - 1.0).abs() < 2e-6;
                    assert!(
                        std.is_nan() || sigmas < 4.5 || is_exact,
                        "{}, {what}, seed {seed}: {name} {value:e} ± {std:.1e}",
                        experiment.name
                    );
                }
                let record = &problem(record_again.clone()).records[0];
                for (trace, channel) in found.traces[0].iter().zip(&record.channels) {
                    let averaged = if what == "dense" { 1 } else { block };
                    let noise = NOISE[trace.output as usize] / (averaged as f64).sqrt();
                    for ratio in [trace.rmse / noise, channel.noise_std / noise] {
                        assert!(
                            (0.85..1.15).contains(&ratio),
                            "{}, {what}, seed {seed}: {} {ratio}",
                            experiment.name,
                            trace.output.name()
                        );
                    }
                }
            }
        }
    }
}
