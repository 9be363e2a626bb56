//! The quality of a transient, and the influence of each effect of the model on it.
//!
//! The thesis observed one more oscillation on the bench than in its simulation.
//! [`effects_on_transient`] repeats a transient with every effect alone and with all together, and
//! counts the oscillations.

use crate::closed_loop::{ClosedLoop, LoopTrace};
use crate::error::SimulateError;
use crate::law::Law;
use crate::motion::Motion;
use crate::scenario::Scenario;
use plant::{EffectId, Kind, Model, Plant};

/// Measures of a transient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// Number of swings beyond the threshold, each on the side opposite to the one before;
    /// two make an oscillation.
    pub swings: usize,
    /// Largest angle on the side opposite to the start, in rad.
    pub overshoot_rad: f64,
    /// Time in s at which the body was last beyond the threshold.
    pub settling_s: f64,
    /// Root mean square of the angle over the last quarter of the run in rad. Dry friction, noise and quantisation
    /// cause it.
    pub residual_rad: f64,
    /// Largest wheel speed in rad/s.
    pub wheel_speed_rad_s: f64,
    /// Largest current in A.
    pub current_a: f64,
    /// Whether the body fell.
    pub fell: bool,
}

impl Transient {
    /// Measures a run that starts away from upright. `threshold_rad` is the angle that counts as a
    /// swing; 2 % of the start is usual for settling.
    pub fn of(trace: &LoopTrace, threshold_rad: f64) -> Transient {
        let start = trace.angle_rad.first().copied().unwrap_or(0.0);
        let mut side = start.signum();
        let (mut swings, mut settling_s, mut overshoot_rad) = (0, 0.0, 0.0_f64);
        for (&angle, &time_s) in trace.angle_rad.iter().zip(&trace.time_s) {
            if angle.abs() > threshold_rad {
                settling_s = time_s;
                if angle.signum() != side {
                    side = angle.signum();
                    swings += 1;
                }
            }
            overshoot_rad = overshoot_rad.max(-angle * start.signum());
        }
        let largest = |values: &[f64]| values.iter().map(|value| value.abs()).fold(0.0, f64::max);
        let last = &trace.angle_rad[trace.len() - trace.len() / 4..];
        let squares: f64 = last.iter().map(|angle| angle * angle).sum();
        Transient {
            swings,
            overshoot_rad,
            settling_s,
            residual_rad: (squares / last.len().max(1) as f64).sqrt(),
            wheel_speed_rad_s: largest(&trace.wheel_speed_rad_s),
            current_a: largest(&trace.current_a),
            fell: trace.fell_at_s.is_some(),
        }
    }
}

/// A transient of the bench with some of its effects.
#[derive(Clone, Debug, PartialEq)]
pub struct WithEffects {
    /// The effects beyond viscous friction; empty for the base model.
    pub effects: Vec<EffectId>,
    /// The run.
    pub trace: LoopTrace,
    /// The measures of the run.
    pub transient: Transient,
}

/// The transients of the base model, of the base model with each further effect of `model` alone,
/// and of `model` itself (if it has more than one further effect). `values` are the parameters
/// of `model`. The loop is that of `on`, with its plant replaced.
///
/// # Errors
/// Times that are not positive; a law that fails; a motion that is no longer finite.
pub fn effects_on_transient(
    model: &Model,
    values: &[f64],
    on: &ClosedLoop<'_>,
    scenario: &Scenario,
    law: &mut dyn Law,
    threshold_rad: f64,
) -> Result<Vec<WithEffects>, SimulateError> {
    let base = Model::base();
    let further: Vec<EffectId> = model
        .effects()
        .iter()
        .copied()
        .filter(|effect| !base.has(*effect))
        .collect();
    let mut sets = vec![vec![]];
    sets.extend(further.iter().map(|effect| vec![*effect]));
    if further.len() > 1 {
        sets.push(further);
    }
    sets.into_iter()
        .map(|effects| {
            let part = effects
                .iter()
                .fold(base.clone(), |part, effect| part.with(*effect));
            let plant = Plant::new(&part, &values_of(&part, model, values), Kind::Balance);
            let bench = ClosedLoop {
                motion: Motion::Nonlinear(&plant),
                pushes: scenario.pushes.clone(),
                ..on.clone()
            };
            let trace = bench.run(&scenario.start, scenario.duration_s, law, false)?;
            Ok(WithEffects {
                transient: Transient::of(&trace, threshold_rad),
                effects,
                trace,
            })
        })
        .collect()
}

/// The parameters of `part`, a model with some of the effects of `model`; zero for those that
/// `model` does not have.
pub(crate) fn values_of(part: &Model, model: &Model, values: &[f64]) -> Vec<f64> {
    part.parameters()
        .iter()
        .map(|info| {
            model
                .position_of(info.name)
                .and_then(|position| values.get(position))
                .copied()
                .unwrap_or(0.0)
        })
        .collect()
}
