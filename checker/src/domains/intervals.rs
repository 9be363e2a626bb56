//! Ranges of every word by interval analysis in exact integers.
//!
//! A condition narrows the words that it compares, on the side of the branch where it holds. Where
//! intervals are too wide because a word occurs several times in one expression (Newton's method),
//! [`crate::domains::halving`] divides the domain.

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::program::place::SourcePlace;
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::{Integer, Type};

/// All integers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IntegerInterval {
    /// Smallest.
    pub low: i128,
    /// Largest, at least `low`.
    pub high: i128,
}

impl IntegerInterval {
    /// One integer.
    pub fn point(value: i128) -> Self {
        IntegerInterval {
            low: value,
            high: value,
        }
    }

    /// From `low` to `high`.
    pub fn new(low: i128, high: i128) -> Self {
        IntegerInterval { low, high }
    }

    /// Every value of a word of this type.
    pub fn of(type_: &Type) -> Self {
        let (low, high) = type_.range();
        IntegerInterval { low, high }
    }

    /// The smallest interval that holds both.
    pub fn hull(self, other: Self) -> Self {
        IntegerInterval {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Whether every integer of `self` lies in `other`.
    pub fn is_within(self, other: Self) -> bool {
        other.low <= self.low && self.high <= other.high
    }
}

/// A possible fault: an overflow, for example, or a result outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct Finding {
    /// The place.
    pub place: SourcePlace,
    /// The fault.
    pub message: String,
}

/// The origin of a truth value.
#[derive(Clone, Copy, Debug)]
enum Truth {
    Compared(WordComparison, Slot, Slot),
    Not(Slot),
    Both(Slot, Slot),
    Either(Slot, Slot),
}

/// The known ranges of the words while a program is walked.
struct Intervals {
    /// The origins of truth values, by slot; `None` for other words.
    truths: Vec<Option<Truth>>,
    /// Words that were narrowed, with their earlier ranges.
    narrowed: Vec<(Slot, IntegerInterval)>,
    /// Length of `narrowed` at the start of each side that is being visited.
    marks: Vec<usize>,
}

/// The ranges of the results for arguments in `arguments`, one interval for each word.
///
/// # Errors
/// [`Finding`] for the first step that may overflow, lose bits, shift too far, clamp to an empty range,
/// fail an assertion or violate a contract. A finding may be spurious; a success is a proof.
pub fn ranges(
    program: &Program,
    arguments: &[IntegerInterval],
) -> Result<Vec<IntegerInterval>, Finding> {
    let mut is_stated = arguments.len() == program.arguments.len();
    for (interval, type_) in arguments.iter().zip(&program.argument_types) {
        is_stated &=
            interval.low <= interval.high && interval.is_within(IntegerInterval::of(type_));
    }
    if !is_stated {
        return Err(Finding {
            place: program.places[0].clone(),
            message: "the stated ranges are not those of the arguments".to_owned(),
        });
    }
    let mut domain = Intervals {
        truths: vec![None; program.initial.len()],
        narrowed: Vec::new(),
        marks: Vec::new(),
    };
    let mut words = start(&mut domain, program, arguments.iter().copied());
    walk(&mut domain, program, &mut words)?;
    Ok(program.results.iter().map(|slot| words[*slot]).collect())
}

/// The full range of every word of the arguments.
pub fn every_bit_pattern(program: &Program) -> Vec<IntegerInterval> {
    program
        .argument_types
        .iter()
        .map(IntegerInterval::of)
        .collect()
}

fn finding<T>(site: &Site<IntegerInterval>, message: String) -> Result<T, Finding> {
    Err(Finding {
        place: site.place(),
        message,
    })
}

impl Domain for Intervals {
    type Word = IntegerInterval;
    type Stop = Finding;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> IntegerInterval {
        IntegerInterval::point(constant.unwrap_or(0))
    }

    fn arithmetic(
        &mut self,
        site: &Site<IntegerInterval>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        type_: Integer,
    ) -> Result<IntegerInterval, Finding> {
        let (x, y) = (*site.word(a), *site.word(b));
        // In x · x, the two operands are not independent.
        let value = if a == b && operation == Arithmetic::Multiply {
            square(x)
        } else {
            arithmetic(operation, x, y, type_)
        };
        match value {
            Some(value) if value.is_within(IntegerInterval::new(type_.min(), type_.max())) => {
                Ok(value)
            }
            _ => finding(
                site,
                format!(
                    "{} of [{}, {}] and [{}, {}] may overflow",
                    operation.name(),
                    x.low,
                    x.high,
                    y.low,
                    y.high
                ),
            ),
        }
    }

    fn comparison(
        &mut self,
        site: &Site<IntegerInterval>,
        to: Slot,
        comparison: WordComparison,
        (a, b): (Slot, Slot),
    ) -> Result<IntegerInterval, Finding> {
        self.truths[to] = Some(Truth::Compared(comparison, a, b));
        Ok(compared(comparison, *site.word(a), *site.word(b)))
    }

    fn negation(
        &mut self,
        site: &Site<IntegerInterval>,
        to: Slot,
        operand: Slot,
    ) -> Result<IntegerInterval, Finding> {
        self.truths[to] = Some(Truth::Not(operand));
        let value = site.word(operand);
        Ok(IntegerInterval::new(1 - value.high, 1 - value.low))
    }

    fn cast(
        &mut self,
        site: &Site<IntegerInterval>,
        operand: Slot,
        type_: Integer,
    ) -> Result<IntegerInterval, Finding> {
        let value = *site.word(operand);
        if value.is_within(IntegerInterval::new(type_.min(), type_.max())) {
            Ok(value)
        } else {
            finding(
                site,
                format!("the cast of [{}, {}] may lose bits", value.low, value.high),
            )
        }
    }

    fn clamp(
        &mut self,
        site: &Site<IntegerInterval>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Result<IntegerInterval, Finding> {
        let (low, high) = (*site.word(low), *site.word(high));
        if low.high > high.low {
            return finding(site, "the clamp's ends may cross".to_owned());
        }
        let value = site.word(operand);
        Ok(IntegerInterval {
            low: value.low.clamp(low.low, high.low),
            high: value.high.clamp(low.high, high.high),
        })
    }

    fn assertion(
        &mut self,
        site: &Site<IntegerInterval>,
        condition: Slot,
        message: &str,
    ) -> Result<(), Finding> {
        if site.word(condition).low == 0 {
            return finding(site, format!("the assertion {message} may fail"));
        }
        Ok(())
    }

    fn call(
        &mut self,
        site: &Site<IntegerInterval>,
        call: ContractedCall,
    ) -> Result<Vec<IntegerInterval>, Finding> {
        for (slot, low, high) in call.requires {
            let found = *site.word(*slot);
            if !found.is_within(IntegerInterval::new(*low, *high)) {
                return finding(
                    site,
                    format!(
                        "`{}` is given [{}, {}], its contract allows [{low}, {high}]",
                        call.function, found.low, found.high
                    ),
                );
            }
        }
        let ensured = call.ensures.iter();
        Ok(ensured
            .map(|(_, low, high)| IntegerInterval::new(*low, *high))
            .collect())
    }

    fn enter(&mut self, words: &mut [IntegerInterval], condition: Slot, side: bool) -> bool {
        self.marks.push(self.narrowed.len());
        self.narrow(words, condition, side)
    }

    fn leave(&mut self, words: &mut [IntegerInterval]) {
        let mark = self.marks.pop().unwrap_or(0);
        for (slot, before) in self.narrowed.drain(mark..).rev() {
            words[slot] = before;
        }
    }

    fn join(
        &mut self,
        site: &Site<IntegerInterval>,
        condition: Slot,
        joins: &[Join],
        [then, otherwise]: [BranchEnd<IntegerInterval>; 2],
    ) -> Result<Vec<IntegerInterval>, Finding> {
        for join in joins {
            self.remember_connective(site.program, condition, join);
        }
        Ok(match (then.is_reached, otherwise.is_reached) {
            (true, true) => {
                let both = then.words.into_iter().zip(otherwise.words);
                both.map(|(one, other)| one.hull(other)).collect()
            }
            (true, false) => then.words,
            _ => otherwise.words,
        })
    }
}

impl Intervals {
    /// `a && b` and `a || b` are branches with a constant on one side.
    fn remember_connective(&mut self, program: &Program, condition: Slot, join: &Join) {
        let is =
            |slot: Slot, value: i128| program.is_constant[slot] && program.initial[slot] == value;
        let knows = |slot: Slot| self.truths[slot].is_some();
        if is(join.otherwise, 0) && knows(join.then) {
            self.truths[join.to] = Some(Truth::Both(condition, join.then));
        } else if is(join.then, 1) && knows(join.otherwise) {
            self.truths[join.to] = Some(Truth::Either(condition, join.otherwise));
        }
    }

    fn set(&mut self, words: &mut [IntegerInterval], slot: Slot, value: IntegerInterval) {
        if words[slot] != value {
            self.narrowed.push((slot, words[slot]));
            words[slot] = value;
        }
    }

    /// Narrows `words` to those for which `slot` is `value`; returns whether any remain.
    fn narrow(&mut self, words: &mut [IntegerInterval], slot: Slot, value: bool) -> bool {
        let wanted = i128::from(value);
        let found = words[slot];
        if wanted < found.low || found.high < wanted {
            return false;
        }
        self.set(words, slot, IntegerInterval::point(wanted));
        match self.truths[slot] {
            None => true,
            Some(Truth::Not(a)) => self.narrow(words, a, !value),
            Some(Truth::Both(a, b)) => match value {
                true => self.narrow(words, a, true) && self.narrow(words, b, true),
                false if words[a].low == 1 => self.narrow(words, b, false),
                false if words[b].low == 1 && words[b].high == 1 => self.narrow(words, a, false),
                false => true,
            },
            Some(Truth::Either(a, b)) => match value {
                false => self.narrow(words, a, false) && self.narrow(words, b, false),
                true if words[a].high == 0 => self.narrow(words, b, true),
                true => true,
            },
            Some(Truth::Compared(comparison, a, b)) => match (comparison, value) {
                (WordComparison::Less, true) => self.below(words, a, b, 1),
                (WordComparison::Less, false) => self.below(words, b, a, 0),
                (WordComparison::LessEqual, true) => self.below(words, a, b, 0),
                (WordComparison::LessEqual, false) => self.below(words, b, a, 1),
                (WordComparison::Equal, true) | (WordComparison::NotEqual, false) => {
                    self.below(words, a, b, 0) && self.below(words, b, a, 0)
                }
                _ => true,
            },
        }
    }

    /// Narrows to a + gap ≤ b.
    fn below(&mut self, words: &mut [IntegerInterval], a: Slot, b: Slot, gap: i128) -> bool {
        let mut lower = words[a];
        lower.high = lower.high.min(words[b].high - gap);
        self.set(words, a, lower);
        let mut upper = words[b];
        upper.low = upper.low.max(words[a].low + gap);
        self.set(words, b, upper);
        words[a].low <= words[a].high && words[b].low <= words[b].high
    }
}

fn compared(comparison: WordComparison, a: IntegerInterval, b: IntegerInterval) -> IntegerInterval {
    let (never, always) = match comparison {
        WordComparison::Less => (a.low >= b.high, a.high < b.low),
        WordComparison::LessEqual => (a.low > b.high, a.high <= b.low),
        WordComparison::Equal | WordComparison::NotEqual => {
            let apart = a.high < b.low || b.high < a.low;
            let same = a.low == a.high && a == b;
            if comparison == WordComparison::Equal {
                (apart, same)
            } else {
                (same, apart)
            }
        }
    };
    IntegerInterval::new(i128::from(always), i128::from(!never))
}

fn square(x: IntegerInterval) -> Option<IntegerInterval> {
    let (low, high) = (x.low.checked_mul(x.low)?, x.high.checked_mul(x.high)?);
    let least = if x.low <= 0 && 0 <= x.high {
        0
    } else {
        low.min(high)
    };
    Some(IntegerInterval::new(least, low.max(high)))
}

/// The range of an operation; `None` if 128 bits or the shift's range are not sufficient.
fn arithmetic(
    operation: Arithmetic,
    a: IntegerInterval,
    b: IntegerInterval,
    type_: Integer,
) -> Option<IntegerInterval> {
    let corner = |x, y| operation.apply(x, y, type_.bits);
    match operation {
        Arithmetic::Add => Some(IntegerInterval::new(
            a.low.checked_add(b.low)?,
            a.high.checked_add(b.high)?,
        )),
        Arithmetic::Subtract => Some(IntegerInterval::new(
            a.low.checked_sub(b.high)?,
            a.high.checked_sub(b.low)?,
        )),
        // Monotone in each operand on each side of zero, so that the corners suffice.
        Arithmetic::Multiply | Arithmetic::ShiftLeft | Arithmetic::ShiftRight => {
            let corners = [
                corner(a.low, b.low)?,
                corner(a.low, b.high)?,
                corner(a.high, b.low)?,
                corner(a.high, b.high)?,
            ];
            let mut result = IntegerInterval::point(corners[0]);
            for value in corners {
                result = result.hull(IntegerInterval::point(value));
            }
            Some(result)
        }
        // With a mask that is not negative the result lies between zero and the mask.
        Arithmetic::And => {
            let mask = if b.low >= 0 { b.high } else { a.high };
            (b.low >= 0 || a.low >= 0).then_some(IntegerInterval::new(0, mask))
        }
    }
}
