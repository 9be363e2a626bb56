//! The closed loop: sample, command, hold.
//!
//! At every sample, the sensors are read, the law commands a current, and the drive clips it. The current
//! flows until the command of the next sample replaces it. A delay (of the computation, or of the
//! model's effect `input-delay`) postpones that change to any instant, also between samples; the
//! integration step is then divided there.

use crate::error::{SimulateError, check_positive};
use crate::law::{Law, LawFailure, Measured};
use crate::motion::Motion;
use crate::push::{Push, torque_at};
use crate::sensors::{Sensors, from_upright_rad};
use plant::{Drive, Late, Reading, State};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI};

/// The drive, between command and current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Largest current in A; larger commands are clipped.
    pub limit_a: f64,
    /// Step of the command's converter in A; zero for none.
    pub step_a: f64,
}

impl Actuator {
    /// The drive of the thesis: ±2.2 A over 10 % to 90 % of a 16-bit duty (6554 to 58982).
    pub const OF_THE_THESIS: Actuator = Actuator {
        limit_a: 2.2,
        step_a: 4.4 / (58982.0 - 6554.0),
    };

    fn flows(&self, command_a: f64) -> f64 {
        let stepped = if self.step_a > 0.0 {
            (command_a / self.step_a).round() * self.step_a
        } else {
            command_a
        };
        stepped.clamp(-self.limit_a, self.limit_a)
    }
}

/// All settings of a run, except the law.
#[derive(Clone, Debug)]
pub struct ClosedLoop<'a> {
    /// The plant.
    pub motion: Motion<'a>,
    /// The sensors, whose readings the law receives.
    pub sensors: Sensors,
    /// The drive.
    pub actuator: Actuator,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// Time in s from a sample to the change of the current, in addition to the model's own delay.
    pub computation_s: f64,
    /// Pushes on the body.
    pub pushes: Vec<Push>,
    /// Seed of the sensors' noise; runs with the same seed have the same noise.
    pub seed: u64,
}

/// The record of a run, with one entry per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopTrace {
    /// Time in s.
    pub time_s: Vec<f64>,
    /// True body angle from upright in rad, within ±π.
    pub angle_rad: Vec<f64>,
    /// True body rate in rad/s.
    pub rate_rad_s: Vec<f64>,
    /// True wheel speed in rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Angle that the law received, rad from upright.
    pub measured_angle_rad: Vec<f64>,
    /// Rate that the law received, rad/s.
    pub measured_rate_rad_s: Vec<f64>,
    /// Wheel speed that the law received, rad/s.
    pub measured_wheel_speed_rad_s: Vec<f64>,
    /// Current that the law commanded, A.
    pub current_a: Vec<f64>,
    /// Push on the body, N m.
    pub push: Vec<f64>,
    /// Time in s at which the body first was horizontal; `None` if it never was.
    pub fell_at_s: Option<f64>,
}

/// The bench at the instant of a sample.
pub(crate) struct Instant<'a> {
    /// The true state.
    pub state: &'a State<f64>,
    /// The readings of the model's sensors in this state, without noise.
    pub reading: Reading<f64>,
    /// Current that flows just before, in A.
    pub flowing_a: f64,
    /// Torque of the pushes, N m.
    pub push: f64,
}

/// The measurement that a controller received at a sample, and its command.
pub(crate) struct Answer {
    /// The measurement.
    pub measured: Measured,
    /// The current in A.
    pub command_a: f64,
}

/// Largest differences between two runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Largest difference of the angle, rad.
    pub angle_rad: f64,
    /// Largest difference of the rate, rad/s.
    pub rate_rad_s: f64,
    /// Largest difference of the wheel speed, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Largest difference of the command, A.
    pub current_a: f64,
}

impl LoopTrace {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The columns with their names, in the order of a table.
    pub fn columns(&self) -> [(&'static str, &[f64]); 9] {
        [
            ("time_s", &self.time_s),
            ("angle_from_upright_rad", &self.angle_rad),
            ("rate_rad_s", &self.rate_rad_s),
            ("wheel_speed_rad_s", &self.wheel_speed_rad_s),
            ("measured_angle_from_upright_rad", &self.measured_angle_rad),
            ("measured_rate_rad_s", &self.measured_rate_rad_s),
            (
                "measured_wheel_speed_rad_s",
                &self.measured_wheel_speed_rad_s,
            ),
            ("current_A", &self.current_a),
            ("push_N_m", &self.push),
        ]
    }

    /// Largest differences to `other` over the samples that both have.
    pub fn deviation(&self, other: &LoopTrace) -> Deviation {
        let largest = |left: &[f64], right: &[f64]| {
            left.iter()
                .zip(right)
                .map(|(left, right)| (left - right).abs())
                .fold(0.0, f64::max)
        };
        Deviation {
            angle_rad: largest(&self.angle_rad, &other.angle_rad),
            rate_rad_s: largest(&self.rate_rad_s, &other.rate_rad_s),
            wheel_speed_rad_s: largest(&self.wheel_speed_rad_s, &other.wheel_speed_rad_s),
            current_a: largest(&self.current_a, &other.current_a),
        }
    }
}

/// A body at rest at `angle_rad` from upright, with the wheel still.
pub fn at_rest(angle_rad: f64) -> State<f64> {
    State {
        angle_rad: PI + angle_rad,
        ..State::rest()
    }
}

impl ClosedLoop<'_> {
    fn check(&self) -> Result<(), SimulateError> {
        check_positive("the sample time in s", self.sample_time_s)?;
        check_positive("the current limit of the drive in A", self.actuator.limit_a)?;
        if !(self.computation_s.is_finite() && self.computation_s >= 0.0) {
            return Err(SimulateError::NotPositive {
                what: "the computation time in s",
                value: self.computation_s,
            });
        }
        Ok(())
    }

    /// Runs `law` from `start` for `duration_s` seconds. If `until_fall` is set, the run ends early once the body has
    /// fallen to the horizontal.
    ///
    /// # Errors
    /// Times that are not positive; a law that fails; a motion that is no longer finite.
    pub fn run(
        &self,
        start: &State<f64>,
        duration_s: f64,
        law: &mut dyn Law,
        until_fall: bool,
    ) -> Result<LoopTrace, SimulateError> {
        self.run_until(start, duration_s, law, |trace| {
            until_fall && trace.fell_at_s.is_some()
        })
        .map(|(trace, _)| trace)
    }

    /// Runs the loop like [`ClosedLoop::run`], but ends as soon as `over` returns `true`; also returns the last state.
    pub(crate) fn run_until(
        &self,
        start: &State<f64>,
        duration_s: f64,
        law: &mut dyn Law,
        over: impl Fn(&LoopTrace) -> bool,
    ) -> Result<(LoopTrace, State<f64>), SimulateError> {
        law.reset();
        let sample = |instant: &Instant<'_>, random: &mut ChaCha8Rng| {
            let measured = self.sensors.read(&instant.reading, random);
            let command_a = law.command_a(&measured)?;
            Ok(Answer {
                measured,
                command_a,
            })
        };
        self.run_sampled(start, duration_s, sample, over)
    }

    /// The loop itself: `sample` is called at every sample time.
    pub(crate) fn run_sampled(
        &self,
        start: &State<f64>,
        duration_s: f64,
        mut sample: impl FnMut(&Instant<'_>, &mut ChaCha8Rng) -> Result<Answer, LawFailure>,
        over: impl Fn(&LoopTrace) -> bool,
    ) -> Result<(LoopTrace, State<f64>), SimulateError> {
        self.check()?;
        check_positive("the duration in s", duration_s)?;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let samples = (duration_s / self.sample_time_s).round() as usize + 1;
        let mut trace = LoopTrace::default();
        let mut state = *start;
        let mut late = self.motion.late_sensors(start);
        let delay_s = self.computation_s + self.motion.delay_s();
        // Commands that have not reached the motor yet, each with its time of arrival.
        let mut pending: VecDeque<(f64, f64)> = VecDeque::new();
        let mut flowing_a = state.current_a;
        for number in 0..samples {
            let time_s = number as f64 * self.sample_time_s;
            let push = torque_at(&self.pushes, time_s);
            let instant = Instant {
                state: &state,
                reading: self.motion.read(&state, late.as_ref(), time_s),
                flowing_a,
                push,
            };
            let Answer {
                measured,
                command_a,
            } = sample(&instant, &mut random)
                .map_err(|failure| SimulateError::Law { time_s, failure })?;
            pending.push_back((time_s + delay_s, self.actuator.flows(command_a)));

            let angle_rad = from_upright_rad(state.angle_rad);
            if trace.fell_at_s.is_none() && angle_rad.abs() >= FRAC_PI_2 {
                trace.fell_at_s = Some(time_s);
            }
            trace.time_s.push(time_s);
            trace.angle_rad.push(angle_rad);
            trace.rate_rad_s.push(state.rate_rad_s);
            trace.wheel_speed_rad_s.push(state.wheel_speed_rad_s);
            trace.measured_angle_rad.push(measured.angle_rad);
            trace.measured_rate_rad_s.push(measured.rate_rad_s);
            trace
                .measured_wheel_speed_rad_s
                .push(measured.wheel_speed_rad_s);
            trace.current_a.push(command_a);
            trace.push.push(push);
            if over(&trace) {
                break;
            }

            let mut from_s = time_s;
            let to_s = (number + 1) as f64 * self.sample_time_s;
            while let Some(&(arrives_s, current_a)) = pending.front() {
                if arrives_s >= to_s {
                    break;
                }
                if arrives_s > from_s {
                    state = self.advance(&state, flowing_a, (from_s, arrives_s), &mut late);
                    from_s = arrives_s;
                }
                flowing_a = current_a;
                pending.pop_front();
            }
            state = self.advance(&state, flowing_a, (from_s, to_s), &mut late);
            if !(state.angle_rad + state.rate_rad_s + state.wheel_speed_rad_s).is_finite() {
                return Err(SimulateError::NotFinite { time_s: to_s });
            }
        }
        Ok((trace, state))
    }

    fn advance(
        &self,
        state: &State<f64>,
        current_a: f64,
        (from_s, to_s): (f64, f64),
        late: &mut Option<Late<f64>>,
    ) -> State<f64> {
        let push = |time_s: f64| torque_at(&self.pushes, time_s);
        let drive = Drive {
            current_a,
            push: [push(from_s), push(0.5 * (from_s + to_s)), push(to_s)],
        };
        self.motion
            .step(state, &drive, (from_s, to_s), late.as_mut())
    }
}
