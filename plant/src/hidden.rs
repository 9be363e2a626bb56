//! An effect hidden in a bench, for an exam: as it says itself, or as any effect can be.

use crate::effect::{EffectInfo, Role};
use crate::hiding::HidingPlace;

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
