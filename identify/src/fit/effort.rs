//! How long a minimisation continues, and the reasons why it ends.

/// The reason why a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Converged: the last step was far below the resolution of the data.
    Converged,
    /// Stalled: no direction lowered the cost, or the gains were negligible for many steps.
    Stalled,
    /// The number of iterations ran out.
    OutOfIterations,
    /// Abandoned before its minimum: at its pace it would not have reached [`Effort::goal`].
    Outclassed,
    /// The model could not be simulated from the given start.
    NotFinite,
    /// Cancelled by the caller ([`Effort::cancelled`]).
    Cancelled,
}

impl Outcome {
    /// Whether the result is a minimum.
    pub fn was_successful(self) -> bool {
        matches!(self, Outcome::Converged | Outcome::Stalled)
    }
}

/// The limits of a minimisation.
#[derive(Clone, Copy)]
pub struct Effort<'a> {
    /// Largest number of evaluations of the normal equations.
    pub evaluations: usize,
    /// The minimisation ends when a step promises to lower the cost by less than this, relative to the mean squared
    /// residual. A move of one unknown by its standard error changes the cost by 1.
    pub tolerance: f64,
    /// The cost below which the fit is of interest. A fit is abandoned if, at its recent pace, it would not reach this
    /// cost with the evaluations that are left.
    pub goal: f64,
    /// Called before every evaluation except the first. If it returns `true`, the fit ends as [`Outcome::Cancelled`].
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Effort<'a> {
    /// The same limits, for a fit that is of interest only if its cost falls to `goal`.
    pub fn towards(self, goal: f64) -> Effort<'a> {
        Effort { goal, ..self }
    }

    /// The same limits, for a fit that ends when `cancelled` returns `true`.
    pub fn until(self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Effort<'a> {
        Effort { cancelled, ..self }
    }
}

impl Effort<'static> {
    /// To a hundredth of a standard error; for final results.
    pub const FULL: Effort<'static> = Effort {
        evaluations: 30,
        tolerance: 1e-4,
        goal: f64::INFINITY,
        cancelled: &|| false,
    };
    /// As [`Effort::FULL`] with more evaluations, for a minimum at the end of a long curved valley (such as the speed and
    /// the levels of a Stribeck curve), which takes many short steps.
    pub const PATIENT: Effort<'static> = Effort {
        evaluations: 200,
        ..Effort::FULL
    };
    /// To a third of a standard error; for deciding which of several starts or models is better.
    pub const SCORE: Effort<'static> = Effort {
        tolerance: 1e-1,
        ..Effort::FULL
    };
    /// Coarse; for handing over to the next stage of a schedule.
    pub const ROUGH: Effort<'static> = Effort {
        evaluations: 12,
        ..Effort::SCORE
    };
}

/// Number of recent evaluations that define the pace of a fit. A direct path to the minimum takes no more than these.
/// A fit that has strayed has up to six steps refused before it gains again.
const PACE: usize = 8;
/// Number of steps whose gains are extrapolated as a geometric series: without damping, least squares converge at
/// least linearly.
const SERIES: usize = 3;

/// The cost that a fit may still reach within so many more `evaluations`: at the pace of its last [`PACE`], or by a
/// geometric series if each of its last [`SERIES`] steps gained less than the one before. `costs` has one entry
/// per evaluation; a refused step repeats the previous cost.
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
