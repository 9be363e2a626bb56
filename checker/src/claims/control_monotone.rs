//! Claim `control-monotone`: the command rises or falls with each state, as the sign of its gain
//! says.

use crate::certificate::reader::Certificate;
use crate::claims::outcome::ClaimOutcome;
use crate::domains::smt::{Question, SolverAnswer, TIMEOUT_MS, answered, io};
use crate::program::steps::Program;

/// A linear form, rounded down and clamped, is monotone in each argument; that the source is one,
/// [`crate::claims::control_law::EmittedLaw::read`] has shown.
pub fn by_intervals() -> ClaimOutcome {
    ClaimOutcome::Proved("a linear form, rounded down and clamped".to_owned())
}

/// The questions to z3, one for each state.
pub fn by_smt(program: &Program, certificate: &Certificate) -> SolverAnswer {
    (0..3)
        .map(|state| monotone(program, certificate, state))
        .find(|answer| *answer != SolverAnswer::Proved)
        .unwrap_or(SolverAnswer::Proved)
}

/// For one state: two copies of the law that differ in it.
fn monotone(program: &Program, certificate: &Certificate, state: usize) -> SolverAnswer {
    let ask = || {
        let mut question = Question::new(TIMEOUT_MS)?;
        let lower = question.arguments(program, "x")?;
        let mut upper = lower.clone();
        let (low, high) = program.argument_types[state].range();
        let sort = question.context.int_sort();
        upper[state] = io(question.context.declare_const("y", sort))?;
        let range = question.within(upper[state], low, high);
        io(question.context.assert(range))?;
        let rises = question.context.lte(lower[state], upper[state]);
        io(question.context.assert(rises))?;
        let one = question.results(program, &lower)?[0];
        let other = question.results(program, &upper)?[0];
        let gain = certificate.constants[state].raw;
        let wanted = if gain >= 0 {
            question.context.lte(one, other)
        } else {
            question.context.lte(other, one)
        };
        question.ask(wanted)
    };
    answered(ask())
}
