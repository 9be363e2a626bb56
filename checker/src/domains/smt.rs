//! Terms of SMT-LIB, and questions to z3 about them.
//!
//! Words are unbounded integers with their ranges as assumptions; truth values are 0 or 1; a right shift is
//! a division that rounds down. For every claim, z3 searches a counterexample; `unsat` proves
//! the claim.

use std::process::{Command, Stdio};

use easy_smt::{Context, ContextBuilder, Response, SExpr};

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::Integer;

/// Time limit for a question about a claim, ms.
pub(crate) const TIMEOUT_MS: u32 = 20_000;
/// Time limit for a comparison of two functions, ms.
const COMPARISON_MS: u32 = 4_000;

/// Memory limit of z3, MB.
const MEMORY: &str = "-memory:2000";

/// The answer of z3.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SolverAnswer {
    /// There is no counterexample.
    Proved,
    /// There is a counterexample.
    Refuted(String),
    /// z3 is missing, or found no answer.
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

/// One question to z3.
pub(crate) struct Question {
    pub(crate) context: Context,
    /// Conditions under which no fault has occurred.
    pub(crate) sound: Vec<SExpr>,
    /// Conditions of the branches around the present step.
    path: Vec<SExpr>,
    /// Number of names used.
    names: usize,
    /// An uninterpreted function for the product of two words, of which only commutativity is known.
    product: Option<SExpr>,
    timeout_ms: u32,
}

/// The reason why a question could not be asked.
pub(crate) type Asked<T> = Result<T, String>;

pub(crate) fn io<T>(result: std::io::Result<T>) -> Asked<T> {
    result.map_err(|error| format!("z3: {error}"))
}

impl Question {
    pub(crate) fn new(timeout_ms: u32) -> Asked<Question> {
        // z3 does not check `:timeout` during preprocessing; the process is ended a little later.
        let seconds = format!("-T:{}", timeout_ms / 1000 + 1);
        let mut context = io(ContextBuilder::new()
            .solver("z3")
            .solver_args(["-smt2", "-in", "-v:0", &seconds, MEMORY])
            .build())?;
        let milliseconds = context.numeral(timeout_ms);
        io(context.set_option(":timeout", milliseconds))?;
        io(context.set_logic("ALL"))?;
        Ok(Question {
            context,
            sound: Vec::new(),
            path: Vec::new(),
            names: 0,
            product: None,
            timeout_ms,
        })
    }

    pub(crate) fn number(&self, value: i128) -> SExpr {
        if value < 0 {
            let magnitude = self.context.numeral(value.unsigned_abs());
            self.context.negate(magnitude)
        } else {
            self.context.numeral(value.unsigned_abs())
        }
    }

    pub(crate) fn within(&self, value: SExpr, low: i128, high: i128) -> SExpr {
        let c = &self.context;
        c.and(
            c.lte(self.number(low), value),
            c.lte(value, self.number(high)),
        )
    }

    /// `value`, or the end beyond which it lies.
    pub(crate) fn clamped(&self, value: SExpr, low: SExpr, high: SExpr) -> SExpr {
        let c = &self.context;
        let upper = c.ite(c.lt(high, value), high, value);
        c.ite(c.lt(value, low), low, upper)
    }

    /// Words of the arguments as unknowns.
    pub(crate) fn arguments(&mut self, program: &Program, prefix: &str) -> Asked<Vec<SExpr>> {
        let mut unknowns = Vec::new();
        for (index, type_) in program.argument_types.iter().enumerate() {
            let sort = self.context.int_sort();
            let unknown = io(self.context.declare_const(format!("{prefix}{index}"), sort))?;
            let (low, high) = type_.range();
            let range = self.within(unknown, low, high);
            io(self.context.assert(range))?;
            unknowns.push(unknown);
        }
        Ok(unknowns)
    }

    /// Defines a name for a value, so that its text is sent only once.
    fn named(&mut self, value: SExpr) -> Asked<SExpr> {
        self.names += 1;
        let sort = self.context.int_sort();
        io(self
            .context
            .define_const(format!("v{}", self.names), sort, value))
    }

    /// Adds the condition that no fault occurs only if `condition` holds where the step is reached.
    fn needs(&mut self, condition: SExpr) {
        let guarded = match self.path[..] {
            [] => condition,
            _ => {
                let reached = self.context.and_many(self.path.iter().copied());
                self.context.imp(reached, condition)
            }
        };
        self.sound.push(guarded);
    }

    /// The program's results for `arguments`.
    pub(crate) fn results(&mut self, program: &Program, arguments: &[SExpr]) -> Asked<Vec<SExpr>> {
        let mut words = start(self, program, arguments.iter().copied());
        walk(self, program, &mut words)?;
        Ok(program.results.iter().map(|slot| words[*slot]).collect())
    }

    /// The truth of a condition as a word.
    fn truth(&mut self, holds: SExpr) -> Asked<SExpr> {
        let value = self.context.ite(holds, self.number(1), self.number(0));
        self.named(value)
    }

    /// Whether a word is a truth that holds.
    fn holds(&self, word: SExpr) -> SExpr {
        self.context.eq(word, self.number(1))
    }

    /// Asks whether `wanted` can fail; if `sound` is used, only for runs without an earlier fault.
    pub(crate) fn ask(mut self, wanted: SExpr) -> Asked<SolverAnswer> {
        let not = self.context.not(wanted);
        io(self.context.assert(not))?;
        match io(self.context.check())? {
            Response::Unsat => Ok(SolverAnswer::Proved),
            Response::Unknown => Ok(SolverAnswer::Unknown(format!(
                "z3 did not know within {} s",
                self.timeout_ms / 1000
            ))),
            Response::Sat => {
                let model = io(self.context.get_model())?;
                let text = self.context.display(model).to_string();
                let flat: Vec<_> = text.split_whitespace().collect();
                Ok(SolverAnswer::Refuted(flat.join(" ")))
            }
        }
    }
}

/// Terms of SMT-LIB. `sound` collects the conditions for a run to continue.
impl Domain for Question {
    type Word = SExpr;
    type Stop = String;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> SExpr {
        self.number(constant.unwrap_or(0))
    }

    fn arithmetic(
        &mut self,
        site: &Site<SExpr>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        type_: Integer,
    ) -> Asked<SExpr> {
        let (x, y) = (*site.word(a), *site.word(b));
        let (a, b) = (site.constant(a), site.constant(b));
        let value = match operation {
            Arithmetic::Add => self.context.plus(x, y),
            Arithmetic::Subtract => self.context.sub(x, y),
            Arithmetic::Multiply => match self.product {
                Some(product) if a.or(b).is_none() => {
                    let c = &self.context;
                    let value = c.list(vec![product, x, y]);
                    let swapped = c.eq(value, c.list(vec![product, y, x]));
                    io(self.context.assert(swapped))?;
                    value
                }
                _ => self.context.times(x, y),
            },
            Arithmetic::ShiftRight | Arithmetic::ShiftLeft => {
                let amount = b
                    .and_then(|amount| u32::try_from(amount).ok())
                    .filter(|amount| *amount < type_.bits)
                    .ok_or("a shift by no constant")?;
                let factor = self.number(1_i128 << amount);
                if operation == Arithmetic::ShiftRight {
                    self.context.div(x, factor)
                } else {
                    self.context.times(x, factor)
                }
            }
            Arithmetic::And => {
                // The lowest bits of a number: what a division leaves.
                let (value, mask) = match (a, b) {
                    (_, Some(mask)) => (x, mask),
                    (Some(mask), None) => (y, mask),
                    _ => return Err("bits are not translated".to_owned()),
                };
                if mask < 0 || (mask & (mask + 1)) != 0 {
                    return Err("bits are not translated".to_owned());
                }
                self.context.modulo(value, self.number(mask + 1))
            }
        };
        let value = self.named(value)?;
        let fits = self.within(value, type_.min(), type_.max());
        self.needs(fits);
        Ok(value)
    }

    fn comparison(
        &mut self,
        site: &Site<SExpr>,
        _to: Slot,
        comparison: WordComparison,
        (a, b): (Slot, Slot),
    ) -> Asked<SExpr> {
        let (x, y) = (*site.word(a), *site.word(b));
        let c = &self.context;
        let holds = match comparison {
            WordComparison::Less => c.lt(x, y),
            WordComparison::LessEqual => c.lte(x, y),
            WordComparison::Equal => c.eq(x, y),
            WordComparison::NotEqual => c.not(c.eq(x, y)),
        };
        self.truth(holds)
    }

    fn negation(&mut self, site: &Site<SExpr>, _to: Slot, operand: Slot) -> Asked<SExpr> {
        let value = self.context.sub(self.number(1), *site.word(operand));
        self.named(value)
    }

    fn cast(&mut self, site: &Site<SExpr>, operand: Slot, type_: Integer) -> Asked<SExpr> {
        let value = *site.word(operand);
        let fits = self.within(value, type_.min(), type_.max());
        self.needs(fits);
        Ok(value)
    }

    fn clamp(
        &mut self,
        site: &Site<SExpr>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Asked<SExpr> {
        let (low, high) = (*site.word(low), *site.word(high));
        let ordered = self.context.lte(low, high);
        let clamped = self.clamped(*site.word(operand), low, high);
        self.needs(ordered);
        self.named(clamped)
    }

    fn assertion(&mut self, site: &Site<SExpr>, condition: Slot, _message: &str) -> Asked<()> {
        let holds = self.holds(*site.word(condition));
        self.needs(holds);
        Ok(())
    }

    fn call(&mut self, _site: &Site<SExpr>, _call: ContractedCall) -> Asked<Vec<SExpr>> {
        Err("contracts are not translated".to_owned())
    }

    fn enter(&mut self, words: &mut [SExpr], condition: Slot, side: bool) -> bool {
        let holds = self.holds(words[condition]);
        self.path
            .push(if side { holds } else { self.context.not(holds) });
        true
    }

    fn leave(&mut self, _words: &mut [SExpr]) {
        self.path.pop();
    }

    fn join(
        &mut self,
        site: &Site<SExpr>,
        condition: Slot,
        _joins: &[Join],
        [then, otherwise]: [BranchEnd<SExpr>; 2],
    ) -> Asked<Vec<SExpr>> {
        let holds = self.holds(*site.word(condition));
        let both = then.words.into_iter().zip(otherwise.words);
        both.map(|(one, other)| {
            let joined = self.context.ite(holds, one, other);
            self.named(joined)
        })
        .collect()
    }
}

/// The answer of z3, or the reason why it could not be asked.
pub(crate) fn answered(asked: Asked<SolverAnswer>) -> SolverAnswer {
    asked.unwrap_or_else(SolverAnswer::Unknown)
}

/// Whether two versions of a function return the same words, and neither overflows where the other
/// does not, for all arguments within `ranges`. Products of two words are first treated as unknown values,
/// which quickly proves everything that does not depend on them.
pub fn same(one: &Program, other: &Program, ranges: &[(i128, i128)]) -> SolverAnswer {
    match compared(one, other, ranges, true) {
        Ok(SolverAnswer::Proved) => SolverAnswer::Proved,
        _ => answered(compared(one, other, ranges, false)),
    }
}

fn compared(
    one: &Program,
    other: &Program,
    ranges: &[(i128, i128)],
    products_are_unknown: bool,
) -> Asked<SolverAnswer> {
    if one.argument_types != other.argument_types || one.results.len() != other.results.len() {
        return Err("the functions have different arguments or results".to_owned());
    }
    let mut question = Question::new(COMPARISON_MS)?;
    if products_are_unknown {
        let sort = question.context.int_sort();
        let declared = question
            .context
            .declare_fun("product", vec![sort, sort], sort);
        question.product = Some(io(declared)?);
    }
    let arguments = question.arguments(one, "x")?;
    for (argument, (low, high)) in arguments.iter().zip(ranges) {
        let range = question.within(*argument, *low, *high);
        io(question.context.assert(range))?;
    }
    let first = question.results(one, &arguments)?;
    let assumed = std::mem::take(&mut question.sound);
    let second = question.results(other, &arguments)?;
    for condition in assumed {
        io(question.context.assert(condition))?;
    }
    let mut wanted = std::mem::take(&mut question.sound);
    for (a, b) in first.iter().zip(&second) {
        wanted.push(question.context.eq(*a, *b));
    }
    let wanted = question.context.and_many(wanted);
    question.ask(wanted)
}
