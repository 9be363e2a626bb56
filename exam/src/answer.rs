//! The true answer for a bench, as far as it is known.

use identify::FitProblem;
use plant::EffectId;

use crate::draw::ExamBench;

/// The true answer for a bench.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The hidden effects of the library, also those that are hidden together with an outsider.
    pub effects: Vec<EffectId>,
    /// True parameters in SI by name, as far as they are known.
    pub parameters: Vec<(String, f64)>,
    /// Whether a hidden term is not among the suspects.
    pub outside: bool,
}

impl Answer {
    /// The answer of a drawn bench.
    pub fn of(bench: &ExamBench) -> Answer {
        let outside = bench.question.is_outside();
        let mut parameters: Vec<(String, f64)> = plant::BASE_PARAMETERS
            .iter()
            .zip(bench.truth.base)
            .map(|(info, value)| (info.name.to_owned(), value))
            .collect();
        parameters.push(("body_viscous_friction".to_owned(), bench.truth.body_viscous));
        parameters.push((
            "wheel_viscous_friction".to_owned(),
            bench.truth.wheel_viscous,
        ));
        let mut effects = vec![];
        for hidden in &bench.truth.hidden {
            let Some((effect, p)) = hidden.effect() else {
                continue;
            };
            for (info, value) in effect.info().parameters.iter().zip(p) {
                parameters.push((info.name.to_owned(), *value));
            }
            if !outside {
                effects.push(effect);
            }
        }
        effects.sort();
        Answer {
            effects,
            parameters,
            outside,
        }
    }

    /// The answer in which each effect has its parameters for each log of the bench ([`FitProblem::made_for_logs`]).
    #[must_use]
    pub fn made_for(&self, problem: &FitProblem) -> Answer {
        let effects = self
            .effects
            .iter()
            .map(|&effect| problem.made_for_logs(effect));
        let mut effects: Vec<EffectId> = effects.collect();
        effects.sort();
        Answer {
            effects,
            ..self.clone()
        }
    }

    /// The answer from the names of effects in a truth.json; "unknown" stands for an outsider.
    ///
    /// # Errors
    /// [`UnknownEffect`] if the library does not have one of them.
    pub fn from_names(
        effects: &[String],
        parameters: Vec<(String, f64)>,
    ) -> Result<Answer, UnknownEffect> {
        let mut answer = Answer {
            effects: vec![],
            parameters,
            outside: false,
        };
        for name in effects {
            match EffectId::from_name(name) {
                Some(effect) => answer.effects.push(effect),
                None if name == "unknown" => answer.outside = true,
                None => return Err(UnknownEffect(name.clone())),
            }
        }
        answer.effects.sort();
        Ok(answer)
    }
}

/// A truth.json names an effect that the library does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not an effect of the library; an outsider is called \"unknown\"")]
pub struct UnknownEffect(pub String);
