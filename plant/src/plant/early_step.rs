//! Steps of a command that came earlier than the sample which shows them.
//!
//! A log says what the command was at its samples, and nothing about the instants between them. A command that a
//! controller changes between two samples is recorded with the later one. If it changed by Δ at t − e instead of at t,
//! then Δ times e more charge has flowed from t on: ∫ i dt grows by Δ c(t′), with c(t′) = t′ − (t − e) limited to
//! [0, e]. The mean command over an interval contains this charge, and an interval of the integration ends where the
//! step comes. The motion is differentiable with respect to e; behind a stage of the motor that is no straight line, the derivative
//! has the slope of the stage at the new command instead of its chord, and a fit takes more rounds.

use super::Plant;
use crate::Scalar;
use crate::input::LEAST_SHARE;

/// A step of a held command that came earlier than its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarlyStep<S> {
    /// Time in s of the first sample with the new command.
    pub sample_s: f64,
    /// New command minus old command, A.
    pub change_a: f64,
    /// By how much the step came earlier than this sample, s; negative: later.
    pub earlier_s: S,
}

impl<S: Scalar> EarlyStep<S> {
    /// The charge in A s up to `time_s` that a step at the sample would not have brought.
    fn charge(&self, time_s: S) -> S {
        let since = time_s - self.sample_s;
        let earlier = self.earlier_s;
        let time = if earlier.value() >= 0.0 {
            let time = since + earlier;
            // An interval that begins with the step has all of its charge, and its derivative.
            if time.value() <= LEAST_SHARE * earlier.value() {
                S::zero()
            } else if since.value() >= 0.0 {
                earlier
            } else {
                time
            }
        } else if since.value() <= 0.0 {
            S::zero()
        } else if (since + earlier).value() >= 0.0 {
            earlier
        } else {
            -since
        };
        time * self.change_a
    }
}

impl<S: Scalar> Plant<S> {
    /// The same plant, with these steps of the recorded command earlier than the samples that show them, in the order of
    /// time.
    #[must_use]
    pub fn with_early_steps(mut self, steps: Vec<EarlyStep<S>>) -> Plant<S> {
        self.early_steps = steps;
        self
    }

    /// Adds the instants within (from_s, to_s) at which an early step reaches the motor, and sorts. A stage of the motor that
    /// is no straight line, such as a dead zone, must not get the mean of both commands.
    // Not inlined: most logs have none.
    #[inline(never)]
    pub(super) fn cut_at_early_steps(&self, cuts: &mut Vec<f64>, from_s: f64, to_s: f64) {
        let delay_s = self.delay_s.map_or(0.0, |delay| delay.value());
        let least_s = LEAST_SHARE * (to_s - from_s);
        let steps = self.early_steps.iter();
        let instants = steps.map(|step| step.sample_s - step.earlier_s.value() + delay_s);
        cuts.extend(instants.filter(|&at_s| at_s > from_s + least_s && at_s < to_s - least_s));
        cuts.sort_unstable_by(f64::total_cmp);
    }

    /// By how much early steps raise the mean command over [from_s, to_s], in A, after the model's delay.
    // Not inlined: most logs have none.
    #[inline(never)]
    pub(super) fn of_early_steps(&self, from_s: f64, to_s: f64) -> S {
        let delay = self.delay_s.unwrap_or(S::zero());
        let (from, to) = (S::constant(from_s) - delay, S::constant(to_s) - delay);
        let mut charge = S::zero();
        for step in &self.early_steps {
            let earlier_s = step.earlier_s.value();
            let (first_s, last_s) = (
                step.sample_s - earlier_s.max(0.0),
                step.sample_s - earlier_s.min(0.0),
            );
            if first_s < to.value() && last_s > from.value() {
                charge += step.charge(to) - step.charge(from);
            }
        }
        charge * (1.0 / (to_s - from_s))
    }
}
