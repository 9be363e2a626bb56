//! Claim `control-total`: no operation of `control` overflows its type, and the command is within the
//! limit.

use crate::claims::control_law::{EmittedLaw, LawError};
use crate::claims::outcome::ClaimOutcome;
use crate::domains::smt::{Question, SolverAnswer, TIMEOUT_MS, answered};
use crate::program::steps::Program;

/// The outcome that follows from reading the law.
pub fn by_intervals(law: &Result<EmittedLaw, LawError>) -> ClaimOutcome {
    match law {
        Err(error) => ClaimOutcome::Failed(error.to_string()),
        Ok(_) => ClaimOutcome::Proved("no operation leaves its type".to_owned()),
    }
}

/// The question to z3.
pub fn by_smt(program: &Program, limit: i128) -> SolverAnswer {
    let ask = || {
        let mut question = Question::new(TIMEOUT_MS)?;
        let arguments = question.arguments(program, "x")?;
        let results = question.results(program, &arguments)?;
        let within = question.within(results[0], -limit, limit);
        let mut all = question.sound.clone();
        all.push(within);
        let wanted = question.context.and_many(all);
        question.ask(wanted)
    };
    answered(ask())
}
