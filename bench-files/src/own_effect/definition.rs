//! From the content of an effect's file to the definition of the effect.

use plant::{
    Definition, EffectInfo, ExternalEffect, Instant, Kind, Linearised, ParameterInfo, Partials,
    Role, Smoothing,
};

use super::expression::Formula;
use super::{MOTION, OWN_PREFIX, ParameterText};

/// The place of the wheel's angle in [`MOTION`].
const WHEEL_ANGLE: usize = 3;
/// Largest number of sets of start values: several starts for several parameters multiply.
const MOST_STARTS: usize = 64;
/// Number of parameters and variables up to which an evaluation needs no heap allocation.
const FEW: usize = 24;

fn leaked(text: String) -> &'static str {
    Box::leak(text.into_boxed_str())
}

/// The effect of a file: its description and its equations. Torque, fingerprint, parameters and formula are those of the
/// file.
pub(super) fn define(
    name: &str,
    role: Role,
    torque: &str,
    fingerprint: Option<String>,
    parameters: &[ParameterText],
    formula: Formula,
) -> Definition {
    // A fit treats the first parameters as amplitudes: those without which the torque vanishes.
    let is_amplitude = |index: &usize| vanishes_without(&formula, parameters, *index);
    let (amplitudes, shapes): (Vec<usize>, Vec<usize>) =
        (0..parameters.len()).partition(is_amplitude);
    let order: Vec<usize> = amplitudes.iter().chain(&shapes).copied().collect();
    let infos: Vec<ParameterInfo> = order
        .iter()
        .map(|&index| {
            let one = &parameters[index];
            let size = one
                .starts
                .iter()
                .fold(0.0, |most: f64, x| most.max(x.abs()))
                .max(1e-6);
            ParameterInfo {
                name: leaked(format!("{}_{}", name.replace('-', "_"), one.name)),
                unit: leaked(one.unit.clone()),
                meaning: leaked(format!("{} of effects/{name}.toml", one.name)),
                plausible: if one.bounds.0.is_finite() && one.bounds.1.is_finite() {
                    one.bounds
                } else {
                    (-100.0 * size, 100.0 * size)
                },
                bounds: one.bounds,
                is_torque: one.unit.replace('·', " ").starts_with("N m"),
                logarithmic: false,
                is_whole: false,
            }
        })
        .collect();
    let mut starts: Vec<Vec<f64>> = vec![vec![]];
    for &index in &order {
        let longer = starts.iter().flat_map(|start| {
            parameters[index].starts.iter().map(move |&next| {
                let mut longer = start.clone();
                longer.push(next);
                longer
            })
        });
        starts = longer.take(MOST_STARTS).collect();
    }
    let absent = (!amplitudes.is_empty()).then(|| {
        let mut values = starts[0].clone();
        values[0] = 0.0;
        &*values.leak()
    });
    let shows_in: &'static [Kind] = match role {
        Role::Wheel => &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        _ => &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
    };
    let starts: Vec<&'static [f64]> = starts.into_iter().map(|start| &*start.leak()).collect();
    let text = fingerprint.unwrap_or_else(|| format!("what effects/{name}.toml describes"));
    let text = leaked(text);
    Definition {
        info: EffectInfo {
            name: leaked(format!("{OWN_PREFIX}{name}")),
            equation: leaked(torque.to_owned()),
            meaning: text,
            source: "the user's own",
            fingerprint: text,
            role,
            parameters: infos.leak(),
            starts: starts.leak(),
            absent,
            shows_in,
            has_kink: formula.has_kink(),
            linearised: Linearised::Exactly,
            uses_wheel_angle: formula.uses(WHEEL_ANGLE),
            ..EffectInfo::PLAIN
        },
        equations: Box::new(OwnTorque {
            formula,
            is_on_body: role == Role::Body,
            order,
        }),
    }
}

/// Whether the torque is 0 everywhere if this parameter is 0. It is evaluated at arbitrary points where no formula is
/// zero by accident.
fn vanishes_without(formula: &Formula, parameters: &[ParameterText], index: usize) -> bool {
    (1..=20).all(|point| {
        let spread = |k: usize| (point as f64 * (0.618 + 0.1 * k as f64)).fract() * 4.0 - 2.0;
        let motion = (0..MOTION.len()).map(spread);
        let own = parameters
            .iter()
            .enumerate()
            .map(|(k, one)| match k == index {
                true => 0.0,
                false => one.starts[0] * (1.0 + 0.1 * spread(k + MOTION.len())),
            });
        let variables: Vec<f64> = motion.chain(own).collect();
        let mut slopes = vec![0.0; variables.len()];
        formula.value(&variables, 0.01, &mut slopes) == 0.0
    })
}

/// The torque of a formula, against the motion.
struct OwnTorque {
    formula: Formula,
    is_on_body: bool,
    /// For each parameter of the vector: its position in the file.
    order: Vec<usize>,
}

impl ExternalEffect for OwnTorque {
    fn torque(&self, p: &[f64], at: &Instant<f64>, v0: &Smoothing, partials: &mut Partials) -> f64 {
        let count = MOTION.len() + p.len();
        let mut stack = [0.0; 2 * FEW];
        let mut heap = vec![];
        let room: &mut [f64] = if count <= FEW {
            &mut stack[..2 * count]
        } else {
            heap.resize(2 * count, 0.0);
            &mut heap
        };
        let (variables, slopes) = room.split_at_mut(count);
        variables[..MOTION.len()].copy_from_slice(&[
            at.angle_rad,
            at.rate_rad_s,
            at.wheel_speed_rad_s,
            at.wheel_angle_rad,
            at.current_a,
        ]);
        for (value, &index) in p.iter().zip(&self.order) {
            variables[MOTION.len() + index] = *value;
        }
        let smoothing = match self.is_on_body {
            true => v0.body_rad_s,
            false => v0.wheel_rad_s,
        };
        let torque = self.formula.value(variables, smoothing, slopes);
        partials.at.angle_rad = -slopes[0];
        partials.at.rate_rad_s = -slopes[1];
        partials.at.wheel_speed_rad_s = -slopes[2];
        partials.at.wheel_angle_rad = -slopes[3];
        partials.at.current_a = -slopes[4];
        for (partial, &index) in partials.p.iter_mut().zip(&self.order) {
            *partial = -slopes[MOTION.len() + index];
        }
        -torque
    }
}
