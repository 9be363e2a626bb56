//! The motion: thesis 1.26 and 3.10 with any set of effects, under the constraint of an experiment.
//!
//! With T_b the torques against the body's motion (gravity G sin α among them), T_w those against
//! the wheel's, M = τ i the torque of the motor and f a push on the body:
//!
//! - free (`balance`, `driven`): (Θ − j_w) α̈ = f − T_b − M + T_w and φ̈ = (M − T_w)/j_w − α̈,
//! - wheel locked (`free-swing`): Θ α̈ = f − T_b,
//! - body clamped (`spin-up`): j_w φ̈ = M − T_w.

use crate::effect::{Instant, Role, Smoothing};
use crate::input::{Input, LEAST_SHARE};
use crate::model::{GRAVITY_TORQUE, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};
use crate::{EffectId, Kind, Model, Reading, Scalar};

/// The state of the pendulum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<S> {
    /// Body angle α in rad, 0 hanging.
    pub angle_rad: S,
    /// Body rate α̇ in rad/s.
    pub rate_rad_s: S,
    /// Wheel angle φ relative to the body in rad.
    pub wheel_angle_rad: S,
    /// Wheel speed φ̇ relative to the body in rad/s.
    pub wheel_speed_rad_s: S,
    /// Torque of presliding friction in N m.
    pub friction_torque: S,
    /// Current behind the lag of the motor in A.
    pub current_a: S,
}

impl<S: Scalar> State<S> {
    /// At rest, hanging.
    pub fn rest() -> State<S> {
        State {
            angle_rad: S::zero(),
            rate_rad_s: S::zero(),
            wheel_angle_rad: S::zero(),
            wheel_speed_rad_s: S::zero(),
            friction_torque: S::zero(),
            current_a: S::zero(),
        }
    }
}

/// What acts on the pendulum during a step.
#[derive(Clone, Copy, Debug)]
pub struct Drive<S> {
    /// Mean commanded current in A, after any delay.
    pub current_a: S,
    /// Push on the body in N m at the start, the middle and the end of the step.
    pub push: [f64; 3],
}

/// The commanded (or measured) current during a run.
#[derive(Clone, Copy, Debug)]
pub enum Current<'a, S> {
    /// As recorded.
    Recorded(&'a Input),
    /// Held at this value in A, possibly unknown to whoever recorded the log.
    Held(S),
}

/// The most parameters of one effect.
const MOST_PARAMETERS: usize = 3;

/// An effect with its parameters, as a model in use holds it.
#[derive(Clone, Copy, Debug)]
struct Term<S> {
    effect: EffectId,
    p: [S; MOST_PARAMETERS],
}

/// A model with numbers, under the constraint of one kind of experiment.
#[derive(Clone, Debug)]
pub struct Plant<S> {
    kind: Kind,
    gravity_torque: S,
    torque_constant: S,
    /// 1/Θ where the wheel is locked, 1/(Θ − j_w) where it is free, in 1/(kg m²).
    inverse_body: S,
    /// 1/j_w in 1/(kg m²).
    inverse_wheel: S,
    body: Vec<Term<S>>,
    wheel: Vec<Term<S>>,
    motor: Vec<Term<S>>,
    sensor: Vec<Term<S>>,
    presliding: Option<Term<S>>,
    lag_s: Option<S>,
    delay_s: Option<S>,
    cogging_order: Option<f64>,
    smoothing: Smoothing,
    body_kink: bool,
    wheel_kink: bool,
    longest_step_s: f64,
}

/// Steps are at most this fraction of a radian of the pendulum's own oscillation: the phase error
/// of RK4, (ω h)⁴/120 per radian, is then below 1e-6.
const STEP_RAD: f64 = 0.1;
/// Angle over which the stiffness of springs is probed.
const STIFFNESS_PROBE_RAD: f64 = 1e-3;
/// Steps are at most this long, in s, whatever the parameters say: a coarsely sampled log may hold
/// motion that they do not foresee.
const LONGEST_STEP_S: f64 = 0.02;
/// Steps are at most this many time constants of the fastest friction (RK4 is stable to 2.78).
const STEP_TIME_CONSTANTS: f64 = 1.0;
/// Most parts into which the interval between two samples is divided. Parameters that would need
/// more have no meaning on the bench that was sampled at this rate; a fit that strays there must be
/// told so by a bad result, not by one that never comes.
const MOST_PARTS: f64 = 64.0;
/// Shortest step that presliding friction asks for.
const CONTACT_STEP_S: f64 = 2e-3;
/// A step in which dry friction changes its sign is repeated in this many parts.
const KINK_PARTS: usize = 8;
/// Below this step the repetition gains nothing that a sensor could show.
const KINK_STEP_S: f64 = 1.1e-3;
/// Time constants after which a lag has forgotten its past (e⁻¹⁰).
const LAG_MEMORY: f64 = 10.0;
/// Steps turn the wheel by at most this much of a cogging period, in rad.
const RIPPLE_STEP_RAD: f64 = 1.0;
/// Cogging that asks for more parts of a step than this is left out.
const RIPPLE_MOST_PARTS: f64 = 8.0;

impl<S: Scalar> Plant<S> {
    /// The model with its parameter vector (layout of [`Model::parameters`], SI units) in an
    /// experiment of this kind.
    pub fn new(model: &Model, values: &[S], kind: Kind) -> Plant<S> {
        Plant::smoothed(model, values, kind, Smoothing::SIMULATION)
    }

    /// As [`Plant::new`], with another smoothing of dry friction.
    pub fn smoothed(model: &Model, values: &[S], kind: Kind, smoothing: Smoothing) -> Plant<S> {
        let one = S::constant(1.0);
        let body_inertia = match kind {
            Kind::FreeSwing => values[TOTAL_INERTIA],
            _ => values[TOTAL_INERTIA] - values[WHEEL_INERTIA],
        };
        let mut plant = Plant {
            kind,
            gravity_torque: values[GRAVITY_TORQUE],
            torque_constant: values[TORQUE_CONSTANT],
            inverse_body: one / body_inertia,
            inverse_wheel: one / values[WHEEL_INERTIA],
            body: vec![],
            wheel: vec![],
            motor: vec![],
            sensor: vec![],
            presliding: None,
            lag_s: None,
            delay_s: None,
            cogging_order: None,
            smoothing,
            body_kink: false,
            wheel_kink: false,
            longest_step_s: f64::INFINITY,
        };
        for &effect in model.effects() {
            let info = effect.info();
            let start = model.position(effect).unwrap_or(values.len());
            let mut p = [S::zero(); MOST_PARAMETERS];
            for (slot, &value) in p
                .iter_mut()
                .zip(&values[start..start + info.parameters.len()])
            {
                *slot = value;
            }
            let term = Term { effect, p };
            match info.role {
                Role::Body => {
                    if effect == EffectId::BodyPreslidingFriction {
                        plant.presliding = Some(term);
                    }
                    plant.body_kink |= info.has_kink;
                    plant.body.push(term);
                }
                Role::Wheel => {
                    if effect == EffectId::WheelCogging {
                        plant.cogging_order = Some(p[1].value());
                    }
                    plant.wheel_kink |= info.has_kink;
                    plant.wheel.push(term);
                }
                Role::Motor => {
                    plant.lag_s = plant.lag_s.or(effect.lag_s(&p));
                    plant.delay_s = plant.delay_s.or(effect.delay_s(&p));
                    if effect.lag_s(&p).is_none() && effect.delay_s(&p).is_none() {
                        plant.motor.push(term);
                    }
                }
                Role::Sensor => plant.sensor.push(term),
            }
        }
        plant.longest_step_s = plant.stable_step_s();
        plant
    }

    /// Leaves out what lies between the command and the current that flowed: delay, lag and the
    /// limit of the supply. For logs whose current is the measured one.
    pub fn with_measured_current(mut self) -> Plant<S> {
        self.lag_s = None;
        self.delay_s = None;
        self.motor
            .retain(|term| term.effect != EffectId::BackEmfLimit);
        self
    }

    /// The delay of the motor's current in s, if the model has one.
    pub fn delay_s(&self) -> Option<S> {
        self.delay_s
    }

    /// The longest step that is accurate and stable, from the slopes of the torques at rest.
    fn stable_step_s(&self) -> f64 {
        let inverse_body = self.inverse_body.value().abs();
        let inverse_wheel = self.inverse_wheel.value().abs();
        let mut stiffness = self.gravity_torque.value().abs();
        for term in &self.body {
            let at = |angle: f64| {
                let instant = Instant {
                    angle_rad: S::constant(angle),
                    rate_rad_s: S::zero(),
                    wheel_angle_rad: S::zero(),
                    wheel_speed_rad_s: S::zero(),
                    memory: S::zero(),
                };
                let torque = term.effect.torque(&term.p, &instant, &self.smoothing);
                torque.value()
            };
            stiffness += (at(STIFFNESS_PROBE_RAD) - at(0.0)).abs() / STIFFNESS_PROBE_RAD;
        }
        let mut step = LONGEST_STEP_S;
        if self.kind != Kind::SpinUp {
            step = step.min(STEP_RAD / (stiffness * inverse_body).sqrt().max(1e-9));
        }
        if let Some(term) = self.presliding {
            // The contact's own oscillation is resolved down to steps of two milliseconds. A stiffer
            // contact yields before any sensor could see it bend; its force stays bounded by μ.
            let stiffness = stiffness + term.p[1].value().abs();
            step = step.min((STEP_RAD / (stiffness * inverse_body).sqrt()).max(CONTACT_STEP_S));
        }
        let probe = |rate: f64, wheel: f64| Instant {
            angle_rad: S::zero(),
            rate_rad_s: S::constant(rate),
            wheel_angle_rad: S::zero(),
            wheel_speed_rad_s: S::constant(wheel),
            memory: S::zero(),
        };
        let (rate, wheel) = (
            1e-3 * self.smoothing.body_rad_s,
            1e-3 * self.smoothing.wheel_rad_s,
        );
        let damping = |terms: &[Term<S>], at: Instant<S>, rest: Instant<S>, speed: f64| -> f64 {
            terms
                .iter()
                .map(|term| {
                    let moving = term.effect.torque(&term.p, &at, &self.smoothing).value();
                    let still = term.effect.torque(&term.p, &rest, &self.smoothing).value();
                    ((moving - still) / speed).abs()
                })
                .sum()
        };
        if self.kind != Kind::SpinUp {
            let slope = damping(&self.body, probe(rate, 0.0), probe(0.0, 0.0), rate);
            step = step.min(STEP_TIME_CONSTANTS / (slope * inverse_body).max(1e-9));
        }
        if self.kind != Kind::FreeSwing {
            let slope = damping(&self.wheel, probe(0.0, wheel), probe(0.0, 0.0), wheel);
            let inverse = inverse_wheel
                + if self.kind == Kind::SpinUp {
                    0.0
                } else {
                    inverse_body
                };
            step = step.min(STEP_TIME_CONSTANTS / (slope * inverse).max(1e-9));
        }
        // A step below a microsecond would only be asked for by parameters without meaning.
        step.max(1e-6)
    }

    /// The current that makes the torque, in A, from the one behind the lag.
    #[inline(always)]
    fn through_motor(&self, current_a: S, at: &Instant<S>) -> S {
        let mut current_a = current_a;
        for term in &self.motor {
            let effect = term.effect;
            current_a = effect.current(&term.p, current_a, at, self.torque_constant);
        }
        current_a
    }

    /// The same plant driven by the current that makes the torque.
    fn without_motor(&self) -> Plant<S> {
        Plant {
            motor: vec![],
            lag_s: None,
            delay_s: None,
            ..self.clone()
        }
    }

    /// The mean command in A that reaches the motor over [from_s, to_s], delayed where the model says so;
    /// `before_a` was commanded before the log began. `hint` is the index of a sample nearby.
    pub fn command(
        &self,
        input: &Input,
        (from_s, to_s): (f64, f64),
        before_a: S,
        hint: usize,
    ) -> S {
        let mean = input.mean(from_s, to_s, self.delay_s, hint);
        let (Some(delay), Some((first_s, first_a))) = (self.delay_s, input.first()) else {
            return mean;
        };
        // So long what was commanded before still flows.
        let late = delay + (first_s - from_s);
        let span_s = to_s - from_s;
        if late.value() <= 0.0 {
            mean
        } else if late.value() > span_s * (1.0 + LEAST_SHARE) {
            before_a
        } else {
            // Also where it just ends with the interval, which is where `run` cuts: a longer delay then costs
            // this interval what the next one would still get.
            mean + (before_a - first_a) * late * (1.0 / span_s)
        }
    }

    /// The mean of the current that makes the torque over [from_s, to_s], and the one that flows behind the
    /// lag at its end, in A: each sample of the command passes the motor by itself.
    fn through_motor_on_average(
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

    /// The current behind the lag at the end of a step, from which the next one starts.
    #[inline(always)]
    fn left_behind_lag(&self, start_a: S, drive_a: S, step_s: f64) -> S {
        match self.lag_s {
            Some(lag) if lag.value() > 0.0 => {
                self.flowing_current(start_a, drive_a, step_s, step_s)
            }
            _ => drive_a,
        }
    }

    /// Body and wheel acceleration in rad/s², for the current behind the lag and a push in N m.
    #[inline]
    fn accelerations(
        &self,
        at: &mut Instant<S>,
        memory: S,
        current_a: S,
        push: f64,
        with_ripple: bool,
    ) -> (S, S) {
        let mut wheel_torque = S::zero();
        if self.kind != Kind::FreeSwing {
            let current = self.through_motor(current_a, at);
            wheel_torque = self.torque_constant * current;
            for term in &self.wheel {
                if !with_ripple && term.effect == EffectId::WheelCogging {
                    continue;
                }
                wheel_torque = wheel_torque - term.effect.torque(&term.p, at, &self.smoothing);
            }
        }
        if self.kind == Kind::SpinUp {
            return (S::zero(), wheel_torque * self.inverse_wheel);
        }
        let mut body_torque = -(self.gravity_torque * at.angle_rad.sin()) + push;
        at.memory = memory;
        for term in &self.body {
            body_torque = body_torque - term.effect.torque(&term.p, at, &self.smoothing);
        }
        if self.kind == Kind::FreeSwing {
            return (body_torque * self.inverse_body, S::zero());
        }
        let rate_derivative = (body_torque - wheel_torque) * self.inverse_body;
        (
            rate_derivative,
            wheel_torque * self.inverse_wheel - rate_derivative,
        )
    }

    /// (α̈, φ̈) in rad/s² in a state, with the current that flows and a push in N m: the one
    /// right-hand side of simulation, fit and linearisation.
    pub fn derivative(&self, state: &State<S>, current_a: S, push: f64) -> (S, S) {
        let mut at = Instant {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_angle_rad: state.wheel_angle_rad,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
            memory: S::zero(),
        };
        self.accelerations(&mut at, state.friction_torque, current_a, push, true)
    }

    /// The torque of presliding friction in N m after the body has moved by `displacement_rad` in
    /// one direction since it was `memory`; unchanged in a model without it.
    #[inline(always)]
    pub fn remember(&self, memory: S, displacement_rad: S) -> S {
        match &self.presliding {
            Some(term) => term.effect.remember(&term.p, memory, displacement_rad),
            None => memory,
        }
    }

    /// The distance μ/σ in rad over which presliding friction yields, if the model has it.
    pub fn presliding_distance_rad(&self) -> Option<f64> {
        let term = self.presliding?;
        let distance_rad = term.p[0].value() / term.p[1].value();
        distance_rad.is_finite().then_some(distance_rad)
    }

    /// The current in A behind the lag, `after_s` into an interval of `step_s`: `start_a` flowed at
    /// its beginning, `drive_a` is the mean command over it (after any delay).
    #[inline(always)]
    pub fn flowing_current(&self, start_a: S, drive_a: S, after_s: f64, step_s: f64) -> S {
        match self.lag_s {
            Some(lag) if lag.value() > 0.0 => {
                let decay = (S::constant(-after_s) / lag).exp();
                drive_a + (start_a - drive_a) * decay
            }
            // The lag T → 0 delays the current by T: −T di/dt is left to first order so that the
            // derivative with respect to T exists at T = 0.
            Some(lag) => drive_a - lag * (drive_a - start_a) * (1.0 / step_s),
            None => drive_a,
        }
    }

    /// The current during a step as a straight line: its value in A in the middle and what it gains
    /// from start to end.
    ///
    /// Behind a lag T the current runs along an exponential, which the three points of a Runge–Kutta
    /// step cannot follow where T is short against the step h. The line has the same integral and the
    /// same first moment, ∫c ds = M₀ and ∫(1 − s) c ds = M₁ over s = t/h, so that the speed and the
    /// angle which it gives are right for every lag and the limit T → 0 is the model without lag:
    /// with θ = T/h and E = exp(−1/θ), M₀ = θ (1 − E) and M₁ = θ − θ² (1 − E); RK4 gives a line
    /// A + B (s − 1/2) the moments A and A/2 − B/12.
    #[inline(always)]
    fn current_line(&self, start_a: S, drive_a: S, step_s: f64) -> (S, S) {
        let Some(lag) = self.lag_s else {
            return (drive_a, S::zero());
        };
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

    /// Whether cogging of this wheel speed is slow enough against a step to be followed; a faster
    /// ripple averages out, and its speed (below a/(j_w n φ̇)) is far below any sensor's noise.
    fn ripples(&self, wheel_speed_rad_s: f64, step_s: f64) -> Option<f64> {
        let order = self.cogging_order?;
        let phase = (order * wheel_speed_rad_s * step_s).abs();
        (phase < RIPPLE_STEP_RAD * RIPPLE_MOST_PARTS).then_some(phase)
    }

    /// One step of the classical Runge–Kutta method (Hairer, Nørsett, Wanner I, table II.1.2),
    /// without any check of its length. Lag and presliding friction use their exact solutions over
    /// the step, so that neither limits it. `with_ripple`: cogging acts.
    // Not inlined: it is used twice, and large.
    fn rk4(&self, start: &State<S>, drive: &Drive<S>, step_s: f64, with_ripple: bool) -> State<S> {
        let half = 0.5 * step_s;
        let (middle, gain) = self.current_line(start.current_a, drive.current_a, step_s);
        let current = |after_s: f64| middle + gain * (after_s / step_s - 0.5);
        let moves_body = self.kind != Kind::SpinUp;
        let moves_wheel = self.kind != Kind::FreeSwing;
        let stage = |rate: S, rate_dot: S, wheel: S, wheel_dot: S, span: f64, push: f64| {
            let mut at = Instant {
                angle_rad: start.angle_rad,
                rate_rad_s: start.rate_rad_s,
                wheel_angle_rad: start.wheel_angle_rad,
                wheel_speed_rad_s: start.wheel_speed_rad_s,
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

    /// The state after `step_s` seconds under `drive`: as many equal steps as accuracy and
    /// stability ask for, and a finer repetition where dry friction changes its sign.
    pub fn step(&self, start: &State<S>, drive: &Drive<S>, step_s: f64) -> State<S> {
        let ripple = self.ripples(start.wheel_speed_rad_s.value(), step_s);
        let with_ripple = self.cogging_order.is_none() || ripple.is_some();
        let parts = (step_s / self.longest_step_s)
            .max(ripple.unwrap_or(0.0) / RIPPLE_STEP_RAD)
            .ceil()
            .min(MOST_PARTS);
        if parts <= 1.0 {
            return self.checked_step(start, drive, step_s, with_ripple);
        }
        let part_s = step_s / parts;
        let push = |fraction: f64| {
            // The parabola through the three given values.
            let [a, b, c] = drive.push;
            let x = 2.0 * fraction - 1.0;
            b + 0.5 * (c - a) * x + (0.5 * (a + c) - b) * x * x
        };
        let mut state = *start;
        for part in 0..parts as usize {
            let from = part as f64 / parts;
            let to = (part as f64 + 1.0) / parts;
            let drive = Drive {
                current_a: drive.current_a,
                push: [push(from), push(0.5 * (from + to)), push(to)],
            };
            state = self.checked_step(&state, &drive, part_s, with_ripple);
        }
        state
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
        let kink = (self.body_kink && reverses(start.rate_rad_s, end.rate_rad_s))
            || (self.wheel_kink && reverses(start.wheel_speed_rad_s, end.wheel_speed_rad_s));
        if !kink || step_s < KINK_STEP_S {
            return end;
        }
        let mut state = *start;
        for _ in 0..KINK_PARTS {
            state = self.rk4(&state, drive, step_s / KINK_PARTS as f64, with_ripple);
        }
        state
    }

    /// What the sensors say in a state.
    #[inline(always)]
    pub fn read(&self, state: &State<S>) -> Reading<S> {
        let mut reading = Reading {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
        };
        for term in &self.sensor {
            term.effect.distort(&term.p, &mut reading);
        }
        reading
    }

    /// Runs from `start` at `time_s[first]` to `time_s[last]` under the recorded current and calls
    /// `each` with the index, the reading and the state at every sample, both ends included.
    ///
    /// In a run from the first sample the current of the start is the one that was commanded before the log
    /// began, for as long as a delay or a lag remembers it; in any other the first command held before the
    /// log. `push` gives the torque on the body in N m at a time in s. Between two samples a log that holds
    /// more samples of the current is driven by the mean of what the motor makes of them.
    pub fn run(
        &self,
        start: State<S>,
        time_s: &[f64],
        samples: std::ops::Range<usize>,
        current: Current<S>,
        push: Option<&dyn Fn(f64) -> f64>,
        mut each: impl FnMut(usize, &Reading<S>, &State<S>),
    ) {
        let mut state = start;
        if let (Some(lag), Current::Recorded(input)) = (self.lag_s, current)
            && state.current_a.value() == 0.0
            && lag.value() >= 0.0
        {
            // A window in the middle of a log starts with the current that its past commands left.
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
        // A log that was thinned has more samples of the current than of anything else.
        let is_thinned = |input: &Input| input.len() > time_s.len();
        let has_motor = !self.motor.is_empty() || self.lag_s.is_some();
        let averaged = match current {
            Current::Recorded(input) if has_motor && is_thinned(input) => {
                Some((input, self.without_motor()))
            }
            _ => None,
        };
        for k in samples.clone() {
            each(k, &self.read(&state), &state);
            if k + 1 >= samples.end {
                break;
            }
            if let Some((input, driven)) = &averaged {
                let (from, to) = (time_s[k], time_s[k + 1]);
                let (current_a, flowing_a) =
                    self.through_motor_on_average(input, &state, (from, to), before_a, k);
                let push = push.map_or([0.0; 3], |push| {
                    [push(from), push(0.5 * (from + to)), push(to)]
                });
                state = driven.step(&state, &Drive { current_a, push }, to - from);
                state.current_a = flowing_a;
                continue;
            }
            // A delayed command changes within the interval: one step up to there, one from there.
            let change = match (current, &self.delay_s) {
                (Current::Recorded(input), Some(delay)) if !is_thinned(input) => {
                    input.change_within(time_s[k], time_s[k + 1], delay.value(), k)
                }
                _ => None,
            };
            let mut from = time_s[k];
            for to in change.into_iter().chain([time_s[k + 1]]) {
                let drive = Drive {
                    current_a: match current {
                        Current::Recorded(input) => self.command(input, (from, to), before_a, k),
                        Current::Held(current) => current,
                    },
                    push: push.map_or([0.0; 3], |push| {
                        [push(from), push(0.5 * (from + to)), push(to)]
                    }),
                };
                state = self.step(&state, &drive, to - from);
                from = to;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dual, Hold};

    const VALUES: [f64; 6] = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
    ];

    fn swing(plant: &Plant<f64>, angle_rad: f64, step_s: f64, steps: usize) -> Vec<State<f64>> {
        let time_s: Vec<f64> = (0..=steps).map(|k| k as f64 * step_s).collect();
        let start = State {
            angle_rad,
            ..State::rest()
        };
        let mut states = vec![];
        plant.run(
            start,
            &time_s,
            0..time_s.len(),
            Current::Held(0.0),
            None,
            |_, _, state| states.push(*state),
        );
        states
    }

    /// Period of a pendulum: 4 K(sin(α₀/2))/ω₀, with K by the arithmetic-geometric mean
    /// (Abramowitz & Stegun 17.6.3).
    fn period_s(angle_rad: f64) -> f64 {
        let (mut a, mut b) = (1.0, (0.5 * angle_rad).cos());
        for _ in 0..40 {
            (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
        }
        2.0 * std::f64::consts::PI / ((VALUES[2] / VALUES[0]).sqrt() * a)
    }

    #[test]
    fn a_swing_without_friction_has_the_period_of_the_elliptic_integral_and_keeps_its_energy() {
        let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], 0.0, 0.0];
        let plant = Plant::new(&Model::base(), &values, Kind::FreeSwing);
        for angle in [0.1, 0.9, 2.5] {
            let period = period_s(angle);
            let steps = 400;
            let end = swing(&plant, angle, period / steps as f64, steps)[steps];
            assert!((end.angle_rad - angle).abs() < 1e-6 * angle, "{angle}");
            assert!(end.rate_rad_s.abs() < 1e-4, "{angle} {}", end.rate_rad_s);
        }
    }

    #[test]
    fn a_locked_swing_is_the_free_one_with_an_infinitely_sluggish_wheel() {
        // With the wheel locked Θ counts; with it free and frictionless the wheel keeps its absolute
        // speed, so that only Θ − j_w swings.
        let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], 0.0, 0.0];
        let free = Plant::new(&Model::base(), &values, Kind::Driven);
        let end = swing(&free, 0.4, 1e-3, 1000)[1000];
        assert!((end.wheel_speed_rad_s + end.rate_rad_s).abs() < 1e-9);
        let lighter = [values[0] - values[1], 1e-9, values[2], values[3], 0.0, 0.0];
        let locked = Plant::new(&Model::base(), &lighter, Kind::FreeSwing);
        let same = swing(&locked, 0.4, 1e-3, 1000)[1000];
        assert!((end.angle_rad - same.angle_rad).abs() < 1e-9);
    }

    #[test]
    fn a_spin_up_follows_its_exponential() {
        let plant = Plant::new(&Model::base(), &VALUES, Kind::SpinUp);
        let time_s: Vec<f64> = (0..1501).map(|k| k as f64 * 0.004).collect();
        let input = Input::new(&time_s, &vec![0.4; time_s.len()], Hold::Zero);
        let mut worst: f64 = 0.0;
        plant.run(
            State::rest(),
            &time_s,
            0..time_s.len(),
            Current::Recorded(&input),
            None,
            |k, reading, _| {
                let (j, r) = (VALUES[1], VALUES[5]);
                let exact = 0.0335 * 0.4 / r * (1.0 - (-r / j * time_s[k]).exp());
                worst = worst.max((reading.wheel_speed_rad_s - exact).abs());
            },
        );
        assert!(worst < 1e-6, "{worst}");
    }

    #[test]
    fn dry_friction_takes_four_mu_over_g_of_the_amplitude_in_every_cycle() {
        let model = Model::with_effects(&[EffectId::BodyCoulombFriction]);
        let mu = 1e-3;
        let values = [VALUES[0], VALUES[1], VALUES[2], VALUES[3], mu];
        let plant = Plant::new(&model, &values, Kind::FreeSwing);
        let states = swing(&plant, 0.1, 0.004, 5000);
        let maxima: Vec<f64> = states
            .windows(3)
            .filter(|w| w[1].angle_rad > w[0].angle_rad && w[1].angle_rad >= w[2].angle_rad)
            .map(|w| w[1].angle_rad)
            .collect();
        let loss = 4.0 * mu / VALUES[2];
        for pair in maxima.windows(2).take_while(|pair| pair[1] > 3.0 * loss) {
            assert!(((pair[0] - pair[1]) / loss - 1.0).abs() < 0.03, "{pair:?}");
        }
        assert!(maxima.len() > 4);
    }

    #[test]
    fn presliding_friction_starts_as_a_spring_and_ends_as_dry_friction() {
        let (mu, sigma) = (4e-4, 0.02);
        let effect = EffectId::BodyPreslidingFriction;
        let p = [mu, sigma, 0.0];
        let small = effect.remember(&p, 0.0, 1e-6);
        assert!((small / (sigma * 1e-6) - 1.0).abs() < 1e-3);
        assert!((effect.remember(&p, 0.0, 1.0) - mu).abs() < 1e-12);
        assert!((effect.remember(&p, mu, -1.0) + mu).abs() < 1e-12);
        // Two half displacements are one whole displacement: the solution is exact.
        let twice = effect.remember(&p, effect.remember(&p, 1e-4, 0.01), 0.01);
        assert!((twice - effect.remember(&p, 1e-4, 0.02)).abs() < 1e-15);
    }

    /// A command that alternates across a dead zone of 0.03 A: its mean of 0.01 A alone would drive nothing,
    /// every second sample passes 0.02 A.
    #[test]
    fn each_sample_of_the_command_passes_the_motor_also_where_the_log_is_thinned() {
        let model = Model::base().with(EffectId::MotorDeadZone);
        let values = [&VALUES[..], &[0.03]].concat();
        let plant = Plant::new(&model, &values, Kind::SpinUp);
        let time_s: Vec<f64> = (0..=1000).map(|k| k as f64 * 1e-3).collect();
        let command = |k: usize| 0.01 + if k.is_multiple_of(2) { 0.04 } else { -0.04 };
        let current_a: Vec<f64> = (0..=1000).map(command).collect();
        let input = Input::new(&time_s, &current_a, Hold::Zero);
        let end = |step: usize| {
            let times: Vec<f64> = time_s.iter().copied().step_by(step).collect();
            let mut end = 0.0;
            plant.run(
                State::rest(),
                &times,
                0..times.len(),
                Current::Recorded(&input),
                None,
                |_, reading, _| end = reading.wheel_speed_rad_s,
            );
            end
        };
        let (j, r) = (VALUES[1], VALUES[5]);
        let exact = 0.0335 * 0.01 / r * (1.0 - (-r / j).exp());
        for step in [1, 4] {
            assert!(
                (end(step) / exact - 1.0).abs() < 1e-3,
                "{step}: {} {exact}",
                end(step)
            );
        }
    }

    /// A delayed command is the same command later, after the one from before the log; also where the log is
    /// thinned and the motor has a chain.
    #[test]
    fn a_delay_carries_the_command_from_before_the_log() {
        let (before_a, delay_s) = (-0.7, 0.013);
        let command = |k: usize| 0.4 + 0.3 * (k as f64 * 0.05).sin();
        let later = |k: usize| if k < 13 { before_a } else { command(k - 13) };
        let time_s: Vec<f64> = (0..=400).map(|k| k as f64 * 1e-3).collect();
        let input = |current: &dyn Fn(usize) -> f64| {
            let current_a: Vec<f64> = (0..=400).map(current).collect();
            Input::new(&time_s, &current_a, Hold::Zero)
        };
        let end = |model: &Model, own: &[f64], input: &Input, step: usize| {
            let values = [&VALUES[..], own].concat();
            let plant = Plant::new(model, &values, Kind::SpinUp);
            let times: Vec<f64> = time_s.iter().copied().step_by(step).collect();
            let start = State {
                current_a: before_a,
                ..State::rest()
            };
            let current = Current::Recorded(input);
            let mut end = 0.0;
            plant.run(
                start,
                &times,
                0..times.len(),
                current,
                None,
                |_, reading, _| {
                    end = reading.wheel_speed_rad_s;
                },
            );
            end
        };
        let (recorded, shifted) = (input(&command), input(&later));
        let plain = Model::base();
        let delayed = plain.with(EffectId::InputDelay);
        for step in [1, 5] {
            let (a, b) = (
                end(&delayed, &[delay_s], &recorded, step),
                end(&plain, &[], &shifted, step),
            );
            assert!((a - b).abs() < 1e-6 * b.abs(), "{step}: {a} {b}");
            let saturated = plain.with(EffectId::MotorSaturation);
            let both = saturated.with(EffectId::InputDelay);
            let own = |effect: EffectId| -> f64 {
                if effect == EffectId::InputDelay {
                    delay_s
                } else {
                    0.5
                }
            };
            let chain: Vec<f64> = both.effects().iter().skip(2).map(|&e| own(e)).collect();
            let (a, b) = (
                end(&both, &chain, &recorded, step),
                end(&saturated, &[0.5], &shifted, step),
            );
            assert!((a - b).abs() < 1e-6 * b.abs(), "{step}, chain: {a} {b}");
        }
    }

    /// Where an effect says that it is the one which it replaces, it is.
    #[test]
    fn the_limit_of_a_refinement_is_what_it_refines() {
        let refinements = EffectId::ALL
            .iter()
            .filter(|effect| effect.info().limit.is_some());
        for &effect in refinements.clone() {
            let info = effect.info();
            let simpler = EffectId::from_name(info.replaces[0]).expect("an effect");
            let mut own: Vec<f64> = info.parameters.iter().map(|one| one.plausible.1).collect();
            let (one, other) = info.limit.expect("filtered");
            own[one] = own[other];
            let of = |effect: EffectId, own: &[f64], rate: f64| {
                let values = [&VALUES[..], own].concat();
                let plant = Plant::new(&Model::base().with(effect), &values, Kind::FreeSwing);
                let state = State {
                    rate_rad_s: rate,
                    ..State::rest()
                };
                plant.derivative(&state, 0.0, 0.0).0
            };
            for rate in [-3.0, -0.01, 0.0, 0.3, 5.0] {
                let (a, b) = (
                    of(effect, &own, rate),
                    of(simpler, &own[other..=other], rate),
                );
                assert!((a - b).abs() <= 1e-12 * b.abs(), "{}: {a} {b}", info.name);
            }
        }
        assert!(refinements.count() > 0);
    }

    #[test]
    fn sensitivities_agree_with_finite_differences_for_every_effect() {
        let time_s: Vec<f64> = (0..400).map(|k| k as f64 * 0.004).collect();
        let current_a: Vec<f64> = time_s.iter().map(|t| 1.2 * (7.0 * t).sin() + 0.3).collect();
        let input = |hold| Input::new(&time_s, &current_a, hold);
        let inputs = [
            (input(Hold::Linear), 1),
            (input(Hold::Zero), 1),
            (input(Hold::Zero), 3),
        ];
        // Another command than the first one of the log came before it.
        let before_a = 0.9;
        let every = |(input, step)| {
            EffectId::ALL
                .iter()
                .map(move |effect| (effect, input, step))
        };
        for (&effect, input, step) in inputs
            .iter()
            .map(|(input, step)| (input, *step))
            .flat_map(every)
        {
            let time_s: Vec<f64> = time_s.iter().copied().step_by(step).collect();
            let info = effect.info();
            let model = Model::base().with(effect);
            let at = model.position(effect).expect("just added");
            let mut values = VALUES.to_vec();
            if at >= 6 {
                values.truncate(6);
                values.extend(info.parameters.iter().map(|parameter| {
                    let (low, high) = parameter.plausible;
                    if low > 0.0 {
                        (low * high).sqrt()
                    } else {
                        0.3 * high
                    }
                }));
            }
            if effect == EffectId::BackEmfLimit {
                values[at..].copy_from_slice(&[12.0, 8.0]);
            }
            let outputs = |values: &[f64]| {
                let plant = Plant::new(&model, values, Kind::Driven);
                let mut out = vec![];
                let start = State {
                    angle_rad: 0.3,
                    current_a: before_a,
                    ..State::rest()
                };
                plant.run(
                    start,
                    &time_s,
                    0..time_s.len(),
                    Current::Recorded(input),
                    None,
                    |_, r, _| {
                        out.extend([r.angle_rad, r.rate_rad_s, r.wheel_speed_rad_s]);
                    },
                );
                out
            };
            for index in at..at + info.parameters.len() {
                let duals: Vec<Dual<1>> = values
                    .iter()
                    .enumerate()
                    .map(|(k, &v)| {
                        if k == index {
                            Dual::variable(v, 0)
                        } else {
                            Dual::constant(v)
                        }
                    })
                    .collect();
                let plant = Plant::new(&model, &duals, Kind::Driven);
                let mut exact = vec![];
                let start = State {
                    angle_rad: Dual::constant(0.3),
                    current_a: Dual::constant(before_a),
                    ..State::rest()
                };
                plant.run(
                    start,
                    &time_s,
                    0..time_s.len(),
                    Current::Recorded(input),
                    None,
                    |_, r, _| {
                        for channel in [r.angle_rad, r.rate_rad_s, r.wheel_speed_rad_s] {
                            exact.push(channel.derivatives[0]);
                        }
                    },
                );
                let h = 1e-5 * values[index].abs().max(1e-4);
                let (mut up, mut down) = (values.clone(), values.clone());
                up[index] += h;
                down[index] -= h;
                let difference: Vec<f64> = outputs(&up)
                    .iter()
                    .zip(outputs(&down))
                    .map(|(a, b)| (a - b) / (2.0 * h))
                    .collect();
                let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
                let error: Vec<f64> = exact.iter().zip(&difference).map(|(a, b)| a - b).collect();
                assert!(
                    norm(&exact) > 0.0,
                    "{} has no trace",
                    info.parameters[index - at].name
                );
                // A held command that comes later acts in the derivative over the stretch before its change, on
                // average half a sample early, of the tenths of a second in which the body swings.
                let is_moved = effect == EffectId::InputDelay && input.held_s().is_some();
                let tolerance = if is_moved { 0.005 * step as f64 } else { 2e-3 };
                assert!(
                    norm(&error) < tolerance * norm(&exact),
                    "{}, every {step}: {} of {}",
                    info.parameters[index - at].name,
                    norm(&error),
                    norm(&exact)
                );
            }
        }
    }
}
