//! How common an effect is on real benches, before any measurement is looked at.

/// How often a bench of this kind has the effect in a size that its sensors show. Only the order of the
/// classes matters, and only where measurements cannot decide: of explanations that tie, the most usual one
/// is taken provisionally.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Commonness {
    /// It takes an unusual part or an unusual use.
    Rare,
    /// Some benches have it, as they are built.
    Occasional,
    /// Nearly every bench has it.
    Usual,
}

impl Commonness {
    /// The odds that a bench has it. Judgement: a class is three times as common as the one below.
    pub fn odds(self) -> f64 {
        match self {
            Commonness::Rare => 1.0 / 9.0,
            Commonness::Occasional => 1.0 / 3.0,
            Commonness::Usual => 1.0,
        }
    }
}

/// The commonness of an effect with the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prior {
    /// The class.
    pub commonness: Commonness,
    /// Why, in a few words.
    pub reason: &'static str,
}
