//! An effect in Rust as an external one.

use std::marker::PhantomData;

use super::{ExternalEffect, Partials};
use crate::effect::{Effect, Instant, Smoothing};
use crate::{Dual, Output, Reading, Scalar};

/// An ordinary [`Effect`] as an external one: its equations, with derivatives from dual numbers.
pub(super) struct Adapted<E>(pub(super) PhantomData<E>);

/// Number of variables that are differentiated in one pass.
const AT_ONCE: usize = 8;
type Numbers = Dual<AT_ONCE>;
/// Makes a variable out of a value and its index.
type Variable<'a> = dyn Fn(f64, usize) -> Numbers + 'a;

/// Calls `evaluate` as often as needed to differentiate with respect to `count` variables. `variable(value, index)` is
/// the variable with this index, and `each` receives the index and the derivative. Returns the value.
fn differentiated(
    count: usize,
    evaluate: &mut dyn FnMut(&Variable) -> Numbers,
    each: &mut dyn FnMut(usize, f64),
) -> f64 {
    let mut value = 0.0;
    for first in (0..count).step_by(AT_ONCE) {
        let variable = |value: f64, index: usize| {
            // An index outside of this pass gives a constant.
            Numbers::variable(value, index.checked_sub(first).unwrap_or(AT_ONCE))
        };
        let result = evaluate(&variable);
        value = result.value;
        let last = AT_ONCE.min(count - first);
        for (lane, &derivative) in result.derivatives[..last].iter().enumerate() {
            each(first + lane, derivative);
        }
    }
    value
}

/// The parameters as variables, after `before` others.
fn parameters(p: &[f64], before: usize, variable: &Variable) -> Vec<Numbers> {
    p.iter()
        .enumerate()
        .map(|(index, &value)| variable(value, before + index))
        .collect()
}

/// Number of the variables of an instant.
const OF_INSTANT: usize = 5;

/// The instant as the first variables.
fn instant(at: &Instant<f64>, variable: &Variable) -> Instant<Numbers> {
    Instant {
        angle_rad: variable(at.angle_rad, 0),
        rate_rad_s: variable(at.rate_rad_s, 1),
        wheel_angle_rad: variable(at.wheel_angle_rad, 2),
        wheel_speed_rad_s: variable(at.wheel_speed_rad_s, 3),
        current_a: variable(at.current_a, 4),
        memory: Numbers::constant(at.memory),
    }
}

/// The place for the derivative with respect to a member of the instant; `None` for a higher index.
fn slope_of_instant(at: &mut Instant<f64>, index: usize) -> Option<&mut f64> {
    match index {
        0 => Some(&mut at.angle_rad),
        1 => Some(&mut at.rate_rad_s),
        2 => Some(&mut at.wheel_angle_rad),
        3 => Some(&mut at.wheel_speed_rad_s),
        4 => Some(&mut at.current_a),
        _ => None,
    }
}

impl<E: Effect + Send + Sync> ExternalEffect for Adapted<E> {
    fn torque(&self, p: &[f64], at: &Instant<f64>, v0: &Smoothing, partials: &mut Partials) -> f64 {
        const BEFORE: usize = OF_INSTANT;
        differentiated(
            BEFORE + p.len(),
            &mut |variable| E::torque(&parameters(p, BEFORE, variable), &instant(at, variable), v0),
            &mut |index, slope| match slope_of_instant(&mut partials.at, index) {
                Some(place) => *place = slope,
                None => partials.p[index - BEFORE] = slope,
            },
        )
    }

    fn current(
        &self,
        p: &[f64],
        current_a: f64,
        at: &Instant<f64>,
        torque_constant: f64,
        partials: &mut Partials,
    ) -> f64 {
        const CURRENT: usize = OF_INSTANT;
        const TORQUE_CONSTANT: usize = CURRENT + 1;
        const BEFORE: usize = TORQUE_CONSTANT + 1;
        differentiated(
            BEFORE + p.len(),
            &mut |variable| {
                E::current(
                    &parameters(p, BEFORE, variable),
                    variable(current_a, CURRENT),
                    &instant(at, variable),
                    variable(torque_constant, TORQUE_CONSTANT),
                )
            },
            &mut |index, slope| match (index, slope_of_instant(&mut partials.at, index)) {
                (_, Some(place)) => *place = slope,
                (CURRENT, _) => partials.current_a = slope,
                (TORQUE_CONSTANT, _) => partials.torque_constant = slope,
                _ => partials.p[index - BEFORE] = slope,
            },
        )
    }

    fn measured(
        &self,
        p: &[f64],
        output: Output,
        reading: &Reading<f64>,
        partials: &mut Partials,
    ) -> f64 {
        let before = Output::ALL.len();
        differentiated(
            before + p.len(),
            &mut |variable| {
                let mut distorted = Reading {
                    angle_rad: variable(reading.angle_rad, 0),
                    rate_rad_s: variable(reading.rate_rad_s, 1),
                    wheel_speed_rad_s: variable(reading.wheel_speed_rad_s, 2),
                };
                E::distort(&parameters(p, before, variable), &mut distorted);
                output.of(&distorted)
            },
            &mut |index, slope| match Output::ALL.get(index) {
                Some(&output) => *output.part_of(&mut partials.reading) = slope,
                None => partials.p[index - before] = slope,
            },
        )
    }
}
