//! The chain rule: from the partial derivatives of an external effect to the number type of the model.

use super::{External, Partials};
use crate::effect::{Instant, Smoothing};
use crate::{Output, Reading, Scalar};

/// Number of parameters up to which an evaluation needs no heap allocation.
const FEW_PARAMETERS: usize = 16;

/// The instant without its derivatives.
fn plain<S: Scalar>(at: &Instant<S>) -> Instant<f64> {
    Instant {
        angle_rad: at.angle_rad.value(),
        rate_rad_s: at.rate_rad_s.value(),
        wheel_angle_rad: at.wheel_angle_rad.value(),
        wheel_speed_rad_s: at.wheel_speed_rad_s.value(),
        current_a: at.current_a.value(),
        memory: at.memory.value(),
    }
}

const NO_INSTANT: Instant<f64> = Instant {
    angle_rad: 0.0,
    rate_rad_s: 0.0,
    wheel_angle_rad: 0.0,
    wheel_speed_rad_s: 0.0,
    current_a: 0.0,
    memory: 0.0,
};

const NO_READING: Reading<f64> = Reading {
    angle_rad: 0.0,
    rate_rad_s: 0.0,
    wheel_speed_rad_s: 0.0,
};

/// Receives an input and the partial derivative with respect to it.
type Pair<'a, S> = dyn FnMut(S, f64) + 'a;

/// Calls `evaluate` with the values of the parameters and extends its result by the chain rule:
/// df = Σ ∂f/∂x dx over the parameters and over the further inputs. `pairs` passes each of these inputs
/// with its partial derivative.
fn lifted<S: Scalar>(
    p: &[S],
    evaluate: &mut dyn FnMut(&[f64], &mut Partials) -> f64,
    pairs: &dyn Fn(&Partials, &mut Pair<S>),
) -> S {
    let mut stack = [0.0; 2 * FEW_PARAMETERS];
    let mut heap = vec![];
    let room: &mut [f64] = if p.len() <= FEW_PARAMETERS {
        &mut stack[..2 * p.len()]
    } else {
        heap.resize(2 * p.len(), 0.0);
        &mut heap
    };
    let (values, slopes) = room.split_at_mut(p.len());
    for (value, parameter) in values.iter_mut().zip(p) {
        *value = parameter.value();
    }
    let mut partials = Partials {
        at: NO_INSTANT,
        current_a: 0.0,
        torque_constant: 0.0,
        reading: NO_READING,
        p: slopes,
    };
    let value = evaluate(values, &mut partials);
    let mut result = S::constant(value);
    let mut add = |input: S, slope: f64| {
        if slope != 0.0 {
            result += input.chain(0.0, slope);
        }
    };
    pairs(&partials, &mut add);
    for (&parameter, &slope) in p.iter().zip(partials.p.iter()) {
        add(parameter, slope);
    }
    result
}

/// The members of the instant with their partial derivatives.
fn of_instant<S: Scalar>(at: &Instant<S>, partials: &Partials, add: &mut Pair<S>) {
    add(at.angle_rad, partials.at.angle_rad);
    add(at.rate_rad_s, partials.at.rate_rad_s);
    add(at.wheel_angle_rad, partials.at.wheel_angle_rad);
    add(at.wheel_speed_rad_s, partials.at.wheel_speed_rad_s);
    add(at.current_a, partials.at.current_a);
}

// These functions are not inlined, so that they do not slow down the built-in effects.
impl External {
    /// [`crate::effect::Effect::torque`].
    #[inline(never)]
    pub(crate) fn torque<S: Scalar>(self, p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        let values = plain(at);
        lifted(
            p,
            &mut |p, partials| self.equations().torque(p, &values, v0, partials),
            &|partials, add| of_instant(at, partials, add),
        )
    }

    /// [`crate::effect::Effect::current`].
    #[inline(never)]
    pub(crate) fn current<S: Scalar>(
        self,
        p: &[S],
        current_a: S,
        at: &Instant<S>,
        torque_constant: S,
    ) -> S {
        let values = plain(at);
        let (current, constant) = (current_a.value(), torque_constant.value());
        lifted(
            p,
            &mut |p, partials| {
                let equations = self.equations();
                equations.current(p, current, &values, constant, partials)
            },
            &|partials, add| {
                of_instant(at, partials, add);
                add(current_a, partials.current_a);
                add(torque_constant, partials.torque_constant);
            },
        )
    }

    /// [`crate::effect::Effect::distort`].
    #[inline(never)]
    pub(crate) fn distort<S: Scalar>(self, p: &[S], reading: &mut Reading<S>) {
        let Some(output) = self.info().senses else {
            return;
        };
        let before = *reading;
        let values = Reading {
            angle_rad: before.angle_rad.value(),
            rate_rad_s: before.rate_rad_s.value(),
            wheel_speed_rad_s: before.wheel_speed_rad_s.value(),
        };
        *output.part_of(reading) = lifted(
            p,
            &mut |p, partials| self.equations().measured(p, output, &values, partials),
            &|partials, add| {
                for output in Output::ALL {
                    add(output.of(&before), output.of(&partials.reading));
                }
            },
        );
    }
}
