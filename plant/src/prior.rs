//! How common an effect is on real benches, independent of any measurement.

/// How often benches of this kind have the effect in a size that their sensors show. Only the order of the
/// classes matters, and only if the measurements do not decide: among explanations that tie, the most common one
/// is used provisionally.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Commonness {
    /// Only benches with an unusual part or an unusual use have it.
    Rare,
    /// Some benches have it.
    Occasional,
    /// Nearly every bench has it.
    Usual,
}

impl Commonness {
    /// The prior odds that a bench has an effect of this class. They are a judgement: each class is three times as
    /// common as the class below.
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
    /// The reason, in a few words.
    pub reason: &'static str,
}
