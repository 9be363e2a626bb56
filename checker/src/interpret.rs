//! Runs a resolved function on words, with every overflow found.

use crate::language::Type;
use crate::program::{Action, Arithmetic, Comparison, Program, Step};
use crate::source::Place;

/// What stops a run: arithmetic that leaves its type, a cast that loses bits, an assertion.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct Trap {
    /// Where.
    pub place: Place,
    /// What happened.
    pub message: String,
}

/// Runs one function many times without allocating anew.
#[derive(Clone, Debug)]
pub struct Machine<'a> {
    program: &'a Program,
    slots: Vec<i128>,
    results: Vec<i128>,
}

impl<'a> Machine<'a> {
    /// A machine for `program`.
    pub fn new(program: &'a Program) -> Self {
        Machine {
            program,
            slots: program.initial.clone(),
            results: vec![0; program.results.len()],
        }
    }

    /// Calls the function: words of the arguments in, words of the result (and of `&mut`
    /// arguments) out. Booleans are 0 and 1; fixed-point numbers are their bits.
    ///
    /// # Errors
    /// [`Trap`] where the compiled code would overflow or panic, where a cast loses bits, and
    /// where `arguments` are not words of the argument types.
    pub fn call(&mut self, arguments: &[i128]) -> Result<&[i128], Trap> {
        let program = self.program;
        if arguments.len() != program.arguments.len() {
            return Err(trap(
                program,
                0,
                format!(
                    "{} takes {} words, not {}",
                    program.name,
                    program.arguments.len(),
                    arguments.len()
                ),
            ));
        }
        for (index, (slot, value)) in program.arguments.iter().zip(arguments).enumerate() {
            if !holds(&program.argument_types[index], *value) {
                return Err(trap(
                    program,
                    0,
                    format!("{value} is no {}", program.inputs[index]),
                ));
            }
            self.slots[*slot] = *value;
        }
        run(program, &program.steps, &mut self.slots)?;
        for (result, slot) in self.results.iter_mut().zip(&program.results) {
            *result = self.slots[*slot];
        }
        Ok(&self.results)
    }
}

/// Whether a word can have this value.
pub(crate) fn holds(type_: &Type, value: i128) -> bool {
    let (low, high) = range_of(type_);
    low <= value && value <= high
}

/// Smallest and largest value of a word.
pub fn range_of(type_: &Type) -> (i128, i128) {
    match type_ {
        Type::Integer(integer) => (integer.min(), integer.max()),
        Type::Fixed(_) => (i32::MIN.into(), i32::MAX.into()),
        // Words are integers, fixed-point numbers or booleans.
        _ => (0, 1),
    }
}

fn trap(program: &Program, place: u32, message: String) -> Trap {
    Trap {
        place: program.places[place as usize].clone(),
        message,
    }
}

fn run(program: &Program, steps: &[Step], slots: &mut [i128]) -> Result<(), Trap> {
    for step in steps {
        match &step.action {
            Action::Arithmetic {
                to,
                operation,
                a,
                b,
                type_,
            } => {
                let (a, b) = (slots[*a], slots[*b]);
                let value = apply(*operation, a, b, type_.bits).filter(|value| type_.holds(*value));
                let Some(value) = value else {
                    return Err(trap(
                        program,
                        step.place,
                        format!("{} of {a} and {b} overflows", name(*operation)),
                    ));
                };
                slots[*to] = value;
            }
            Action::Compare {
                to,
                comparison,
                a,
                b,
            } => {
                let (a, b) = (slots[*a], slots[*b]);
                let holds = match comparison {
                    Comparison::Less => a < b,
                    Comparison::LessEqual => a <= b,
                    Comparison::Equal => a == b,
                    Comparison::NotEqual => a != b,
                };
                slots[*to] = i128::from(holds);
            }
            Action::Not { to, a } => slots[*to] = 1 - slots[*a],
            Action::Cast { to, a, type_ } => {
                let value = slots[*a];
                if !type_.holds(value) {
                    return Err(trap(
                        program,
                        step.place,
                        format!("the cast of {value} loses bits"),
                    ));
                }
                slots[*to] = value;
            }
            Action::Clamp { to, a, low, high } => {
                let (low, high) = (slots[*low], slots[*high]);
                if low > high {
                    return Err(trap(
                        program,
                        step.place,
                        format!("clamp to [{low}, {high}], which is empty"),
                    ));
                }
                slots[*to] = slots[*a].clamp(low, high);
            }
            Action::If {
                condition,
                then,
                otherwise,
                joins,
            } => {
                if slots[*condition] != 0 {
                    run(program, then, slots)?;
                    for (to, value, _) in joins {
                        slots[*to] = slots[*value];
                    }
                } else {
                    run(program, otherwise, slots)?;
                    for (to, _, value) in joins {
                        slots[*to] = slots[*value];
                    }
                }
            }
            Action::Assert { a, message } => {
                if slots[*a] == 0 {
                    return Err(trap(program, step.place, format!("assertion: {message}")));
                }
            }
            Action::Contract { function, .. } => {
                return Err(trap(
                    program,
                    step.place,
                    format!("{function} stands for its contract only and cannot run"),
                ));
            }
        }
    }
    Ok(())
}

/// a op b in unlimited integers; `None` where even 128 bits or the shift's range do not suffice.
pub(crate) fn apply(operation: Arithmetic, a: i128, b: i128, bits: u32) -> Option<i128> {
    match operation {
        Arithmetic::Add => a.checked_add(b),
        Arithmetic::Subtract => a.checked_sub(b),
        Arithmetic::Multiply => a.checked_mul(b),
        Arithmetic::ShiftLeft | Arithmetic::ShiftRight => {
            let amount = u32::try_from(b).ok().filter(|amount| *amount < bits)?;
            if operation == Arithmetic::ShiftRight {
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
pub(crate) fn name(operation: Arithmetic) -> &'static str {
    match operation {
        Arithmetic::Add => "the sum",
        Arithmetic::Subtract => "the difference",
        Arithmetic::Multiply => "the product",
        Arithmetic::ShiftLeft => "the left shift",
        Arithmetic::ShiftRight => "the right shift",
        Arithmetic::And => "the common bits",
    }
}
