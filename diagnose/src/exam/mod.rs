//! The exam: benches with a hidden effect, and how the verdicts on them are marked.
//!
//! | file | job |
//! |---|---|
//! | `truth` | what hides in a bench; the terms that no library knows |
//! | `true_motion` | the true motion, simulated more faithfully than any fit does it |
//! | `bench_plan` | the experiments of a bench and their logs |
//! | `draw` | which bench a seed stands for |
//! | `marking` | how one verdict is marked; ties worked out by refitting |
//! | `marks` | the marks of many benches together |

mod bench_plan;
mod draw;
mod marking;
mod marks;
mod true_motion;
mod truth;

pub use bench_plan::{Driving, ExamLog, ExperimentPlan, SensorNoise, record};
pub use draw::{ExamBench, LEFT_BY_THE_BEST, Question, ROUND, SIZES, draw, effects, question};
pub use marking::{Answer, CLOSE, EQUAL, Interval, Mark, PLAIN, Paper, answer_from, fitted, mark};
pub use marks::{Bin, Entry, Marks, Rate};
pub use true_motion::{Push, TrueMotion};
pub use truth::{Hidden, Outsider, Truth};

use plant::EffectId;

/// Draws the bench of a seed and marks the verdict on it. `None` if the seed has no bench whose
/// hidden term counts.
pub fn sit(seed: u64) -> Option<Entry> {
    let bench = draw(seed)?;
    let paper = mark(&bench.setup, &Answer::of(&bench), &bench.suspects).ok()?;
    Some(Entry {
        label: format!("seed {seed}"),
        truth: match &bench.question {
            Question::Nothing => vec!["nothing".to_owned()],
            Question::One(effect) => vec![effect.name().to_owned()],
            Question::Two(a, b) => vec![a.name().to_owned(), b.name().to_owned()],
            Question::Outside(outsider) => vec![outsider.name().to_owned()],
            Question::Withheld(effect) => vec![format!("withheld {}", effect.name())],
        },
        hidden: Answer::of(&bench).effects,
        outside: Answer::of(&bench).outside,
        sizes: bench.sizes,
        noise: bench.noise.std.to_vec(),
        experiments: bench
            .setup
            .records
            .iter()
            .map(|record| record.name.clone())
            .collect(),
        observations: bench
            .setup
            .records
            .iter()
            .map(|record| record.observations())
            .sum(),
        paper,
    })
}

/// The names of effects joined by a plus sign; "nothing" if there are none.
pub fn joined(effects: &[EffectId]) -> String {
    if effects.is_empty() {
        return "nothing".to_owned();
    }
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    names.join(" + ")
}
