//! The kinds of experiment: constraints on one and the same model.

/// What is held still while a log is recorded, and about which equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Wheel locked to the body, no current, about hanging.
    FreeSwing,
    /// Body clamped; the wheel is driven or coasts.
    SpinUp,
    /// Everything free, upright, under a controller.
    Balance,
    /// Everything free, about hanging, open loop.
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
