//! At least 95 % of small damages to the source are noticed, those set aside that are proved to change nothing;
//! survivors are listed with the reason.

use std::path::Path;

use checker::Module;
use checker::certificate::reader::Certificate;
use checker::domains::smt::{SolverAnswer, same as same_words};
use checker::mutate::{Fate, applied, chosen, judged, mutants, notices, summary};
use checker::prove::Emitted;
use rayon::prelude::*;

#[test]
fn most_damages_are_noticed_and_survivors_are_listed() {
    let emitted = Emitted::read(Path::new("../generated")).unwrap();
    let certificate = Certificate::parse(&emitted.certificate).unwrap();
    assert_eq!(notices(&emitted, &certificate), [], "undamaged");
    // The longest test of all, and not for one core alone.
    let verdicts: Vec<_> = chosen(&emitted, Some(14))
        .into_par_iter()
        .map(|mutant| judged(&emitted, &certificate, mutant))
        .collect();
    let summary = summary(&verdicts);
    for verdict in verdicts.iter().filter(|verdict| verdict.noticed.is_empty()) {
        let m = &verdict.mutant;
        eprintln!(
            "survives: {}:{}:{} {}: `{}` -> `{}`: {}",
            m.file, m.line, m.column, m.kind, m.before, m.after, verdict.reason
        );
    }
    eprintln!("{summary:?}");
    assert!(summary.mutants > 150, "{}", summary.mutants);
    // Of those that are not proved to change nothing.
    let damages = summary.mutants - summary.same;
    assert!(summary.caught * 100 >= damages * 95, "{summary:?}");
}

/// Damages to what the reader reads (types, names, receivers, visibility) are noticed, all of them that change anything.
#[test]
#[cfg_attr(not(have_z3), ignore = "needs z3")]
#[cfg_attr(
    have_z3,
    ignore = "minutes: cargo test -p checker --test all damages_to -- --ignored"
)]
fn damages_to_what_is_read_are_noticed() {
    let emitted = Emitted::read(Path::new("../generated")).unwrap();
    let certificate = Certificate::parse(&emitted.certificate).unwrap();
    let mut counts = std::collections::BTreeMap::new();
    let mut survivors = Vec::new();
    for (path, text) in &emitted.sources {
        let of_kind = mutants(path, text);
        for kind in ["type", "name", "receiver", "visibility"] {
            let all: Vec<_> = of_kind
                .iter()
                .filter(|mutant| mutant.kind == kind)
                .collect();
            let count = all.len().min(3);
            for index in 0..count {
                let mutant = all[index * all.len() / count].clone();
                let verdict = judged(&emitted, &certificate, mutant);
                *counts.entry(kind).or_insert(0) += 1;
                // A word of another type may be the same word, and what only its own file calls may be private. That is proved:
                // a sample without a difference is not enough.
                let is_harmless = verdict.fate == Fate::Same;
                if verdict.noticed.is_empty() {
                    let m = &verdict.mutant;
                    let said = format!(
                        "{}:{} {}: {} -> {}: {}",
                        m.file, m.line, kind, m.before, m.after, verdict.reason
                    );
                    println!("{said}");
                    if !is_harmless {
                        survivors.push(said);
                    }
                }
            }
        }
    }
    println!("{counts:?}");
    assert!(survivors.is_empty(), "{survivors:#?}");
    assert!(
        counts.len() == 4 && counts.values().sum::<i32>() > 60,
        "{counts:?}"
    );
}

#[test]
fn a_mutant_changes_its_place_and_nothing_else() {
    let text = "/// 5 ü\npub fn f(a: i32) -> i32 {\n    (a + 7) >> 3\n}\n";
    let found = mutants("src/x.rs", text);
    let is_read = ["type", "visibility"];
    let code = found
        .iter()
        .filter(|mutant| !is_read.contains(&mutant.kind));
    assert!(code.clone().count() > 5 && code.clone().all(|mutant| mutant.line == 3));
    let texts: Vec<_> = found.iter().map(|mutant| applied(text, mutant)).collect();
    for wanted in [
        "(a - 7) >> 3",
        "(a + 8) >> 3",
        "(a + 7) >> 2",
        "(a + 7) << 3",
        "(a + -7) >> 3",
    ] {
        assert!(texts.iter().any(|text| text.contains(wanted)), "{wanted}");
    }
}

/// z3 proves what is the same for all arguments, and proves nothing of what differs in one.
#[test]
#[cfg_attr(not(have_z3), ignore = "needs z3")]
fn two_versions_of_a_function_are_compared_for_all_arguments() {
    let text = "pub fn f(a: i32, b: i32) -> i32 {\n    let p = (a as i64 * b as i64) >> 31;\n    \
                if p < -1_000 { -1_000 } else if p > 1_000 { 1_000 } else { p as i32 }\n}\n";
    let whole = (i128::from(i32::MIN), i128::from(i32::MAX));
    let answer = |other: &str, ranges: [(i128, i128); 2]| {
        let read = |text: &str| Module::parse(&[("src/x.rs", text)]).unwrap();
        let (one, other) = (read(text), read(other));
        let function = |module: &Module| module.function("f").unwrap().clone();
        same_words(&function(&one), &function(&other), &ranges)
    };
    for same in [
        text.replace("p > 1_000", "p >= 1_000"),
        text.replace("p < -1_000", "p <= -1_000"),
        text.replace("a as i64 * b as i64", "b as i64 * a as i64"),
    ] {
        assert_eq!(answer(&same, [whole; 2]), SolverAnswer::Proved, "{same}");
    }
    let lower = text.replace("p > 1_000 {", "p > 999 {");
    let shifted = text.replace(">> 31", ">> 30");
    assert_eq!(answer(&lower, [whole; 2]), SolverAnswer::Proved);
    assert_ne!(answer(&shifted, [whole; 2]), SolverAnswer::Proved);
    let higher = text.replace("p > 1_000 {", "p > 1_001 {");
    assert_ne!(answer(&higher, [whole; 2]), SolverAnswer::Proved);
    // Where the arguments cannot reach the difference there is none.
    assert_eq!(answer(&higher, [(0, 1 << 20); 2]), SolverAnswer::Proved);
}
