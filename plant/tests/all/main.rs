//! Tests of the public interface of the crate.

mod early_step;
mod late;
mod motion;
mod motor;
mod outside;
mod sensitivities;
mod unbalance;

use plant::{Current, Plant, State};

/// The parameter set behind matrix 4.4 of the thesis, with the frictions of its 3.5.
const VALUES: [f64; 6] = [
    2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
];

fn swing(plant: &Plant<f64>, angle_rad: f64, step_s: f64, steps: usize) -> Vec<State<f64>> {
    let time_s: Vec<f64> = (0..=steps).map(|k| k as f64 * step_s).collect();
    let start = State {
        angle_rad,
        ..State::rest()
    };
    let mut states = vec![];
    plant.run(
        start,
        &time_s,
        0..time_s.len(),
        Current::Held(0.0),
        None,
        |_, _, state| states.push(*state),
    );
    states
}
