//! What an effect is: a named physical term of the model.
//!
//! One file in `effects/` holds one effect: its description and its equation. To add one, copy a
//! file, change it, and add its line to the list in `effects/mod.rs`; fit, diagnosis, reports and
//! the exam take it from there. An effect may also come while the program runs: see
//! [`crate::ExternalEffect`].

use crate::hiding::Hiding;
use crate::learned::LearnedCurve;
use crate::prior::{Commonness, Prior};
use crate::{Kind, Output, Reading, Scalar};

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
    /// Dry friction of the body: μ/ι with a smoothing speed ι that the designer chooses, or nothing. The smaller
    /// ι, the more damping the design believes in where there is only stick. Of an effect that replaces
    /// a simpler one, that one stands in the linear model.
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

/// A stage of the motor chain that needs the time, and not only the current.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Timing {
    /// The current follows its command with a time constant ([`Effect::lag_s`]).
    Lag,
    /// The current comes later than its command ([`Effect::delay_s`]).
    Delay,
}

/// A torque a sin(n φ + ψ) over the angle of the wheel. Its order n is found by looking through all whole
/// numbers; steps follow the ripple, or leave it out where it is too fast to be seen. The members
/// say which parameter is which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ripple {
    /// Of the amplitude a in N m.
    pub amplitude: usize,
    /// Of the order n.
    pub order: usize,
    /// Of the phase ψ in rad.
    pub phase: usize,
}

/// A torque that remembers the way of the body: a spring that yields at a level. The members say which
/// parameter is which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Of the torque in N m at which it yields.
    pub level: usize,
    /// Of the stiffness in N m/rad before it yields.
    pub stiffness: usize,
}

/// A fault of the rate sensor that the measured angle shows without any model of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RateFault {
    /// The one parameter is the relative error of the sensitivity.
    Scale,
    /// The one parameter is the bias in rad/s.
    Bias,
}

/// What the logs say about the parameters of an effect before any fit.
#[derive(Clone, Copy, Debug)]
pub enum StartFrom {
    /// Nothing: a fit starts where [`EffectInfo::starts`] says.
    Stated,
    /// The damping of the motion itself: the one parameter is the viscous friction of body or wheel.
    Damping,
    /// The angle around which free swings come to rest: the one parameter is that angle, in rad.
    AngleZero,
    /// The ripple whose trace is largest in the measured wheel speed ([`Ripple`]).
    Ripple,
    /// What was asked of the motor: further starts, from the samples in which it drove the wheel.
    Driving(fn(&Driving) -> Vec<Vec<f64>>),
}

/// The samples in which the motor drove the wheel, current and speed having one sign.
#[derive(Clone, Debug, Default)]
pub struct Driving {
    /// Wheel speed in rad/s and current in A, as amounts.
    pub samples: Vec<(f64, f64)>,
    /// τ in N m/A, or in the unit in which the bench knows it.
    pub torque_constant: f64,
    /// One Ohm in the unit that goes with that torque constant.
    pub ohm: f64,
}

/// The description of an effect: everything that the fit, the diagnosis, the design, the exam and the
/// reports need to know of it beside its equation. Nothing outside of an effect's file names it.
#[derive(Clone, Copy, Debug)]
pub struct EffectInfo {
    /// The name in model.toml, on the command line and in every report.
    pub name: &'static str,
    /// The term.
    pub equation: &'static str,
    /// What causes it.
    pub meaning: &'static str,
    /// Where the equation is taken from: paper or book, with the equation, page or chapter.
    pub source: &'static str,
    /// What a person would look for in the measurements.
    pub fingerprint: &'static str,
    /// How common it is on real benches.
    pub prior: Prior,
    /// Where in the model it acts.
    pub role: Role,
    /// Its parameters, as many as it needs. Their place in a parameter vector is [`crate::Model`]'s job.
    pub parameters: &'static [ParameterInfo],
    /// Parameter values from which a fit may start: the first entries are amplitudes that make the
    /// effect small, the others shapes (speeds, orders, lengths), several of them where the shape
    /// enters nonlinearly.
    pub starts: &'static [&'static [f64]],
    /// Parameter values with which the term vanishes exactly (`None`: no such values).
    pub absent: Option<&'static [f64]>,
    /// The effects that this one contains as a limit and therefore replaces.
    pub replaces: &'static [&'static str],
    /// The effects that some logs cannot tell from it: in them the two are one function of the motion.
    pub confused_with: &'static [&'static str],
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
    /// The sensor that it distorts (role `Sensor` only).
    pub senses: Option<Output>,
    /// The fault of the rate sensor that it is, where it is one that the angle shows.
    pub rate_fault: Option<RateFault>,
    /// The stage of the motor chain that it is, where that stage needs the time. Such a stage carries
    /// what was commanded before a log began into the log.
    pub timing: Option<Timing>,
    /// It lies between the command and the current: where a log holds the measured current, what it
    /// does is in the log already, and it is left out.
    pub is_electrical: bool,
    /// It is a limit: where it is not reached it leaves no trace ([`crate::EffectId::is_reached`]).
    pub is_limit: bool,
    /// Its torque is, to lowest order, this power of the angle. The terms of the powers 0, 1 and 3 together fit any
    /// smooth torque over the angle and explain none.
    pub angle_power: Option<u32>,
    /// It looks at the angle of the wheel ([`Instant::wheel_angle_rad`]).
    pub uses_wheel_angle: bool,
    /// The ripple that it is.
    pub ripple: Option<Ripple>,
    /// The memory that it has ([`Effect::remember`]).
    pub memory: Option<Memory>,
    /// What the logs say about its parameters before any fit.
    pub start_from: StartFrom,
    /// The curve that it is, where it was learned from the logs and explains nothing.
    pub learned: Option<&'static LearnedCurve>,
    /// How the exam hides it; `None`: as [`EffectInfo::hidden`] does with any effect.
    pub hiding: Option<Hiding>,
}

impl EffectInfo {
    /// A term without any peculiarity and without a name: an effect states what differs.
    pub const PLAIN: EffectInfo = EffectInfo {
        name: "",
        equation: "",
        meaning: "",
        source: "",
        fingerprint: "",
        prior: Prior {
            commonness: Commonness::Occasional,
            reason: "nothing is known of how common it is",
        },
        role: Role::Body,
        parameters: &[],
        starts: &[],
        absent: None,
        replaces: &[],
        confused_with: &[],
        shows_in: &[],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
        senses: None,
        rate_fault: None,
        timing: None,
        is_electrical: false,
        is_limit: false,
        angle_power: None,
        uses_wheel_angle: false,
        ripple: None,
        memory: None,
        start_from: StartFrom::Stated,
        learned: None,
        hiding: None,
    };
}

/// The equations of an effect. An effect implements those that its [`Role`] calls for.
///
/// `p` holds the parameters in the order of [`EffectInfo::parameters`], in SI units.
pub trait Effect {
    /// The description.
    const INFO: EffectInfo;

    /// Torque in N m against the motion: of the body (role `Body`) or of the wheel (role `Wheel`).
    #[inline(always)]
    fn torque<S: Scalar>(_p: &[S], _at: &Instant<S>, _v0: &Smoothing) -> S {
        S::zero()
    }

    /// Memory after the body has moved by `displacement_rad` since `memory` held (role `Body`).
    #[inline(always)]
    fn remember<S: Scalar>(_p: &[S], memory: S, _displacement_rad: S) -> S {
        memory
    }

    /// A static stage of the motor chain: current in A in, current in A out (role `Motor`).
    /// `torque_constant` in N m/A, which is also the back-EMF constant in V s/rad.
    #[inline(always)]
    fn current<S: Scalar>(_p: &[S], current_a: S, _at: &Instant<S>, _torque_constant: S) -> S {
        current_a
    }

    /// Time constant in s by which the current follows its command (role `Motor`).
    #[inline(always)]
    fn lag_s<S: Scalar>(_p: &[S]) -> Option<S> {
        None
    }

    /// Time in s by which the current comes later than its command (role `Motor`).
    #[inline(always)]
    fn delay_s<S: Scalar>(_p: &[S]) -> Option<S> {
        None
    }

    /// Changes what the sensors say (role `Sensor`).
    #[inline(always)]
    fn distort<S: Scalar>(_p: &[S], _reading: &mut Reading<S>) {}
}
