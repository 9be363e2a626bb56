//! The chain from the command to the current that makes the torque: delay, lag, static stages.

use super::{Plant, State};
use crate::Scalar;
use crate::effect::Instant;
use crate::input::{Input, LEAST_SHARE};

impl<S: Scalar> Plant<S> {
    /// The delay of the motor's current in s, if the model has one.
    pub fn delay_s(&self) -> Option<S> {
        self.delay_s
    }

    /// The current in A that makes the torque, computed from the current behind the lag.
    #[inline(always)]
    pub(super) fn through_motor(&self, current_a: S, at: &Instant<S>) -> S {
        if self.structure.motor.is_empty() {
            current_a
        } else {
            self.through_stages(current_a, at)
        }
    }

    // Not inlined: most models do not have such a stage.
    #[inline(never)]
    fn through_stages(&self, current_a: S, at: &Instant<S>) -> S {
        let mut current_a = current_a;
        for term in &self.structure.motor {
            let effect = term.effect;
            current_a = effect.current(self.p(term), current_a, at, self.torque_constant);
        }
        current_a
    }

    /// The same plant, with the torque-making current as its input.
    pub(super) fn without_motor(&self) -> Plant<S> {
        let mut driven = self.clone();
        driven.structure.motor.clear();
        driven.lag_s = None;
        driven.delay_s = None;
        driven
    }

    /// The same plant driven by the current behind delay and lag.
    pub(super) fn without_timing(&self) -> Plant<S> {
        let mut driven = self.clone();
        driven.lag_s = None;
        driven.delay_s = None;
        driven
    }

    /// The mean command in A that reaches the motor over [from_s, to_s], after the model's delay, if it has one.
    /// `before_a` was commanded before the log began. `hint` is the index of a sample nearby.
    pub fn command(
        &self,
        input: &Input,
        (from_s, to_s): (f64, f64),
        before_a: S,
        hint: usize,
    ) -> S {
        let mut mean = input.mean(from_s, to_s, self.delay_s, hint);
        if !self.early_steps.is_empty() {
            mean += self.of_early_steps(from_s, to_s);
        }
        let (Some(delay), Some((first_s, first_a))) = (self.delay_s, input.first()) else {
            return mean;
        };
        // For this long, the command from before the log is still effective.
        let late = delay + (first_s - from_s);
        let span_s = to_s - from_s;
        if late.value() <= 0.0 {
            mean
        } else if late.value() > span_s * (1.0 + LEAST_SHARE) {
            before_a
        } else {
            // The end of the interval counts as inside, because `run` divides intervals there: with a longer delay the
            // change of the current belongs to the next interval.
            mean + (before_a - first_a) * late * (1.0 / span_s)
        }
    }

    /// The mean of the torque-making current over [from_s, to_s], and the current behind the lag at its end, in A. Each
    /// sample of the command passes through the motor separately.
    // Not inlined: only thinned logs use it.
    #[inline(never)]
    pub(super) fn through_motor_on_average(
        &self,
        input: &Input,
        state: &State<S>,
        (from_s, to_s): (f64, f64),
        before_a: S,
        hint: usize,
    ) -> (S, S) {
        let at = Instant {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_angle_rad: state.wheel_angle_rad,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
            current_a: S::zero(),
            memory: S::zero(),
        };
        let delay_s = self.delay_s.map_or(0.0, |delay| delay.value());
        let mut charge_as = S::zero();
        let mut flowing_a = state.current_a;
        for (start_s, end_s) in input.stretches(from_s, to_s, delay_s, hint) {
            let span_s = end_s - start_s;
            let drive_a = self.command(input, (start_s, end_s), before_a, hint);
            let (middle_a, _) = self.current_line(flowing_a, drive_a, span_s);
            charge_as += self.through_motor(middle_a, &at) * span_s;
            flowing_a = self.left_behind_lag(flowing_a, drive_a, span_s);
        }
        (charge_as * (1.0 / (to_s - from_s)), flowing_a)
    }

    /// The current behind the lag at the end of a step, with which the next step starts.
    #[inline(always)]
    pub(super) fn left_behind_lag(&self, start_a: S, drive_a: S, step_s: f64) -> S {
        match self.lag_s {
            Some(lag) if lag.value() > 0.0 => {
                self.flowing_current(start_a, drive_a, step_s, step_s)
            }
            _ => drive_a,
        }
    }

    /// The current in A behind the lag, `after_s` into an interval of `step_s`. `start_a` is the current at
    /// its beginning, `drive_a` the mean command over it (after any delay).
    #[inline(never)]
    pub fn flowing_current(&self, start_a: S, drive_a: S, after_s: f64, step_s: f64) -> S {
        match self.lag_s {
            Some(lag) if lag.value() > 0.0 => {
                let decay = (S::constant(-after_s) / lag).exp();
                drive_a + (start_a - drive_a) * decay
            }
            // A lag T → 0 delays the current by T. The first-order term −T di/dt is kept, so that the
            // derivative with respect to T exists at T = 0.
            Some(lag) => drive_a - lag * (drive_a - start_a) * (1.0 / step_s),
            None => drive_a,
        }
    }

    /// The current during a step as a straight line: its value in A in the middle, and its change in A
    /// from start to end.
    ///
    /// Behind a lag T, the current follows an exponential. The three points of a Runge–Kutta
    /// step do not resolve it if T is short against the step h. The line has the same integral and the
    /// same first moment, ∫c ds = M₀ and ∫(1 − s) c ds = M₁ over s = t/h. The resulting speed and
    /// angle are correct for every lag, and the limit T → 0 is the model without lag. With
    /// θ = T/h and E = exp(−1/θ): M₀ = θ (1 − E) and M₁ = θ − θ² (1 − E). For a line
    /// A + B (s − 1/2), RK4 gives the moments A and A/2 − B/12.
    #[inline(always)]
    pub(super) fn current_line(&self, start_a: S, drive_a: S, step_s: f64) -> (S, S) {
        match self.lag_s {
            Some(lag) => Self::line_behind_lag(lag, start_a, drive_a, step_s),
            None => (drive_a, S::zero()),
        }
    }

    // Not inlined: most models do not have a lag.
    #[inline(never)]
    fn line_behind_lag(lag: S, start_a: S, drive_a: S, step_s: f64) -> (S, S) {
        let theta = lag * (1.0 / step_s);
        let left = if theta.value() > 0.0 {
            (S::constant(-1.0) / theta).exp()
        } else {
            S::zero()
        };
        let zeroth = theta * (S::constant(1.0) - left);
        let first = theta - theta * zeroth;
        let gain = (zeroth * 0.5 - first) * 12.0;
        let excess = start_a - drive_a;
        (drive_a + excess * zeroth, excess * gain)
    }
}
