//! What an effect is: a named physical term of the model.
//!
//! One file in `effects/` holds one effect: its description and its equation. To add one, copy a
//! file, change it, and add its line to the list in `effects/mod.rs`; fit, diagnosis, reports and
//! the exam take it from there.

use crate::{Kind, Scalar};

/// Everything that a term of the model may look at, at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Instant<S> {
    /// Body angle α in rad, 0 hanging.
    pub angle_rad: S,
    /// Body rate α̇ in rad/s.
    pub rate_rad_s: S,
    /// Wheel angle φ relative to the body, in rad from where the log (or window) began.
    pub wheel_angle_rad: S,
    /// Wheel speed φ̇ relative to the body, in rad/s.
    pub wheel_speed_rad_s: S,
    /// Memory of the effect that is asked (its friction torque in N m), 0 for all others.
    pub memory: S,
}

/// The numerical smoothing of sign(v) as tanh(v/v₀). Not physics: small and fixed in simulation,
/// and chosen apart when the model is linearised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// v₀ on the body, rad/s.
    pub body_rad_s: f64,
    /// v₀ on the wheel, rad/s.
    pub wheel_rad_s: f64,
}

impl Smoothing {
    /// The smoothing used in every simulation and fit.
    pub const SIMULATION: Smoothing = Smoothing {
        body_rad_s: 0.01,
        wheel_rad_s: 1.0,
    };
}

/// What the sensors say at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<S> {
    /// Measured body angle, rad.
    pub angle_rad: S,
    /// Measured body rate, rad/s.
    pub rate_rad_s: S,
    /// Measured wheel speed, rad/s.
    pub wheel_speed_rad_s: S,
}

/// Where in the model a term acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// A torque on the body against its motion.
    Body,
    /// A torque on the wheel against its motion relative to the body.
    Wheel,
    /// A stage between the commanded current and the torque of the motor.
    Motor,
    /// A distortion of what a sensor says; the motion does not know of it.
    Sensor,
}

/// What becomes of a term in the linear model about upright.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linearised {
    /// It is differentiated like everything else.
    Exactly,
    /// Dry friction of the body: μ/ι with the design's ι, or nothing (physics.md, "a design choice").
    AsDryFriction,
    /// Left out: its slope at rest says nothing about the motion the controller sees (a dead zone
    /// has slope zero there), or it needs states that the controller does not have (lag, delay).
    LeftOut,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// The name in model.toml and in every report.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
    /// Range in which the value lies on benches of this size (centimetres to decimetres, tenths of
    /// a kilogram); the exam draws from it and reports mark what lies outside.
    pub plausible: (f64, f64),
    /// Range beyond which the value makes no physical sense; the fit stays inside.
    pub bounds: (f64, f64),
    /// The value is a torque, a torque per something, or an electrical value that goes with the torque constant
    /// as the back-EMF: without a known torque it is identifiable only per unit of inertia.
    pub is_torque: bool,
    /// The fit moves the logarithm of the value: a scale that spans decades.
    pub logarithmic: bool,
    /// The value is a whole number by its nature: it is chosen, and no fit moves it.
    pub is_whole: bool,
}

/// The description of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectInfo {
    /// The name in the contract.
    pub name: &'static str,
    /// The term, as in the contract.
    pub equation: &'static str,
    /// What causes it.
    pub meaning: &'static str,
    /// Where the equation is taken from.
    pub source: &'static str,
    /// What a person would look for in the measurements.
    pub fingerprint: &'static str,
    /// Where in the model it acts.
    pub role: Role,
    /// Its parameters, at most [`MAX_PARAMETERS`].
    pub parameters: &'static [ParameterInfo],
    /// Parameter values from which a fit may start: the first entries are amplitudes that make the
    /// effect small, the others shapes (speeds, orders, lengths), several of them where the shape
    /// enters nonlinearly.
    pub starts: &'static [&'static [f64]],
    /// Parameter values with which the term vanishes exactly (`None`: no such values).
    pub absent: Option<&'static [f64]>,
    /// The effects that this one contains as a limit and therefore replaces.
    pub replaces: &'static [&'static str],
    /// The experiments in which it shows.
    pub shows_in: &'static [Kind],
    /// The torque has a kink where the speed that it acts against changes sign.
    pub has_kink: bool,
    /// The torque is linear in p[i] and in the product p[i] p[j] for this (i, j), not in p[j] itself.
    pub product: Option<(usize, usize)>,
    /// Where p[i] equals p[j] for this (i, j) the term is that of the effect which it replaces
    /// (`None`: at no finite parameters).
    pub limit: Option<(usize, usize)>,
    /// What becomes of it in the linear model.
    pub linearised: Linearised,
}

/// The most parameters that one effect may have.
pub const MAX_PARAMETERS: usize = 3;

/// The equations of an effect. An effect implements those that its [`Role`] calls for.
///
/// `p` holds the parameters in the order of [`EffectInfo::parameters`], in SI units.
pub trait Effect {
    /// The description.
    const INFO: EffectInfo;

    /// Torque in N m against the motion: of the body (role `Body`) or of the wheel (role `Wheel`).
    #[inline(always)]
    fn torque<S: Scalar>(_p: &[S; MAX_PARAMETERS], _at: &Instant<S>, _v0: &Smoothing) -> S {
        S::zero()
    }

    /// Memory after the body has moved by `displacement_rad` since `memory` held (role `Body`).
    #[inline(always)]
    fn remember<S: Scalar>(_p: &[S; MAX_PARAMETERS], memory: S, _displacement_rad: S) -> S {
        memory
    }

    /// A static stage of the motor chain: current in A in, current in A out (role `Motor`).
    /// `torque_constant` in N m/A, which is also the back-EMF constant in V s/rad.
    #[inline(always)]
    fn current<S: Scalar>(
        _p: &[S; MAX_PARAMETERS],
        current_a: S,
        _at: &Instant<S>,
        _torque_constant: S,
    ) -> S {
        current_a
    }

    /// Time constant in s by which the current follows its command (role `Motor`).
    #[inline(always)]
    fn lag_s<S: Scalar>(_p: &[S; MAX_PARAMETERS]) -> Option<S> {
        None
    }

    /// Time in s by which the current comes later than its command (role `Motor`).
    #[inline(always)]
    fn delay_s<S: Scalar>(_p: &[S; MAX_PARAMETERS]) -> Option<S> {
        None
    }

    /// Changes what the sensors say (role `Sensor`).
    #[inline(always)]
    fn distort<S: Scalar>(_p: &[S; MAX_PARAMETERS], _reading: &mut Reading<S>) {}
}
