//! How the exam hides an effect in a bench: parameters of a size that the bench can show.

use crate::effect::{EffectInfo, Role};

/// How the exam hides an effect.
#[derive(Clone, Copy, Debug)]
pub struct Hiding {
    /// The parameters (SI, in the order of the effect's description) for an amplitude, which is a pure
    /// number: the term grows with it, and at 1 it is about as large as what it is measured by.
    pub parameters: fn(f64, &HidingPlace) -> Vec<f64>,
    /// An amplitude from which the one that is wanted is looked for.
    pub first_guess: f64,
    /// The parameters go with the bench, and may lie outside of their plausible range.
    pub beyond_plausible: bool,
}

/// The bench in which an effect is hidden, and what was drawn for the effect's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HidingPlace {
    /// Θ in kg m².
    pub total_inertia: f64,
    /// j_w in kg m².
    pub wheel_inertia: f64,
    /// G in N m.
    pub gravity_torque: f64,
    /// τ in N m/A.
    pub torque_constant: f64,
    /// Largest current of a spin-up, A.
    pub top_current_a: f64,
    /// Wheel speed that it reaches, rad/s.
    pub top_wheel_speed_rad_s: f64,
    /// 1 or −1.
    pub side: f64,
    /// A number from 0 to 1, 1 excluded.
    pub shape: f64,
    /// A number from −1 to 1, 1 excluded.
    pub second: f64,
}

impl HidingPlace {
    /// The drawn shape, log-uniform between two values.
    pub fn between(&self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.shape)
    }

    /// The motor's torque at the largest current, N m.
    pub fn top_torque(&self) -> f64 {
        self.torque_constant * self.top_current_a
    }
}

/// First guess for the amplitude of an effect that says nothing of how it hides.
const FIRST_GUESS: f64 = 1e-2;

impl EffectInfo {
    /// How the exam hides this effect: as it says itself, otherwise with its first parameter as the
    /// amplitude (in gravity torques, in torques of the motor, in amperes of the largest current, or in the
    /// unit of the sensor, with either sign where its bounds allow) and the others as one of its stated
    /// starts has them.
    pub fn hidden(&self, amplitude: f64, place: &HidingPlace) -> Vec<f64> {
        if let Some(hiding) = self.hiding {
            return (hiding.parameters)(amplitude, place);
        }
        let scale = match self.role {
            Role::Body => place.gravity_torque,
            Role::Wheel => place.top_torque(),
            Role::Motor => place.top_current_a,
            Role::Sensor => 1.0,
        };
        let chosen = (place.shape * self.starts.len() as f64) as usize;
        let mut parameters = self
            .starts
            .get(chosen)
            .map_or(vec![], |start| start.to_vec());
        if let (Some(first), Some(info)) = (parameters.first_mut(), self.parameters.first()) {
            let side = if info.bounds.0 < 0.0 { place.side } else { 1.0 };
            *first = side * scale * amplitude;
        }
        parameters
    }

    /// An amplitude from which [`EffectInfo::hidden`] may be tried.
    pub fn first_guess(&self) -> f64 {
        self.hiding.map_or(FIRST_GUESS, |hiding| hiding.first_guess)
    }

    /// Whether such parameters must lie where [`crate::ParameterInfo::plausible`] says.
    pub fn hides_within_plausible(&self) -> bool {
        self.hiding.is_none_or(|hiding| !hiding.beyond_plausible)
    }
}
