//! The hidden terms of a bench: effects of the library, and terms that are in no library.

use std::fmt;
use std::sync::Arc;

use plant::EffectId;

/// A physical term that is not in the library. `p` are its parameters, in the order of [`Outsider::meaning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Outsider {
    /// A torque p₀ z exp(−z²) on the body with z = (α − p₁)/p₂.
    MagnetNearAnAngle,
    /// A dry friction of the body that grows with time: p₀ t/20 s.
    FrictionThatGrows,
    /// A dry friction p₀ of the body where p₁ < |α| < π/2.
    RubbingBeyondAnAngle,
    /// A torque p₀ sin(p₁ t + p₂) cos α on the body.
    VibrationOfTheBase,
    /// A torque −p₀ (α − p₁) on the body where p₁ < α < π/2.
    SoftStop,
    /// A viscous drag of the wheel that grows with time: the torque −p₀ φ̇ t/10 s.
    WheelDragThatGrows,
    /// A torque of the motor that falls with time: its factor is 1 − p₀ (1 − exp(−t/p₁)).
    SupplyThatSags,
    /// A measured angle with the error p₀ sin(8 α + p₁).
    UnevenEncoder,
}

impl Outsider {
    /// All outsiders.
    pub const ALL: [Outsider; 8] = [
        Outsider::MagnetNearAnAngle,
        Outsider::FrictionThatGrows,
        Outsider::RubbingBeyondAnAngle,
        Outsider::VibrationOfTheBase,
        Outsider::SoftStop,
        Outsider::WheelDragThatGrows,
        Outsider::SupplyThatSags,
        Outsider::UnevenEncoder,
    ];

    /// Short name.
    pub fn name(self) -> &'static str {
        match self {
            Outsider::MagnetNearAnAngle => "magnet-near-an-angle",
            Outsider::FrictionThatGrows => "friction-that-grows",
            Outsider::RubbingBeyondAnAngle => "rubbing-beyond-an-angle",
            Outsider::VibrationOfTheBase => "vibration-of-the-base",
            Outsider::SoftStop => "soft-stop",
            Outsider::WheelDragThatGrows => "wheel-drag-that-grows",
            Outsider::SupplyThatSags => "supply-that-sags",
            Outsider::UnevenEncoder => "uneven-encoder",
        }
    }

    /// Whether the term acts on the wheel or its motor. Then only experiments with a motor show it.
    pub fn needs_a_motor(self) -> bool {
        matches!(
            self,
            Outsider::WheelDragThatGrows | Outsider::SupplyThatSags
        )
    }

    /// The term, with p₀ its amplitude and p₁, p₂ its shape; t counts from the start of a log.
    pub fn meaning(self) -> &'static str {
        match self {
            Outsider::MagnetNearAnAngle => "torque p0 z exp(−z²) on the body, z = (α − p1)/p2",
            Outsider::FrictionThatGrows => "dry friction p0 t/20 s of the body",
            Outsider::RubbingBeyondAnAngle => "dry friction p0 of the body where p1 < |α| < π/2",
            Outsider::VibrationOfTheBase => "torque p0 sin(p1 t + p2) cos α on the body",
            Outsider::SoftStop => "torque −p0 (α − p1) on the body where p1 < α < π/2",
            Outsider::WheelDragThatGrows => "torque −p0 φ̇ t/10 s on the wheel",
            Outsider::SupplyThatSags => "torque of the motor times 1 − p0 (1 − exp(−t/p1))",
            Outsider::UnevenEncoder => "measured angle + p0 sin(8 α + p1)",
        }
    }
}

/// The instant at which the torque of a term is evaluated, with true values.
#[derive(Clone, Copy, Debug)]
pub struct TrueInstant {
    /// Time since the start of the log, s.
    pub time_s: f64,
    /// Body angle, rad.
    pub angle_rad: f64,
    /// Body rate, rad/s.
    pub rate_rad_s: f64,
    /// Wheel angle relative to the body since the start of the log, rad.
    pub wheel_angle_rad: f64,
    /// Wheel speed relative to the body, rad/s.
    pub wheel_speed_rad_s: f64,
}

/// A torque in N m against the motion, as a function of the parameters and the instant.
pub type Torque = dyn Fn(&[f64], &TrueInstant) -> f64 + Send + Sync;

/// The torque of an effect that this simulator does not have (a user's effect, or one of a test). The equation is
/// stated here a second time, because the exam never uses an equation of the plant.
#[derive(Clone)]
pub struct StatedTorque {
    /// Whether the torque acts on the body; otherwise it acts on the wheel.
    pub on_body: bool,
    /// The torque against the motion of the body or the wheel; smooth in the motion.
    pub torque: Arc<Torque>,
}

impl fmt::Debug for StatedTorque {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let joint = if self.on_body { "body" } else { "wheel" };
        write!(formatter, "a torque on the {joint}")
    }
}

impl PartialEq for StatedTorque {
    /// Whether both are the same function object.
    fn eq(&self, other: &StatedTorque) -> bool {
        self.on_body == other.on_body && Arc::ptr_eq(&self.torque, &other.torque)
    }
}

/// A hidden term with its numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Hidden {
    /// An effect of the library with its parameters in SI, in the order of its description.
    Library(EffectId, Vec<f64>),
    /// An effect that is not part of this program: its parameters as for `Library`, and its equation for the exam.
    Stated(EffectId, Vec<f64>, StatedTorque),
    /// A term that is not in the library.
    Outsider(Outsider, [f64; 3]),
}

impl Hidden {
    /// The name of the effect or outsider.
    pub fn name(&self) -> &'static str {
        match self {
            Hidden::Library(effect, _) | Hidden::Stated(effect, ..) => effect.name(),
            Hidden::Outsider(outsider, _) => outsider.name(),
        }
    }

    /// The effect with its parameters, if it can be a suspect.
    pub fn effect(&self) -> Option<(EffectId, &[f64])> {
        match self {
            Hidden::Library(effect, p) | Hidden::Stated(effect, p, _) => Some((*effect, p)),
            Hidden::Outsider(..) => None,
        }
    }
}

/// The true pendulum: base parameters in SI, and hidden terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Θ (kg m²), j_w (kg m²), G (N m), τ (N m/A).
    pub base: [f64; 4],
    /// r_b in N m s/rad.
    pub body_viscous: f64,
    /// r_w in N m s/rad.
    pub wheel_viscous: f64,
    /// The hidden terms.
    pub hidden: Vec<Hidden>,
}

impl Truth {
    /// The same pendulum with other hidden terms.
    pub fn with(&self, hidden: Vec<Hidden>) -> Truth {
        Truth {
            hidden,
            ..self.clone()
        }
    }
}
