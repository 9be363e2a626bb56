//! The direction in which a word changes when one argument rises and the others are constant.
//!
//! Sums keep a direction that both terms have, and factors reverse it if they are negative. Rounding down
//! by a shift, a clamp to constants, and a cast without loss keep it.

use std::convert::Infallible;

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::Integer;

/// How a word changes when an argument rises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// It is constant.
    Stays,
    /// It does not fall.
    Rises,
    /// It does not rise.
    Falls,
    /// It may do any of these.
    Unknown,
}

impl Direction {
    fn plus(self, other: Direction) -> Direction {
        match (self, other) {
            (Direction::Stays, other) => other,
            (own, Direction::Stays) => own,
            (own, other) if own == other => own,
            _ => Direction::Unknown,
        }
    }

    fn times(self, factor: i128) -> Direction {
        match self {
            _ if factor == 0 => Direction::Stays,
            Direction::Rises if factor < 0 => Direction::Falls,
            Direction::Falls if factor < 0 => Direction::Rises,
            own => own,
        }
    }
}

/// A word: its value if it is a constant, and its direction for each argument.
#[derive(Clone, Debug)]
struct Word {
    value: Option<i128>,
    directions: Vec<Direction>,
}

/// For each result of `program`: its direction for each argument, if nothing overflows (which
/// [`crate::domains::intervals`] proves).
pub fn directions(program: &Program) -> Vec<Vec<Direction>> {
    let count = program.arguments.len();
    let mut domain = Directions { count };
    let arguments = (0..count).map(|index| Word {
        value: None,
        directions: (0..count)
            .map(|other| {
                if other == index {
                    Direction::Rises
                } else {
                    Direction::Stays
                }
            })
            .collect(),
    });
    let mut words = start(&mut domain, program, arguments);
    match walk(&mut domain, program, &mut words) {
        Ok(()) => {}
    }
    let results = program.results.iter();
    results
        .map(|slot| words[*slot].directions.clone())
        .collect()
}

struct Directions {
    count: usize,
}

impl Directions {
    fn unknown(&self) -> Word {
        Word {
            value: None,
            directions: vec![Direction::Unknown; self.count],
        }
    }
}

fn each(a: &Word, b: &Word, of: impl Fn(Direction, Direction) -> Direction) -> Word {
    let pairs = a.directions.iter().zip(&b.directions);
    Word {
        value: None,
        directions: pairs.map(|(a, b)| of(*a, *b)).collect(),
    }
}

fn scaled(word: &Word, factor: i128) -> Word {
    let directions = word.directions.iter();
    Word {
        value: None,
        directions: directions.map(|own| own.times(factor)).collect(),
    }
}

impl Domain for Directions {
    type Word = Word;
    type Stop = Infallible;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> Word {
        Word {
            value: constant,
            directions: vec![Direction::Stays; self.count],
        }
    }

    fn arithmetic(
        &mut self,
        site: &Site<Word>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        type_: Integer,
    ) -> Result<Word, Infallible> {
        let (a, b) = (site.word(a), site.word(b));
        if let (Some(a), Some(b)) = (a.value, b.value) {
            return Ok(Word {
                value: operation.apply(a, b, type_.bits),
                directions: vec![Direction::Stays; self.count],
            });
        }
        Ok(match (operation, a.value, b.value) {
            (Arithmetic::Add, ..) => each(a, b, Direction::plus),
            (Arithmetic::Subtract, ..) => each(a, &scaled(b, -1), Direction::plus),
            (Arithmetic::Multiply, Some(factor), _) => scaled(b, factor),
            (Arithmetic::Multiply, _, Some(factor)) => scaled(a, factor),
            (Arithmetic::ShiftLeft | Arithmetic::ShiftRight, _, Some(_)) => scaled(a, 1),
            _ => self.unknown(),
        })
    }

    fn comparison(
        &mut self,
        _site: &Site<Word>,
        _to: Slot,
        _comparison: WordComparison,
        _operands: (Slot, Slot),
    ) -> Result<Word, Infallible> {
        Ok(self.unknown())
    }

    fn negation(
        &mut self,
        _site: &Site<Word>,
        _to: Slot,
        _operand: Slot,
    ) -> Result<Word, Infallible> {
        Ok(self.unknown())
    }

    fn cast(
        &mut self,
        site: &Site<Word>,
        operand: Slot,
        _type: Integer,
    ) -> Result<Word, Infallible> {
        Ok(site.word(operand).clone())
    }

    fn clamp(
        &mut self,
        site: &Site<Word>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Result<Word, Infallible> {
        // Rising limits raise the result, too.
        let ends = each(site.word(low), site.word(high), Direction::plus);
        Ok(each(site.word(operand), &ends, Direction::plus))
    }

    fn assertion(
        &mut self,
        _site: &Site<Word>,
        _condition: Slot,
        _message: &str,
    ) -> Result<(), Infallible> {
        Ok(())
    }

    fn call(&mut self, _site: &Site<Word>, call: ContractedCall) -> Result<Vec<Word>, Infallible> {
        Ok(vec![self.unknown(); call.ensures.len()])
    }

    fn join(
        &mut self,
        _site: &Site<Word>,
        _condition: Slot,
        joins: &[Join],
        _sides: [BranchEnd<Word>; 2],
    ) -> Result<Vec<Word>, Infallible> {
        Ok(vec![self.unknown(); joins.len()])
    }
}
