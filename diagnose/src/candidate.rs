//! A model that was tried: which effects it adds, how it was fitted, what it leaves.

use std::sync::OnceLock;

use identify::{Minimum, Record, Setup, Trace, traces};
use plant::{EffectId, Model};

use crate::imperfection::{Imperfection, imperfection};
use crate::search::remainders;

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
    pub traces: Vec<Vec<Trace>>,
    /// The same model fitted in windows of a few periods, each with a start of its own, where the
    /// free run drifts away from the logs: what the model lacks cannot add up there.
    pub windowed: Option<Minimum>,
    /// Number of free parameters that do not lie on a bound.
    pub parameters: usize,
    imperfection: OnceLock<Imperfection>,
    remainders: OnceLock<Vec<Vec<f64>>>,
}

impl Candidate {
    /// Describes a finished fit.
    pub fn new(
        setup: &Setup,
        records: &[&Record],
        added: Vec<EffectId>,
        model: Model,
        minimum: Minimum,
        windowed: Option<Minimum>,
    ) -> Candidate {
        let traces = records
            .iter()
            .zip(&minimum.windows)
            .map(|(record, windows)| traces(record, windows, &model, &minimum.values))
            .collect();

        let parameters = setup
            .free(&model)
            .len()
            .saturating_sub(minimum.on_bound.iter().filter(|held| **held).count());
        Candidate {
            added,
            model,
            minimum,
            traces,
            windowed,
            parameters,
            imperfection: OnceLock::new(),
            remainders: OnceLock::new(),
        }
    }

    /// As [`imperfection()`], computed once.
    pub fn imperfection(&self, setup: &Setup, records: &[&Record]) -> &Imperfection {
        self.imperfection
            .get_or_init(|| imperfection(setup, records, self))
    }

    /// As [`remainders()`], computed once.
    pub fn remainders(&self, records: &[&Record]) -> &[Vec<f64>] {
        self.remainders.get_or_init(|| remainders(records, self))
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
