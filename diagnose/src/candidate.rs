//! A model that was tried: which effects it adds, how it was fitted, what it leaves. Plain data.

use identify::{FitProblem, Minimum, PredictedSeries, Record, traces};
use plant::{EffectId, Model};

use crate::remainder::remainders;

/// A fitted model with what is left of every series.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects beyond the model that was diagnosed, in the order in which they were found.
    pub added: Vec<EffectId>,
    /// The model.
    pub model: Model,
    /// Its fit to all records.
    pub minimum: Minimum,
    /// For every record and channel, model against measurement.
    pub traces: Vec<Vec<PredictedSeries>>,
    /// For every record and channel, the structured remainder in units of its noise (0 where not significant).
    pub remainders: Vec<Vec<f64>>,
    /// The same model fitted in windows of a few periods, each with a start of its own, where the
    /// free run drifts away from the logs: what the model lacks cannot add up there.
    pub windowed: Option<Minimum>,
    /// Number of free parameters that do not lie on a bound.
    pub parameters: usize,
}

impl Candidate {
    /// Describes a finished fit.
    pub fn new(
        problem: &FitProblem,
        records: &[&Record],
        added: Vec<EffectId>,
        model: Model,
        minimum: Minimum,
        windowed: Option<Minimum>,
    ) -> Candidate {
        let traces: Vec<Vec<PredictedSeries>> = records
            .iter()
            .zip(&minimum.windows)
            .map(|(record, windows)| traces(record, windows, &model, &minimum.values))
            .collect();
        let parameters = problem
            .free(&model)
            .len()
            .saturating_sub(minimum.on_bound.iter().filter(|held| **held).count());
        Candidate {
            added,
            model,
            minimum,
            remainders: remainders(records, &traces),
            traces,
            windowed,
            parameters,
        }
    }

    /// The fit on which further effects are scored: in short windows where there is one.
    pub fn point(&self) -> &Minimum {
        self.windowed.as_ref().unwrap_or(&self.minimum)
    }

    /// Root mean square errors of all series, record by record and channel by channel.
    pub fn rmse(&self) -> Vec<f64> {
        self.traces
            .iter()
            .flatten()
            .map(|trace| trace.rmse)
            .collect()
    }

    /// The largest structured remainder over all series, in units of noise.
    pub fn largest_remainder(&self) -> f64 {
        self.remainders
            .iter()
            .flatten()
            .copied()
            .fold(0.0, f64::max)
    }

    /// The added effects as a set, in the order of the library.
    pub fn set(&self) -> Vec<EffectId> {
        let mut set = self.added.clone();
        set.sort();
        set
    }

    /// Whether this candidate contains `other` as a special case: it has all of its effects, or
    /// effects that contain them, and is not the same.
    pub fn strictly_contains(&self, other: &Candidate) -> bool {
        self.set() != other.set()
            && other
                .added
                .iter()
                .all(|effect| self.model.has(*effect) || replaced(*effect, &self.model))
    }
}

/// Whether an effect of the model contains this one.
fn replaced(effect: EffectId, model: &Model) -> bool {
    model
        .effects()
        .iter()
        .any(|present| present.info().replaces.contains(&effect.name()))
}

/// The effects in words.
pub fn names(effects: &[EffectId]) -> String {
    if effects.is_empty() {
        return "the model as it is".to_owned();
    }
    effects
        .iter()
        .map(|effect| effect.name())
        .collect::<Vec<_>>()
        .join(" + ")
}
