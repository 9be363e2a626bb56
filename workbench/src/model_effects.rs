//! Adding effects to the model of a session, and removing them.

use bench_files::{ModelFile, Tie};
use identify::Progress;
use plant::{EffectId, Model};

use crate::change::EffectChange;
use crate::comparison::effect_names;
use crate::error::Error;
use crate::session::Session;

impl Session {
    /// Adds an effect to the model and fits it again. If a tie is open, an effect that is provisional in the model
    /// is confirmed; an effect of a rival set replaces, together with its set, the provisional effects.
    ///
    /// # Errors
    /// [`Error::UnknownEffect`], [`Error::EffectPresent`]; those of [`Session::identify`].
    pub fn add_effect(&mut self, name: &str, progress: &Progress) -> Result<EffectChange, Error> {
        let before = self.structure();
        let effect = self
            .effect_named(name)
            .ok_or_else(|| self.unknown_effect(name))?;
        if let Some((after, tie)) = self.model().and_then(|file| settled(file, effect)) {
            let mut change = self.change(&before, &after, progress)?;
            change.provisional = provisional_names(tie.as_ref());
            self.set_tie(tie);
            return Ok(change);
        }
        let after = before.with(effect);
        if after == before {
            let mut effects = before.effects().iter();
            let larger = effects.find(|present| present.info().replaces.contains(&effect.name()));
            return Err(Error::EffectPresent {
                model: self.model_path().to_path_buf(),
                effect: effect.name().to_owned(),
                reason: match larger {
                    Some(larger) => format!("{} contains it already", larger.name()),
                    None => "the model has it already".to_owned(),
                },
            });
        }
        self.change(&before, &after, progress)
    }

    /// Removes an effect from the model and fits it again.
    ///
    /// # Errors
    /// [`Error::NoModel`], [`Error::EffectAbsent`]; those of [`Session::identify`].
    pub fn remove_effect(
        &mut self,
        name: &str,
        progress: &Progress,
    ) -> Result<EffectChange, Error> {
        let before = self.required_model()?.model();
        // The effect is found by its name, because the zeros of a model may belong to other logs than the bench has
        // now.
        let mut effects = before.effects().iter();
        match effects.find(|effect| effect.name() == name) {
            Some(&effect) => self.change(&before, &before.without(effect), progress),
            None => Err(Error::EffectAbsent {
                model: self.model_path().to_path_buf(),
                effect: name.to_owned(),
                present: effect_names(&before),
            }),
        }
    }

    pub(crate) fn change(
        &mut self,
        before: &Model,
        after: &Model,
        progress: &Progress,
    ) -> Result<EffectChange, Error> {
        let old = self.present_fit(before, progress)?;
        let new = self.identify_beside(&old, after, progress)?;
        let old = self.comparison_of(&old);
        let tie = self.model().and_then(|file| file.tie.as_ref());
        Ok(EffectChange {
            provisional: provisional_names(tie),
            after: new,
            effects_before: old.effects,
            rmse_before: old.rmse,
            fit_percent_before: old.fit_percent,
        })
    }

    /// The effect with this name: of the library, of the bench's own effects, or of those that the model file defines.
    pub(crate) fn effect_named(&self, name: &str) -> Option<EffectId> {
        let of_model = self
            .model()
            .into_iter()
            .flat_map(|model| &model.own_effects);
        let mut own = self.bench().own_effects.iter().chain(of_model);
        let model = self.structure();
        EffectId::from_name(name)
            .map(|effect| self.problem().made_for_logs(effect))
            .or_else(|| {
                own.find(|own| own.effect.name() == name)
                    .map(|own| own.effect)
            })
            .or_else(|| model.learned().find(|curve| curve.name() == name))
    }

    fn unknown_effect(&self, name: &str) -> Error {
        let own = self.bench().own_effects.iter();
        Error::UnknownEffect {
            name: name.to_owned(),
            own: own.map(|own| own.effect.name().to_owned()).collect(),
        }
    }
}

/// The model in which `effect` settles the open tie, and the rest of the tie; `None` if the tie
/// does not concern the effect.
fn settled(file: &ModelFile, effect: EffectId) -> Option<(Model, Option<Tie>)> {
    let tie = file.tie.as_ref()?;
    if tie.provisional.contains(&effect) {
        return Some((file.model(), None));
    }
    let chosen = tie.rivals.iter().position(|set| set.contains(&effect))?;
    let mut rivals = tie.rivals.clone();
    let provisional = std::mem::replace(&mut rivals[chosen], tie.provisional.clone());
    let certain = file.certain_model();
    let after = provisional
        .iter()
        .fold(certain, |model, &effect| model.with(effect));
    Some((
        after,
        Some(Tie {
            provisional,
            rivals,
        }),
    ))
}

fn provisional_names(tie: Option<&Tie>) -> Vec<String> {
    let effects = tie.iter().flat_map(|tie| &tie.provisional);
    effects.map(|effect| effect.name().to_owned()).collect()
}
