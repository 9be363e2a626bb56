//! Contracts as ranges: the arguments that a function takes, and the results that it then gives.

use crate::program::Slot;

/// The range of one word, by its position among the words of arguments or results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    /// Position.
    pub word: usize,
    /// Smallest value.
    pub low: i128,
    /// Largest value.
    pub high: i128,
}

/// If the arguments lie in their ranges, nothing overflows and the results lie in theirs.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Contract {
    /// Ranges of words of the arguments; those left out may have any value.
    pub requires: Vec<Range>,
    /// Ranges of words of the result; those left out may have any value.
    pub ensures: Vec<Range>,
}

impl Contract {
    /// Ranges with the slots in which their words stand.
    pub(crate) fn applied(&self, ranges: &[Range], slots: &[Slot]) -> Vec<(Slot, i128, i128)> {
        ranges
            .iter()
            .filter_map(|range| Some((*slots.get(range.word)?, range.low, range.high)))
            .collect()
    }
}
