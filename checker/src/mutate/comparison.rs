//! A function before and after a damage: whether the two are equivalent.

use crate::claims::filter_exact::draw::Draw;
use crate::domains::machine::Machine;
use crate::domains::smt::{self, SolverAnswer};
use crate::language::contracts::stated;
use crate::language::emitted::Emitted;
use crate::language::module::Module;
use crate::mutate::mutants::Mutant;
use crate::mutate::tokens::tokens;
use crate::program::steps::Program;

/// How equal two versions are that no engine distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Likeness {
    /// z3 proves that they return the same words, or the language's rules do.
    Proved,
    /// A random sample shows no difference.
    Sampled,
}

/// Seed of the random sample.
const SEED: u64 = 1;

/// Runs of one function before and after the damage.
const COMPARISONS: usize = 20_000;

/// Smallest number of runs without an overflow (before the damage) for a result.
const ENOUGH: usize = 500;

/// Number of levels of callers that are compared.
const MOST_CALLERS_UP: usize = 3;

/// Compares the damaged function with the original, for arguments within its contract. First, runs with arguments
/// near the places where branches meet are compared (numbers in the function,
/// their neighbours, powers of two, ends of ranges). If these show no difference, z3 compares the functions
/// for all arguments. If the function differs, its callers are compared, which may never pass
/// the arguments that make the difference. `None` if a difference remains, or nothing can be
/// compared.
pub(crate) fn compared(
    emitted: &Emitted,
    damaged: &Emitted,
    mutant: &Mutant,
) -> Option<(Likeness, String)> {
    let (before, after) = (emitted.module().ok()?, damaged.module().ok()?);
    // The reader refuses an item that is private and imported (`language/visibility.rs`). A free item that it still
    // reads is called within its own file alone, where `pub` means nothing.
    if mutant.kind == "visibility" && mutant.after.is_empty() && mutant.column == 1 {
        let why = "no other file names the item".to_owned();
        return Some((Likeness::Proved, why));
    }
    let number = function_at(&before, &mutant.file, mutant.line)?;
    alike(&before, &after, number, MOST_CALLERS_UP)
}

/// Whether a damaged crate, which rustc accepts, computes the same words by the rules of the language, or by z3:
/// every constant has its words, and every function its steps, or is proved to return the same for all arguments of
/// its contract.
pub(crate) fn same_everywhere(emitted: &Emitted, damaged: &Emitted) -> Option<String> {
    let (before, after) = (emitted.module().ok()?, damaged.module().ok()?);
    let (old, new) = (before.declarations(), after.declarations());
    if old.functions.len() != new.functions.len() || old.constants.len() != new.constants.len() {
        return None;
    }
    for (own, other) in old.constants.iter().zip(&new.constants) {
        // Of `src/x.rs` the module `x`.
        let file = own.place.file.trim_start_matches("src/");
        let file = file.trim_end_matches(".rs");
        if own.name != other.name
            || before.constant(file, &own.name) != after.constant(file, &own.name)
        {
            return None;
        }
    }
    let mut proved = Vec::new();
    for number in 0..old.functions.len() {
        let (one, other) = (before.program(number)?, after.program(number)?);
        if !has_same_steps(one, other) {
            match alike(&before, &after, number, 0)? {
                (Likeness::Proved, why) => proved.push(why),
                (Likeness::Sampled, _) => return None,
            }
        }
    }
    Some(if proved.is_empty() {
        "it compiles, and every constant and every step is read as before".to_owned()
    } else {
        format!("it compiles, and {}", proved.join("; "))
    })
}

/// Whether two functions are one, but for the places of their steps.
fn has_same_steps(one: &Program, other: &Program) -> bool {
    let actions = |program: &Program| -> Vec<_> {
        let steps = program.steps.iter();
        steps.map(|step| step.action.clone()).collect()
    };
    one.name == other.name
        && one.inputs == other.inputs
        && one.arguments == other.arguments
        && one.argument_types == other.argument_types
        && one.results == other.results
        && one.result_types == other.result_types
        && one.initial == other.initial
        && one.is_constant == other.is_constant
        && actions(one) == actions(other)
}

/// The function that contains a line: the last that begins at or above it.
fn function_at(module: &Module, file: &str, line: usize) -> Option<usize> {
    let functions = &module.declarations().functions;
    (0..functions.len())
        .filter(|&number| {
            let place = &functions[number].place;
            *place.file == *file && place.line <= line
        })
        .max_by_key(|&number| functions[number].place.line)
}

/// The functions whose text contains the name of function `number`.
fn callers(module: &Module, number: usize) -> Vec<usize> {
    let name = &module.declarations().functions[number].name;
    let name = name.rsplit("::").next().unwrap_or(name);
    let mut found: Vec<usize> = module
        .texts()
        .iter()
        .flat_map(|(file, text)| {
            tokens(text)
                .into_iter()
                .filter(|token| token.text == name)
                .filter_map(|token| function_at(module, file, token.line))
                .collect::<Vec<_>>()
        })
        .filter(|&caller| caller != number)
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

fn alike(before: &Module, after: &Module, number: usize, up: usize) -> Option<(Likeness, String)> {
    let function = &before.declarations().functions[number];
    let (old, new) = (before.program(number)?, after.program(number)?);
    let contract = stated(before, number).unwrap_or_default();
    let ranges: Vec<(i128, i128)> = old
        .argument_types
        .iter()
        .enumerate()
        .map(|(word, type_)| {
            let required = contract.requires.iter().filter(|range| range.word == word);
            required.fold(type_.range(), |(low, high), range| {
                (low.max(range.low), high.min(range.high))
            })
        })
        .collect();
    let name = &function.name;
    match runs_alike(old, new, &ranges) {
        Some(_) if smt::is_available() && smt::same(old, new, &ranges) == SolverAnswer::Proved => {
            let text = format!("`{name}` returns the same words for all arguments (z3)");
            Some((Likeness::Proved, text))
        }
        Some(runs) if runs >= ENOUGH => {
            let text = format!("`{name}`: no difference found in {runs} runs aimed at its numbers");
            Some((Likeness::Sampled, text))
        }
        Some(_) => None,
        None if up == 0 => None,
        None => {
            let callers = callers(before, number);
            let mut all = (Likeness::Proved, Vec::new());
            for &caller in &callers {
                let (likeness, text) = alike(before, after, caller, up - 1)?;
                if likeness != Likeness::Proved {
                    all.0 = likeness;
                }
                if !all.1.contains(&text) {
                    all.1.push(text);
                }
            }
            (!callers.is_empty()).then(|| {
                let text = format!(
                    "`{name}` differs for arguments that its callers do not pass: {}",
                    all.1.join("; ")
                );
                (all.0, text)
            })
        }
    }
}

/// The number of random runs in which two versions of a function return the same words; `None` if one run
/// differs.
fn runs_alike(old: &Program, new: &Program, ranges: &[(i128, i128)]) -> Option<usize> {
    let constants = old.initial.iter().zip(&old.is_constant);
    let corners: Vec<i128> = constants
        .filter_map(|(word, is_constant)| is_constant.then_some(*word))
        .collect();
    let mut draw = Draw::new(SEED);
    let (mut old, mut new) = (Machine::new(old), Machine::new(new));
    let mut runs = 0;
    for _ in 0..COMPARISONS {
        let arguments: Vec<i128> = ranges
            .iter()
            .map(|&(low, high)| draw.at_corners(low, high, &corners))
            .collect();
        let Ok(wanted) = old.call(&arguments) else {
            continue;
        };
        if wanted != new.call(&arguments).ok()? {
            return None;
        }
        runs += 1;
    }
    Some(runs)
}
