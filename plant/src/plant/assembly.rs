//! The assembly of a plant: which terms act where, and how long an integration step may be.

use std::ops::Range;

use crate::effect::{Instant, Memory, Ripple, Role, Smoothing};
use crate::model::{GRAVITY_TORQUE, TOTAL_INERTIA, WHEEL_INERTIA};
use crate::{EffectId, Kind, LearnedCoordinate, Model, Timing};

/// An effect with the position of its parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub effect: EffectId,
    first: usize,
    end: usize,
    timing: Option<Timing>,
    is_electrical: bool,
    pub is_ripple: bool,
    memory: Option<Memory>,
}

impl Term {
    /// The positions of its parameters in the parameter vector.
    #[inline(always)]
    pub fn own(&self) -> Range<usize> {
        self.first..self.end
    }

    /// Level in N m and stiffness in N m/rad of the memory, from the parameters of the term.
    pub fn memory_of<S: Copy>(&self, p: &[S]) -> Option<(S, S)> {
        let memory = self.memory?;
        Some((p[memory.level], p[memory.stiffness]))
    }
}

/// The parts of a plant that do not depend on its number type.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    pub kind: Kind,
    pub body: Vec<Term>,
    pub wheel: Vec<Term>,
    /// The static stages of the motor chain.
    pub motor: Vec<Term>,
    pub sensor: Vec<Term>,
    /// Effects with one parameter for each log. They act as soon as the log is known.
    per_log: Vec<Term>,
    /// The lags and delays of the sensors.
    pub late: Vec<Term>,
    timed: Vec<Term>,
    /// The unbalance of the wheel.
    pub unbalance: Option<Term>,
    /// The term of the body that has a memory.
    pub memory: Option<Term>,
    /// The order of the ripple that integration steps must resolve.
    pub ripple_order: Option<f64>,
    pub smoothing: Smoothing,
    /// A torque on the body has a kink at rest.
    pub body_kink: bool,
    /// A torque on the wheel has a kink at rest.
    pub wheel_kink: bool,
    /// The longest integration step that is accurate and stable, s.
    pub longest_step_s: f64,
}

/// Largest integration step, in radians of the pendulum's own oscillation. The phase error
/// of RK4, (ω h)⁴/120 per radian, is then below 1e-6.
const STEP_RAD: f64 = 0.1;
/// Angle in rad over which the stiffness of springs is evaluated.
const STIFFNESS_PROBE_RAD: f64 = 1e-3;
/// Longest integration step in s, for any parameters: a coarsely sampled log may contain
/// motion that the parameters do not suggest.
const LONGEST_STEP_S: f64 = 0.02;
/// Largest integration step, in time constants of the fastest friction (RK4 is stable up to 2.78).
const STEP_TIME_CONSTANTS: f64 = 1.0;
/// Shortest integration step in s that presliding friction may require.
const CONTACT_STEP_S: f64 = 2e-3;

impl Structure {
    /// The structure of a model with its parameter vector (SI units) in an experiment of this kind.
    pub fn new(model: &Model, values: &[f64], kind: Kind, smoothing: Smoothing) -> Structure {
        let mut structure = Structure {
            kind,
            body: vec![],
            wheel: vec![],
            motor: vec![],
            sensor: vec![],
            late: vec![],
            per_log: vec![],
            timed: vec![],
            unbalance: None,
            memory: None,
            ripple_order: None,
            smoothing,
            body_kink: false,
            wheel_kink: false,
            longest_step_s: f64::INFINITY,
        };
        for (effect, own) in model.ranges() {
            let info = effect.info();
            let term = Term {
                effect,
                first: own.start,
                end: own.end,
                timing: info.timing,
                is_electrical: info.is_electrical,
                is_ripple: info.ripple.is_some(),
                memory: info.memory,
            };
            if let Some(Ripple { order, .. }) = info.ripple {
                let faster = structure.ripple_order.unwrap_or(0.0);
                structure.ripple_order = Some(values[own.start + order].max(faster));
            }
            if info.is_unbalance {
                structure.unbalance = Some(term);
                // An unbalance acts once in every turn: steps resolve it like a ripple of order one.
                let order = structure.ripple_order.unwrap_or(0.0);
                structure.ripple_order = Some(order.max(1.0));
                continue;
            }
            if info.memory.is_some() {
                structure.memory = Some(term);
            }
            match info.role {
                Role::Body => {
                    structure.body_kink |= info.has_kink;
                    structure.body.push(term);
                }
                Role::Wheel => {
                    structure.wheel_kink |= info.has_kink;
                    structure.wheel.push(term);
                }
                Role::Motor if info.timing.is_some() => structure.timed.push(term),
                Role::Motor => structure.motor.push(term),
                Role::Sensor if matches!(effect, EffectId::PerLog(_)) => {
                    structure.per_log.push(term);
                }
                Role::Sensor if info.sensor_timing.is_some() => structure.late.push(term),
                Role::Sensor => structure.sensor.push(term),
            }
        }
        structure.longest_step_s = structure.stable_step_s(values);
        structure
    }

    /// The stage of the motor chain with this kind of time dependence.
    pub fn timed(&self, timing: Timing) -> Option<&Term> {
        self.timed.iter().find(|term| term.timing == Some(timing))
    }

    /// Lets each effect that has one parameter per log act with the parameter of `log`.
    pub fn act_in_log(&mut self, log: &str) {
        for term in std::mem::take(&mut self.per_log) {
            let EffectId::PerLog(made) = term.effect else {
                continue;
            };
            if let Some(at) = made.parameter_of(log) {
                self.sensor.push(Term {
                    effect: made.template(),
                    first: term.first + at,
                    end: term.first + at + 1,
                    ..term
                });
            }
        }
    }

    /// Removes the stages between the command and the current.
    pub fn leave_out_electrical(&mut self) {
        self.motor.retain(|term| !term.is_electrical);
        self.timed.retain(|term| !term.is_electrical);
    }

    /// The longest accurate and stable integration step in s, from the slopes of the torques at rest.
    fn stable_step_s(&self, values: &[f64]) -> f64 {
        let body_inertia = match self.kind {
            Kind::FreeSwing => values[TOTAL_INERTIA],
            _ => values[TOTAL_INERTIA] - values[WHEEL_INERTIA],
        };
        let inverse_body = (1.0 / body_inertia).abs();
        let inverse_wheel = (1.0 / values[WHEEL_INERTIA]).abs();
        let mut stiffness = values[GRAVITY_TORQUE].abs();
        for term in &self.body {
            let at = |angle: f64| {
                let instant = Instant {
                    angle_rad: angle,
                    rate_rad_s: 0.0,
                    wheel_angle_rad: 0.0,
                    wheel_speed_rad_s: 0.0,
                    current_a: 0.0,
                    memory: 0.0,
                };
                let p = &values[term.own()];
                term.effect.torque(p, &instant, &self.smoothing)
            };
            stiffness += match term.effect.info().learned {
                // A learned curve may be flat at the hanging position and steep elsewhere: its steepest slope counts.
                Some(curve) if curve.coordinate == LearnedCoordinate::Angle => {
                    curve.spline.steepest(&values[term.own()])
                }
                _ => (at(STIFFNESS_PROBE_RAD) - at(0.0)).abs() / STIFFNESS_PROBE_RAD,
            };
        }
        let mut step = LONGEST_STEP_S;
        if self.kind != Kind::SpinUp {
            step = step.min(STEP_RAD / (stiffness * inverse_body).sqrt().max(1e-9));
        }
        if let Some(term) = &self.memory
            && let Some((_, contact)) = term.memory_of(&values[term.own()])
        {
            // The contact's own oscillation is resolved down to steps of two milliseconds. A stiffer
            // contact yields before any sensor could show its deflection; its force stays bounded by μ.
            let stiffness = stiffness + contact.abs();
            step = step.min((STEP_RAD / (stiffness * inverse_body).sqrt()).max(CONTACT_STEP_S));
        }
        let probe = |rate: f64, wheel: f64| Instant {
            angle_rad: 0.0,
            rate_rad_s: rate,
            wheel_angle_rad: 0.0,
            wheel_speed_rad_s: wheel,
            current_a: 0.0,
            memory: 0.0,
        };
        let (rate, wheel) = (
            1e-3 * self.smoothing.body_rad_s,
            1e-3 * self.smoothing.wheel_rad_s,
        );
        let damping = |terms: &[Term], at: Instant<f64>, rest: Instant<f64>, speed: f64| -> f64 {
            terms
                .iter()
                .map(|term| {
                    if let Some(curve) = term.effect.info().learned {
                        let is_speed = matches!(
                            curve.coordinate,
                            LearnedCoordinate::Rate | LearnedCoordinate::WheelSpeed
                        );
                        let steepest = curve.spline.steepest(&values[term.own()]);
                        return if is_speed { steepest } else { 0.0 };
                    }
                    let moving = term
                        .effect
                        .torque(&values[term.own()], &at, &self.smoothing);
                    let still = term
                        .effect
                        .torque(&values[term.own()], &rest, &self.smoothing);
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
        // Only unphysical parameters would require a step below a microsecond.
        step.max(1e-6)
    }
}
