//! Questions about the control law to z3, as integer problems in SMT-LIB.
//!
//! Words are unbounded integers with their ranges as assumptions; a right shift is a division
//! that rounds down. Every claim is asked as "is there a counterexample"; `unsat` proves it.

use std::collections::HashMap;
use std::process::{Command, Stdio};

use easy_smt::{Context, ContextBuilder, Response, SExpr};

use crate::certificate::Certificate;
use crate::interpret::range_of;
use crate::program::{Action, Arithmetic, Comparison, Program, Slot, Step};

/// Milliseconds that a question may take.
const TIMEOUT_MS: u32 = 20_000;

/// What z3 said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// There is no counterexample.
    Proved,
    /// There is one.
    Refuted(String),
    /// z3 is missing, or did not know.
    Unknown(String),
}

/// Whether a `z3` can be run.
pub fn is_available() -> bool {
    Command::new("z3")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// One question.
struct Question {
    context: Context,
    /// Conditions under which nothing has gone wrong.
    sound: Vec<SExpr>,
}

/// Why a question could not be asked.
type Asked<T> = Result<T, String>;

fn io<T>(result: std::io::Result<T>) -> Asked<T> {
    result.map_err(|error| format!("z3: {error}"))
}

impl Question {
    fn new() -> Asked<Question> {
        let mut context = io(ContextBuilder::new().with_z3_defaults().build())?;
        let milliseconds = context.numeral(TIMEOUT_MS);
        io(context.set_option(":timeout", milliseconds))?;
        io(context.set_logic("ALL"))?;
        Ok(Question {
            context,
            sound: Vec::new(),
        })
    }

    fn number(&self, value: i128) -> SExpr {
        if value < 0 {
            let magnitude = self.context.numeral(value.unsigned_abs());
            self.context.negate(magnitude)
        } else {
            self.context.numeral(value.unsigned_abs())
        }
    }

    fn within(&self, value: SExpr, low: i128, high: i128) -> SExpr {
        let c = &self.context;
        c.and(
            c.lte(self.number(low), value),
            c.lte(value, self.number(high)),
        )
    }

    /// Words of the arguments as unknowns.
    fn arguments(&mut self, program: &Program, prefix: &str) -> Asked<Vec<SExpr>> {
        let mut unknowns = Vec::new();
        for (index, type_) in program.argument_types.iter().enumerate() {
            let sort = self.context.int_sort();
            let unknown = io(self.context.declare_const(format!("{prefix}{index}"), sort))?;
            let (low, high) = range_of(type_);
            let range = self.within(unknown, low, high);
            io(self.context.assert(range))?;
            unknowns.push(unknown);
        }
        Ok(unknowns)
    }

    /// The program's results for `arguments`.
    fn results(&mut self, program: &Program, arguments: &[SExpr]) -> Asked<Vec<SExpr>> {
        let mut values: HashMap<Slot, SExpr> = HashMap::new();
        for (slot, value) in program.initial.iter().enumerate() {
            if program.is_constant[slot] {
                values.insert(slot, self.number(*value));
            }
        }
        for (slot, argument) in program.arguments.iter().zip(arguments) {
            values.insert(*slot, *argument);
        }
        for step in &program.steps {
            self.step(program, step, &mut values)?;
        }
        program
            .results
            .iter()
            .map(|slot| {
                values
                    .get(slot)
                    .copied()
                    .ok_or("a word without value".to_owned())
            })
            .collect()
    }

    fn step(
        &mut self,
        program: &Program,
        step: &Step,
        values: &mut HashMap<Slot, SExpr>,
    ) -> Asked<()> {
        let known = |slot: &Slot| {
            values
                .get(slot)
                .copied()
                .ok_or("a word without value".to_owned())
        };
        match &step.action {
            Action::Arithmetic {
                to,
                operation,
                a,
                b,
                type_,
            } => {
                let (x, y) = (known(a)?, known(b)?);
                let c = &self.context;
                let value = match operation {
                    Arithmetic::Add => c.plus(x, y),
                    Arithmetic::Subtract => c.sub(x, y),
                    Arithmetic::Multiply => c.times(x, y),
                    Arithmetic::ShiftRight | Arithmetic::ShiftLeft => {
                        let amount = u32::try_from(program.initial[*b]).unwrap_or(u32::MAX);
                        if !program.is_constant[*b] || amount >= type_.bits {
                            return Err("a shift by no constant".to_owned());
                        }
                        let factor = self.number(1_i128 << amount);
                        if *operation == Arithmetic::ShiftRight {
                            c.div(x, factor)
                        } else {
                            c.times(x, factor)
                        }
                    }
                    Arithmetic::And => return Err("bits are not translated".to_owned()),
                };
                let fits = self.within(value, type_.min(), type_.max());
                self.sound.push(fits);
                values.insert(*to, value);
            }
            Action::Cast { to, a, type_ } => {
                let value = known(a)?;
                let fits = self.within(value, type_.min(), type_.max());
                self.sound.push(fits);
                values.insert(*to, value);
            }
            Action::Clamp { to, a, low, high } => {
                let (value, low, high) = (known(a)?, known(low)?, known(high)?);
                let c = &self.context;
                let ordered = c.lte(low, high);
                let upper = c.ite(c.lt(high, value), high, value);
                let clamped = c.ite(c.lt(value, low), low, upper);
                self.sound.push(ordered);
                values.insert(*to, clamped);
            }
            Action::Compare {
                to,
                comparison,
                a,
                b,
            } => {
                let (x, y) = (known(a)?, known(b)?);
                let c = &self.context;
                let value = match comparison {
                    Comparison::Less => c.lt(x, y),
                    Comparison::LessEqual => c.lte(x, y),
                    Comparison::Equal => c.eq(x, y),
                    Comparison::NotEqual => c.not(c.eq(x, y)),
                };
                values.insert(*to, value);
            }
            _ => return Err("branches are not translated".to_owned()),
        }
        Ok(())
    }

    /// Asks whether `wanted` can fail, with nothing gone wrong before if `sound` says so.
    fn ask(mut self, wanted: SExpr) -> Asked<Answer> {
        let not = self.context.not(wanted);
        io(self.context.assert(not))?;
        match io(self.context.check())? {
            Response::Unsat => Ok(Answer::Proved),
            Response::Unknown => Ok(Answer::Unknown(format!(
                "z3 did not know within {} s",
                TIMEOUT_MS / 1000
            ))),
            Response::Sat => {
                let model = io(self.context.get_model())?;
                let text = self.context.display(model).to_string();
                let flat: Vec<_> = text.split_whitespace().collect();
                Ok(Answer::Refuted(flat.join(" ")))
            }
        }
    }
}

fn answered(asked: Asked<Answer>) -> Answer {
    asked.unwrap_or_else(Answer::Unknown)
}

/// Claim `control-total`: no operation leaves its type, and the command lies within the limit.
pub fn total(program: &Program, limit: i128) -> Answer {
    let ask = || {
        let mut question = Question::new()?;
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

/// Claim `control-accurate`: |command 2ˢ − clamp(Σ N X, ±limit 2ˢ)| ≤ 2ˢ⁻¹, with words, shift and
/// limit of the certificate.
pub fn accurate(program: &Program, certificate: &Certificate) -> Answer {
    let ask = || {
        let mut question = Question::new()?;
        let arguments = question.arguments(program, "x")?;
        let results = question.results(program, &arguments)?;
        let shift = certificate.bounds.shift;
        if shift == 0 || shift > 62 {
            return Err("the certificate states no law".to_owned());
        }
        let c = &question.context;
        let mut sum = question.number(0);
        for (constant, argument) in certificate.constants.iter().zip(&arguments) {
            let gain = question.number(constant.raw.into());
            sum = c.plus(sum, c.times(gain, *argument));
        }
        let scale = 1_i128 << shift;
        let limit = i128::from(certificate.constants[3].raw) * scale;
        let (low, high) = (question.number(-limit), question.number(limit));
        let upper = c.ite(c.lt(high, sum), high, sum);
        let saturated = c.ite(c.lt(sum, low), low, upper);
        let error = c.sub(c.times(results[0], question.number(scale)), saturated);
        let wanted = question.within(error, -scale / 2, scale / 2);
        question.ask(wanted)
    };
    answered(ask())
}

/// Claim `control-monotone`, for one state: two copies of the law that differ in it.
pub fn monotone(program: &Program, certificate: &Certificate, state: usize) -> Answer {
    let ask = || {
        let mut question = Question::new()?;
        let lower = question.arguments(program, "x")?;
        let mut upper = lower.clone();
        let (low, high) = range_of(&program.argument_types[state]);
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
