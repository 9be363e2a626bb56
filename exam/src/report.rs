//! The marks as JSON data.

use std::path::PathBuf;

use diagnose::Verdict;
use serde::Serialize;

use crate::marks::{Entry, Marks, Rate};

/// Statements with about the same stated probability, and how often they came true.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationReport {
    /// Mean stated probability.
    pub stated: f64,
    /// The share of these statements that came true.
    pub came_true: Rate,
}

/// One bench with its verdict and mark.
#[derive(Clone, Debug, Serialize)]
pub struct BenchReport {
    /// The seed or folder.
    pub bench: String,
    /// The hidden terms, one entry per term.
    pub truth: Vec<String>,
    /// Size of each hidden term alone, in units of noise; empty if unknown.
    pub sizes: Vec<f64>,
    /// Noise of angle (rad), rate (rad/s) and wheel speed (rad/s); empty if unknown.
    pub noise: Vec<f64>,
    /// The verdict, by the name of [`Verdict::name`].
    pub verdict: &'static str,
    /// The effects that the verdict calls certain.
    pub named: Vec<&'static str>,
    /// The suspects with their probabilities, most probable first.
    pub suspects: Vec<(&'static str, f64)>,
    /// The mark, by the name of [`crate::Mark::name`].
    pub mark: &'static str,
    /// Time that the verdict took, s.
    pub seconds: f64,
}

/// The result of an exam: the marks, by class and for each bench.
#[derive(Clone, Debug, Serialize)]
pub struct ExamReport {
    /// Number of benches.
    pub benches: usize,
    /// Seeds without a bench whose hidden term counts.
    pub void: Vec<u64>,
    /// Benches with one hidden effect, a trace of at least [`crate::PLAIN`] and no tie: the effect is the first
    /// suspect.
    pub right_effect_first: Rate,
    /// The same benches: the effect is among the first two suspects.
    pub right_effect_among_first_two: Rate,
    /// Benches with two hidden effects, each with a trace of at least [`crate::PLAIN`]: the diagnosis names both.
    pub both_of_two: Rate,
    /// Benches with an outsider: the verdict is "unexplained".
    pub outsiders_unexplained: Rate,
    /// Benches in which nothing is hidden: the verdict is a false alarm.
    pub false_alarms: Rate,
    /// All benches: the verdict is confident and wrong.
    pub wrong_confident: Rate,
    /// Benches whose logs leave a tie: the verdict is "ambiguous".
    pub ties_called_ambiguous: Rate,
    /// 95 % intervals of added parameters: the interval contains the true value.
    pub interval_coverage: Rate,
    /// Stated probabilities compared with frequencies, by tenths.
    pub calibration: Vec<CalibrationReport>,
    /// Verdicts that were marked right, by hidden effect.
    pub by_effect: Vec<(String, Rate)>,
    /// Verdicts that were marked right, by the size of the smallest hidden term in units of noise.
    pub by_size: Vec<(String, Rate)>,
    /// Verdicts that were marked right, by the noise of the angle.
    pub by_noise: Vec<(String, Rate)>,
    /// The verdict and mark of every bench.
    pub verdicts: Vec<BenchReport>,
    /// Further files that were written.
    pub files: Vec<PathBuf>,
}

impl BenchReport {
    fn of(entry: &Entry) -> BenchReport {
        let paper = &entry.paper;
        let verdict: Verdict = paper.verdict;
        BenchReport {
            bench: entry.label.clone(),
            truth: entry.truth.clone(),
            sizes: entry.sizes.clone(),
            noise: entry.noise.clone(),
            verdict: verdict.name(),
            named: paper.named.iter().map(|effect| effect.name()).collect(),
            suspects: paper
                .suspects
                .iter()
                .map(|(effect, probability)| (effect.name(), *probability))
                .collect(),
            mark: paper.mark.name(),
            seconds: paper.seconds,
        }
    }
}

impl ExamReport {
    /// The report on these benches.
    pub fn new(entries: &[Entry], void: Vec<u64>, marks: &Marks) -> ExamReport {
        ExamReport {
            benches: entries.len(),
            void,
            right_effect_first: marks.first,
            right_effect_among_first_two: marks.first_two,
            both_of_two: marks.both,
            outsiders_unexplained: marks.outsiders,
            false_alarms: marks.false_alarms,
            wrong_confident: marks.wrong,
            ties_called_ambiguous: marks.ties,
            interval_coverage: marks.coverage,
            calibration: marks
                .calibration
                .iter()
                .map(|bin| CalibrationReport {
                    stated: bin.stated,
                    came_true: bin.came_true,
                })
                .collect(),
            by_effect: Marks::by(entries, |entry| entry.truth.clone()),
            by_size: Marks::by(entries, |entry| entry.size_class()),
            by_noise: Marks::by(entries, |entry| entry.noise_class()),
            verdicts: entries.iter().map(BenchReport::of).collect(),
            files: vec![],
        }
    }
}
