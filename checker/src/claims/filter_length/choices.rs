//! Proof that `clamp` gives the nearest value between two ends, for all words.

use crate::domains::machine::Machine;
use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::language::module::Module;
use crate::program::steps::{Arithmetic, Join, Slot, WordComparison};
use crate::program::types::Integer;

use crate::claims::filter_length::algebra::unless;

/// `clamp` only compares and picks among its arguments, so it is settled by every order in which
/// three numbers can stand.
pub(crate) fn clamp_is_nearest(module: &Module) -> Result<(), String> {
    let program = module
        .function("product::clamp")
        .ok_or("there is no product::clamp")?;
    let arguments = vec![Choice::Argument; program.arguments.len()];
    let mut words = start(&mut Choices, program, arguments);
    let is_walked = walk(&mut Choices, program, &mut words).is_ok();
    let only_picks = program
        .results
        .iter()
        .all(|slot| words[*slot] != Choice::Other);
    unless(
        program.arguments.len() == 3 && program.results.len() == 1 && is_walked && only_picks,
        "`clamp` does more than compare its arguments",
    )?;
    let mut machine = Machine::new(program);
    for order in 0..27 {
        let (value, low, high) = (order % 3, order / 3 % 3, order / 9);
        if low > high {
            continue;
        }
        let result = machine
            .call(&[value, low, high])
            .map_err(|trap| trap.to_string())?;
        unless(
            result == [value.clamp(low, high)],
            "`clamp` does not give the nearest value",
        )?;
    }
    Ok(())
}

/// A word as a function sees it that may only compare and choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    /// An argument.
    Argument,
    /// One of the arguments, it depends which.
    Picked,
    /// A truth, a constant, or not written yet.
    Other,
}

/// Ends where a step does anything but compare arguments, or pick one of them.
struct Choices;

/// Something else was done.
struct MoreThanChoices;

type Chosen = Result<Choice, MoreThanChoices>;

impl Domain for Choices {
    type Word = Choice;
    type Stop = MoreThanChoices;

    fn initial(&mut self, _slot: Slot, _constant: Option<i128>) -> Choice {
        Choice::Other
    }

    fn arithmetic(
        &mut self,
        _site: &Site<Choice>,
        _to: Slot,
        _operation: Arithmetic,
        _operands: (Slot, Slot),
        _type: Integer,
    ) -> Chosen {
        Err(MoreThanChoices)
    }

    fn comparison(
        &mut self,
        site: &Site<Choice>,
        _to: Slot,
        _comparison: WordComparison,
        (a, b): (Slot, Slot),
    ) -> Chosen {
        match (site.word(a), site.word(b)) {
            (Choice::Argument, Choice::Argument) => Ok(Choice::Other),
            _ => Err(MoreThanChoices),
        }
    }

    fn negation(&mut self, _site: &Site<Choice>, _to: Slot, _operand: Slot) -> Chosen {
        Err(MoreThanChoices)
    }

    fn cast(&mut self, _site: &Site<Choice>, _operand: Slot, _type: Integer) -> Chosen {
        Err(MoreThanChoices)
    }

    fn clamp(
        &mut self,
        _site: &Site<Choice>,
        _to: Slot,
        _operand: Slot,
        _ends: (Slot, Slot),
    ) -> Chosen {
        Err(MoreThanChoices)
    }

    fn assertion(
        &mut self,
        _site: &Site<Choice>,
        _condition: Slot,
        _message: &str,
    ) -> Result<(), MoreThanChoices> {
        Err(MoreThanChoices)
    }

    fn call(
        &mut self,
        _site: &Site<Choice>,
        _call: ContractedCall,
    ) -> Result<Vec<Choice>, MoreThanChoices> {
        Err(MoreThanChoices)
    }

    fn join(
        &mut self,
        _site: &Site<Choice>,
        _condition: Slot,
        _joins: &[Join],
        [then, otherwise]: [BranchEnd<Choice>; 2],
    ) -> Result<Vec<Choice>, MoreThanChoices> {
        let both = then.words.iter().zip(&otherwise.words);
        both.map(|sides| match sides {
            (Choice::Other, _) | (_, Choice::Other) => Err(MoreThanChoices),
            _ => Ok(Choice::Picked),
        })
        .collect()
    }
}
