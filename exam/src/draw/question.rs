//! The question of a seed.

use plant::{EffectId, Model};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::truth::Outsider;

/// Seeds in a round of those below [`SENSOR_SEEDS`].
pub const ROUND: u64 = 40;
/// From this seed on, the effects of the second list are hidden, too (lags and delays of sensors, among others). A
/// lower seed hides what it has always hidden, so that marks of different years can be compared.
pub const SENSOR_SEEDS: u64 = 1_000_000;
/// From this seed on, the effects of the third list, too (Stribeck friction of the wheel).
pub const WHEEL_SEEDS: u64 = 2_000_000;

/// The question that a bench asks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question {
    /// Nothing is hidden.
    Nothing,
    /// One effect.
    One(EffectId),
    /// Two effects.
    Two(EffectId, EffectId),
    /// A term that is not in the library.
    Outside(Outsider),
    /// An effect of the library that is removed from the suspects.
    Withheld(EffectId),
}

impl Question {
    /// The hidden effects of the library.
    pub fn hidden(&self) -> Vec<EffectId> {
        match self {
            Question::Nothing | Question::Outside(_) => vec![],
            Question::One(effect) | Question::Withheld(effect) => vec![*effect],
            Question::Two(a, b) => vec![*a, *b],
        }
    }

    /// Whether a hidden term is not among the suspects.
    pub fn is_outside(&self) -> bool {
        matches!(self, Question::Outside(_) | Question::Withheld(_))
    }

    /// The hidden terms in words, one entry per term.
    pub fn truth(&self) -> Vec<String> {
        match self {
            Question::Nothing => vec!["nothing".to_owned()],
            Question::One(effect) => vec![effect.name().to_owned()],
            Question::Two(a, b) => vec![a.name().to_owned(), b.name().to_owned()],
            Question::Outside(outsider) => vec![outsider.name().to_owned()],
            Question::Withheld(effect) => vec![format!("withheld {}", effect.name())],
        }
    }
}

/// The effects that may be hidden: all of the library except the two of the base model.
pub fn effects() -> Vec<EffectId> {
    EffectId::ALL
        .iter()
        .copied()
        .filter(|&effect| !Model::base().has(effect))
        .collect()
}

/// The effects that may be hidden in the bench of this seed: those of the first list, of two, or of all three.
pub fn effects_of(seed: u64) -> Vec<EffectId> {
    let since = u32::from(seed >= SENSOR_SEEDS) + u32::from(seed >= WHEEL_SEEDS);
    let mut effects = effects();
    effects.retain(|effect| effect.info().drawn_since <= since);
    effects
}

/// Number of seeds in the round of a seed: one for each effect alone, for each pair of effects, for each outsider and
/// for a withheld effect, and [`NOTHING`] that hide nothing.
fn round_of(seed: u64) -> u64 {
    let effects = effects_of(seed).len();
    (effects + effects / 2 + Outsider::ALL.len() + 1 + NOTHING) as u64
}

/// Benches of a round that hide nothing.
const NOTHING: usize = 4;

/// Two effects can hide together if neither replaces the other.
fn go_together(a: EffectId, b: EffectId) -> bool {
    let model = Model::base().with(a).with(b);
    model.has(a) && model.has(b)
}

/// The question of a seed.
pub fn question(seed: u64) -> Question {
    let effects = effects_of(seed);
    let round = round_of(seed);
    let slot = (seed % round) as usize;
    let mut rng = ChaCha8Rng::seed_from_u64(0x0b5e_55ed ^ (seed / round));
    if let Some(&effect) = effects.get(slot) {
        return Question::One(effect);
    }
    let slot = slot - effects.len();
    if let Some(&outsider) = Outsider::ALL.get(slot) {
        return Question::Outside(outsider);
    }
    match slot - Outsider::ALL.len() {
        0 => Question::Withheld(effects[(seed / round) as usize % effects.len()]),
        1..=NOTHING => Question::Nothing,
        pair => {
            // The pairs of the round: shuffled until the effects of every pair can be hidden together.
            let mut order = effects;
            loop {
                for last in (1..order.len()).rev() {
                    order.swap(last, rng.random_range(0..=last));
                }
                if order.chunks_exact(2).all(|two| go_together(two[0], two[1])) {
                    break;
                }
            }
            let at = 2 * ((pair - NOTHING - 1) % (order.len() / 2));
            Question::Two(order[at], order[at + 1])
        }
    }
}
