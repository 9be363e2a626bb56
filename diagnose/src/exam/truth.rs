//! What hides in a bench: effects of the library and terms that nobody's library has.

use plant::EffectId;

/// A physical term that no library knows. `p` are its numbers as [`Outsider::meaning`] lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Outsider {
    /// See [`Outsider::meaning`].
    MagnetNearAnAngle,
    /// See [`Outsider::meaning`].
    FrictionThatGrows,
    /// See [`Outsider::meaning`].
    RubbingBeyondAnAngle,
    /// See [`Outsider::meaning`].
    VibrationOfTheBase,
    /// See [`Outsider::meaning`].
    SoftStop,
    /// See [`Outsider::meaning`].
    WheelDragThatGrows,
    /// See [`Outsider::meaning`].
    SupplyThatSags,
    /// See [`Outsider::meaning`].
    UnevenEncoder,
}

impl Outsider {
    /// All of them.
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

/// A hidden term with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hidden {
    /// An effect of the library with its parameters in SI, in the order of its description.
    Library(EffectId, [f64; 3]),
    /// A term of nobody's library.
    Outsider(Outsider, [f64; 3]),
}

impl Hidden {
    /// The name of the effect or outsider.
    pub fn name(&self) -> &'static str {
        match self {
            Hidden::Library(effect, _) => effect.name(),
            Hidden::Outsider(outsider, _) => outsider.name(),
        }
    }
}

/// The true pendulum: base parameters in SI and what is hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Θ, j_w, G, τ.
    pub base: [f64; 4],
    /// r_b in N m s/rad.
    pub body_viscous: f64,
    /// r_w in N m s/rad.
    pub wheel_viscous: f64,
    /// The hidden terms.
    pub hidden: Vec<Hidden>,
}
