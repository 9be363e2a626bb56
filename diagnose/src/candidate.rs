//! A candidate: a model that was tried, with its added effects, its fit and its residuals. Plain data.

use identify::{FitProblem, Minimum, PredictedSeries, Record, traces_that_count};
use parallel::parallel_map;
use plant::{EffectId, Model};

use crate::physical::{Unphysical, unphysical};
use crate::remainder::remainders_of;

/// A fitted model with its residuals.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects added to the model from which the search started, in the order in which they were found.
    pub added: Vec<EffectId>,
    /// That model with these effects.
    pub model: Model,
    /// Its fit to all records.
    pub minimum: Minimum,
    /// For every record and channel: the predicted series, compared with the measurement; NaN in windows of which
    /// nothing counts.
    pub traces: Vec<Vec<PredictedSeries>>,
    /// For every record and channel: the structured remainder in units of noise (0 where not significant).
    pub remainders: Vec<Vec<f64>>,
    /// The same model fitted in windows of a few periods, each with its own start of the motion. Present where
    /// the free run drifts away from the logs: within a short window the error of an incomplete model cannot
    /// accumulate.
    pub windowed: Option<Minimum>,
    /// Number of free parameters that do not lie on a bound.
    pub parameters: usize,
    /// The fitted values that the causes of the added effects cannot have.
    pub unphysical: Vec<Unphysical>,
}

impl Candidate {
    /// Builds the candidate from a finished fit.
    pub fn new(
        problem: &FitProblem,
        records: &[&Record],
        added: Vec<EffectId>,
        model: Model,
        minimum: Minimum,
        windowed: Option<Minimum>,
    ) -> Candidate {
        let of_records = parallel_map(records.iter().zip(&minimum.windows), |(record, windows)| {
            let traces = traces_that_count(record, windows, &model, &minimum.values);
            (remainders_of(record, &traces), traces)
        });
        let (remainders, traces) = of_records.into_iter().unzip();
        let parameters = problem
            .free(&model)
            .len()
            .saturating_sub(minimum.on_bound.iter().filter(|held| **held).count());
        let unphysical = unphysical(problem, records, (&model, &added), &minimum);
        Candidate {
            added,
            model,
            minimum,
            remainders,
            traces,
            windowed,
            parameters,
            unphysical,
        }
    }

    /// The fit on which further effects are scored: the one in short windows if there is one, else the whole one.
    pub fn point(&self) -> &Minimum {
        self.windowed.as_ref().unwrap_or(&self.minimum)
    }

    /// Root mean square error of every series, each in the unit of its channel; record by record, channel by
    /// channel.
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

    /// Whether an effect has a value that its cause cannot have, by more than `sigmas` standard errors. Such a candidate
    /// describes the measurements and explains nothing.
    pub fn is_unphysical(&self, sigmas: f64) -> bool {
        self.unphysical.iter().any(|one| one.sigmas() > sigmas)
    }

    /// The added effects as a set, in the order of the library.
    pub fn set(&self) -> Vec<EffectId> {
        let mut set = self.added.clone();
        set.sort();
        set
    }

    /// Whether this candidate contains `other` as a special case: it has all effects of `other`, or effects
    /// that replace them, and the two sets differ.
    pub fn strictly_contains(&self, other: &Candidate) -> bool {
        self.set() != other.set()
            && other
                .added
                .iter()
                .all(|effect| self.model.has(*effect) || replaced(*effect, &self.model))
    }
}

/// Whether the model has an effect that replaces this one.
fn replaced(effect: EffectId, model: &Model) -> bool {
    model
        .effects()
        .iter()
        .any(|present| present.info().replaces.contains(&effect.name()))
}

/// The names of the effects for a report, such as "drag + offset".
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
