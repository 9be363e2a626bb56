//! A function of the emitted crate, resolved: words in numbered slots, calls inlined.
//!
//! There are no loops in the language, so a function is a finite list of steps with branches.
//! Every slot is written once, except that a branch writes the slots in which its two sides join.
//! Every computation with a function uses this form, through the walk of
//! [`crate::domains::walk`].

use crate::program::place::SourcePlace;
use crate::program::types::{Integer, Type};

/// Number of a word.
pub type Slot = usize;

/// Operation on two integers of one type (the amount of a shift is `u32` or another integer).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// a + b
    Add,
    /// a − b
    Subtract,
    /// a · b
    Multiply,
    /// a << b
    ShiftLeft,
    /// ⌊a / 2ᵇ⌋
    ShiftRight,
    /// Bits that both have.
    And,
}

impl Arithmetic {
    /// a op b in unlimited integers; `None` if 128 bits or the shift's range (`bits` of the
    /// type) are not sufficient.
    pub fn apply(self, a: i128, b: i128, bits: u32) -> Option<i128> {
        match self {
            Arithmetic::Add => a.checked_add(b),
            Arithmetic::Subtract => a.checked_sub(b),
            Arithmetic::Multiply => a.checked_mul(b),
            Arithmetic::ShiftLeft | Arithmetic::ShiftRight => {
                let amount = u32::try_from(b).ok().filter(|amount| *amount < bits)?;
                if self == Arithmetic::ShiftRight {
                    return Some(a >> amount);
                }
                // Rust's << drops high bits without a panic; here that counts as an overflow.
                1_i128
                    .checked_shl(amount)
                    .filter(|power| *power > 0)
                    .and_then(|power| a.checked_mul(power))
            }
            Arithmetic::And => Some(a & b),
        }
    }

    /// The operation in words.
    pub fn name(self) -> &'static str {
        match self {
            Arithmetic::Add => "the sum",
            Arithmetic::Subtract => "the difference",
            Arithmetic::Multiply => "the product",
            Arithmetic::ShiftLeft => "the left shift",
            Arithmetic::ShiftRight => "the right shift",
            Arithmetic::And => "the common bits",
        }
    }
}

/// Comparison of two integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordComparison {
    /// a < b
    Less,
    /// a ≤ b
    LessEqual,
    /// a = b
    Equal,
    /// a ≠ b
    NotEqual,
}

/// A word in which the two sides of a branch join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Join {
    /// Result.
    pub to: Slot,
    /// Its word if the condition holds.
    pub then: Slot,
    /// Its word if it does not.
    pub otherwise: Slot,
}

impl Join {
    /// Its word on one side.
    pub fn of(&self, is_then: bool) -> Slot {
        if is_then { self.then } else { self.otherwise }
    }
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// to ← a op b, which must fit `type_`.
    Arithmetic {
        /// Result.
        to: Slot,
        /// Operation.
        operation: Arithmetic,
        /// First operand.
        a: Slot,
        /// Second operand.
        b: Slot,
        /// Type of the result.
        type_: Integer,
    },
    /// to ← a compared with b.
    Compare {
        /// Result.
        to: Slot,
        /// Comparison.
        comparison: WordComparison,
        /// First operand.
        a: Slot,
        /// Second operand.
        b: Slot,
    },
    /// to ← not a.
    Not {
        /// Result.
        to: Slot,
        /// Operand.
        a: Slot,
    },
    /// to ← a, which must fit `type_`.
    Cast {
        /// Result.
        to: Slot,
        /// Operand.
        a: Slot,
        /// Type of the result.
        type_: Integer,
    },
    /// to ← the value nearest to a within [low, high]; low ≤ high.
    Clamp {
        /// Result.
        to: Slot,
        /// Operand.
        a: Slot,
        /// Lower end.
        low: Slot,
        /// Upper end.
        high: Slot,
    },
    /// Executes one of two lists of steps, then copies, for each join, the word of that side.
    If {
        /// Condition.
        condition: Slot,
        /// Steps if it holds.
        then: Vec<ProgramStep>,
        /// Steps if it does not.
        otherwise: Vec<ProgramStep>,
        /// The words in which the two sides join.
        joins: Vec<Join>,
    },
    /// Fails unless `a` holds.
    Assert {
        /// Condition.
        a: Slot,
        /// What is said otherwise.
        message: String,
    },
    /// A call, represented by its contract: the arguments must be in their ranges, the results are in theirs.
    Contract {
        /// Function.
        function: String,
        /// Arguments and their ranges.
        requires: Vec<(Slot, i128, i128)>,
        /// Results and their ranges.
        ensures: Vec<(Slot, i128, i128)>,
    },
}

/// A step, with its place in the source.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramStep {
    /// What it does.
    pub action: Action,
    /// Number in [`Program::places`].
    pub place: u32,
}

/// A resolved function.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Name of the function.
    pub name: String,
    /// Names of the words of the arguments, `accel[1]` for instance.
    pub inputs: Vec<String>,
    /// Slots of the words of the arguments, in order.
    pub arguments: Vec<Slot>,
    /// Types of these words.
    pub argument_types: Vec<Type>,
    /// Slots of the words of the result, followed by those of `&mut` arguments.
    pub results: Vec<Slot>,
    /// Types of these words.
    pub result_types: Vec<Type>,
    /// Slots before the first step; they already contain the constants.
    pub initial: Vec<i128>,
    /// Slots that hold constants.
    pub is_constant: Vec<bool>,
    /// Steps.
    pub steps: Vec<ProgramStep>,
    /// Places of the steps.
    pub places: Vec<SourcePlace>,
}

impl Program {
    /// The place of a step.
    pub fn place(&self, step: &ProgramStep) -> &SourcePlace {
        &self.places[step.place as usize]
    }

    /// Number of steps, those of branches included.
    pub fn len(&self) -> usize {
        fn count(steps: &[ProgramStep]) -> usize {
            steps
                .iter()
                .map(|step| match &step.action {
                    Action::If {
                        then, otherwise, ..
                    } => 1 + count(then) + count(otherwise),
                    _ => 1,
                })
                .sum()
        }
        count(&self.steps)
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }
}
