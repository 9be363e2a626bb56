//! The walk over a program, for every domain in which its words are computed.
//!
//! A [`Domain`] defines what a word is and the result of each operation. [`walk`] visits
//! the steps, including both sides of branches, and stores the words.
//!
//! **Branches.** If a domain knows which side of a branch is taken, only that side is visited, and the words in which
//! the sides join are copied from it. Otherwise both sides are visited. Before a side, the domain is told to
//! enter it; it may narrow the words to those for which the side is taken, or find that the side is
//! never taken. Afterwards it undoes the narrowing. Then it joins the results of the two sides.
//! Every word is written once, so neither side disturbs the other.

use crate::program::place::SourcePlace;
use crate::program::steps::{Action, Arithmetic, Join, Program, ProgramStep, Slot, WordComparison};
use crate::program::types::Integer;

/// The present state of a walk: the step, and the words so far.
#[derive(Debug)]
pub struct Site<'a, W> {
    /// The program.
    pub program: &'a Program,
    /// The step.
    pub step: &'a ProgramStep,
    /// The words, by slot.
    pub words: &'a [W],
}

impl<W> Site<'_, W> {
    /// A word.
    pub fn word(&self, slot: Slot) -> &W {
        &self.words[slot]
    }

    /// The value of a word that is a constant.
    pub fn constant(&self, slot: Slot) -> Option<i128> {
        self.program.is_constant[slot].then(|| self.program.initial[slot])
    }

    /// Where the step stands in the source.
    pub fn place(&self) -> SourcePlace {
        self.program.place(self.step).clone()
    }
}

/// A call that its contract represents.
#[derive(Clone, Copy, Debug)]
pub struct ContractedCall<'a> {
    /// Function.
    pub function: &'a str,
    /// Arguments and their ranges.
    pub requires: &'a [(Slot, i128, i128)],
    /// Results and their ranges.
    pub ensures: &'a [(Slot, i128, i128)],
}

/// Which sides of a branch are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Only the side for this value of the condition.
    One(bool),
    /// Both.
    Both,
}

/// The result of one side of a branch.
#[derive(Clone, Debug)]
pub struct BranchEnd<W> {
    /// Whether the side can be taken.
    pub is_reached: bool,
    /// For each join: its word from this side.
    pub words: Vec<W>,
}

/// Defines what a word is, and the results of a program's operations on words.
///
/// An operation receives the slots of its operands, because some domains know more about a word than
/// its value: that two operands are the same word, or that a word is a constant.
pub trait Domain {
    /// A word.
    type Word: Clone;
    /// The reason why a walk ends early.
    type Stop;

    /// The word of a slot before the first step: a constant, or one that is not written yet.
    fn initial(&mut self, slot: Slot, constant: Option<i128>) -> Self::Word;

    /// The result of an operation, for the slot `to`; it must fit `type_`.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn arithmetic(
        &mut self,
        site: &Site<Self::Word>,
        to: Slot,
        operation: Arithmetic,
        operands: (Slot, Slot),
        type_: Integer,
    ) -> Result<Self::Word, Self::Stop>;

    /// The truth of a comparison.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn comparison(
        &mut self,
        site: &Site<Self::Word>,
        to: Slot,
        comparison: WordComparison,
        operands: (Slot, Slot),
    ) -> Result<Self::Word, Self::Stop>;

    /// The negation of a truth value.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn negation(
        &mut self,
        site: &Site<Self::Word>,
        to: Slot,
        operand: Slot,
    ) -> Result<Self::Word, Self::Stop>;

    /// The same number in another type, which it must fit.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn cast(
        &mut self,
        site: &Site<Self::Word>,
        operand: Slot,
        type_: Integer,
    ) -> Result<Self::Word, Self::Stop>;

    /// The value nearest to the operand between two ends, which must not cross.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn clamp(
        &mut self,
        site: &Site<Self::Word>,
        to: Slot,
        operand: Slot,
        ends: (Slot, Slot),
    ) -> Result<Self::Word, Self::Stop>;

    /// A condition that must hold.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn assertion(
        &mut self,
        site: &Site<Self::Word>,
        condition: Slot,
        message: &str,
    ) -> Result<(), Self::Stop>;

    /// The results of a call that is represented by the contract of the function: one word for each range that the
    /// contract ensures.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn call(
        &mut self,
        site: &Site<Self::Word>,
        call: ContractedCall,
    ) -> Result<Vec<Self::Word>, Self::Stop>;

    /// Which sides of a branch with this condition are visited; both by default.
    fn sides(&self, _condition: &Self::Word) -> Sides {
        Sides::Both
    }

    /// Called before a side is visited; returns whether it can be taken. It may narrow words.
    fn enter(&mut self, _words: &mut [Self::Word], _condition: Slot, _side: bool) -> bool {
        true
    }

    /// Called after a side; undoes [`Domain::enter`].
    fn leave(&mut self, _words: &mut [Self::Word]) {}

    /// The words in which the sides of a branch join, one for each of `joins`. Not called if only one side is
    /// visited.
    ///
    /// # Errors
    /// The reason to end the walk.
    fn join(
        &mut self,
        site: &Site<Self::Word>,
        condition: Slot,
        joins: &[Join],
        sides: [BranchEnd<Self::Word>; 2],
    ) -> Result<Vec<Self::Word>, Self::Stop>;
}

/// The words before the first step, those of the arguments among them.
pub fn start<D: Domain>(
    domain: &mut D,
    program: &Program,
    arguments: impl IntoIterator<Item = D::Word>,
) -> Vec<D::Word> {
    let constants = program.initial.iter().zip(&program.is_constant);
    let mut words: Vec<D::Word> = constants
        .enumerate()
        .map(|(slot, (value, is_constant))| domain.initial(slot, is_constant.then_some(*value)))
        .collect();
    for (slot, argument) in program.arguments.iter().zip(arguments) {
        words[*slot] = argument;
    }
    words
}

/// Computes every word of `program`; `words` holds those before the first step.
///
/// # Errors
/// The reason why the walk ended.
pub fn walk<D: Domain>(
    domain: &mut D,
    program: &Program,
    words: &mut [D::Word],
) -> Result<(), D::Stop> {
    steps(domain, program, &program.steps, words)
}

fn steps<D: Domain>(
    domain: &mut D,
    program: &Program,
    steps: &[ProgramStep],
    words: &mut [D::Word],
) -> Result<(), D::Stop> {
    for step in steps {
        let site = Site {
            program,
            step,
            words: &*words,
        };
        match &step.action {
            Action::Arithmetic {
                to,
                operation,
                a,
                b,
                type_,
            } => words[*to] = domain.arithmetic(&site, *to, *operation, (*a, *b), *type_)?,
            Action::Compare {
                to,
                comparison,
                a,
                b,
            } => words[*to] = domain.comparison(&site, *to, *comparison, (*a, *b))?,
            Action::Not { to, a } => words[*to] = domain.negation(&site, *to, *a)?,
            Action::Cast { to, a, type_ } => words[*to] = domain.cast(&site, *a, *type_)?,
            Action::Clamp { to, a, low, high } => {
                words[*to] = domain.clamp(&site, *to, *a, (*low, *high))?;
            }
            Action::Assert { a, message } => domain.assertion(&site, *a, message)?,
            Action::Contract {
                function,
                requires,
                ensures,
            } => {
                let call = ContractedCall {
                    function,
                    requires,
                    ensures,
                };
                let results = domain.call(&site, call)?;
                for ((to, _, _), result) in ensures.iter().zip(results) {
                    words[*to] = result;
                }
            }
            Action::If {
                condition,
                then,
                otherwise,
                joins,
            } => match domain.sides(&words[*condition]) {
                Sides::One(true) => {
                    self::steps(domain, program, then, words)?;
                    for join in joins {
                        words[join.to] = words[join.then].clone();
                    }
                }
                Sides::One(false) => {
                    self::steps(domain, program, otherwise, words)?;
                    for join in joins {
                        words[join.to] = words[join.otherwise].clone();
                    }
                }
                Sides::Both => {
                    let mut side = |is_then: bool, steps: &[ProgramStep]| {
                        let is_reached = domain.enter(words, *condition, is_then);
                        if is_reached {
                            self::steps(domain, program, steps, words)?;
                        }
                        let left = joins.iter().map(|join| words[join.of(is_then)].clone());
                        let left = left.collect();
                        domain.leave(words);
                        Ok(BranchEnd {
                            is_reached,
                            words: left,
                        })
                    };
                    let sides = [side(true, then)?, side(false, otherwise)?];
                    let site = Site {
                        program,
                        step,
                        words: &*words,
                    };
                    let joined = domain.join(&site, *condition, joins, sides)?;
                    for (join, word) in joins.iter().zip(joined) {
                        words[join.to] = word;
                    }
                }
            },
        }
    }
    Ok(())
}
