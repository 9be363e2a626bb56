//! What a search works on, and what it keeps of it.

use std::sync::Arc;

use identify::{Cancelled, Effort, FitProblem, Record};
use plant::EffectId;

use crate::candidate::Candidate;
use crate::imperfection::{Imperfection, Imperfections};
use crate::thresholds::Thresholds;

/// Whether the work has been called off, asked from any thread.
pub type IsCancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// What a search works on.
#[derive(Clone)]
pub struct SearchBench<'a> {
    /// The bench with what is known of it.
    pub problem: &'a FitProblem,
    /// Its records.
    pub records: Vec<&'a Record>,
    /// Length of the short windows in s, where the model as it was drifts away from the logs.
    pub window_s: Option<f64>,
    /// The effects that are tried.
    pub suspects: &'a [EffectId],
    /// Least gain in χ² for which one of them is fitted.
    pub least_gain: f64,
    /// The numbers that decide.
    pub thresholds: &'a Thresholds,
    is_cancelled: IsCancelled<'a>,
    imperfections: Arc<Imperfections>,
}

impl<'a> SearchBench<'a> {
    /// A bench whose logs are read in one piece. What is known of `imperfections` must be of these very logs.
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

    /// Goes on unless the work has been called off: asked before every fit and after it.
    pub fn check(&self) -> Result<(), Cancelled> {
        if (self.is_cancelled)() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    /// An effort that ends when the work is called off: within one evaluation of the normal equations. What such a
    /// fit has come to is no minimum, so that every fit is followed by a [`SearchBench::check`].
    pub fn until_called_off(&self, effort: Effort<'static>) -> Effort<'a> {
        let effort: Effort<'a> = effort;
        effort.until(self.is_cancelled)
    }

    /// Number of samples over all channels, which is the cost that is expected of noise alone.
    pub fn noise_cost(&self) -> f64 {
        let observed = self.records.iter().map(|record| record.observations());
        observed.sum::<usize>() as f64
    }

    /// χ² of a candidate beyond what the noise of the sensors makes.
    pub fn excess(&self, candidate: &Candidate) -> f64 {
        (candidate.minimum.cost - self.noise_cost()).max(0.0)
    }

    /// Whether a candidate leaves no structure that a sensor would show.
    pub fn leaves_nothing(&self, candidate: &Candidate) -> bool {
        candidate.largest_remainder() < self.thresholds.least_trace
    }

    /// What the smoothed sign of dry friction alone leaves of a candidate.
    pub fn imperfection(&self, candidate: &Candidate) -> Arc<Imperfection> {
        self.imperfections.of(
            self.problem,
            &self.records,
            candidate,
            self.until_called_off(Effort::ROUGH),
        )
    }

    /// The largest structured remainder over all series that is not what a smoothed sign of dry friction
    /// leaves, in units of noise: of a small one that makes no difference.
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
