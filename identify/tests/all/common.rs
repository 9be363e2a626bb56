//! Fits of simulated logs, and the parameters that they find.

use crate::simulated::{Experiment, PUSHES, Physics, balance, free_swing, simulate, spin_up};
use identify::{FitProblem, Identification, Record, identify};
use plant::{EffectId, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub fn fitted(problem: &FitProblem, effects: &[EffectId]) -> Identification {
    let model = effects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    identify(problem, &model, None).expect("a fit")
}

/// Value and standard error of a parameter.
pub fn parameter(found: &Identification, name: &str) -> (f64, f64) {
    let position = found.fit.model.position_of(name).expect("in the model");
    let std = found.fit.std(position).unwrap_or(f64::NAN);
    (found.fit.values[position], std)
}

pub fn log(physics: &Physics, experiment: &Experiment, seed: u64) -> Record {
    simulate(physics, experiment, &mut ChaCha8Rng::seed_from_u64(seed))
}

/// A bench with short logs, so that a test can simulate many benches.
pub fn short_bench(physics: &Physics, seed: u64) -> Vec<Record> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let forward = |_: f64| 0.6;
    let reversed = |_: f64| -0.6;
    [
        spin_up("spin-up 0.6 A", &forward, 3.0),
        spin_up("spin-up -0.6 A", &reversed, 3.0),
        free_swing("free swing 20 deg", 20f64.to_radians(), 8.0),
        free_swing("free swing 52 deg", 52f64.to_radians(), 8.0),
        Experiment {
            length_s: 6.0,
            ..balance("balance", &PUSHES)
        },
    ]
    .iter()
    .map(|experiment| simulate(physics, experiment, &mut rng))
    .collect()
}
