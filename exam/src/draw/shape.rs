//! The shape of a hidden term, before its amplitude is determined.

use std::f64::consts::TAU;

use plant::{EffectId, HidingPlace};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::dice::sign;
use crate::truth::{Hidden, Outsider, StatedTorque, Truth};

/// A hidden term whose amplitude is not determined yet.
pub struct TermShape {
    /// The term for an amplitude.
    pub make: Box<dyn Fn(f64) -> Hidden + Send + Sync>,
    /// A first guess for the amplitude.
    pub guess: f64,
}

/// Distance from the pivot to the wheel's axis in m, scaled from the bench of the thesis: for equal materials the
/// inertia Θ (kg m²) grows with the fifth power of the lengths.
pub fn pivot_to_wheel_m(total_inertia: f64) -> f64 {
    0.085 * (total_inertia / 2.3e-3).powf(0.2)
}

/// The properties of the bench that decide the parameters of a hidden effect. The fields for the shape are drawn later.
pub fn place(truth: &Truth, (top_current_a, top_wheel_speed_rad_s): (f64, f64)) -> HidingPlace {
    let [
        total_inertia,
        wheel_inertia,
        gravity_torque,
        torque_constant,
    ] = truth.base;
    HidingPlace {
        total_inertia,
        wheel_inertia,
        gravity_torque,
        torque_constant,
        pivot_to_wheel_m: pivot_to_wheel_m(total_inertia),
        top_current_a,
        top_wheel_speed_rad_s,
        side: 1.0,
        shape: 0.0,
        second: 0.0,
    }
}

/// A library effect with a drawn shape. An effect that is not part of this program brings its equation.
pub fn shape_of_effect(
    rng: &mut ChaCha8Rng,
    effect: EffectId,
    place: &HidingPlace,
    stated: Option<&StatedTorque>,
) -> TermShape {
    let stated = stated.cloned();
    let place = HidingPlace {
        side: sign(rng),
        shape: rng.random_range(0.0..1.0),
        second: rng.random_range(-1.0..1.0),
        ..*place
    };
    TermShape {
        make: Box::new(move |s| {
            let parameters = effect.info().hidden(s, &place);
            match &stated {
                Some(torque) => Hidden::Stated(effect, parameters, torque.clone()),
                None => Hidden::Library(effect, parameters),
            }
        }),
        guess: effect.info().first_guess(),
    }
}

/// An outsider with a drawn shape.
pub fn shape_of_outsider(rng: &mut ChaCha8Rng, outsider: Outsider, truth: &Truth) -> TermShape {
    let gravity = truth.base[2];
    let uniform = |rng: &mut ChaCha8Rng, low: f64, high: f64| rng.random_range(low..high);
    let (factor, p1, p2, guess) = match outsider {
        Outsider::MagnetNearAnAngle => {
            let place = sign(rng) * uniform(rng, 0.05, 0.3);
            (gravity, place, uniform(rng, 0.03, 0.08), 1e-2)
        }
        Outsider::FrictionThatGrows => (gravity, 0.0, 0.0, 1e-2),
        Outsider::RubbingBeyondAnAngle => (gravity, uniform(rng, 0.1, 0.3), 0.0, 1e-2),
        Outsider::VibrationOfTheBase => (
            gravity,
            TAU * uniform(rng, 2.5, 7.0),
            uniform(rng, 0.0, TAU),
            1e-2,
        ),
        Outsider::SoftStop => (gravity, uniform(rng, 0.1, 0.3), 0.0, 1e-2),
        Outsider::WheelDragThatGrows => (truth.wheel_viscous, 0.0, 0.0, 0.1),
        Outsider::SupplyThatSags => (1.0, uniform(rng, 0.5, 2.0), 0.0, 1e-2),
        Outsider::UnevenEncoder => (1.0, uniform(rng, 0.0, TAU), 0.0, 1e-3),
    };
    TermShape {
        make: Box::new(move |s| Hidden::Outsider(outsider, [factor * s, p1, p2])),
        guess,
    }
}

/// Whether the parameters of a library effect lie within the plausible range of its description.
pub fn is_plausible(hidden: &Hidden) -> bool {
    let Some((effect, p)) = hidden.effect() else {
        return true;
    };
    let info = effect.info();
    !info.hides_within_plausible()
        || info.parameters.iter().zip(p).all(|(info, value)| {
            let (low, high) = info.plausible;
            // Only the upper limit is checked: the drawn size determines how small an amplitude is.
            value.abs() <= high.abs().max(low.abs())
        })
}
