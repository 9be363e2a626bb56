//! The parameters of an effect that is hidden in a bench for the exam: as its description says, or in a general way.

use crate::effect::{EffectInfo, Role};
use crate::hiding::HidingPlace;

/// First guess of the amplitude for an effect whose description has no [`Hiding`].
const FIRST_GUESS: f64 = 1e-2;

impl EffectInfo {
    /// The parameters with which the exam hides this effect. If its description has no [`Hiding`], its first parameter is
    /// scaled by `amplitude`, and the others come from one of its stated starts. The scale is the gravity torque, the
    /// motor's torque, the largest current, or the unit of the sensor. The sign is drawn if the bounds allow both.
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

    /// An amplitude to begin with in the search for one that is visible (see [`EffectInfo::hidden`]).
    pub fn first_guess(&self) -> f64 {
        self.hiding.map_or(FIRST_GUESS, |hiding| hiding.first_guess)
    }

    /// Whether the hidden parameters must lie within [`crate::ParameterInfo::plausible`].
    pub fn hides_within_plausible(&self) -> bool {
        self.hiding.is_none_or(|hiding| !hiding.beyond_plausible)
    }
}
