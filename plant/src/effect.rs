//! The definition of an effect: a named physical term of the model.
//!
//! One file in `effects/` holds one effect: its description and its equation. To add one, copy a
//! file, change it, and add its line to the list in `effects/mod.rs`; fit, diagnosis, reports and
//! the exam then know it. An effect can also be defined while the program runs: see
//! [`crate::ExternalEffect`].

use crate::hiding::Hiding;
use crate::learned_curve::LearnedCurve;
use crate::physical::PhysicalRange;
use crate::prior::{Commonness, Prior};
use crate::{Kind, Output, Reading, Scalar};

/// The inputs of a term of the model at one instant.
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
    /// The current in A that makes the motor's torque: the command after delay, lag and all stages of the motor. It is
    /// 0 while such a stage is evaluated itself, and where the wheel is locked.
    pub current_a: S,
    /// Memory of the evaluated effect, its friction torque in N m; an effect without memory receives 0.
    pub memory: S,
}

/// The numerical smoothing of sign(v) as tanh(v/v₀). The speed v₀ describes no physics. Simulation uses a small, fixed
/// v₀; the linearisation of a model has a v₀ of its own.
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

/// The place in the model where a term acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// A torque on the body against its motion.
    Body,
    /// A torque on the wheel against its motion relative to the body.
    Wheel,
    /// A stage between the commanded current and the torque of the motor.
    Motor,
    /// A distortion of a sensor's reading; it does not affect the motion.
    Sensor,
}

/// How a term enters the linear model about the upright equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linearised {
    /// By its exact derivative.
    Exactly,
    /// As dry friction of the body: the Coulomb torque μ enters as a viscous friction μ/ι, for a smoothing speed ι that
    /// the designer chooses. Without such a speed the term is left out. A smaller ι assumes more damping near
    /// standstill, where a real joint sticks. An effect that replaces a simpler one is linearised as the simpler one.
    AsDryFriction,
    /// The term is left out, for one of two reasons: its slope at rest does not describe the motion under control (a
    /// dead zone has slope zero there), or it needs states that the controller does not have (lag, delay).
    LeftOut,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// The name in model.toml and in every report.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// The meaning of the parameter, in words.
    pub meaning: &'static str,
    /// Plausible range for benches of this size (centimetres to decimetres, tenths of
    /// a kilogram), in the parameter's unit. The exam draws from it, and reports mark values outside.
    pub plausible: (f64, f64),
    /// Physically possible range, in the parameter's unit. The fit stays inside.
    pub bounds: (f64, f64),
    /// Whether the value is a torque, a torque per something, or an electrical value that is tied to the torque
    /// constant through the back-EMF. Without a known torque, such a value is identifiable only per unit of inertia.
    pub is_torque: bool,
    /// Whether the fit adjusts the logarithm of the value, because its scale spans decades.
    pub logarithmic: bool,
    /// Whether only whole numbers have a meaning (such as the number of teeth of a motor). The fit then tries whole
    /// numbers instead of adjusting the value.
    pub is_whole: bool,
}

/// A stage of the motor chain, or of a sensor, that needs the time and not only the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Timing {
    /// The output follows the input with a time constant ([`Effect::lag_s`]).
    Lag,
    /// The output is the input of an earlier instant ([`Effect::delay_s`]).
    Delay,
}

/// A torque a sin(n φ + ψ) over the angle φ of the wheel. The fit tries all whole numbers as its order n. Integration
/// steps resolve the ripple, or leave it out where it is too fast to be measured. Each member is the index of a
/// parameter of the effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ripple {
    /// Index of the amplitude a in N m.
    pub amplitude: usize,
    /// Index of the order n.
    pub order: usize,
    /// Index of the phase ψ in rad.
    pub phase: usize,
}

/// A torque on the body that depends on the path: like that of a spring that yields, it grows with the displacement up
/// to a level and then stays there. Each member is the index of a parameter of the effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Index of the torque in N m at which the spring yields.
    pub level: usize,
    /// Index of the stiffness in N m/rad before it yields.
    pub stiffness: usize,
}

/// A fault of the rate sensor that a comparison with the measured angle shows, without any model of the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RateFault {
    /// The one parameter is the relative error of the sensitivity.
    Scale,
    /// The one parameter is the bias in rad/s.
    Bias,
}

/// The terms that an unbalanced wheel adds to the left sides of the equations of motion.
#[derive(Clone, Copy, Debug)]
pub struct Unbalance<S> {
    /// c in kg m²: the body's equation gains c (2α̈ + φ̈), the wheel's c α̈.
    pub coupling: S,
    /// The part of the unbalance's torque on the body that no acceleration causes, in N m, positive against the body's
    /// motion.
    pub body_torque: S,
    /// The part of the unbalance's torque on the wheel that no acceleration causes, in N m, positive against the
    /// wheel's motion.
    pub wheel_torque: S,
}

/// A parameter that is measured on the bench and not fitted: a key of `[known]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Given {
    /// g in m/s².
    Gravity,
    /// Distance from the pivot to the axis of the wheel in m.
    PivotToWheel,
}

/// The source of start values for the parameters of an effect, before any fit.
#[derive(Clone, Copy, Debug)]
pub enum StartFrom {
    /// No measurement: a fit starts from [`EffectInfo::starts`].
    Stated,
    /// The damping of the measured motion. The effect has one parameter, the viscous friction of body or wheel.
    Damping,
    /// The angle around which free swings come to rest. The effect has one parameter, this angle in rad.
    AngleZero,
    /// The ripple whose trace is largest in the measured wheel speed ([`Ripple`]).
    Ripple,
    /// The samples in which the motor drove the wheel. The function makes further starts from them.
    Driving(fn(&Driving) -> Vec<Vec<f64>>),
}

/// The samples in which the motor drove the wheel: current and speed had the same sign.
#[derive(Clone, Debug, Default)]
pub struct Driving {
    /// Absolute wheel speed in rad/s, and absolute current in A.
    pub samples: Vec<(f64, f64)>,
    /// τ in N m/A, or per unit of inertia if no torque is known.
    pub torque_constant: f64,
    /// One ohm in the unit that matches this torque constant.
    pub ohm: f64,
}

/// The description of an effect: everything that fit, diagnosis, design, exam and reports need to know about it, apart
/// from its equation. No other file names the effect.
#[derive(Clone, Copy, Debug)]
pub struct EffectInfo {
    /// The name in model.toml, on the command line and in every report.
    pub name: &'static str,
    /// The term as a formula.
    pub equation: &'static str,
    /// Its physical cause.
    pub meaning: &'static str,
    /// Where the equation is taken from: paper or book, with the equation, page or chapter.
    pub source: &'static str,
    /// What the effect looks like in the measurements.
    pub fingerprint: &'static str,
    /// How common the effect is on real benches.
    pub prior: Prior,
    /// The place in the model where the effect acts.
    pub role: Role,
    /// Its parameters. [`crate::Model`] assigns their positions in a parameter vector.
    pub parameters: &'static [ParameterInfo],
    /// The ranges of those parameters that the cause of the effect bounds, with the reasons.
    pub physical: &'static [PhysicalRange],
    /// Parameter values from which a fit may start. The first entries of each set are amplitudes that make the
    /// effect small. The others are shapes (speeds, orders, lengths); there are several sets if a shape
    /// enters nonlinearly.
    pub starts: &'static [&'static [f64]],
    /// Parameter values with which the term vanishes exactly; `None` if there are none.
    pub absent: Option<&'static [f64]>,
    /// The effects that this one contains as a limiting case, and therefore replaces.
    pub replaces: &'static [&'static str],
    /// The effects that some logs cannot distinguish from it, because both are the same function of the motion there.
    pub confused_with: &'static [&'static str],
    /// The kinds of experiment in which it is visible.
    pub shows_in: &'static [Kind],
    /// Whether the torque has a kink where the speed that it opposes changes its sign.
    pub has_kink: bool,
    /// For (i, j): the torque is linear in p[i] and in the product p[i] p[j], but not in p[j] alone.
    pub product: Option<(usize, usize)>,
    /// For (i, j): with p[i] = p[j], the term equals the effect that it replaces; `None` if no finite parameters do
    /// that.
    pub limit: Option<(usize, usize)>,
    /// How the effect enters the linear model.
    pub linearised: Linearised,
    /// The sensor that it distorts (role `Sensor` only).
    pub senses: Option<Output>,
    /// The fault of the rate sensor that the effect describes, if the measured angle can reveal it.
    pub rate_fault: Option<RateFault>,
    /// The time-dependent stage of the motor chain that the effect describes, if any. Such a stage carries
    /// commands from before the log into the log.
    pub timing: Option<Timing>,
    /// Whether the reading of the sensor [`EffectInfo::senses`] has a lag ([`Effect::lag_s`]) or a delay
    /// ([`Effect::delay_s`]); `None` for neither.
    pub sensor_timing: Option<Timing>,
    /// Whether the effect acts between the command and the current. Where a log has the measured current, the effect is
    /// left out, because the measured current already contains it.
    pub is_electrical: bool,
    /// Whether it is a limit: it changes nothing unless the limit is reached ([`crate::EffectId::is_reached`]).
    pub is_limit: bool,
    /// The lowest power of the angle in the effect's torque. Terms of the powers 0, 1 and 3 together fit any smooth
    /// torque over the angle, and so explain none.
    pub angle_power: Option<u32>,
    /// Whether it depends on the angle of the wheel ([`Instant::wheel_angle_rad`]).
    pub uses_wheel_angle: bool,
    /// For (i, j): p[i] is an amplitude and p[j] its phase. Together they are the components of a vector, and to first
    /// order the term is linear in this vector.
    pub polar: Option<(usize, usize)>,
    /// Whether the effect moves the centre of mass of the wheel ([`Effect::unbalance`]).
    pub is_unbalance: bool,
    /// The parameters that are measured and not fitted, by index.
    pub given: &'static [(usize, Given)],
    /// Its ripple over the wheel's angle, if it has one.
    pub ripple: Option<Ripple>,
    /// Its memory, if it has one ([`Effect::remember`]).
    pub memory: Option<Memory>,
    /// The source of start values for its parameters, before any fit.
    pub start_from: StartFrom,
    /// The curve of a torque that was learned from the logs. Such a torque explains nothing; `None` for an effect with
    /// an equation.
    pub learned: Option<&'static LearnedCurve>,
    /// For an effect with one value for each log ([`crate::EffectId::for_logs`]): the name of this parameter in the
    /// effect that is replaced. `None` for an effect whose parameters are common to all logs.
    pub per_log: Option<&'static str>,
    /// The number of the first list of the exam that contains the effect. A seed that is drawn with an earlier list
    /// never hides the effect, so that old seeds keep their benches. An effect that depends on the bench is in no list
    /// (`u32::MAX`).
    pub drawn_since: u32,
    /// How the exam draws its parameters; `None` for the general way ([`EffectInfo::hidden`]).
    pub hiding: Option<Hiding>,
}

impl EffectInfo {
    /// A description without a name and without any special property. An effect states only what differs.
    pub const PLAIN: EffectInfo = EffectInfo {
        name: "",
        equation: "",
        meaning: "",
        source: "",
        fingerprint: "",
        prior: Prior {
            commonness: Commonness::Occasional,
            reason: "nothing is known about how common it is",
        },
        role: Role::Body,
        parameters: &[],
        physical: &[],
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
        sensor_timing: None,
        is_electrical: false,
        is_limit: false,
        angle_power: None,
        uses_wheel_angle: false,
        polar: None,
        is_unbalance: false,
        given: &[],
        ripple: None,
        memory: None,
        start_from: StartFrom::Stated,
        per_log: None,
        drawn_since: 0,
        learned: None,
        hiding: None,
    };
}

/// The equations of an effect. An effect implements those that its [`Role`] requires.
///
/// `p` holds the parameters in the order of [`EffectInfo::parameters`], in SI units.
pub trait Effect {
    /// The description.
    const INFO: EffectInfo;

    /// Torque in N m against the motion of the body (role `Body`) or of the wheel (role `Wheel`).
    #[inline(always)]
    fn torque<S: Scalar>(_p: &[S], _at: &Instant<S>, _v0: &Smoothing) -> S {
        S::zero()
    }

    /// The terms of an unbalanced wheel (role `Wheel`, [`EffectInfo::is_unbalance`]).
    #[inline(always)]
    fn unbalance<S: Scalar>(_p: &[S], _at: &Instant<S>) -> Unbalance<S> {
        Unbalance {
            coupling: S::zero(),
            body_torque: S::zero(),
            wheel_torque: S::zero(),
        }
    }

    /// Memory after a displacement of the body by `displacement_rad`; `memory` is the value before the displacement
    /// (role `Body`).
    #[inline(always)]
    fn remember<S: Scalar>(_p: &[S], memory: S, _displacement_rad: S) -> S {
        memory
    }

    /// A static stage of the motor chain: input current in A to output current in A (role `Motor`).
    /// `torque_constant` in N m/A, which is also the back-EMF constant in V s/rad.
    #[inline(always)]
    fn current<S: Scalar>(_p: &[S], current_a: S, _at: &Instant<S>, _torque_constant: S) -> S {
        current_a
    }

    /// Time constant in s with which the current follows its command (role `Motor`), or the reading follows the
    /// measured quantity (role `Sensor`).
    #[inline(always)]
    fn lag_s<S: Scalar>(_p: &[S]) -> Option<S> {
        None
    }

    /// Delay in s of the current behind its command (role `Motor`), or of the reading behind the measured quantity
    /// (role `Sensor`).
    #[inline(always)]
    fn delay_s<S: Scalar>(_p: &[S]) -> Option<S> {
        None
    }

    /// Changes the sensors' readings (role `Sensor`).
    #[inline(always)]
    fn distort<S: Scalar>(_p: &[S], _reading: &mut Reading<S>) {}
}
