//! Ranges of every word by interval analysis in exact integers.
//!
//! Conditions narrow the words that they compare, on the side of a branch where they hold. Where
//! intervals are too wide because a word occurs several times in one expression (Newton's method),
//! the domain is halved again and again, down to single words if need be: then the analysis is
//! exact.

use std::collections::HashMap;

use crate::domains::walk::{ContractedCall, Domain, Side, Site, start, walk};
use crate::program::contract::Contract;
use crate::program::place::Place;
use crate::program::steps::{Arithmetic, Comparison, Join, Program, Slot};
use crate::program::types::{Integer, Type};

/// All integers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// Smallest.
    pub low: i128,
    /// Largest, at least `low`.
    pub high: i128,
}

impl Interval {
    /// One integer.
    pub fn point(value: i128) -> Self {
        Interval {
            low: value,
            high: value,
        }
    }

    /// From `low` to `high`.
    pub fn new(low: i128, high: i128) -> Self {
        Interval { low, high }
    }

    /// Every value of a word of this type.
    pub fn of(type_: &Type) -> Self {
        let (low, high) = type_.range();
        Interval { low, high }
    }

    /// The smallest interval that holds both.
    pub fn hull(self, other: Self) -> Self {
        Interval {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Whether every integer of `self` lies in `other`.
    pub fn is_within(self, other: Self) -> bool {
        other.low <= self.low && self.high <= other.high
    }
}

/// What may go wrong, or a result outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct Finding {
    /// Where.
    pub place: Place,
    /// What.
    pub message: String,
}

/// Where a truth value comes from.
#[derive(Clone, Copy, Debug)]
enum Truth {
    Compared(Comparison, Slot, Slot),
    Not(Slot),
    Both(Slot, Slot),
    Either(Slot, Slot),
}

/// What is known of the words while a program is walked.
#[derive(Default)]
struct Intervals {
    /// Where truth values come from.
    truths: HashMap<Slot, Truth>,
    /// Words that were narrowed, with what they were before.
    narrowed: Vec<(Slot, Interval)>,
    /// Length of `narrowed` at the start of each side that is being walked.
    marks: Vec<usize>,
}

/// The ranges of the results for arguments in `arguments`, one interval for each word.
///
/// # Errors
/// [`Finding`] for the first step that may overflow, lose bits, shift too far, clamp to nothing,
/// fail an assertion or break a contract. A finding may be spurious, a success is not.
pub fn ranges(program: &Program, arguments: &[Interval]) -> Result<Vec<Interval>, Finding> {
    let mut is_stated = arguments.len() == program.arguments.len();
    for (interval, type_) in arguments.iter().zip(&program.argument_types) {
        is_stated &= interval.low <= interval.high && interval.is_within(Interval::of(type_));
    }
    if !is_stated {
        return Err(Finding {
            place: program.places[0].clone(),
            message: "the stated ranges are not those of the arguments".to_owned(),
        });
    }
    let mut domain = Intervals::default();
    let mut words = start(&mut domain, program, arguments.iter().copied());
    walk(&mut domain, program, &mut words)?;
    Ok(program.results.iter().map(|slot| words[*slot]).collect())
}

/// The full range of every word of the arguments.
pub fn every_bit_pattern(program: &Program) -> Vec<Interval> {
    program.argument_types.iter().map(Interval::of).collect()
}

/// How much work a proof by halving was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Boxes that were analysed.
    pub boxes: usize,
}

/// Proves a contract of `program`, halving the domain where the analysis is too coarse.
///
/// # Errors
/// [`Finding`]: of a single point, where the contract fails indeed, or of the first box when
/// `limit` boxes did not suffice.
pub fn prove(program: &Program, contract: &Contract, limit: usize) -> Result<Effort, Finding> {
    let mut domain = every_bit_pattern(program);
    for range in &contract.requires {
        if let Some(interval) = domain.get_mut(range.word) {
            *interval = Interval::new(range.low, range.high);
        }
    }
    let mut pending = vec![domain];
    let mut boxes = 0;
    while let Some(domain) = pending.pop() {
        boxes += 1;
        let Err(finding) = meets(program, &domain, contract) else {
            continue;
        };
        let widest = (0..domain.len())
            .max_by_key(|word| domain[*word].high - domain[*word].low)
            .filter(|word| domain[*word].high > domain[*word].low);
        let Some(word) = widest.filter(|_| boxes < limit) else {
            let place = finding.place;
            let text: Vec<_> = program
                .inputs
                .iter()
                .zip(&domain)
                .map(|(name, interval)| format!("{name} in [{}, {}]", interval.low, interval.high))
                .collect();
            return Err(Finding {
                place,
                message: format!("{}, for {}", finding.message, text.join(", ")),
            });
        };
        let Interval { low, high } = domain[word];
        let middle = low + (high - low) / 2;
        let mut lower = domain.clone();
        lower[word].high = middle;
        let mut upper = domain;
        upper[word].low = middle + 1;
        pending.push(lower);
        pending.push(upper);
    }
    Ok(Effort { boxes })
}

fn meets(program: &Program, domain: &[Interval], contract: &Contract) -> Result<(), Finding> {
    let results = ranges(program, domain)?;
    for range in &contract.ensures {
        let found = results.get(range.word).copied();
        let wanted = Interval::new(range.low, range.high);
        if !found.is_some_and(|found| found.is_within(wanted)) {
            let found = found.map_or("missing".to_owned(), |found| {
                format!("in [{}, {}]", found.low, found.high)
            });
            return Err(Finding {
                place: program.places[0].clone(),
                message: format!(
                    "word {} of the result of `{}` is {found}, not within [{}, {}]",
                    range.word, program.name, range.low, range.high
                ),
            });
        }
    }
    Ok(())
}

fn finding<T>(site: &Site<Interval>, message: String) -> Result<T, Finding> {
    Err(Finding {
        place: site.place(),
        message,
    })
}

impl Domain for Intervals {
    type Word = Interval;
    type Stop = Finding;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> Interval {
        Interval::point(constant.unwrap_or(0))
    }

    fn arithmetic(
        &mut self,
        site: &Site<Interval>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        type_: Integer,
    ) -> Result<Interval, Finding> {
        let (x, y) = (*site.word(a), *site.word(b));
        // x · x is no product of two independent words.
        let value = if a == b && operation == Arithmetic::Multiply {
            square(x)
        } else {
            arithmetic(operation, x, y, type_)
        };
        match value {
            Some(value) if value.is_within(Interval::new(type_.min(), type_.max())) => Ok(value),
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
        site: &Site<Interval>,
        to: Slot,
        comparison: Comparison,
        (a, b): (Slot, Slot),
    ) -> Result<Interval, Finding> {
        self.truths.insert(to, Truth::Compared(comparison, a, b));
        Ok(compared(comparison, *site.word(a), *site.word(b)))
    }

    fn negation(
        &mut self,
        site: &Site<Interval>,
        to: Slot,
        operand: Slot,
    ) -> Result<Interval, Finding> {
        self.truths.insert(to, Truth::Not(operand));
        let value = site.word(operand);
        Ok(Interval::new(1 - value.high, 1 - value.low))
    }

    fn cast(
        &mut self,
        site: &Site<Interval>,
        operand: Slot,
        type_: Integer,
    ) -> Result<Interval, Finding> {
        let value = *site.word(operand);
        if value.is_within(Interval::new(type_.min(), type_.max())) {
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
        site: &Site<Interval>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Result<Interval, Finding> {
        let (low, high) = (*site.word(low), *site.word(high));
        if low.high > high.low {
            return finding(site, "the clamp's ends may cross".to_owned());
        }
        let value = site.word(operand);
        Ok(Interval {
            low: value.low.clamp(low.low, high.low),
            high: value.high.clamp(low.high, high.high),
        })
    }

    fn assertion(
        &mut self,
        site: &Site<Interval>,
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
        site: &Site<Interval>,
        call: ContractedCall,
    ) -> Result<Vec<Interval>, Finding> {
        for (slot, low, high) in call.requires {
            let found = *site.word(*slot);
            if !found.is_within(Interval::new(*low, *high)) {
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
            .map(|(_, low, high)| Interval::new(*low, *high))
            .collect())
    }

    fn enter(&mut self, words: &mut [Interval], condition: Slot, side: bool) -> bool {
        self.marks.push(self.narrowed.len());
        self.narrow(words, condition, side)
    }

    fn leave(&mut self, words: &mut [Interval]) {
        let mark = self.marks.pop().unwrap_or(0);
        for (slot, before) in self.narrowed.drain(mark..).rev() {
            words[slot] = before;
        }
    }

    fn join(
        &mut self,
        site: &Site<Interval>,
        condition: Slot,
        joins: &[Join],
        [then, otherwise]: [Side<Interval>; 2],
    ) -> Result<Vec<Interval>, Finding> {
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
    /// `a && b` and `a || b` are branches whose other side is a constant.
    fn remember_connective(&mut self, program: &Program, condition: Slot, join: &Join) {
        let is =
            |slot: Slot, value: i128| program.is_constant[slot] && program.initial[slot] == value;
        let knows = |slot: Slot| self.truths.contains_key(&slot);
        if is(join.otherwise, 0) && knows(join.then) {
            self.truths
                .insert(join.to, Truth::Both(condition, join.then));
        } else if is(join.then, 1) && knows(join.otherwise) {
            self.truths
                .insert(join.to, Truth::Either(condition, join.otherwise));
        }
    }

    fn set(&mut self, words: &mut [Interval], slot: Slot, value: Interval) {
        if words[slot] != value {
            self.narrowed.push((slot, words[slot]));
            words[slot] = value;
        }
    }

    /// Narrows `words` to where `slot` is `value`; whether anything is left.
    fn narrow(&mut self, words: &mut [Interval], slot: Slot, value: bool) -> bool {
        let wanted = i128::from(value);
        let found = words[slot];
        if wanted < found.low || found.high < wanted {
            return false;
        }
        self.set(words, slot, Interval::point(wanted));
        match self.truths.get(&slot).copied() {
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
                (Comparison::Less, true) => self.below(words, a, b, 1),
                (Comparison::Less, false) => self.below(words, b, a, 0),
                (Comparison::LessEqual, true) => self.below(words, a, b, 0),
                (Comparison::LessEqual, false) => self.below(words, b, a, 1),
                (Comparison::Equal, true) | (Comparison::NotEqual, false) => {
                    self.below(words, a, b, 0) && self.below(words, b, a, 0)
                }
                _ => true,
            },
        }
    }

    /// Narrows to a + gap ≤ b.
    fn below(&mut self, words: &mut [Interval], a: Slot, b: Slot, gap: i128) -> bool {
        let mut lower = words[a];
        lower.high = lower.high.min(words[b].high - gap);
        self.set(words, a, lower);
        let mut upper = words[b];
        upper.low = upper.low.max(words[a].low + gap);
        self.set(words, b, upper);
        words[a].low <= words[a].high && words[b].low <= words[b].high
    }
}

fn compared(comparison: Comparison, a: Interval, b: Interval) -> Interval {
    let (never, always) = match comparison {
        Comparison::Less => (a.low >= b.high, a.high < b.low),
        Comparison::LessEqual => (a.low > b.high, a.high <= b.low),
        Comparison::Equal | Comparison::NotEqual => {
            let apart = a.high < b.low || b.high < a.low;
            let same = a.low == a.high && a == b;
            if comparison == Comparison::Equal {
                (apart, same)
            } else {
                (same, apart)
            }
        }
    };
    Interval::new(i128::from(always), i128::from(!never))
}

fn square(x: Interval) -> Option<Interval> {
    let (low, high) = (x.low.checked_mul(x.low)?, x.high.checked_mul(x.high)?);
    let least = if x.low <= 0 && 0 <= x.high {
        0
    } else {
        low.min(high)
    };
    Some(Interval::new(least, low.max(high)))
}

/// The range of an operation; `None` where 128 bits or the shift's range do not suffice.
fn arithmetic(operation: Arithmetic, a: Interval, b: Interval, type_: Integer) -> Option<Interval> {
    let corner = |x, y| operation.apply(x, y, type_.bits);
    match operation {
        Arithmetic::Add => Some(Interval::new(
            a.low.checked_add(b.low)?,
            a.high.checked_add(b.high)?,
        )),
        Arithmetic::Subtract => Some(Interval::new(
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
            let mut result = Interval::point(corners[0]);
            for value in corners {
                result = result.hull(Interval::point(value));
            }
            Some(result)
        }
        // With a mask that is not negative the result lies between zero and the mask.
        Arithmetic::And => {
            let mask = if b.low >= 0 { b.high } else { a.high };
            (b.low >= 0 || a.low >= 0).then_some(Interval::new(0, mask))
        }
    }
}
