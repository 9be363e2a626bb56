//! The inputs of a search: records, suspects, thresholds, cancellation.

use std::sync::Arc;

use identify::{Cancelled, Effort, FitProblem, Record};
use plant::EffectId;

use crate::candidate::Candidate;
use crate::economy::CONCLUSIVE_SAMPLES;
use crate::imperfection::{Imperfection, Imperfections};
use crate::thresholds::Thresholds;

/// Returns whether the work has been cancelled. Any thread may call it.
pub type IsCancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// The inputs of a search.
#[derive(Clone)]
pub struct SearchBench<'a> {
    /// The bench: its records, and what is known about its parameters.
    pub problem: &'a FitProblem,
    /// The records that are searched.
    pub records: Vec<&'a Record>,
    /// Length in s of the short windows, if the starting model drifts away from the logs; `None` if the logs
    /// are read in one piece.
    pub window_s: Option<f64>,
    /// The effects that are tried.
    pub suspects: &'a [EffectId],
    /// Least gain in χ² for which a suspect is fitted.
    pub least_gain: f64,
    /// The numbers that decide verdicts.
    pub thresholds: &'a Thresholds,
    is_cancelled: IsCancelled<'a>,
    imperfections: Arc<Imperfections>,
}

impl<'a> SearchBench<'a> {
    /// A search that reads the logs in one piece. `imperfections` may hold only results for these same logs.
    pub fn whole(
        problem: &'a FitProblem,
        suspects: &'a [EffectId],
        thresholds: &'a Thresholds,
        is_cancelled: IsCancelled<'a>,
        imperfections: Arc<Imperfections>,
    ) -> SearchBench<'a> {
        SearchBench {
            problem,
            records: problem.all_records(),
            window_s: None,
            suspects,
            least_gain: thresholds.least_gain,
            thresholds,
            is_cancelled,
            imperfections,
        }
    }

    /// Returns [`Cancelled`] if the work has been cancelled. Called before and after every fit.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if (self.is_cancelled)() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    /// As `effort`, for a fit that also ends when the work is cancelled, within one evaluation of the normal equations.
    /// The result of a cancelled fit is not a minimum; every fit is therefore followed by a [`SearchBench::check`].
    pub fn until_called_off(&self, effort: Effort<'static>) -> Effort<'a> {
        let effort: Effort<'a> = effort;
        effort.until(self.is_cancelled)
    }

    /// Number of samples over all channels: the cost (χ²) that is expected of noise alone.
    pub fn noise_cost(&self) -> f64 {
        let observed = self.records.iter().map(|record| record.observations());
        observed.sum::<usize>() as f64
    }

    /// The χ² of a candidate beyond what is expected of sensor noise alone; never negative.
    pub fn excess(&self, candidate: &Candidate) -> f64 {
        (candidate.minimum.cost - self.noise_cost()).max(0.0)
    }

    /// Whether the candidate's structured remainder is below `least_trace` in every series.
    pub fn leaves_nothing(&self, candidate: &Candidate) -> bool {
        candidate.largest_remainder() < self.thresholds.least_trace
    }

    /// Whether the candidate leaves nothing and the logs are long enough to rule out that an effect hides in its residual
    /// (see [`CONCLUSIVE_SAMPLES`]).
    pub fn proves_nothing_missing(&self, candidate: &Candidate) -> bool {
        let counts = |record: &Record, channel: usize| {
            let samples = record.channels[channel].samples.iter().zip(&record.weight);
            samples
                .filter(|(sample, weight)| sample.is_finite() && **weight > 0.0)
                .count()
        };
        self.leaves_nothing(candidate)
            && self.records.iter().all(|record| {
                (0..record.channels.len()).all(|at| counts(record, at) >= CONCLUSIVE_SAMPLES)
            })
    }

    /// The misfit that the smoothed sign of dry friction alone leaves in this candidate's fit.
    pub fn imperfection(&self, candidate: &Candidate) -> Arc<Imperfection> {
        self.imperfections.of(
            self.problem,
            &self.records,
            candidate,
            self.until_called_off(Effort::ROUGH),
        )
    }

    /// The largest structured remainder over all series, in units of noise, without the part that the smoothed
    /// sign of dry friction leaves. A remainder of at most `remains` is returned as it is, since the correction
    /// needs another fit and would not change any decision.
    pub fn unexplained_remainder(&self, candidate: &Candidate) -> f64 {
        let plain = candidate.largest_remainder();
        if plain <= self.thresholds.remains {
            return plain;
        }
        let without = self.imperfection(candidate);
        let largest = without.remainders_without.iter().flatten().copied();
        plain.min(largest.fold(0.0, f64::max))
    }
}
