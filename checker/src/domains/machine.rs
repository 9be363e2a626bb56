//! One integer for each word: executes a function and detects every overflow.

use std::cell::Cell;

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Sides, Site, start, walk};
use crate::program::place::SourcePlace;
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::Integer;

/// The reason why a run stops: arithmetic that overflows its type, a cast that loses bits, a failed assertion.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct Trap {
    /// The place.
    pub place: SourcePlace,
    /// The event.
    pub message: String,
}

/// Executes one function many times without new allocations.
#[derive(Clone, Debug)]
pub struct Machine<'a> {
    program: &'a Program,
    words: Vec<i128>,
    results: Vec<i128>,
    path: u64,
}

impl<'a> Machine<'a> {
    /// A machine for `program`.
    pub fn new(program: &'a Program) -> Self {
        Machine {
            program,
            words: start(&mut Integers::default(), program, []),
            results: vec![0; program.results.len()],
            path: 0,
        }
    }

    /// Calls the function with the words of the arguments; returns the words of the result (and of `&mut`
    /// arguments). Booleans are 0 and 1; fixed-point numbers are their bits.
    ///
    /// # Errors
    /// [`Trap`] if the compiled code would overflow or panic, if a cast loses bits, or
    /// if `arguments` are not words of the argument types.
    pub fn call(&mut self, arguments: &[i128]) -> Result<&[i128], Trap> {
        let program = self.program;
        let refused = |message: String| Trap {
            place: program.places[0].clone(),
            message,
        };
        if arguments.len() != program.arguments.len() {
            return Err(refused(format!(
                "{} takes {} words, not {}",
                program.name,
                program.arguments.len(),
                arguments.len()
            )));
        }
        for (index, (slot, value)) in program.arguments.iter().zip(arguments).enumerate() {
            if !program.argument_types[index].holds(*value) {
                return Err(refused(format!("{value} is no {}", program.inputs[index])));
            }
            self.words[*slot] = *value;
        }
        let mut domain = Integers::default();
        walk(&mut domain, program, &mut self.words)?;
        self.path = domain.path.get();
        for (result, slot) in self.results.iter_mut().zip(&program.results) {
            *result = self.words[*slot];
        }
        Ok(&self.results)
    }

    /// A number that identifies the path of the last call: which sides of branches, which ends of clamps.
    pub fn path(&self) -> u64 {
        self.path
    }
}

/// The integers themselves.
#[derive(Default)]
struct Integers {
    /// Changed by every decision; two paths have the same number only by coincidence.
    path: Cell<u64>,
}

impl Integers {
    fn decided(&self, way: u64) {
        let mixed = (self.path.get() ^ way).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.path.set(mixed.rotate_left(29).wrapping_add(1));
    }
}

fn trap<T>(site: &Site<i128>, message: String) -> Result<T, Trap> {
    Err(Trap {
        place: site.place(),
        message,
    })
}

impl Domain for Integers {
    type Word = i128;
    type Stop = Trap;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> i128 {
        constant.unwrap_or(0)
    }

    fn arithmetic(
        &mut self,
        site: &Site<i128>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        type_: Integer,
    ) -> Result<i128, Trap> {
        let (a, b) = (*site.word(a), *site.word(b));
        match operation.apply(a, b, type_.bits) {
            Some(value) if type_.holds(value) => Ok(value),
            _ => trap(
                site,
                format!("{} of {a} and {b} overflows", operation.name()),
            ),
        }
    }

    fn comparison(
        &mut self,
        site: &Site<i128>,
        _to: Slot,
        comparison: WordComparison,
        (a, b): (Slot, Slot),
    ) -> Result<i128, Trap> {
        let (a, b) = (site.word(a), site.word(b));
        Ok(i128::from(match comparison {
            WordComparison::Less => a < b,
            WordComparison::LessEqual => a <= b,
            WordComparison::Equal => a == b,
            WordComparison::NotEqual => a != b,
        }))
    }

    fn negation(&mut self, site: &Site<i128>, _to: Slot, operand: Slot) -> Result<i128, Trap> {
        Ok(1 - site.word(operand))
    }

    fn cast(&mut self, site: &Site<i128>, operand: Slot, type_: Integer) -> Result<i128, Trap> {
        let value = *site.word(operand);
        if type_.holds(value) {
            Ok(value)
        } else {
            trap(site, format!("the cast of {value} loses bits"))
        }
    }

    fn clamp(
        &mut self,
        site: &Site<i128>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Result<i128, Trap> {
        let (low, high) = (*site.word(low), *site.word(high));
        if low > high {
            return trap(site, format!("clamp to [{low}, {high}], which is empty"));
        }
        let value = *site.word(operand);
        self.decided(u64::from(value > low) + u64::from(value >= high) + 2);
        Ok(value.clamp(low, high))
    }

    fn assertion(&mut self, site: &Site<i128>, condition: Slot, message: &str) -> Result<(), Trap> {
        if *site.word(condition) == 0 {
            return trap(site, format!("assertion: {message}"));
        }
        Ok(())
    }

    fn call(&mut self, site: &Site<i128>, call: ContractedCall) -> Result<Vec<i128>, Trap> {
        trap(
            site,
            format!(
                "{} stands for its contract only and cannot run",
                call.function
            ),
        )
    }

    fn sides(&self, condition: &i128) -> Sides {
        self.decided(u64::from(*condition != 0));
        Sides::One(*condition != 0)
    }

    // Only one side is visited; this is the meaning of joining both.
    fn join(
        &mut self,
        site: &Site<i128>,
        condition: Slot,
        _joins: &[Join],
        [then, otherwise]: [BranchEnd<i128>; 2],
    ) -> Result<Vec<i128>, Trap> {
        let taken = if *site.word(condition) != 0 {
            then
        } else {
            otherwise
        };
        Ok(taken.words)
    }
}
