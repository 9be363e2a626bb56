//! The marks as figures.

use figures::{Confusion, FigureError, Reliability, ReliabilityBin};

use crate::marks::Marks;

/// Half width of the band in the figure: the difference between a stated probability and its frequency that is
/// accepted.
const TOLERANCE: f64 = 0.05;

impl Marks {
    /// Two figures of an exam of `benches` benches, each with its file name and its SVG: the answers to each hidden
    /// effect, and how often stated probabilities came true.
    ///
    /// # Errors
    /// [`FigureError`] if the counts are no square table.
    pub fn drawings(&self, benches: usize) -> Result<[(&'static str, String); 2], FigureError> {
        let subtitle = format!("{benches} benches");
        let truths: Vec<&str> = self.truths.iter().map(String::as_str).collect();
        let answers: Vec<&str> = self.answers.iter().map(String::as_str).collect();
        let confusion = figures::confusion(&Confusion {
            title: "What was hidden, and what was answered",
            subtitle: &subtitle,
            truths: &truths,
            answers: &answers,
            counts: &self.confusion,
        })?;
        let bins: Vec<ReliabilityBin> = self
            .calibration
            .iter()
            .map(|bin| {
                let (low, high) = bin.came_true.interval();
                ReliabilityBin {
                    stated: bin.stated,
                    frequency: bin.came_true.share(),
                    low,
                    high,
                    count: bin.came_true.of,
                }
            })
            .collect();
        let reliability = figures::reliability(&Reliability {
            title: "Stated probabilities, and how often they came true",
            subtitle: &subtitle,
            bins: &bins,
            tolerance: TOLERANCE,
        });
        Ok([
            ("exam-confusion.svg", confusion),
            ("exam-reliability.svg", reliability),
        ])
    }
}
