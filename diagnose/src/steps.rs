//! The steps from the diagnosed model to the final one, as the report lists them.

use plant::{EffectId, Model};

use crate::decision::Decision;
use crate::path::path;
use crate::pool::Search;

/// A planned step of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// The effect that the step adds; `None` for the diagnosed model and for a step that only removes effects.
    pub effect: Option<EffectId>,
    /// The effects of the previous model that the step removes.
    pub replaces: Vec<EffectId>,
    /// Whether the step is provisional: an experiment must decide between explanations that tie.
    pub is_provisional: bool,
    /// The model after the step.
    pub model: Model,
}

/// The steps from `given`, the diagnosed model, to the last model of the decision. After the diagnosed model comes one
/// effect per step, first the certain ones, in the order in which the search found them. Effects of `given` that the
/// last model does not have are removed together with the first addition, or in a step of their own.
pub fn planned(found: &Search, decision: &Decision, given: &Model) -> Vec<Planned> {
    let last = &found.pool[decision.last()].model;
    let certain = &found.pool[decision.certain].model;
    let mut steps = vec![Planned {
        effect: None,
        replaces: vec![],
        is_provisional: false,
        model: given.clone(),
    }];
    let mut step = |before: &Model, effect: Option<EffectId>, after: &Model| {
        let was_there = before.effects().iter().copied();
        steps.push(Planned {
            effect,
            replaces: was_there.filter(|&effect| !after.has(effect)).collect(),
            is_provisional: effect.is_some_and(|effect| !certain.has(effect) && last.has(effect)),
            model: after.clone(),
        });
    };
    let mut current = given.clone();
    let ways = [decision.certain, decision.last()].map(|index| path(found, index));
    for effect in ways.concat().into_iter().filter_map(|(effect, _)| effect) {
        if current.with(effect) == current {
            continue;
        }
        // An effect that a later step refines stays until that step.
        let has_place = |present: EffectId| last.has(present) || last.with(present) == *last;
        let kept: Vec<EffectId> = current
            .effects()
            .iter()
            .copied()
            .filter(|&present| has_place(present))
            .collect();
        let next = Model::with_effects(&kept).with(effect);
        step(&current, Some(effect), &next);
        current = next;
    }
    if current != *last {
        step(&current, None, last);
    }
    steps
}

#[cfg(test)]
mod tests {
    use plant::EffectId::{
        BodyCoulombFriction as Coulomb, BodyPreslidingFriction as Presliding,
        BodyQuadraticDrag as Drag, BodySofteningSpring as Softening,
    };

    use super::*;
    use crate::hand_made::search;
    use crate::verdict::Verdict;

    fn decision(certain: usize, provisional: Option<usize>) -> Decision {
        Decision {
            certain,
            provisional,
            ties: vec![],
            verdict: Verdict::Ambiguous,
            remainder: 0.0,
        }
    }

    fn base_with(effects: &[EffectId]) -> Model {
        effects
            .iter()
            .fold(Model::base(), |model, &effect| model.with(effect))
    }

    /// A thesis-like swing: dry friction, and beyond it presliding or a softening spring.
    fn swing() -> Search {
        search(
            &[
                (&[], 100.0, 9.0, -50.0),
                (&[Coulomb], 30.0, 4.0, -20.0),
                (&[Presliding], 2.0, 0.5, 0.0),
                (&[Coulomb, Softening], 2.0, 0.5, -1.0),
            ],
            2,
            &[2, 3],
        )
    }

    fn summary(steps: &[Planned]) -> Vec<(Option<EffectId>, Vec<EffectId>, bool)> {
        let steps = steps.iter();
        steps
            .map(|step| (step.effect, step.replaces.clone(), step.is_provisional))
            .collect()
    }

    #[test]
    fn a_refinement_replaces_what_it_refines() {
        let steps = planned(&swing(), &decision(1, Some(2)), &Model::base());
        let expected = [
            (None, vec![], false),
            (Some(Coulomb), vec![], false),
            (Some(Presliding), vec![Coulomb], true),
        ];
        assert_eq!(summary(&steps), expected);
        assert_eq!(steps[2].model, base_with(&[Presliding]));
    }

    #[test]
    fn the_last_model_does_not_depend_on_the_first() {
        let found = swing();
        let decision = decision(1, Some(2));
        for given in [
            &[][..],
            &[Softening],
            &[Drag],
            &[Presliding],
            &[Coulomb, Drag],
        ] {
            let steps = planned(&found, &decision, &base_with(given));
            assert_eq!(steps[0].model, base_with(given));
            assert_eq!(steps.last().unwrap().model, base_with(&[Presliding]));
        }
        let from_spring = planned(&found, &decision, &base_with(&[Softening]));
        let expected = [
            (None, vec![], false),
            (Some(Coulomb), vec![Softening], false),
            (Some(Presliding), vec![Coulomb], true),
        ];
        assert_eq!(summary(&from_spring), expected);
    }

    #[test]
    fn what_is_needless_is_taken_out_in_a_step_of_its_own() {
        let steps = planned(&swing(), &decision(1, None), &base_with(&[Coulomb, Drag]));
        let expected = [(None, vec![], false), (None, vec![Drag], false)];
        assert_eq!(summary(&steps), expected);
    }
}
