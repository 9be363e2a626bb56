//! The motion over time: classical Runge–Kutta steps, as long as accuracy and stability allow.

use super::{Plant, State};
use crate::effect::Instant;
use crate::input::Input;
use crate::{Kind, Reading, Scalar};

/// The inputs of the pendulum during a step.
#[derive(Clone, Copy, Debug)]
pub struct Drive<S> {
    /// Mean commanded current in A, after any delay.
    pub current_a: S,
    /// Push on the body in N m at the start, the middle and the end of the step.
    pub push: [f64; 3],
}

impl<S: Scalar> Drive<S> {
    /// The drive of a part of the step, from one share of it to another: the push along the parabola through its
    /// three values.
    pub(super) fn part(&self, from: f64, to: f64) -> Drive<S> {
        let push = |fraction: f64| {
            let [a, b, c] = self.push;
            let x = 2.0 * fraction - 1.0;
            b + 0.5 * (c - a) * x + (0.5 * (a + c) - b) * x * x
        };
        Drive {
            current_a: self.current_a,
            push: [push(from), push(0.5 * (from + to)), push(to)],
        }
    }
}

/// The current during a run, commanded or measured.
#[derive(Clone, Copy, Debug)]
pub enum Current<'a, S> {
    /// The current that the log records.
    Recorded(&'a Input),
    /// Constant at this value in A; for logs whose current was not recorded.
    Held(S),
}

/// Called at every sample of a run with its index, the sensors' reading and the state.
type Each<'a, S> = dyn FnMut(usize, &Reading<S>, &State<S>) + 'a;

/// Largest number of steps between two samples. Parameters that would need more are not physical on a bench that was
/// sampled at this rate. A fit that reaches such parameters should get a bad result quickly, not a good one after an
/// endless computation.
const MOST_PARTS: f64 = 64.0;
/// A step in which dry friction changes its sign is repeated in this many steps.
const KINK_PARTS: usize = 8;
/// Shortest step in s that is repeated in finer steps; below, no sensor would show the difference.
const KINK_STEP_S: f64 = 1.1e-3;
/// Number of time constants after which a lag has forgotten its initial state (e⁻¹⁰ is left).
const LAG_MEMORY: f64 = 10.0;
/// Largest change of the cogging's phase in one step, rad.
const RIPPLE_STEP_RAD: f64 = 1.0;
/// Largest number of parts of a step that cogging may require; faster cogging is left out.
const RIPPLE_MOST_PARTS: f64 = 8.0;

impl<S: Scalar> Plant<S> {
    /// The change of the cogging's phase in a step of `step_s` seconds, rad; `None` if that is too fast to be
    /// resolved. A faster ripple averages out; its amplitude in speed (below a/(j_w n φ̇)) is far below any sensor's
    /// noise.
    fn ripples(&self, wheel_speed_rad_s: f64, step_s: f64) -> Option<f64> {
        let order = self.structure.ripple_order?;
        let phase = (order * wheel_speed_rad_s * step_s).abs();
        (phase < RIPPLE_STEP_RAD * RIPPLE_MOST_PARTS).then_some(phase)
    }

    /// One step of the classical Runge–Kutta method (Hairer, Nørsett, Wanner I, table II.1.2),
    /// whose length is not checked. Lag and presliding friction use their exact solutions over
    /// the step, so they do not limit its length. `with_ripple` says whether cogging acts.
    // Not inlined: it is used twice, and large.
    #[inline(never)]
    fn rk4(&self, start: &State<S>, drive: &Drive<S>, step_s: f64, with_ripple: bool) -> State<S> {
        let half = 0.5 * step_s;
        let (middle, gain) = self.current_line(start.current_a, drive.current_a, step_s);
        let current = |after_s: f64| middle + gain * (after_s / step_s - 0.5);
        let moves_body = self.structure.kind != Kind::SpinUp;
        let moves_wheel = self.structure.kind != Kind::FreeSwing;
        let stage = |rate: S, rate_dot: S, wheel: S, wheel_dot: S, span: f64, push: f64| {
            let mut at = Instant {
                angle_rad: start.angle_rad,
                rate_rad_s: start.rate_rad_s,
                wheel_angle_rad: start.wheel_angle_rad,
                wheel_speed_rad_s: start.wheel_speed_rad_s,
                current_a: S::zero(),
                memory: S::zero(),
            };
            let mut memory = start.friction_torque;
            if moves_body {
                at.angle_rad += rate * span;
                at.rate_rad_s += rate_dot * span;
                memory = self.remember(memory, rate * span);
            }
            if moves_wheel {
                at.wheel_angle_rad += wheel * span;
                at.wheel_speed_rad_s += wheel_dot * span;
            }
            let (rate_dot, wheel_dot) =
                self.accelerations(&mut at, memory, current(span), push, with_ripple);
            (at.rate_rad_s, rate_dot, at.wheel_speed_rad_s, wheel_dot)
        };
        let zero = S::zero();
        let k1 = stage(zero, zero, zero, zero, 0.0, drive.push[0]);
        let k2 = stage(k1.0, k1.1, k1.2, k1.3, half, drive.push[1]);
        let k3 = stage(k2.0, k2.1, k2.2, k2.3, half, drive.push[1]);
        let k4 = stage(k3.0, k3.1, k3.2, k3.3, step_s, drive.push[2]);
        let weighted = |a: S, b: S, c: S, d: S| (a + (b + c) * 2.0 + d) * (step_s / 6.0);
        let mut end = *start;
        if moves_body {
            let displacement = weighted(k1.0, k2.0, k3.0, k4.0);
            end.angle_rad += displacement;
            end.rate_rad_s += weighted(k1.1, k2.1, k3.1, k4.1);
            end.friction_torque = self.remember(start.friction_torque, displacement);
        }
        if moves_wheel {
            end.wheel_angle_rad += weighted(k1.2, k2.2, k3.2, k4.2);
            end.wheel_speed_rad_s += weighted(k1.3, k2.3, k3.3, k4.3);
        }
        end.current_a = self.left_behind_lag(start.current_a, drive.current_a, step_s);
        end
    }

    /// The state after `step_s` seconds under `drive`. The interval is divided into as many equal steps as accuracy and
    /// stability require, and into finer ones where dry friction changes its sign.
    pub fn step(&self, start: &State<S>, drive: &Drive<S>, step_s: f64) -> State<S> {
        let ripple = self.ripples(start.wheel_speed_rad_s.value(), step_s);
        let with_ripple = self.structure.ripple_order.is_none() || ripple.is_some();
        let parts = (step_s / self.structure.longest_step_s)
            .max(ripple.unwrap_or(0.0) / RIPPLE_STEP_RAD)
            .ceil()
            .min(MOST_PARTS);
        if parts <= 1.0 {
            return self.checked_step(start, drive, step_s, with_ripple);
        }
        let part_s = step_s / parts;
        let mut state = *start;
        for part in 0..parts as usize {
            let drive = drive.part(part as f64 / parts, (part as f64 + 1.0) / parts);
            state = self.checked_step(&state, &drive, part_s, with_ripple);
        }
        state
    }

    /// The number of equal steps into which accuracy and stability divide an interval of `step_s` seconds, without
    /// regard to cogging.
    pub(super) fn parts(&self, step_s: f64) -> usize {
        let parts = step_s / self.structure.longest_step_s;
        parts.ceil().clamp(1.0, MOST_PARTS) as usize
    }

    /// One Runge–Kutta step over the whole of `step_s` seconds, backwards in time if `step_s` is negative.
    pub(super) fn single_step(&self, start: &State<S>, drive: &Drive<S>, step_s: f64) -> State<S> {
        self.rk4(start, drive, step_s, self.has_ripple(start, step_s))
    }

    /// Whether cogging acts in a step of `step_s` seconds from `start`; false if it is too fast to be resolved there.
    pub(super) fn has_ripple(&self, start: &State<S>, step_s: f64) -> bool {
        let ripple = self.ripples(start.wheel_speed_rad_s.value(), step_s);
        self.structure.ripple_order.is_none() || ripple.is_some()
    }

    fn checked_step(
        &self,
        start: &State<S>,
        drive: &Drive<S>,
        step_s: f64,
        with_ripple: bool,
    ) -> State<S> {
        let end = self.rk4(start, drive, step_s, with_ripple);
        let reverses = |before: S, after: S| before.value() * after.value() < 0.0;
        let kink = (self.structure.body_kink && reverses(start.rate_rad_s, end.rate_rad_s))
            || (self.structure.wheel_kink
                && reverses(start.wheel_speed_rad_s, end.wheel_speed_rad_s));
        if !kink || step_s < KINK_STEP_S {
            return end;
        }
        let mut state = *start;
        for _ in 0..KINK_PARTS {
            state = self.rk4(&state, drive, step_s / KINK_PARTS as f64, with_ripple);
        }
        state
    }

    /// Runs from `start` at `time_s[first]` to `time_s[last]` under the recorded current and calls
    /// `each` with the index, the reading and the state at every sample, both ends included.
    ///
    /// A run from the first sample takes the current of the start as the command from before the log, for as long as a
    /// delay or a lag remembers it. Any other run assumes that the first command was already held before the log.
    /// `push` gives the torque on the body in N m at a time in s. A thinned log has several samples of the current
    /// between two of its samples; the mean of the motor's response to them drives that interval.
    pub fn run(
        &self,
        start: State<S>,
        time_s: &[f64],
        samples: std::ops::Range<usize>,
        current: Current<S>,
        push: Option<&dyn Fn(f64) -> f64>,
        mut each: impl FnMut(usize, &Reading<S>, &State<S>),
    ) {
        self.follow(start, time_s, samples, current, push, &mut each);
    }

    /// [`Plant::run`], compiled only once for all callers.
    #[inline(never)]
    fn follow(
        &self,
        start: State<S>,
        time_s: &[f64],
        samples: std::ops::Range<usize>,
        current: Current<S>,
        push: Option<&dyn Fn(f64) -> f64>,
        each: &mut Each<S>,
    ) {
        let mut state = start;
        if let (Some(lag), Current::Recorded(input)) = (self.lag_s, current)
            && state.current_a.value() == 0.0
            && lag.value() >= 0.0
        {
            // A window in the middle of a log starts with the current that earlier commands left behind the lag.
            let forgotten_s = time_s[samples.start] - LAG_MEMORY * lag.value();
            let first = time_s[..samples.start]
                .partition_point(|&time| time < forgotten_s)
                .min(samples.start.saturating_sub(1));
            for k in first..samples.start {
                let (from, to) = (time_s[k], time_s[k + 1]);
                let drive = input.mean(from, to, self.delay_s, k);
                state.current_a = if k == first && k > 0 {
                    drive
                } else {
                    self.flowing_current(state.current_a, drive, to - from, to - from)
                };
            }
        }
        let before_a = match current {
            Current::Recorded(input) if samples.start > 0 => {
                S::constant(input.first().map_or(0.0, |(_, first_a)| first_a))
            }
            _ => start.current_a,
        };
        // A thinned log has more samples of the current than of the other channels.
        let is_thinned = |input: &Input| input.len() > time_s.len();
        let has_motor = !self.structure.motor.is_empty() || self.lag_s.is_some();
        let averaged = match current {
            Current::Recorded(input) if has_motor && is_thinned(input) => {
                Some((input, self.without_motor()))
            }
            _ => None,
        };
        let mut late = self.late_at_start(&state, time_s, &samples, current);
        for k in samples.clone() {
            match &late {
                None => each(k, &self.read(&state), &state),
                late => each(k, &self.read_late(&state, late.as_ref(), time_s[k]), &state),
            }
            if k + 1 >= samples.end {
                break;
            }
            // If the command steps within an interval of a thinned log, the interval is divided at the step.
            let delay_s = self.delay_s.as_ref().map_or(0.0, |delay| delay.value());
            let steps: &[f64] = match current {
                Current::Recorded(input) if is_thinned(input) => {
                    input.steps_within(time_s[k] - delay_s, time_s[k + 1] - delay_s)
                }
                _ => &[],
            };
            let steps = steps.iter().map(|step_s| step_s + delay_s);
            if let Some((input, driven)) = &averaged {
                let mut from = time_s[k];
                for to in steps.chain([time_s[k + 1]]) {
                    let (current_a, flowing_a) =
                        self.through_motor_on_average(input, &state, (from, to), before_a, k);
                    let push = push.map_or([0.0; 3], |push| {
                        [push(from), push(0.5 * (from + to)), push(to)]
                    });
                    let drive = Drive { current_a, push };
                    state = driven.step_with(&state, &drive, (from, to), late.as_mut());
                    state.current_a = flowing_a;
                    from = to;
                }
                continue;
            }
            // If a delayed command changes within the interval, the interval is divided there.
            let change = match (current, &self.delay_s) {
                (Current::Recorded(input), Some(delay)) if !is_thinned(input) => {
                    input.change_within(time_s[k], time_s[k + 1], delay.value(), k)
                }
                _ => None,
            };
            let mut from = time_s[k];
            // Nothing is allocated where there is no cut, as in nearly all intervals.
            let mut cuts: Vec<f64> = change.into_iter().chain(steps).collect();
            if !self.early_steps.is_empty() {
                self.cut_at_early_steps(&mut cuts, time_s[k], time_s[k + 1]);
            }
            for to in cuts.into_iter().chain([time_s[k + 1]]) {
                let drive = Drive {
                    current_a: match current {
                        Current::Recorded(input) => self.command(input, (from, to), before_a, k),
                        Current::Held(current) => current,
                    },
                    push: push.map_or([0.0; 3], |push| {
                        [push(from), push(0.5 * (from + to)), push(to)]
                    }),
                };
                state = self.step_with(&state, &drive, (from, to), late.as_mut());
                from = to;
            }
        }
    }
}
