//! The true motion, simulated more exactly than in any fit.
//!
//! The equations are those of the thesis (1.26, 3.10), written down a second time and integrated
//! differently. Dry friction is a set-valued law with true stick: a joint at rest stays at rest until
//! the torque on it exceeds the breakaway torque, and the instant of every reversal is found by
//! bisection. Presliding friction and the lag of the motor are differential equations like the
//! others. A delayed command changes at its exact instant. The classical Runge–Kutta method
//! uses steps ten times finer than the samples, and finer still where a term is fast.

mod equations;

use plant::{EffectId, Kind};

use crate::true_sensors::TrueSensors;
use crate::truth::{Hidden, Truth};

/// Number of steps per sampling interval.
const STEPS_PER_SAMPLE: f64 = 10.0;
/// Number of steps if only the difference of two motions is needed: both have the same integration error.
const FEW_STEPS_PER_SAMPLE: f64 = 2.0;
/// Longest step, as a share of the fastest time constant, or of the finest angle scale.
const STEP_SHARE: f64 = 0.25;
/// Number of bisections to find the instant of a reversal.
const BISECTIONS: usize = 40;
/// Largest number of reversals within one step.
const MOST_REVERSALS: usize = 20;

/// α, α̇, φ, φ̇, presliding torque, current behind the lag.
type Motion = [f64; 6];

/// Sliding direction of a joint: −1, 1, or 0 where it sticks.
type Direction = f64;

/// The true pendulum in one experiment.
pub struct TrueMotion {
    kind: Kind,
    truth: Truth,
    motion: Motion,
    time_s: f64,
    body: Direction,
    wheel: Direction,
    steps_per_sample: f64,
    /// The sensors, if one of them has a lag or a delay; otherwise `None`.
    sensors: Option<TrueSensors>,
}

/// The start of a motion.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    /// Time since the start of the log, s.
    pub time_s: f64,
    /// Body angle, rad.
    pub angle_rad: f64,
    /// Body rate, rad/s.
    pub rate_rad_s: f64,
    /// Wheel angle since the start of the log, rad.
    pub wheel_angle_rad: f64,
    /// Wheel speed, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Current in the motor, A.
    pub current_a: f64,
}

/// A push on the body, f = peak exp(−((t − centre)/width)²).
#[derive(Clone, Debug, Default)]
pub struct HiddenPush {
    /// Centre, s.
    pub time_s: f64,
    /// Peak torque, N m.
    pub peak_nm: f64,
    /// Width, s.
    pub width_s: f64,
}

impl TrueMotion {
    /// Starts at rest at this angle, with this wheel speed.
    pub fn new(truth: &Truth, kind: Kind, angle_rad: f64, wheel_speed_rad_s: f64) -> TrueMotion {
        let at_rest = Beginning {
            time_s: 0.0,
            angle_rad,
            rate_rad_s: 0.0,
            wheel_angle_rad: 0.0,
            wheel_speed_rad_s,
            current_a: 0.0,
        };
        TrueMotion {
            steps_per_sample: STEPS_PER_SAMPLE,
            ..TrueMotion::of_differences(truth, kind, &at_rest)
        }
    }

    /// The motion with its sensors, at the first sample of a log.
    fn with_sensors(mut self) -> TrueMotion {
        let effects = self.truth.hidden.iter().filter_map(Hidden::effect);
        let sensors = TrueSensors::new(effects, self.time_s, self.at_once());
        self.sensors = (!sensors.are_prompt()).then_some(sensors);
        self
    }

    /// Starts in the middle of a motion, with coarse steps: only to be compared with another motion of the same steps.
    pub fn of_differences(truth: &Truth, kind: Kind, from: &Beginning) -> TrueMotion {
        let direction = |speed: f64| if speed == 0.0 { 0.0 } else { speed.signum() };
        TrueMotion {
            kind,
            truth: truth.clone(),
            motion: [
                from.angle_rad,
                from.rate_rad_s,
                from.wheel_angle_rad,
                from.wheel_speed_rad_s,
                0.0,
                from.current_a,
            ],
            time_s: from.time_s,
            body: direction(from.rate_rad_s),
            wheel: direction(from.wheel_speed_rad_s),
            steps_per_sample: FEW_STEPS_PER_SAMPLE,
            sensors: None,
        }
        .with_sensors()
    }

    /// Delay of the command in s.
    pub fn delay_s(&self) -> f64 {
        self.library(EffectId::InputDelay).map_or(0.0, |p| p[0])
    }

    /// The readings of the sensors without noise: angle (rad), rate (rad/s), wheel speed (rad/s).
    pub fn reading(&self) -> [f64; 3] {
        let sensors = self.sensors.as_ref();
        sensors.map_or_else(|| self.at_once(), TrueSensors::reading)
    }

    fn runge_kutta(&self, y: &Motion, step_s: f64, command_a: f64, push: &[HiddenPush]) -> Motion {
        let t = self.time_s;
        let moved = |k: &Motion, span: f64| -> Motion {
            std::array::from_fn(|index| y[index] + span * k[index])
        };
        let k1 = self.rates(t, y, command_a, push);
        let k2 = self.rates(t + 0.5 * step_s, &moved(&k1, 0.5 * step_s), command_a, push);
        let k3 = self.rates(t + 0.5 * step_s, &moved(&k2, 0.5 * step_s), command_a, push);
        let k4 = self.rates(t + step_s, &moved(&k3, step_s), command_a, push);
        std::array::from_fn(|index| {
            y[index] + step_s / 6.0 * (k1[index] + 2.0 * (k2[index] + k3[index]) + k4[index])
        })
    }

    /// Decides whether a joint at rest begins to slide or keeps sticking.
    fn decide(&mut self, push: &[HiddenPush]) {
        if self.has_body_dry() && self.motion[1] == 0.0 && self.kind != Kind::SpinUp {
            self.body = 0.0;
            let (body, _) = self.drive(self.time_s, &self.motion, push);
            if body.abs() > self.body_dry(self.time_s, self.motion[0], 0.0) {
                self.body = body.signum();
            }
        }
        if self.has_wheel_dry() && self.motion[3] == 0.0 && self.kind != Kind::FreeSwing {
            self.wheel = 0.0;
            let (_, wheel) = self.drive(self.time_s, &self.motion, push);
            if wheel.abs() > self.wheel_dry(0.0) {
                self.wheel = wheel.signum();
            }
        }
    }

    /// Whether a sliding joint has reversed its direction.
    fn reversed(&self, y: &Motion) -> (bool, bool) {
        (
            self.has_body_dry() && self.body * y[1] < 0.0,
            self.has_wheel_dry() && self.wheel * y[3] < 0.0,
        )
    }

    /// One step with a constant command; every reversal inside is located.
    fn step(&mut self, step_s: f64, command_a: f64, push: &[HiddenPush]) {
        if self.library(EffectId::MotorLag).is_none() {
            self.motion[5] = command_a;
        }
        let mut left_s = step_s;
        for _ in 0..MOST_REVERSALS {
            self.decide(push);
            let end = self.runge_kutta(&self.motion, left_s, command_a, push);
            let (body, wheel) = self.reversed(&end);
            if !body && !wheel {
                self.motion = end;
                self.time_s += left_s;
                return;
            }
            let (mut before_s, mut after_s) = (0.0, left_s);
            for _ in 0..BISECTIONS {
                let middle_s = 0.5 * (before_s + after_s);
                let there = self.runge_kutta(&self.motion, middle_s, command_a, push);
                let (body, wheel) = self.reversed(&there);
                if body || wheel {
                    after_s = middle_s;
                } else {
                    before_s = middle_s;
                }
            }
            let there = self.runge_kutta(&self.motion, after_s, command_a, push);
            let (body, wheel) = self.reversed(&there);
            self.motion = there;
            self.time_s += after_s;
            left_s -= after_s;
            if body {
                self.motion[1] = 0.0;
            }
            if wheel {
                self.motion[3] = 0.0;
            }
            if left_s <= 0.0 {
                return;
            }
        }
        // A joint that reverses so often within one step chatters about rest. It is treated as sticking.
        let (body, wheel) = (self.body, self.wheel);
        if self.motion[1] == 0.0 {
            self.body = 0.0;
        }
        if self.motion[3] == 0.0 {
            self.wheel = 0.0;
        }
        self.motion = self.runge_kutta(&self.motion, left_s, command_a, push);
        self.time_s += left_s;
        (self.body, self.wheel) = (body, wheel);
    }

    /// Longest step in s that resolves every term at the present state.
    fn longest_step_s(&self) -> f64 {
        let mut step_s = f64::INFINITY;
        if let Some(&[limit, stiffness]) = self.library(EffectId::BodyPreslidingFriction) {
            // Gravity may increase the rate during the step.
            let fastest = self.motion[1].abs().max(0.05);
            step_s = step_s.min(STEP_SHARE * limit / stiffness / fastest);
            step_s = step_s.min(STEP_SHARE * (self.truth.base[0] / stiffness).sqrt());
        }
        if let Some(&[lag_s]) = self.library(EffectId::MotorLag) {
            step_s = step_s.min(STEP_SHARE * lag_s);
        }
        if let Some(&[_, order, _]) = self.library(EffectId::WheelCogging) {
            step_s = step_s.min(STEP_SHARE / (order * self.motion[3].abs().max(1.0)));
        }
        if self.library(EffectId::WheelUnbalance).is_some() {
            step_s = step_s.min(STEP_SHARE / self.motion[3].abs().max(1.0));
        }
        step_s
    }

    fn sense(&mut self) {
        let (time_s, measured) = (self.time_s, self.at_once());
        if let Some(sensors) = &mut self.sensors {
            sensors.advance(time_s, measured);
        }
    }

    /// Advances to `until_s`, at most one sample away. The command is `before_a` until `change_s`, and `after_a`
    /// afterwards. `sample_s` is the sampling interval.
    pub fn advance(
        &mut self,
        until_s: f64,
        sample_s: f64,
        (before_a, change_s, after_a): (f64, f64, f64),
        push: &[HiddenPush],
    ) {
        for (end_s, command_a) in [
            (change_s.clamp(self.time_s, until_s), before_a),
            (until_s, after_a),
        ] {
            while end_s - self.time_s > 1e-12 {
                let longest_s = (sample_s / self.steps_per_sample).min(self.longest_step_s());
                let parts = ((end_s - self.time_s) / longest_s).ceil().max(1.0);
                self.step((end_s - self.time_s) / parts, command_a, push);
                self.sense();
            }
            self.time_s = end_s;
        }
    }
}
