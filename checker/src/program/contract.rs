//! Contracts as ranges: the arguments that a function accepts, and the results that it then returns.

use crate::program::steps::Slot;
use crate::program::types::Type;

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

/// A contract: if the arguments are in their ranges, nothing overflows and the results are in theirs.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Contract {
    /// Ranges of words of the arguments; those left out may have any value.
    pub requires: Vec<Range>,
    /// Ranges of words of the result; those left out may have any value.
    pub ensures: Vec<Range>,
    /// Whether the source has a requirement that is not a range and is left out here.
    pub is_partial: bool,
}

impl Contract {
    /// Ranges of all words of the result; a word without a stated range has that of its type.
    pub(crate) fn promised(&self, types: &[Type], slots: &[Slot]) -> Vec<(Slot, i128, i128)> {
        let mut ranges: Vec<_> = slots
            .iter()
            .zip(types)
            .map(|(slot, type_)| {
                let (low, high) = type_.range();
                (*slot, low, high)
            })
            .collect();
        for range in &self.ensures {
            if let Some(word) = ranges.get_mut(range.word) {
                word.1 = word.1.max(range.low);
                word.2 = word.2.min(range.high);
            }
        }
        ranges
    }

    /// Ranges with the slots in which their words stand.
    pub(crate) fn applied(&self, ranges: &[Range], slots: &[Slot]) -> Vec<(Slot, i128, i128)> {
        ranges
            .iter()
            .filter_map(|range| Some((*slots.get(range.word)?, range.low, range.high)))
            .collect()
    }
}
