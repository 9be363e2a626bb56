//! A second statement of an encoder's words, in integers of any size.

use num_traits::ToPrimitive;

use crate::claims::named_words::NamedWords;
use crate::language::module::Module;

/// Words of an encoder: samples seen, count, whether it jumped, sixteen turns, the youngest first.
pub(crate) const WORDS: usize = TURNS + 16;
/// Where the turns begin.
const TURNS: usize = 3;

/// The numbers of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EncoderWords {
    pub(crate) wrap: i128,
    pub(crate) window: i128,
    pub(crate) jump: i128,
}

impl EncoderWords {
    /// The constant of this name in `src/constants.rs`; `None` where there is none.
    pub(crate) fn read(module: &Module, name: &str) -> Result<Option<EncoderWords>, String> {
        if module.constant("constants", name).is_none() {
            return Ok(None);
        }
        let words = NamedWords::read(module, name)?;
        let word = |field: &str| -> Result<i128, String> {
            let found = words.get(&format!("{name}.{field}"))?.to_integer();
            found
                .to_i128()
                .ok_or_else(|| format!("{name}.{field} is too large"))
        };
        let found = EncoderWords {
            wrap: word("wrap")?,
            window: word("window")?,
            jump: word("jump")?,
        };
        if !(2..=1 << 16).contains(&found.wrap)
            || found.wrap & (found.wrap - 1) != 0
            || !(1..=16).contains(&found.window)
            || found.jump < 1
        {
            return Err(format!("{name} is no encoder: {found:?}"));
        }
        Ok(Some(found))
    }

    /// A difference of counts as the shorter way round, half a wrap as backwards.
    pub(crate) fn short(&self, difference: i128) -> i128 {
        let half = self.wrap / 2;
        (difference + half).rem_euclid(self.wrap) - half
    }

    /// The words after a count, and whether it is no motion.
    pub(crate) fn update(&self, words: &[i128], count: i128) -> (Vec<i128>, bool) {
        let count = count.clamp(0, self.wrap - 1);
        let (seen, last, before) = (words[0], words[1], words[TURNS]);
        let turn = if seen > 0 {
            self.short(count - last)
        } else {
            0
        };
        let has_jumped = seen > 1 && (turn - before).abs() > self.jump;
        let mut next = vec![(seen + 1).clamp(1, 2), count, i128::from(has_jumped), turn];
        next.extend_from_slice(&words[TURNS..WORDS - 1]);
        (next, has_jumped)
    }

    /// Counts turned over the window.
    pub(crate) fn turned(&self, words: &[i128]) -> i128 {
        words[TURNS..].iter().take(self.window as usize).sum()
    }

    /// The words of an encoder at count 0 that has turned by this in every step.
    pub(crate) fn turning(&self, turn: i128) -> Vec<i128> {
        [&[2, 0, 0][..], &[self.short(turn); 16]].concat()
    }
}
