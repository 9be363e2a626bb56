//! Candidates made by hand, for the tests of what is said about pools.

use identify::{Minimum, Outcome, Output, PredictedSeries};
use nalgebra::DMatrix;
use plant::{EffectId, Model};

use crate::candidate::Candidate;
use crate::pool::Search;

/// A candidate of one series, with this χ² and remainder.
pub fn candidate(added: &[EffectId], cost: f64, remainder: f64) -> Candidate {
    let model = added
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    Candidate {
        added: added.to_vec(),
        parameters: model.parameter_count(),
        minimum: Minimum {
            values: vec![0.0; model.parameter_count()],
            windows: vec![],
            cost,
            information: DMatrix::zeros(0, 0),
            on_bound: vec![],
            outcome: Outcome::Converged,
            evaluations: 1,
        },
        model,
        traces: vec![vec![PredictedSeries {
            output: Output::Angle,
            predicted: vec![],
            rmse: remainder,
            fit_percent: 0.0,
        }]],
        remainders: vec![vec![remainder]],
        windowed: None,
        unphysical: vec![],
    }
}

/// A search that tried these sets: effects, χ², remainder, evidence.
pub fn search(tried: &[(&[EffectId], f64, f64, f64)], best: usize, ties: &[usize]) -> Search {
    Search {
        pool: tried
            .iter()
            .map(|&(added, cost, remainder, _)| candidate(added, cost, remainder))
            .collect(),
        evidence: tried.iter().map(|one| one.3).collect(),
        best,
        ties: ties.to_vec(),
    }
}
