//! Sensors whose reading depends on the past: it follows the measured quantity with a lag, or shows it after a delay.
//!
//! These sensors do not act on the motion. They receive the motion piece by piece: over every step of the integration
//! each of the three outputs is the cubic through its values and slopes at both ends (Hairer, Nørsett, Wanner I, ch.
//! II.6), as exact as the step itself. Behind a lag T, T ẏ = v − y, a cubic v has the answer v − T v̇ + T² v̈ − T³ v⃛ +
//! c exp(−t/T) in closed form, so that the lag may be short or long against the step; a delay reads the cubic at t − δ.
//! Both carry exact derivatives.
//!
//! Bias, scale, offset and eccentricity are applied afterwards. The result is that of the stated chain (eccentricity or
//! scale, offset or bias, lag, delay), because a delay commutes with every stage without memory, and a lag commutes
//! with scale and bias; the angle has no lag.
//!
//! **Before the first sample of a run.** A delay needs v before the log began, where nothing was recorded. The assumed
//! motion lies between two extremes: body and wheel stood still as at the first sample (a swing is released, a step is
//! commanded), or they already moved as the model predicts: [`Plant::with_motion_before`]. A run that begins in the
//! middle of a log has the commands before it: the motion is integrated back from its start, as far as the delays and
//! the lags reach.

mod piece;

use std::collections::VecDeque;
use std::ops::Range;

use super::{Drive, Plant, State};
use crate::effect::Instant;
use crate::plant::integrator::Current;
use crate::{Kind, Output, Reading, Scalar, Timing};
use piece::Piece;

/// A lag has forgotten its past after this many time constants: e⁻⁴ of a deviation is left by then, and the
/// reconstructed past itself is only a little off.
const LAG_MEMORY: f64 = 4.0;
/// The past is reconstructed over at most this time, in s. Near upright, errors grow on the way back.
const LONGEST_PAST_S: f64 = 0.5;
/// Largest number of integration steps with which the past is reconstructed.
const MOST_STEPS_BACK: f64 = 2000.0;
/// If all lags and delays are shorter than this, in s, the past does not matter.
const NO_TIME_S: f64 = 1e-9;

/// Lag and delay of one sensor.
#[derive(Clone, Copy, Debug)]
struct Timings<S> {
    lag_s: Option<S>,
    delay_s: Option<S>,
}

impl<S> Timings<S> {
    fn is_none(&self) -> bool {
        self.lag_s.is_none() && self.delay_s.is_none()
    }
}

/// One sensor with a lag or a delay.
#[derive(Clone, Debug)]
struct Channel<S> {
    output: Output,
    timings: Timings<S>,
    /// The present reading before the delay.
    now: S,
    /// The pieces that the delay still needs, oldest first.
    kept: VecDeque<Piece<S>>,
}

impl<S: Scalar> Channel<S> {
    /// Receives the next piece of the measured quantity.
    fn take(&mut self, piece: Piece<S>) {
        let piece = match self.timings.lag_s {
            Some(lag_s) => piece.behind(lag_s, self.now),
            None => piece,
        };
        self.now = piece.to;
        if let Some(delay_s) = self.timings.delay_s {
            self.kept.push_back(piece);
            let asked_s = piece.to_s - delay_s.value();
            while self.kept.len() > 1 && self.kept[0].to_s < asked_s {
                self.kept.pop_front();
            }
        }
    }

    /// The reading of the sensor at `time_s`, which must not lie before the start of the last piece. Where the delay
    /// reaches back before the first piece that is kept, the reading is the value at the start of that piece.
    fn says(&self, time_s: f64) -> S {
        let Some(delay_s) = self.timings.delay_s else {
            return self.now;
        };
        let asked_s = time_s - delay_s.value();
        let Some(first) = self.kept.front() else {
            return self.now;
        };
        if asked_s < first.from_s {
            return first.from;
        }
        let at = self.kept.partition_point(|piece| piece.to_s < asked_s);
        let piece = &self.kept[at.min(self.kept.len() - 1)];
        piece.at(S::constant(time_s - piece.from_s) - delay_s)
    }
}

/// The sensors of a plant that have a lag or a delay, along one run.
#[derive(Clone, Debug)]
pub struct Late<S> {
    channels: Vec<Channel<S>>,
    /// Whether a sensor needs the slope of a rate or a speed, and thus the accelerations where a piece ends.
    needs_accelerations: bool,
}

/// The values of the outputs and their derivatives with respect to time.
#[derive(Clone, Copy, Debug)]
struct Measured<S> {
    values: [S; 3],
    slopes: [S; 3],
}

/// One step of the motion before a run: its start and end in s, and the measured quantities at both.
type Past<S> = ((f64, f64), Measured<S>, Measured<S>);

impl<S: Scalar> Plant<S> {
    /// The share of the model's motion that took place before the first sample of a log, for sensors with a delay. With
    /// 0, the default, body and wheel stood still until then; with 1 they moved as the model predicts.
    #[must_use]
    pub fn with_motion_before(mut self, share: S) -> Plant<S> {
        self.motion_before = share;
        self
    }

    /// Lags and delays of the sensors, by output.
    fn sensor_timings(&self) -> Vec<(Output, Timings<S>)> {
        let own = |output: Output| {
            let mut timings = Timings {
                lag_s: None,
                delay_s: None,
            };
            for (effect, info) in self.structure.late.iter().map(|t| (t, t.effect.info())) {
                if info.senses != Some(output) {
                    continue;
                }
                let p = self.p(effect);
                match info.sensor_timing {
                    Some(Timing::Lag) => timings.lag_s = effect.effect.lag_s(p),
                    Some(Timing::Delay) => timings.delay_s = effect.effect.delay_s(p),
                    None => {}
                }
            }
            (output, timings)
        };
        let all = Output::ALL.map(own);
        all.into_iter().filter(|(_, own)| !own.is_none()).collect()
    }

    /// Whether the model has sensors with a lag or a delay.
    pub fn has_late_sensors(&self) -> bool {
        !self.structure.late.is_empty()
    }

    /// Lag and delay of the sensor of an output in s, 0 where it has none.
    pub fn sensor_times_s(&self, output: Output) -> (f64, f64) {
        let of = |time_s: Option<S>| time_s.map_or(0.0, |time_s| time_s.value());
        let timings = self.sensor_timings();
        let own = timings.iter().find(|(sensor, _)| *sensor == output);
        own.map_or((0.0, 0.0), |(_, own)| (of(own.lag_s), of(own.delay_s)))
    }

    /// The sensors that have a lag or a delay, at the start of a run without any motion before it; `None` where the
    /// model has no such sensors.
    pub fn late_sensors(&self, start: &State<S>) -> Option<Late<S>> {
        if !self.has_late_sensors() {
            return None;
        }
        let values = outputs(start);
        let mut needs_accelerations = false;
        let channels = self.sensor_timings().into_iter().map(|(output, timings)| {
            needs_accelerations |= output != Output::Angle;
            Channel {
                output,
                timings,
                now: values[output as usize],
                kept: VecDeque::new(),
            }
        });
        let channels = channels.collect();
        Some(Late {
            channels,
            needs_accelerations,
        })
    }

    /// The readings of the sensors in a state. `time_s` must not be later than the motion that `late` has received.
    pub fn read_late(&self, state: &State<S>, late: Option<&Late<S>>, time_s: f64) -> Reading<S> {
        let mut reading = Reading {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
        };
        for channel in late.iter().flat_map(|late| &late.channels) {
            *channel.output.part_of(&mut reading) = channel.says(time_s);
        }
        self.distorted(reading)
    }

    /// The state after the step from `from_s` to `to_s` under `drive`, like [`Plant::step`]. `late`, if there is one,
    /// receives the motion of this step.
    pub fn step_with(
        &self,
        start: &State<S>,
        drive: &Drive<S>,
        (from_s, to_s): (f64, f64),
        late: Option<&mut Late<S>>,
    ) -> State<S> {
        let Some(late) = late else {
            return self.step(start, drive, to_s - from_s);
        };
        // A cubic spans one step of the integration, and no more.
        let parts = self.parts(to_s - from_s);
        let mut state = *start;
        let mut before_s = from_s;
        for part in 1..=parts {
            let share = |part: usize| part as f64 / parts as f64;
            let after_s = if part == parts {
                to_s
            } else {
                from_s + (to_s - from_s) * share(part)
            };
            let drive = drive.part(share(part - 1), share(part));
            let step_s = after_s - before_s;
            let (middle, gain) = self.current_line(state.current_a, drive.current_a, step_s);
            let end = self.step(&state, &drive, step_s);
            let pushes = drive.push;
            let of = |state: &State<S>, current_a: S, push: f64| {
                late.measured(self, state, (current_a, push), step_s)
            };
            let from = of(&state, middle - gain * 0.5, pushes[0]);
            let to = of(&end, middle + gain * 0.5, pushes[2]);
            late.take((before_s, after_s), &from, &to);
            state = end;
            before_s = after_s;
        }
        state
    }

    /// The sensors with a lag or a delay at the start of a run over these samples. They have received the motion before
    /// it.
    pub(super) fn late_at_start(
        &self,
        start: &State<S>,
        time_s: &[f64],
        samples: &Range<usize>,
        current: Current<S>,
    ) -> Option<Late<S>> {
        let mut late = self.late_sensors(start)?;
        let first = samples.start;
        let (Some(&start_s), Some(interval_s)) = (time_s.get(first), mean_interval_s(time_s))
        else {
            return Some(late);
        };
        let begins_with_log = first == 0;
        let span_s = late.memory_s(begins_with_log).min(LONGEST_PAST_S);
        let first_s = time_s.first().copied().unwrap_or(start_s);
        let span_s = if begins_with_log {
            span_s
        } else {
            span_s.min(start_s - first_s)
        };
        if span_s < NO_TIME_S {
            return Some(late);
        }
        let unlagged = self.without_timing();
        let step_s = self.structure.longest_step_s.min(interval_s);
        let steps = (span_s / step_s).ceil().clamp(1.0, MOST_STEPS_BACK);
        let step_s = span_s / steps;
        let currents = self.currents_back(start_s, step_s, steps as usize, time_s, first, current);
        // The motion is integrated backwards from the start; its pieces are then sorted forwards in time.
        let mut state = *start;
        let mut pieces = vec![];
        let mut to_s = start_s;
        for (back, &current_a) in currents.iter().enumerate() {
            let from_s = start_s - step_s * (back + 1) as f64;
            let drive = Drive {
                current_a,
                push: [0.0; 3],
            };
            let to = late.measured(&unlagged, &state, (current_a, 0.0), step_s);
            state = unlagged.single_step(&state, &drive, from_s - to_s);
            let from = late.measured(&unlagged, &state, (current_a, 0.0), step_s);
            pieces.push(((from_s, to_s), from, to));
            to_s = from_s;
        }
        pieces.reverse();
        // Pieces with values that are not finite are dropped.
        let is_number = |value: &S| value.value().is_finite();
        let is_motion =
            |(_, from, _): &Past<S>| from.values.iter().chain(&from.slopes).all(is_number);
        pieces.retain(is_motion);
        if begins_with_log {
            late.had_moved(&pieces, self.motion_before);
        } else {
            late.follow(&pieces, start_s - span_s - first_s > 0.5 * interval_s);
        }
        Some(late)
    }

    /// The current after delay and lag of the motor, for the steps before the start of a run, the latest step first.
    fn currents_back(
        &self,
        start_s: f64,
        step_s: f64,
        steps: usize,
        time_s: &[f64],
        first: usize,
        current: Current<S>,
    ) -> Vec<S> {
        let Current::Recorded(input) = current else {
            let Current::Held(held) = current else {
                return vec![S::zero(); steps];
            };
            return vec![held; steps];
        };
        let before_a = S::constant(input.first().map_or(0.0, |(_, first_a)| first_a));
        let hint = |time_s_: f64| {
            let after = time_s[..=first].partition_point(|&sample_s| sample_s <= time_s_);
            after.saturating_sub(1)
        };
        let lag = self.lag_s.map_or(0.0, |lag| lag.value().max(0.0));
        let lead = ((LAG_MEMORY * lag / step_s).ceil() as usize).min(MOST_STEPS_BACK as usize);
        let mut flowing: Option<S> = None;
        let mut forwards = vec![];
        for back in (0..steps + lead).rev() {
            let from_s = start_s - step_s * (back + 1) as f64;
            let to_s = start_s - step_s * back as f64;
            let drive = self.command(input, (from_s, to_s), before_a, hint(from_s));
            let before = flowing.unwrap_or(drive);
            let (middle, _) = self.current_line(before, drive, step_s);
            flowing = Some(self.left_behind_lag(before, drive, step_s));
            if back < steps {
                forwards.push(middle);
            }
        }
        forwards.reverse();
        forwards
    }
}

fn mean_interval_s(time_s: &[f64]) -> Option<f64> {
    let (first, last) = (time_s.first()?, time_s.last()?);
    let interval_s = (last - first) / time_s.len().saturating_sub(1).max(1) as f64;
    (interval_s > 0.0).then_some(interval_s)
}

/// The true outputs of a state, in the order of [`Output::ALL`].
fn outputs<S: Scalar>(state: &State<S>) -> [S; 3] {
    [state.angle_rad, state.rate_rad_s, state.wheel_speed_rad_s]
}

impl<S: Scalar> Late<S> {
    /// Outputs and their slopes in a state, at an end of a step of length `step_s`. The current is that after the
    /// motor's lag; `push` is the torque of a push.
    fn measured(
        &self,
        plant: &Plant<S>,
        state: &State<S>,
        (current_a, push): (S, f64),
        step_s: f64,
    ) -> Measured<S> {
        let (rate_dot, wheel_dot) = if self.needs_accelerations {
            let mut at = Instant {
                angle_rad: state.angle_rad,
                rate_rad_s: state.rate_rad_s,
                wheel_angle_rad: state.wheel_angle_rad,
                wheel_speed_rad_s: state.wheel_speed_rad_s,
                current_a: S::zero(),
                memory: S::zero(),
            };
            let with_ripple = plant.has_ripple(state, step_s);
            plant.accelerations(&mut at, state.friction_torque, current_a, push, with_ripple)
        } else {
            (S::zero(), S::zero())
        };
        let rate = if plant.structure.kind == Kind::SpinUp {
            S::zero()
        } else {
            state.rate_rad_s
        };
        Measured {
            values: outputs(state),
            slopes: [rate, rate_dot, wheel_dot],
        }
    }

    fn take(&mut self, (from_s, to_s): (f64, f64), from: &Measured<S>, to: &Measured<S>) {
        for channel in &mut self.channels {
            let at = channel.output as usize;
            channel.take(Piece {
                from_s,
                to_s,
                from: from.values[at],
                from_slope: from.slopes[at],
                to: to.values[at],
                to_slope: to.slopes[at],
            });
        }
    }

    /// How far back from the start of a run the motion still influences a reading, in s.
    fn memory_s(&self, begins_with_log: bool) -> f64 {
        let of = |time_s: Option<S>| time_s.map_or(0.0, |time_s| time_s.value().max(0.0));
        let channels = self.channels.iter().map(|channel| {
            // At the first sample of a log the output of a lag equals its input.
            let lag_s = if begins_with_log {
                0.0
            } else {
                LAG_MEMORY * of(channel.timings.lag_s)
            };
            of(channel.timings.delay_s) + lag_s
        });
        channels.fold(0.0, f64::max)
    }

    /// Feeds the past of a run that begins in the middle of a log. Where the past begins later than the log (`is_cut`),
    /// a lag starts as if the slope of its input had always been the first slope of that past.
    fn follow(&mut self, pieces: &[Past<S>], is_cut: bool) {
        let Some((_, oldest, _)) = pieces.first() else {
            return;
        };
        for channel in &mut self.channels {
            let at = channel.output as usize;
            channel.now = oldest.values[at];
            if let (Some(lag_s), true) = (channel.timings.lag_s, is_cut) {
                channel.now = channel.now - lag_s * oldest.slopes[at];
            }
        }
        for (span, from, to) in pieces {
            self.take(*span, from, to);
        }
    }

    /// Fills the pieces that a delay reads before the first sample of a log. The deviation from the values at that
    /// sample is `share` times the deviation that the model predicts.
    fn had_moved(&mut self, pieces: &[Past<S>], share: S) {
        for channel in &mut self.channels {
            if channel.timings.delay_s.is_none() {
                continue;
            }
            let at = channel.output as usize;
            let start = channel.now;
            for ((from_s, to_s), from, to) in pieces {
                channel.kept.push_back(Piece {
                    from_s: *from_s,
                    to_s: *to_s,
                    from: start + share * (from.values[at] - start),
                    from_slope: share * from.slopes[at],
                    to: start + share * (to.values[at] - start),
                    to_slope: share * to.slopes[at],
                });
            }
        }
    }
}
