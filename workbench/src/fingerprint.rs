//! What an effect looks like on a bench: the model without it and with it, each fitted to all experiments.

use identify::Progress;

use crate::comparison::ComparisonReport;
use crate::error::Error;
use crate::session::Session;
use crate::swing_decay::SwingDecay;

/// The result of [`Session::fingerprint`].
#[derive(Clone, Debug)]
pub struct EffectFingerprint {
    /// The effect.
    pub effect: String,
    /// The model without it, beside the measurements.
    pub without: ComparisonReport,
    /// The model with it.
    pub with: ComparisonReport,
    /// How the free swings die out, measured and by the model without the effect.
    pub decay_without: Vec<SwingDecay>,
    /// The same with it.
    pub decay_with: Vec<SwingDecay>,
}

impl Session {
    /// What the effect of this name looks like: the session's model without and with it. The session stays as it is.
    ///
    /// # Errors
    /// As for [`Session::add_effect`].
    pub fn fingerprint(
        &self,
        effect: &str,
        progress: &Progress,
    ) -> Result<EffectFingerprint, Error> {
        let (mut without, mut with) = (self.clone(), self.clone());
        let is_there = self
            .model()
            .is_some_and(|model| model.effects.iter().any(|one| one.name() == effect));
        if is_there {
            without.remove_effect(effect, progress)?;
        } else {
            with.add_effect(effect, progress)?;
        }
        let decays = |session: &Session| Ok::<_, Error>(session.predictor(progress)?.decays());
        Ok(EffectFingerprint {
            effect: effect.to_owned(),
            decay_without: decays(&without)?,
            decay_with: decays(&with)?,
            without: without.compare(progress)?,
            with: with.compare(progress)?,
        })
    }
}
