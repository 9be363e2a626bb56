//! How the missing torque changes with the parameters of the model.

use plant::{Model, ParameterInfo, Plant};

use super::motion::MeasuredMotion;
use super::torque::ResidualTorque;
use crate::records::{Record, dot};

/// Step of a difference quotient, as a share of the parameter.
const DIFFERENCE: f64 = 1e-5;
/// A change of less than this number of rounding errors counts as none.
const ROUNDED: f64 = 64.0;

/// The typical size of a parameter that is zero at present, from its plausible range.
fn usual_size(info: &ParameterInfo) -> f64 {
    let (low, high) = info.plausible;
    let size = 0.01 * low.abs().max(high.abs());
    if size.is_finite() { size } else { 0.0 }
}

impl MeasuredMotion {
    /// The derivative of every value of a missing torque with respect to each parameter, in the order of the parameter
    /// vector: the torque that would be missing if only that parameter were wrong.
    pub fn parameter_slopes(
        &self,
        record: &Record,
        model: &Model,
        values: &[f64],
        missing: &ResidualTorque,
    ) -> Vec<Vec<f64>> {
        let mut slopes = vec![vec![0.0; values.len()]; missing.centres.len()];
        let Some((of_body, of_wheel)) = missing.on.inertias(record.kind, values) else {
            return slopes;
        };
        // The torque at every instant, and the size of the terms that are added up in it.
        let modelled = |values: &[f64]| -> Vec<(f64, f64)> {
            let plant = Plant::new(model, values, record.kind);
            self.state
                .iter()
                .map(|state| {
                    let (body, wheel) = plant.derivative(state, state.current_a, 0.0);
                    let (body, wheel) = (of_body * body, of_wheel * wheel);
                    (body + wheel, body.abs() + wheel.abs())
                })
                .collect()
        };
        let weights: Vec<Vec<f64>> = missing
            .centres
            .iter()
            .map(|&centre| missing.weights(record, centre))
            .collect();
        let at = modelled(values);
        let infos = model.parameters();
        for parameter in 0..values.len() {
            let size = [values[parameter].abs(), usual_size(infos[parameter])];
            let step = DIFFERENCE * size.into_iter().fold(1e-9, f64::max);
            let mut moved = values.to_vec();
            moved[parameter] += step;
            let there = modelled(&moved);
            let slope = |k: usize| {
                let change = at[k].0 - there[k].0;
                // Apart from rounding, a torque on the wheel does not depend on the body's inertia. As a regressor,
                // this rounding would move the inertia by any amount.
                if change.abs() > ROUNDED * f64::EPSILON * at[k].1 {
                    change / step
                } else {
                    0.0
                }
            };
            for ((slopes, centre), weights) in slopes.iter_mut().zip(&missing.centres).zip(&weights)
            {
                let span = centre - missing.half..centre + missing.half;
                slopes[parameter] = dot(weights, span.map(slope));
            }
        }
        slopes
    }
}
