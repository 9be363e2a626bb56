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
    /// How many of them came true.
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
    /// See [`Marks::first`].
    pub right_effect_first: Rate,
    /// See [`Marks::first_two`].
    pub right_effect_among_first_two: Rate,
    /// See [`Marks::both`].
    pub both_of_two: Rate,
    /// See [`Marks::outsiders`].
    pub outsiders_unexplained: Rate,
    /// See [`Marks::false_alarms`].
    pub false_alarms: Rate,
    /// See [`Marks::wrong`].
    pub wrong_confident: Rate,
    /// See [`Marks::ties`].
    pub ties_called_ambiguous: Rate,
    /// See [`Marks::coverage`].
    pub interval_coverage: Rate,
    /// Stated probabilities compared with frequencies, by tenths.
    pub calibration: Vec<CalibrationReport>,
    /// How many were marked right, by hidden effect.
    pub by_effect: Vec<(String, Rate)>,
    /// How many were marked right, by the size of the smallest hidden term in units of noise.
    pub by_size: Vec<(String, Rate)>,
    /// How many were marked right, by the noise of the angle.
    pub by_noise: Vec<(String, Rate)>,
    /// Bench by bench.
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
