//! The influence of each threshold on the verdicts: every threshold is moved down and up by a quarter, one at
//! a time, and the benches of some seeds are diagnosed again. Prints the table of `docs/guide/thresholds.md` in
//! Markdown.
//!
//!     cargo run --release -p exam --example thresholds -- 0..40 [NAME …]
//!
//! With NAME, only these thresholds are moved. All thresholds over forty seeds take hours. `cargo test` does not run
//! this program.

use diagnose::{Options, Thresholds, diagnose_with};
use exam::{ExamBench, draw};
use identify::{Minimum, Progress, identify};
use plant::{EffectId, Model};
use rayon::prelude::*;

/// A bench with its base model fitted, which no threshold of the diagnosis touches.
struct Ready {
    bench: ExamBench,
    fitted: Minimum,
}

/// The verdict of a diagnosis in words.
fn said(ready: &Ready, thresholds: &Thresholds) -> String {
    let options = Options {
        suspects: &ready.bench.suspects,
        thresholds: thresholds.clone(),
    };
    let (problem, base) = (&ready.bench.problem, Model::base());
    let fitted = ready.fitted.clone();
    match diagnose_with(problem, &base, fitted, &options, &Progress::silent()) {
        Ok(found) => {
            let set = found.last().map(|step| step.candidate.set());
            let mut words = found.verdict.name().to_owned();
            for effects in set.into_iter().chain(found.ambiguous_between) {
                let names: Vec<&str> = effects
                    .iter()
                    .map(|effect: &EffectId| effect.name())
                    .collect();
                words.push_str(&format!(" [{}]", names.join(" + ")));
            }
            words
        }
        Err(cancelled) => cancelled.to_string(),
    }
}

fn main() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let seeds = arguments.next().ok_or("which seeds? such as 0..40")?;
    let (from, to) = seeds.split_once("..").ok_or("seeds as FROM..TO")?;
    let number = |text: &str| text.parse::<u64>().map_err(|error| error.to_string());
    let (from, to) = (number(from)?, number(to)?);
    let wanted: Vec<String> = arguments.collect();
    let benches: Vec<Ready> = (from..to)
        .into_par_iter()
        .filter_map(|seed| {
            let bench = draw(seed)?;
            let fitted = identify(&bench.problem, &Model::base(), None).ok()?;
            Some(Ready {
                bench,
                fitted: fitted.fit.minimum,
            })
        })
        .collect();
    let all = |thresholds: &Thresholds| -> Vec<String> {
        let benches = benches.par_iter();
        benches.map(|ready| said(ready, thresholds)).collect()
    };
    let usual = all(&Thresholds::default());
    println!("Seeds {seeds}: {} benches.\n", benches.len());
    println!("| threshold | value | less by a quarter | more by a quarter |");
    println!("|---|---|---|---|");
    let mut usual_values = Thresholds::default();
    let names = usual_values.each();
    for (index, (name, value)) in names.into_iter().enumerate() {
        if !wanted.is_empty() && !wanted.iter().any(|one| one == name) {
            continue;
        }
        let changes = [0.75, 1.25].map(|factor| {
            let mut moved = Thresholds::default();
            *moved.each().swap_remove(index).1 = factor * *value;
            let changes: Vec<String> = benches
                .iter()
                .zip(usual.iter().zip(all(&moved)))
                .filter(|(_, (usual, moved))| *usual != moved)
                .map(|(ready, (usual, moved))| format!("{}: {usual} → {moved}", ready.bench.seed))
                .collect();
            if changes.is_empty() {
                "–".to_owned()
            } else {
                changes.join("; ")
            }
        });
        println!("| `{name}` | {value} | {} | {} |", changes[0], changes[1]);
    }
    Ok(())
}
