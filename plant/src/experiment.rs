//! The kinds of experiment: different constraints on the same model.

/// What is held still while a log is recorded, and the equilibrium around which the motion takes place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Wheel locked to the body, no current, around the hanging equilibrium.
    FreeSwing,
    /// Body clamped; the wheel is driven or coasts.
    SpinUp,
    /// Body and wheel free, upright, under a controller.
    Balance,
    /// Body and wheel free, around the hanging equilibrium, open loop.
    Driven,
}

impl Kind {
    /// All kinds, in the order of the documentation.
    pub const ALL: [Kind; 4] = [Kind::FreeSwing, Kind::SpinUp, Kind::Balance, Kind::Driven];

    /// The name used in bench.toml.
    pub fn name(self) -> &'static str {
        match self {
            Kind::FreeSwing => "free-swing",
            Kind::SpinUp => "spin-up",
            Kind::Balance => "balance",
            Kind::Driven => "driven",
        }
    }

    /// The kind with this name in bench.toml, if there is one.
    pub fn from_name(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}
