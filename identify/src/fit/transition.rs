//! The motion of a window from sample to sample, linearised along itself: how a small change of the state or of the
//! current at one sample changes the state at the next.
//!
//! These are the exact derivatives of the plant's own step. They contain every effect of the model, including
//! the sensors and the motor. Dry friction, whose sign is smoothed over the speed v₀, has the slope μ/v₀ at rest. The
//! plant splits a step that takes a joint through rest into finer parts. The derivative then contains the mean
//! slope along the path, not the large slope at the instant of rest. A joint that stays at rest really forgets: an
//! error of the current does not move it.

use nalgebra::{SMatrix, SVector};
use plant::{Drive, Dual, Model, Output, Scalar, Smoothing, State};

use super::simulation::{early_steps, plant_of, simulate};
use super::unknowns::Window;
use crate::records::{Record, RecordedCurrent};

/// Components of the state: body angle, body rate, wheel angle, wheel speed, torque of friction with memory, current
/// behind a lag.
const STATES: usize = 6;

/// Dual numbers for the state and the current, with a number of lanes for which the integrator is compiled anyway.
type Numbers = Dual<8>;
/// The lane of the current.
const CURRENT: usize = STATES;

/// The linearised step from one sample to the next.
#[derive(Clone, Debug)]
pub struct Transition {
    /// ∂(state at the next sample)/∂(state at this one).
    pub state: SMatrix<f64, STATES, STATES>,
    /// ∂(state at the next sample)/∂(current over the step), per ampere.
    pub input: SVector<f64, STATES>,
    /// ∂(sensor readings at the next sample)/∂(state there), in the order of [`Output::ALL`].
    pub shown: [SVector<f64, STATES>; 3],
}

fn components<S: Copy>(state: &State<S>) -> [S; STATES] {
    [
        state.angle_rad,
        state.rate_rad_s,
        state.wheel_angle_rad,
        state.wheel_speed_rad_s,
        state.friction_torque,
        state.current_a,
    ]
}

/// The state whose components are the first variables.
fn variables(state: &State<f64>) -> State<Numbers> {
    let of = components(state);
    State {
        angle_rad: Dual::variable(of[0], 0),
        rate_rad_s: Dual::variable(of[1], 1),
        wheel_angle_rad: Dual::variable(of[2], 2),
        wheel_speed_rad_s: Dual::variable(of[3], 3),
        friction_torque: Dual::variable(of[4], 4),
        current_a: Dual::variable(of[5], 5),
    }
}

fn gradient(number: Numbers) -> SVector<f64, STATES> {
    SVector::from_fn(|row, _| number.derivatives[row])
}

/// The transitions between the samples of a window, along the motion of the model; none for a log whose current was
/// not recorded. `each` receives the index of the sample before the transition and the transition itself, the last one
/// first. Only the motion is kept in memory, which needs a tenth of the memory of all transitions.
pub fn transitions_backwards(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    mut each: impl FnMut(usize, &Transition),
) {
    let RecordedCurrent::Known(input) = &record.current else {
        return;
    };
    let mut states: Vec<State<f64>> = Vec::with_capacity(window.samples.len());
    simulate(record, window, model, values, |_, _, state| {
        states.push(*state);
    });
    let constants: Vec<Numbers> = values.iter().map(|&value| Dual::constant(value)).collect();
    let starts: Vec<Numbers> = window
        .nuisances
        .iter()
        .map(|&value| Dual::constant(value))
        .collect();
    let plant = plant_of(record, model, &constants, Smoothing::SIMULATION)
        .with_early_steps(early_steps(record, window, &starts));
    let before_a = input.first().map_or(0.0, |(_, first_a)| first_a);
    let before_a = Dual::constant(before_a);
    for (k, pair) in window.samples.clone().zip(states.windows(2)).rev() {
        let (from_s, to_s) = (record.time_s[k], record.time_s[k + 1]);
        let command = plant.command(input, (from_s, to_s), before_a, k);
        let drive = Drive {
            current_a: Dual::variable(command.value(), CURRENT),
            push: [0.0; 3],
        };
        let end = components(&plant.step(&variables(&pair[0]), &drive, to_s - from_s));
        let reading = plant.read(&variables(&pair[1]));
        let transition = Transition {
            state: SMatrix::from_fn(|row, column| end[row].derivatives[column]),
            input: SVector::from_fn(|row, _| end[row].derivatives[CURRENT]),
            shown: Output::ALL.map(|output| gradient(output.of(&reading))),
        };
        each(k, &transition);
    }
}

#[cfg(test)]
mod tests {
    use super::super::unknowns::Nuisance;
    use super::*;
    use plant::{EffectId, Kind};

    const VALUES: [f64; 6] = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
    ];

    /// A driven log in which the wheel reverses several times, with this current beside the command at one
    /// sample.
    fn record(changed: Option<(usize, f64)>) -> Record {
        let time_s: Vec<f64> = (0..400).map(|k| k as f64 * 0.004).collect();
        let mut current: Vec<f64> = time_s.iter().map(|t| 0.5 * (7.0 * t).sin()).collect();
        if let Some((k, change)) = changed {
            current[k] += change;
        }
        let still = || Some(vec![0.0; 400]);
        let outputs = [still(), still(), still()];
        Record::new("x", Kind::Driven, time_s, outputs, Some(current), false)
    }

    /// What the sensors say at every sample from `first` on.
    fn outputs(record: &Record, model: &Model, values: &[f64]) -> Vec<[f64; 3]> {
        let window = window(record);
        let mut out = vec![];
        simulate(record, &window, model, values, |_, reading, _| {
            out.push(Output::ALL.map(|output| output.of(reading)));
        });
        out
    }

    fn window(record: &Record) -> Window {
        let nuisances = Nuisance::of(record);
        Window {
            samples: 0..record.len(),
            nuisances: nuisances
                .iter()
                .map(|local| if *local == Nuisance::Angle { 0.3 } else { 0.0 })
                .collect(),
        }
    }

    /// A change of the current over one sample is carried to every later reading as a difference of two whole
    /// simulations says, also through dry friction, a cable, contact that bends, lag, saturation and a
    /// sensor with a wrong scale.
    #[test]
    fn a_change_of_the_current_is_carried_on_as_in_the_simulation() {
        for effects in [
            &[][..],
            &[("wheel-coulomb-friction", &[2e-3][..])],
            &[
                ("body-cable-spring", &[0.02, 0.4]),
                ("body-stribeck-friction", &[4e-4, 8e-4, 0.3]),
            ],
            &[
                ("body-presliding-friction", &[4e-4, 0.03]),
                ("motor-lag", &[0.02]),
            ],
            &[
                ("wheel-quadratic-drag", &[3e-7]),
                ("motor-saturation", &[0.4]),
                ("gyro-scale", &[0.2]),
            ],
        ] {
            let mut model = Model::base();
            for (name, _) in effects {
                model = model.with(EffectId::from_name(name).expect("an effect"));
            }
            let mut values = VALUES.to_vec();
            values.resize(model.parameter_count(), 0.0);
            for (name, own) in effects {
                let effect = EffectId::from_name(name).expect("an effect");
                let at = model.range_of(effect).expect("added");
                values[at].copy_from_slice(own);
            }
            let record_as_it_is = record(None);
            let window = window(&record_as_it_is);
            let mut transitions: Vec<Transition> = vec![];
            transitions_backwards(&record_as_it_is, &window, &model, &values, |_, one| {
                transitions.push(one.clone());
            });
            transitions.reverse();
            for first in [20, 150, 331] {
                let change_a = 1e-5;
                let up = outputs(&record(Some((first, change_a))), &model, &values);
                let down = outputs(&record(Some((first, -change_a))), &model, &values);
                let mut state = transitions[first].input;
                let (mut error, mut size) = ([0.0; 3], [0.0; 3]);
                for k in first..transitions.len() {
                    if k > first {
                        state = transitions[k].state * state;
                    }
                    for output in 0..3 {
                        let carried = transitions[k].shown[output].dot(&state);
                        let there = (up[k + 1][output] - down[k + 1][output]) / (2.0 * change_a);
                        error[output] += (carried - there).powi(2);
                        size[output] += there.powi(2);
                    }
                }
                for output in 0..3 {
                    let share = (error[output] / size[output]).sqrt();
                    assert!(share < 2e-3, "{effects:?}, {first}, {output}: {share}");
                }
            }
        }
    }
}
