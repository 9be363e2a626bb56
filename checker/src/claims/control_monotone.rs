//! Claim `control-monotone`: the command rises or falls with each state, according to the sign of its
//! gain.

use crate::certificate::reader::Certificate;
use crate::claims::outcome::ClaimOutcome;
use crate::domains::directions::{Direction, directions};
use crate::domains::smt::{Question, SolverAnswer, TIMEOUT_MS, answered, io};
use crate::language::module::Module;
use crate::program::steps::Program;

/// Follows through the source in which direction the command moves with each state.
pub fn by_directions(module: &Module, certificate: &Certificate) -> ClaimOutcome {
    let found = module
        .function("control")
        .map(directions)
        .and_then(|results| results.into_iter().next())
        .filter(|found| found.len() == 3);
    let Some(found) = found else {
        return ClaimOutcome::Failed("there is no `control` of three states".to_owned());
    };
    let gains = &certificate.constants;
    for ((state, found), gain) in STATES.iter().zip(found).zip(gains) {
        let wanted = if gain.raw >= 0 {
            Direction::Rises
        } else {
            Direction::Falls
        };
        if found != wanted && found != Direction::Stays {
            return ClaimOutcome::Failed(format!(
                "the command's direction with the {state} is {found:?}, but the gain gives {wanted:?}"
            ));
        }
    }
    ClaimOutcome::Proved("sums, factors, rounding down and a clamp keep the direction".to_owned())
}

/// The names of the states.
const STATES: [&str; 3] = ["angle", "rate", "wheel speed"];

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
