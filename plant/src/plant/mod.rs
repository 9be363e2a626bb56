//! The motion of the pendulum under the constraint of an experiment: thesis 1.26 and 3.10 with any set of effects.
//!
//! With T_b the torques against the body's motion (gravity G sin α among them), T_w those against
//! the wheel's, M = τ i the torque of the motor and f a push on the body:
//!
//! - free (`balance`, `driven`): (Θ − j_w) α̈ = f − T_b − M + T_w and φ̈ = (M − T_w)/j_w − α̈,
//! - wheel locked (`free-swing`): Θ α̈ = f − T_b,
//! - body clamped (`spin-up`): j_w φ̈ = M − T_w.
//!
//! An unbalanced wheel couples the accelerations once more ([`Unbalance`]).
//!
//! This file holds the one right-hand side. `assembly` puts a plant together and says how long its steps may be,
//! `motor` is the chain from command to current, `early_step` a command that changed between two samples, `integrator`
//! follows the motion, `late` are the sensors with a lag
//! or a delay.

mod assembly;
mod early_step;
mod integrator;
mod late;
mod motor;

use assembly::{Structure, Term};

use crate::effect::{Instant, Smoothing, Unbalance};
use crate::model::{GRAVITY_TORQUE, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};
use crate::{Kind, Model, Reading, Scalar, Timing};

pub use early_step::EarlyStep;
pub use integrator::{Current, Drive};
pub use late::Late;

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
    /// Torque in N m of the friction with memory (presliding).
    pub friction_torque: S,
    /// Current behind the lag of the motor in A.
    pub current_a: S,
}

impl<S: Scalar> State<S> {
    /// At rest in the hanging position.
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

/// A model with parameter values, under the constraint of one kind of experiment.
#[derive(Clone, Debug)]
pub struct Plant<S> {
    structure: Structure,
    /// The parameter vector (layout of [`Model::parameters`]).
    values: Vec<S>,
    gravity_torque: S,
    torque_constant: S,
    /// 1/Θ if the wheel is locked, 1/(Θ − j_w) if it is free, in 1/(kg m²).
    inverse_body: S,
    /// 1/j_w in 1/(kg m²).
    inverse_wheel: S,
    /// Θ and j_w in kg m².
    inertias: [S; 2],
    lag_s: Option<S>,
    delay_s: Option<S>,
    /// The share of its motion that the model had before a log began ([`Plant::with_motion_before`]).
    motion_before: S,
    /// In the order of time ([`Plant::with_early_steps`]).
    early_steps: Vec<EarlyStep<S>>,
}

impl<S: Scalar> Plant<S> {
    /// Builds the plant from a model and its parameter vector (layout of [`Model::parameters`], SI units) for an
    /// experiment of this kind.
    pub fn new(model: &Model, values: &[S], kind: Kind) -> Plant<S> {
        Plant::smoothed(model, values, kind, Smoothing::SIMULATION)
    }

    /// Builds the plant like [`Plant::new`], with this smoothing of dry friction instead of [`Smoothing::SIMULATION`].
    pub fn smoothed(model: &Model, values: &[S], kind: Kind, smoothing: Smoothing) -> Plant<S> {
        let one = S::constant(1.0);
        let body_inertia = match kind {
            Kind::FreeSwing => values[TOTAL_INERTIA],
            _ => values[TOTAL_INERTIA] - values[WHEEL_INERTIA],
        };
        let numbers: Vec<f64> = values.iter().map(|value| value.value()).collect();
        let structure = Structure::new(model, &numbers, kind, smoothing);
        let timed = |timing: Timing| -> Option<S> {
            let term = structure.timed(timing)?;
            let p = &values[term.own()];
            match timing {
                Timing::Lag => term.effect.lag_s(p),
                Timing::Delay => term.effect.delay_s(p),
            }
        };
        Plant {
            gravity_torque: values[GRAVITY_TORQUE],
            torque_constant: values[TORQUE_CONSTANT],
            inverse_body: one / body_inertia,
            inverse_wheel: one / values[WHEEL_INERTIA],
            inertias: [values[TOTAL_INERTIA], values[WHEEL_INERTIA]],
            lag_s: timed(Timing::Lag),
            delay_s: timed(Timing::Delay),
            motion_before: S::zero(),
            early_steps: vec![],
            values: values.to_vec(),
            structure,
        }
    }

    /// The plant in the experiment `log`. An effect with one parameter for each log acts with the parameter of this
    /// log. It does not act if this function was not called, or if it has no parameter for this log.
    #[must_use]
    pub fn for_log(mut self, log: &str) -> Plant<S> {
        self.structure.act_in_log(log);
        self
    }

    /// Removes the stages between the command and the current: delay, lag and the
    /// supply limit. For logs with measured current.
    pub fn with_measured_current(mut self) -> Plant<S> {
        self.lag_s = None;
        self.delay_s = None;
        self.structure.leave_out_electrical();
        self
    }

    /// The parameters of a term.
    #[inline(always)]
    fn p(&self, term: &Term) -> &[S] {
        &self.values[term.own()]
    }

    /// Body and wheel acceleration in rad/s², for the current behind the lag and a push in N m.
    // Not inlined: it is large, and an integration step calls it four times.
    #[inline(never)]
    fn accelerations(
        &self,
        at: &mut Instant<S>,
        memory: S,
        current_a: S,
        push: f64,
        with_ripple: bool,
    ) -> (S, S) {
        let structure = &self.structure;
        let mut wheel_torque = S::zero();
        if structure.kind != Kind::FreeSwing {
            let current = self.through_motor(current_a, at);
            wheel_torque = self.torque_constant * current;
            at.current_a = current;
            for term in &structure.wheel {
                if term.is_ripple && !with_ripple {
                    continue;
                }
                let torque = term
                    .effect
                    .torque_on_wheel(self.p(term), at, &structure.smoothing);
                wheel_torque = wheel_torque - torque;
            }
        }
        let unbalance = match &structure.unbalance {
            Some(term) if with_ripple && structure.kind != Kind::FreeSwing => {
                term.effect.unbalance(self.p(term), at)
            }
            _ => None,
        };
        if let Some(unbalance) = &unbalance {
            wheel_torque = wheel_torque - unbalance.wheel_torque;
        }
        if structure.kind == Kind::SpinUp {
            return (S::zero(), wheel_torque * self.inverse_wheel);
        }
        let mut body_torque = -(self.gravity_torque * at.angle_rad.sin()) + push;
        at.memory = memory;
        for term in &structure.body {
            let torque = term
                .effect
                .torque_on_body(self.p(term), at, &structure.smoothing);
            body_torque = body_torque - torque;
        }
        if structure.kind == Kind::FreeSwing {
            return (body_torque * self.inverse_body, S::zero());
        }
        if let Some(unbalance) = unbalance {
            return self.with_unbalance(&unbalance, body_torque, wheel_torque);
        }
        let rate_derivative = (body_torque - wheel_torque) * self.inverse_body;
        (
            rate_derivative,
            wheel_torque * self.inverse_wheel - rate_derivative,
        )
    }

    /// The accelerations where the wheel is unbalanced and free: with c its coupling, B the torque on the body and W
    /// that on the wheel, (Θ + 2c) α̈ + (j_w + c) φ̈ = B and (j_w + c) α̈ + j_w φ̈ = W.
    // Not inlined: most models have none.
    #[inline(never)]
    fn with_unbalance(&self, unbalance: &Unbalance<S>, body_torque: S, wheel_torque: S) -> (S, S) {
        let [total, wheel] = self.inertias;
        let body_torque = body_torque - unbalance.body_torque;
        let total = total + unbalance.coupling * 2.0;
        let shared = wheel + unbalance.coupling;
        let determinant = total * wheel - shared * shared;
        (
            (body_torque * wheel - shared * wheel_torque) / determinant,
            (total * wheel_torque - shared * body_torque) / determinant,
        )
    }

    /// (α̈, φ̈) in rad/s² in a state, for the motor current in A and a push on the body in N m. Simulation, fit and
    /// linearisation all use this right-hand side.
    pub fn derivative(&self, state: &State<S>, current_a: S, push: f64) -> (S, S) {
        let mut at = Instant {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_angle_rad: state.wheel_angle_rad,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
            current_a: S::zero(),
            memory: S::zero(),
        };
        self.accelerations(&mut at, state.friction_torque, current_a, push, true)
    }

    /// The torque in N m of the friction with memory, after the body has moved by `displacement_rad` in one direction
    /// since the torque was `memory`; unchanged in a model without such friction.
    #[inline(always)]
    pub fn remember(&self, memory: S, displacement_rad: S) -> S {
        match &self.structure.memory {
            Some(term) => term.effect.remember(self.p(term), memory, displacement_rad),
            None => memory,
        }
    }

    /// The distance in rad over which the friction with memory yields (its level divided by its stiffness), if
    /// the model has it.
    pub fn memory_distance_rad(&self) -> Option<f64> {
        let term = self.structure.memory.as_ref()?;
        let (level, stiffness) = term.memory_of(self.p(term))?;
        let distance_rad = level.value() / stiffness.value();
        distance_rad.is_finite().then_some(distance_rad)
    }

    /// The readings of the sensors in a state, without lags and delays, which need the motion before it
    /// ([`Plant::read_late`]).
    #[inline(always)]
    pub fn read(&self, state: &State<S>) -> Reading<S> {
        self.distorted(Reading {
            angle_rad: state.angle_rad,
            rate_rad_s: state.rate_rad_s,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
        })
    }

    /// Applies the sensor effects to these readings.
    #[inline(always)]
    fn distorted(&self, mut reading: Reading<S>) -> Reading<S> {
        for term in &self.structure.sensor {
            term.effect.distort(self.p(term), &mut reading);
        }
        reading
    }
}
