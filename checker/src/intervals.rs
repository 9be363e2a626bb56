//! Ranges of every word by interval analysis in exact integers.
//!
//! Conditions narrow the words that they compare, on the side of a branch where they hold. Where
//! intervals are too wide because a word occurs several times in one expression (Newton's method),
//! the domain is halved again and again, down to single words if need be: then the analysis is
//! exact.

use std::collections::HashMap;

use crate::contract::Contract;
use crate::interpret::{name, range_of};
use crate::language::Integer;
use crate::program::{Action, Arithmetic, Comparison, Program, Slot, Step};
use crate::source::Place;

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

struct Analysis<'a> {
    program: &'a Program,
    truths: HashMap<Slot, Truth>,
}

/// The ranges of the results for arguments in `arguments`, one interval for each word.
///
/// # Errors
/// [`Finding`] for the first step that may overflow, lose bits, shift too far, clamp to nothing,
/// fail an assertion or break a contract. A finding may be spurious, a success is not.
pub fn ranges(program: &Program, arguments: &[Interval]) -> Result<Vec<Interval>, Finding> {
    let mut state: Vec<Interval> = program
        .initial
        .iter()
        .map(|value| Interval::point(*value))
        .collect();
    let lacking = arguments.len() != program.arguments.len();
    for ((slot, interval), type_) in program
        .arguments
        .iter()
        .zip(arguments)
        .zip(&program.argument_types)
    {
        let (low, high) = range_of(type_);
        if lacking || interval.low > interval.high || !interval.is_within(Interval { low, high }) {
            return Err(Finding {
                place: program.places[0].clone(),
                message: "the stated ranges are not those of the arguments".to_owned(),
            });
        }
        state[*slot] = *interval;
    }
    let mut analysis = Analysis {
        program,
        truths: HashMap::new(),
    };
    analysis.steps(&program.steps, &mut state)?;
    Ok(program.results.iter().map(|slot| state[*slot]).collect())
}

/// The full range of every word of the arguments.
pub fn every_bit_pattern(program: &Program) -> Vec<Interval> {
    program
        .argument_types
        .iter()
        .map(|type_| {
            let (low, high) = range_of(type_);
            Interval { low, high }
        })
        .collect()
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

impl Analysis<'_> {
    fn finding<T>(&self, step: &Step, message: String) -> Result<T, Finding> {
        Err(Finding {
            place: self.program.place(step).clone(),
            message,
        })
    }

    fn steps(&mut self, steps: &[Step], state: &mut [Interval]) -> Result<(), Finding> {
        steps.iter().try_for_each(|step| self.step(step, state))
    }

    fn step(&mut self, step: &Step, state: &mut [Interval]) -> Result<(), Finding> {
        match &step.action {
            Action::Arithmetic {
                to,
                operation,
                a,
                b,
                type_,
            } => {
                let (x, y) = (state[*a], state[*b]);
                // x · x is no product of two independent words.
                let value = if a == b && *operation == Arithmetic::Multiply {
                    square(x)
                } else {
                    arithmetic(*operation, x, y, *type_)
                };
                let fits =
                    value.filter(|value| value.is_within(Interval::new(type_.min(), type_.max())));
                let Some(value) = fits else {
                    return self.finding(
                        step,
                        format!(
                            "{} of [{}, {}] and [{}, {}] may overflow",
                            name(*operation),
                            x.low,
                            x.high,
                            y.low,
                            y.high
                        ),
                    );
                };
                state[*to] = value;
            }
            Action::Compare {
                to,
                comparison,
                a,
                b,
            } => {
                self.truths
                    .insert(*to, Truth::Compared(*comparison, *a, *b));
                state[*to] = compared(*comparison, state[*a], state[*b]);
            }
            Action::Not { to, a } => {
                self.truths.insert(*to, Truth::Not(*a));
                state[*to] = Interval::new(1 - state[*a].high, 1 - state[*a].low);
            }
            Action::Cast { to, a, type_ } => {
                let value = state[*a];
                if !value.is_within(Interval::new(type_.min(), type_.max())) {
                    return self.finding(
                        step,
                        format!("the cast of [{}, {}] may lose bits", value.low, value.high),
                    );
                }
                state[*to] = value;
            }
            Action::Clamp { to, a, low, high } => {
                let (low, high) = (state[*low], state[*high]);
                if low.high > high.low {
                    return self.finding(step, "the clamp's ends may cross".to_owned());
                }
                let value = state[*a];
                state[*to] = Interval {
                    low: value.low.clamp(low.low, high.low),
                    high: value.high.clamp(low.high, high.high),
                };
            }
            Action::If {
                condition,
                then,
                otherwise,
                joins,
            } => self.branch(*condition, then, otherwise, joins, state)?,
            Action::Assert { a, message } => {
                if state[*a].low == 0 {
                    return self.finding(step, format!("the assertion {message} may fail"));
                }
            }
            Action::Contract {
                function,
                requires,
                ensures,
            } => {
                for (slot, low, high) in requires {
                    let found = state[*slot];
                    if !found.is_within(Interval::new(*low, *high)) {
                        return self.finding(
                            step,
                            format!(
                                "`{function}` is given [{}, {}], its contract allows [{low}, {high}]",
                                found.low, found.high
                            ),
                        );
                    }
                }
                for (slot, low, high) in ensures {
                    state[*slot] = Interval::new(*low, *high);
                }
            }
        }
        Ok(())
    }

    fn branch(
        &mut self,
        condition: Slot,
        then: &[Step],
        otherwise: &[Step],
        joins: &[(Slot, Slot, Slot)],
        state: &mut [Interval],
    ) -> Result<(), Finding> {
        let mut yes = state.to_vec();
        let yes_reached = self.narrow(&mut yes, condition, true);
        if yes_reached {
            self.steps(then, &mut yes)?;
        }
        let mut no = state.to_vec();
        let no_reached = self.narrow(&mut no, condition, false);
        if no_reached {
            self.steps(otherwise, &mut no)?;
        }
        // A condition that was computed inside a side is looked at later only where that side was
        // taken, so its words keep the values that they had there.
        for (steps, from, reached) in [(then, &yes, yes_reached), (otherwise, &no, no_reached)] {
            if reached {
                each_written(steps, &mut |slot| state[slot] = from[slot]);
            }
        }
        for (to, a, b) in joins {
            let (a_value, b_value) = (yes[*a], no[*b]);
            state[*to] = match (yes_reached, no_reached) {
                (true, true) => a_value.hull(b_value),
                (true, false) => a_value,
                _ => b_value,
            };
            self.remember_connective(*to, condition, *a, *b);
        }
        Ok(())
    }

    /// `a && b` and `a || b` are branches whose other side is a constant.
    fn remember_connective(&mut self, to: Slot, condition: Slot, yes: Slot, no: Slot) {
        let is = |slot: Slot, value: i128| {
            self.program.is_constant[slot] && self.program.initial[slot] == value
        };
        let knows = |slot: Slot| self.truths.contains_key(&slot);
        if is(no, 0) && knows(yes) {
            self.truths.insert(to, Truth::Both(condition, yes));
        } else if is(yes, 1) && knows(no) {
            self.truths.insert(to, Truth::Either(condition, no));
        }
    }

    /// Narrows `state` to where `slot` is `value`; whether anything is left.
    fn narrow(&self, state: &mut [Interval], slot: Slot, value: bool) -> bool {
        let wanted = i128::from(value);
        let found = state[slot];
        if wanted < found.low || found.high < wanted {
            return false;
        }
        state[slot] = Interval::point(wanted);
        match self.truths.get(&slot) {
            None => true,
            Some(Truth::Not(a)) => self.narrow(state, *a, !value),
            Some(Truth::Both(a, b)) => match value {
                true => self.narrow(state, *a, true) && self.narrow(state, *b, true),
                false if state[*a].low == 1 => self.narrow(state, *b, false),
                false if state[*b].low == 1 && state[*b].high == 1 => self.narrow(state, *a, false),
                false => true,
            },
            Some(Truth::Either(a, b)) => match value {
                false => self.narrow(state, *a, false) && self.narrow(state, *b, false),
                true if state[*a].high == 0 => self.narrow(state, *b, true),
                true => true,
            },
            Some(Truth::Compared(comparison, a, b)) => {
                let (a, b) = (*a, *b);
                match (comparison, value) {
                    (Comparison::Less, true) => below(state, a, b, 1),
                    (Comparison::Less, false) => below(state, b, a, 0),
                    (Comparison::LessEqual, true) => below(state, a, b, 0),
                    (Comparison::LessEqual, false) => below(state, b, a, 1),
                    (Comparison::Equal, true) | (Comparison::NotEqual, false) => {
                        below(state, a, b, 0) && below(state, b, a, 0)
                    }
                    _ => true,
                }
            }
        }
    }
}

/// Every slot that these steps write.
fn each_written(steps: &[Step], found: &mut impl FnMut(Slot)) {
    for step in steps {
        match &step.action {
            Action::Arithmetic { to, .. }
            | Action::Compare { to, .. }
            | Action::Not { to, .. }
            | Action::Cast { to, .. }
            | Action::Clamp { to, .. } => found(*to),
            Action::If {
                then,
                otherwise,
                joins,
                ..
            } => {
                each_written(then, found);
                each_written(otherwise, found);
                for (to, _, _) in joins {
                    found(*to);
                }
            }
            Action::Assert { .. } => {}
            Action::Contract { ensures, .. } => {
                for (slot, _, _) in ensures {
                    found(*slot);
                }
            }
        }
    }
}

/// Narrows to a + gap ≤ b.
fn below(state: &mut [Interval], a: Slot, b: Slot, gap: i128) -> bool {
    state[a].high = state[a].high.min(state[b].high - gap);
    state[b].low = state[b].low.max(state[a].low + gap);
    state[a].low <= state[a].high && state[b].low <= state[b].high
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
    let corner = |x, y| crate::interpret::apply(operation, x, y, type_.bits);
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
