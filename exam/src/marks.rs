//! The marks of many benches together.

use diagnose::Verdict;
use identify::FitProblem;
use plant::EffectId;
use serde::Serialize;

use crate::answer::Answer;
use crate::marking::{Mark, PLAIN, Paper};

/// One bench with its marked verdict.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The seed or folder.
    pub label: String,
    /// The hidden terms in words, one entry per term.
    pub truth: Vec<String>,
    /// The hidden effects of the library, sorted.
    pub hidden: Vec<EffectId>,
    /// Whether a hidden term is not among the suspects.
    pub outside: bool,
    /// Size of each hidden term alone, in units of noise; empty if unknown.
    pub sizes: Vec<f64>,
    /// Noise of angle (rad), rate (rad/s) and wheel speed (rad/s); empty if unknown.
    pub noise: Vec<f64>,
    /// The experiments of the bench.
    pub experiments: Vec<String>,
    /// Number of samples over all channels.
    pub observations: usize,
    /// The verdict and its mark.
    pub paper: Paper,
}

impl Entry {
    /// A marked bench with unknown sizes.
    pub fn new(
        label: String,
        truth: Vec<String>,
        answer: Answer,
        problem: &FitProblem,
        paper: Paper,
    ) -> Entry {
        let records = problem.records.iter();
        Entry {
            label,
            truth,
            hidden: answer.effects,
            outside: answer.outside,
            sizes: vec![],
            noise: vec![],
            experiments: records.clone().map(|record| record.name.clone()).collect(),
            observations: records.map(|record| record.observations()).sum(),
            paper,
        }
    }

    /// Whether the logs leave a tie between the truth and another set.
    pub fn is_tie(&self) -> bool {
        self.paper.ties.iter().any(|(set, _)| {
            !set.iter()
                .all(|effect| self.paper.accepted.contains(effect))
        })
    }

    /// Whether every hidden effect has a trace of at least [`PLAIN`].
    pub fn is_plain(&self) -> bool {
        self.sizes.iter().all(|size| *size >= PLAIN)
            && self.paper.shown.iter().all(|shown| *shown >= PLAIN)
    }

    /// The class of the smallest hidden term's size, in units of noise.
    pub fn size_class(&self) -> Vec<String> {
        let smallest = self.sizes.iter().copied().fold(f64::INFINITY, f64::min);
        let name = match smallest {
            size if size.is_infinite() => return vec![],
            size if size < 3.0 => "1 to 3",
            size if size < 10.0 => "3 to 10",
            _ => "10 to 30",
        };
        vec![name.to_owned()]
    }

    /// The class of the angle's noise.
    pub fn noise_class(&self) -> Vec<String> {
        let name = match self.noise.first() {
            None => return vec![],
            Some(noise) if *noise < 1e-3 => "below 1 mrad",
            Some(_) => "1 mrad and more",
        };
        vec![name.to_owned()]
    }

    /// Whether a true effect is among the first `count` suspects.
    pub fn among_first(&self, count: usize) -> bool {
        self.paper
            .suspects
            .iter()
            .take(count)
            .any(|(effect, _)| self.paper.accepted.contains(effect))
    }
}

/// A count out of a number of cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(into = "StatedRate")]
pub struct Rate {
    /// The count.
    pub count: usize,
    /// The number of cases.
    pub of: usize,
}

/// A rate as it is serialised: with its share and the 95 % interval of the share.
#[derive(Serialize)]
struct StatedRate {
    count: usize,
    of: usize,
    share: f64,
    interval_95: [f64; 2],
}

impl From<Rate> for StatedRate {
    fn from(rate: Rate) -> StatedRate {
        let (low, high) = rate.interval();
        StatedRate {
            count: rate.count,
            of: rate.of,
            share: rate.share(),
            interval_95: [low, high],
        }
    }
}

impl Rate {
    /// Counts the elements for which `holds` is true.
    pub fn over<'a, T: 'a>(all: impl Iterator<Item = &'a T>, holds: impl Fn(&T) -> bool) -> Rate {
        all.fold(Rate::default(), |rate, one| Rate {
            count: rate.count + usize::from(holds(one)),
            of: rate.of + 1,
        })
    }

    /// The share; NaN if there is no case.
    pub fn share(&self) -> f64 {
        self.count as f64 / self.of as f64
    }

    /// The 95 % interval of the share (Wilson, J. Am. Stat. Assoc. 22 (1927)).
    pub fn interval(&self) -> (f64, f64) {
        let (n, z) = (self.of as f64, 1.959_964);
        if self.of == 0 {
            return (0.0, 1.0);
        }
        let p = self.share();
        let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
        let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        ((centre - half).max(0.0), (centre + half).min(1.0))
    }
}

/// Statements with about the same stated probability.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ReliabilityShare {
    /// Mean stated probability.
    pub stated: f64,
    /// The share of these statements that came true.
    pub came_true: Rate,
}

/// The result of an exam.
#[derive(Clone, Debug)]
pub struct Marks {
    /// Benches with one hidden effect, a trace of at least [`PLAIN`] and no tie: the effect is the first suspect.
    pub first: Rate,
    /// The same benches: the effect is among the first two suspects.
    pub first_two: Rate,
    /// Benches with one hidden effect, of any size, that are marked right.
    pub one_right: Rate,
    /// Benches with two hidden effects, both with a trace of at least [`PLAIN`]: the diagnosis names both, alone or in
    /// a tie.
    pub both: Rate,
    /// Outsiders that the diagnosis calls unexplained.
    pub outsiders: Rate,
    /// Benches without a hidden effect on which the diagnosis gives a false alarm.
    pub false_alarms: Rate,
    /// Wrong confident verdicts among all benches.
    pub wrong: Rate,
    /// Ties that were called "ambiguous".
    pub ties: Rate,
    /// 95 % intervals that contain the true value.
    pub coverage: Rate,
    /// Stated probabilities compared with frequencies, by tenths.
    pub calibration: Vec<ReliabilityShare>,
    /// Rows of the confusion matrix: the truth.
    pub truths: Vec<String>,
    /// Columns of the confusion matrix: the answer.
    pub answers: Vec<String>,
    /// Counts of the confusion matrix, row by row.
    pub confusion: Vec<usize>,
}

/// The verdict's answer in one word or one name, for the confusion matrix.
fn answered(entry: &Entry) -> String {
    match (entry.paper.verdict, entry.paper.named.as_slice()) {
        (Verdict::Explained, [one]) => one.name().to_owned(),
        (Verdict::Explained, named) if *named == entry.hidden => "both".to_owned(),
        (Verdict::Explained, _) => "other combination".to_owned(),
        (verdict, _) => verdict.name().to_owned(),
    }
}

fn asked(entry: &Entry) -> String {
    match entry.truth.as_slice() {
        [_] if entry.outside => "outsider".to_owned(),
        [one] => one.clone(),
        _ => "two effects".to_owned(),
    }
}

impl Marks {
    /// Summarises the marks of these benches.
    pub fn of(entries: &[Entry]) -> Marks {
        let one = || {
            entries
                .iter()
                .filter(|entry| entry.hidden.len() == 1 && !entry.outside)
        };
        let plain = || one().filter(|entry| entry.is_plain() && !entry.is_tie());
        let outside = entries.iter().filter(|entry| entry.outside);
        let nothing = entries
            .iter()
            .filter(|entry| entry.hidden.is_empty() && !entry.outside);
        let two = entries
            .iter()
            .filter(|entry| entry.hidden.len() == 2 && !entry.outside && entry.is_plain());
        let both = |entry: &Entry| {
            entry.paper.named == entry.hidden
                || entry.paper.ambiguous_between.contains(&entry.hidden)
                || entry.paper.mark == Mark::Right
        };
        let (truths, answers, confusion) = confusion(entries);
        Marks {
            first: Rate::over(plain(), |entry| entry.among_first(1)),
            first_two: Rate::over(plain(), |entry| entry.among_first(2)),
            one_right: Rate::over(one(), |entry| entry.paper.mark == Mark::Right),
            both: Rate::over(two, both),
            outsiders: Rate::over(outside, |entry| entry.paper.verdict == Verdict::Unexplained),
            false_alarms: Rate::over(nothing, |entry| entry.paper.mark == Mark::FalseAlarm),
            wrong: Rate::over(entries.iter(), |entry| entry.paper.mark == Mark::Wrong),
            ties: Rate::over(entries.iter().filter(|entry| entry.is_tie()), |entry| {
                entry.paper.verdict == Verdict::Ambiguous
            }),
            coverage: Rate::over(
                entries.iter().flat_map(|entry| &entry.paper.intervals),
                |interval| interval.covers(),
            ),
            calibration: calibration(entries),
            truths,
            answers,
            confusion,
        }
    }
}

impl Marks {
    /// The rate of right answers in each class; `class` returns the classes of a bench.
    pub fn by(entries: &[Entry], class: impl Fn(&Entry) -> Vec<String>) -> Vec<(String, Rate)> {
        let mut names: Vec<String> = entries.iter().flat_map(&class).collect();
        in_order(&mut names);
        names
            .into_iter()
            .map(|name| {
                let own = entries.iter().filter(|entry| class(entry).contains(&name));
                let right = Rate::over(own, |entry| entry.paper.mark == Mark::Right);
                (name, right)
            })
            .collect()
    }
}

/// Removes duplicate names, and sorts: effects in the order of the library, then the others by name.
fn in_order(names: &mut Vec<String>) {
    names.sort_by_key(|name| {
        let effect = EffectId::from_name(name);
        (effect.is_none(), effect, name.clone())
    });
    names.dedup();
}

fn calibration(entries: &[Entry]) -> Vec<ReliabilityShare> {
    const BINS: usize = 10;
    let mut bins = vec![ReliabilityShare::default(); BINS];
    for entry in entries {
        for (effect, probability) in &entry.paper.suspects {
            let bin = &mut bins[((probability * BINS as f64) as usize).min(BINS - 1)];
            bin.stated += probability;
            bin.came_true.of += 1;
            bin.came_true.count += usize::from(entry.paper.accepted.contains(effect));
        }
    }
    for bin in &mut bins {
        bin.stated /= bin.came_true.of.max(1) as f64;
    }
    bins.retain(|bin| bin.came_true.of > 0);
    bins
}

fn confusion(entries: &[Entry]) -> (Vec<String>, Vec<String>, Vec<usize>) {
    let mut truths: Vec<String> = entries.iter().map(asked).collect();
    let mut answers: Vec<String> = entries.iter().map(answered).collect();
    in_order(&mut truths);
    in_order(&mut answers);
    let mut counts = vec![0; truths.len() * answers.len()];
    for entry in entries {
        let row = truths.iter().position(|name| *name == asked(entry));
        let column = answers.iter().position(|name| *name == answered(entry));
        if let (Some(row), Some(column)) = (row, column) {
            counts[row * answers.len() + column] += 1;
        }
    }
    (truths, answers, counts)
}
