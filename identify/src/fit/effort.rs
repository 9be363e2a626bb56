//! How long a minimisation goes on, and how it ended.

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The last step was far below what the data can resolve.
    Converged,
    /// No smaller cost could be found in any direction tried, or only crumbs for many steps.
    Stalled,
    /// The number of iterations ran out.
    OutOfIterations,
    /// Ended before its minimum: at its pace it would not have come to where it matters
    /// ([`Effort::goal`]).
    Outclassed,
    /// The model could not be simulated from the given start.
    NotFinite,
    /// Called off ([`Effort::cancelled`]).
    Cancelled,
}

impl Outcome {
    /// Whether the result is a minimum.
    pub fn was_successful(self) -> bool {
        matches!(self, Outcome::Converged | Outcome::Stalled)
    }
}

/// Steps of the minimisation.
#[derive(Clone, Copy)]
pub struct Effort<'a> {
    /// Most evaluations of the normal equations.
    pub evaluations: usize,
    /// The minimisation ends when a step promises to lower the cost by less than this, relative to
    /// the mean squared residual: 1 is the change that one unknown's own standard error makes.
    pub tolerance: f64,
    /// The cost at which the fit begins to matter. One that would not come there with the evaluations
    /// that are left, at the pace of its last ones, ends.
    pub goal: f64,
    /// Asked before every evaluation but the first: `true` ends the fit as [`Outcome::Cancelled`].
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Effort<'a> {
    /// The same for a fit that matters only if its cost comes down to `goal`.
    pub fn towards(self, goal: f64) -> Effort<'a> {
        Effort { goal, ..self }
    }

    /// The same for a fit that ends when `cancelled` says so.
    pub fn until(self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Effort<'a> {
        Effort { cancelled, ..self }
    }
}

impl Effort<'static> {
    /// To a hundredth of a standard error.
    pub const FULL: Effort<'static> = Effort {
        evaluations: 30,
        tolerance: 1e-4,
        goal: f64::INFINITY,
        cancelled: &|| false,
    };
    /// The same for a minimum at the end of a long curved valley (the speed of Stribeck's curve and
    /// its levels), which takes many short steps.
    pub const PATIENT: Effort<'static> = Effort {
        evaluations: 200,
        ..Effort::FULL
    };
    /// To a third of a standard error: which of several starts or models is better.
    pub const SCORE: Effort<'static> = Effort {
        tolerance: 1e-1,
        ..Effort::FULL
    };
    /// Enough to hand over to the next stage of a schedule.
    pub const ROUGH: Effort<'static> = Effort {
        evaluations: 12,
        ..Effort::SCORE
    };
}

/// Evaluations over which the pace of a fit is taken. A fit that goes straight to its minimum needs no
/// more than these, and one that has lost its way refuses up to six steps before it finds it again.
const PACE: usize = 8;
/// Steps whose gains make a series: where the damping has gone, least squares converge at least linearly.
const SERIES: usize = 3;

/// The cost that a fit may still come down to in so many more evaluations: at the pace of its last [`PACE`],
/// or as a geometric series where its last [`SERIES`] steps all gained, each less than the one before. `costs`
/// has one entry for every evaluation; a refused step repeats the one before it.
pub(super) fn within_pace(costs: &[f64], evaluations: usize) -> f64 {
    let Some(&cost) = costs.last() else {
        return f64::NEG_INFINITY;
    };
    let back = |steps: usize| costs.len().checked_sub(1 + steps).map(|at| costs[at]);
    let at_pace = match back(PACE) {
        Some(before) => cost - (before - cost) * evaluations as f64 / PACE as f64,
        None => f64::NEG_INFINITY,
    };
    let mut ratio = 0.0f64;
    let mut gain = f64::NAN;
    for step in (0..SERIES).rev() {
        let (Some(before), Some(after)) = (back(step + 1), back(step)) else {
            return at_pace;
        };
        let next = before - after;
        if next <= 0.0 || next >= gain {
            return at_pace;
        }
        if gain.is_finite() {
            ratio = ratio.max(next / gain);
        }
        gain = next;
    }
    at_pace.max(cost - gain * ratio / (1.0 - ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_of_gains_that_shrink_is_summed() {
        // 100 + 50 + 25 + … of which 175 are gained: 25 are left.
        assert_eq!(within_pace(&[300.0, 200.0, 150.0, 125.0], 20), 100.0);
        // A refused step, or one that gains more than the one before, says nothing yet.
        for costs in [[300.0, 200.0, 200.0, 150.0], [300.0, 280.0, 200.0, 150.0]] {
            assert_eq!(within_pace(&costs, 20), f64::NEG_INFINITY);
        }
        // Over eight evaluations the pace says how far twenty more may lead.
        let costs: Vec<f64> = (0..=8).map(|k| 1000.0 - 10.0 * f64::from(k)).collect();
        assert_eq!(within_pace(&costs, 20), 720.0);
    }
}
