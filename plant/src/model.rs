//! The structure of a model: its base parameters and its effects.

use std::ops::Range;

use crate::EffectId;
use crate::effect::{EffectInfo, ParameterInfo};

/// Position of Θ in a parameter vector.
pub const TOTAL_INERTIA: usize = 0;
/// Position of j_w in a parameter vector.
pub const WHEEL_INERTIA: usize = 1;
/// Position of G in a parameter vector.
pub const GRAVITY_TORQUE: usize = 2;
/// Position of τ in a parameter vector.
pub const TORQUE_CONSTANT: usize = 3;

/// The parameters that every model has, ahead of those of its effects.
pub const BASE_PARAMETERS: [ParameterInfo; 4] = [
    ParameterInfo {
        name: "total_inertia",
        unit: "kg m2",
        meaning: "Θ, moment of inertia of body and wheel about the pivot",
        plausible: (1e-4, 1.0),
        bounds: (1e-9, 1e3),
        is_torque: true,
        logarithmic: false,
        is_whole: false,
    },
    ParameterInfo {
        name: "wheel_inertia",
        unit: "kg m2",
        meaning: "j_w, moment of inertia of wheel and rotor about their axis",
        plausible: (1e-6, 1e-1),
        bounds: (1e-12, 1e3),
        is_torque: true,
        logarithmic: false,
        is_whole: false,
    },
    ParameterInfo {
        name: "gravity_torque",
        unit: "N m",
        meaning: "G = g (k m_w + l m_b)",
        plausible: (1e-3, 20.0),
        bounds: (1e-9, 1e4),
        is_torque: true,
        logarithmic: false,
        is_whole: false,
    },
    ParameterInfo {
        name: "torque_constant",
        unit: "N m/A",
        meaning: "τ, torque of the motor per ampere",
        plausible: (1e-3, 1.0),
        // Where no torque is known it is per unit of the wheel's inertia: 0.1 N m/A on 1e-9 kg m2 are still within.
        bounds: (1e-9, 1e9),
        is_torque: true,
        logarithmic: false,
        is_whole: false,
    },
];

/// The period of small oscillations about the hanging equilibrium in s, 2π √(Θ/G), from a parameter vector. The result
/// is finite even for parameters that are not physical.
pub fn period_s(values: &[f64]) -> f64 {
    let square = (values[GRAVITY_TORQUE] / values[TOTAL_INERTIA]).abs();
    std::f64::consts::TAU / square.sqrt().max(1e-3)
}

/// The effects of a model. Its parameter vector holds the base parameters
/// followed by those of each effect, in this order. Only the functions here
/// know that layout.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Model {
    effects: Vec<EffectId>,
}

impl Model {
    /// Viscous friction on pivot and wheel, nothing else.
    pub fn base() -> Model {
        Model {
            effects: vec![
                EffectId::BodyViscousFriction,
                EffectId::WheelViscousFriction,
            ],
        }
    }

    /// A model with these effects, in the order of the library. If one of two effects contains the other, only the
    /// containing one is kept.
    pub fn with_effects(effects: &[EffectId]) -> Model {
        effects
            .iter()
            .fold(Model { effects: vec![] }, |model, &effect| {
                model.with(effect)
            })
    }

    /// The effects, in the order of the library.
    pub fn effects(&self) -> &[EffectId] {
        &self.effects
    }

    /// Whether the model has the effect.
    pub fn has(&self, effect: EffectId) -> bool {
        self.effects.contains(&effect)
    }

    /// This model with `effect` added. Effects that it contains are replaced, and so are alternative models of
    /// the same torque (they share a parameter). A model that already has an effect which contains
    /// `effect` is returned unchanged.
    pub fn with(&self, effect: EffectId) -> Model {
        let contained = self
            .effects
            .iter()
            .any(|present| present.info().replaces.contains(&effect.name()));
        if contained || self.has(effect) {
            return self.clone();
        }
        let mut effects: Vec<EffectId> = self
            .effects
            .iter()
            .copied()
            .filter(|present| !effect.info().replaces.contains(&present.name()))
            .filter(|present| {
                let shares = |info: &ParameterInfo| {
                    let own = effect.info().parameters;
                    own.iter().any(|parameter| parameter.name == info.name)
                };
                !present.info().parameters.iter().any(shares)
            })
            .collect();
        effects.push(effect);
        effects.sort();
        Model { effects }
    }

    /// This model without `effect`.
    pub fn without(&self, effect: EffectId) -> Model {
        let mut effects = self.effects.clone();
        effects.retain(|&present| present != effect);
        Model { effects }
    }

    /// This model without the torques that were learned as curves, which explain nothing.
    pub fn without_learned(&self) -> Model {
        let mut effects = self.effects.clone();
        effects.retain(|effect| effect.info().learned.is_none());
        Model { effects }
    }

    /// The torques that were learned as curves.
    pub fn learned(&self) -> impl Iterator<Item = EffectId> {
        let effects = self.effects.iter().copied();
        effects.filter(|effect| effect.info().learned.is_some())
    }

    /// The parameters in the order of the parameter vector.
    pub fn parameters(&self) -> Vec<&'static ParameterInfo> {
        BASE_PARAMETERS
            .iter()
            .chain(
                self.effects
                    .iter()
                    .flat_map(|effect| effect.info().parameters),
            )
            .collect()
    }

    /// The number of parameters.
    pub fn parameter_count(&self) -> usize {
        let own: usize = self
            .effects
            .iter()
            .map(|effect| effect.info().parameters.len())
            .sum();
        BASE_PARAMETERS.len() + own
    }

    /// Every effect with the range of its parameters in the parameter vector.
    pub fn ranges(&self) -> impl Iterator<Item = (EffectId, Range<usize>)> {
        let mut end = BASE_PARAMETERS.len();
        self.effects.iter().map(move |&effect| {
            let start = end;
            end += effect.info().parameters.len();
            (effect, start..end)
        })
    }

    /// The range of the parameters of `effect` in the parameter vector, if the model has it.
    pub fn range_of(&self, effect: EffectId) -> Option<Range<usize>> {
        let mut ranges = self.ranges();
        ranges.find_map(|(present, own)| (present == effect).then_some(own))
    }

    /// Where the parameters of `effect` start in the parameter vector, if the model has it.
    pub fn position(&self, effect: EffectId) -> Option<usize> {
        self.range_of(effect).map(|own| own.start)
    }

    /// The effect to which the parameter at this position belongs; `None` for a base parameter.
    pub fn effect_at(&self, position: usize) -> Option<EffectId> {
        let mut ranges = self.ranges();
        ranges.find_map(|(effect, own)| own.contains(&position).then_some(effect))
    }

    /// The effect to which the parameter at this position belongs, with the range of all its parameters; `None` for a
    /// base parameter.
    pub fn range_at(&self, position: usize) -> Option<(EffectId, Range<usize>)> {
        let mut ranges = self.ranges();
        ranges.find(|(_, own)| own.contains(&position))
    }

    /// The first effect whose description fulfils a condition, and the position of its first parameter.
    pub fn find(&self, holds: impl Fn(&EffectInfo) -> bool) -> Option<(EffectId, usize)> {
        let mut ranges = self.ranges();
        ranges.find_map(|(effect, own)| holds(effect.info()).then_some((effect, own.start)))
    }

    /// The position of the parameter with this name, if the model has it.
    pub fn position_of(&self, parameter: &str) -> Option<usize> {
        self.parameters()
            .iter()
            .position(|info| info.name == parameter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_that_contains_another_replaces_it() {
        let coulomb = Model::base().with(EffectId::BodyCoulombFriction);
        let dahl = coulomb.with(EffectId::BodyPreslidingFriction);
        assert!(!dahl.has(EffectId::BodyCoulombFriction));
        assert_eq!(dahl.with(EffectId::BodyCoulombFriction), dahl);
        assert_eq!(dahl.parameter_count(), dahl.parameters().len());
    }

    #[test]
    fn parameter_names_are_unique_in_every_model_of_two_effects() {
        for &a in EffectId::ALL {
            for &b in EffectId::ALL {
                let model = Model::base().with(a).with(b);
                let mut names: Vec<_> = model.parameters().iter().map(|info| info.name).collect();
                names.sort_unstable();
                let before = names.len();
                names.dedup();
                assert_eq!(before, names.len(), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn every_effect_describes_itself_completely() {
        for &effect in EffectId::ALL {
            let info = effect.info();
            assert_eq!(EffectId::from_name(info.name), Some(effect));
            assert!(!info.shows_in.is_empty() && !info.starts.is_empty());
            for start in info.starts.iter().chain(info.absent.iter()) {
                assert_eq!(start.len(), info.parameters.len(), "{}", info.name);
            }
            for (index, parameter) in info.parameters.iter().enumerate() {
                let (low, high) = parameter.bounds;
                assert!(low <= parameter.plausible.0 && parameter.plausible.1 <= high);
                for start in info.starts {
                    assert!((low..=high).contains(&start[index]), "{}", parameter.name);
                }
            }
        }
    }
}
