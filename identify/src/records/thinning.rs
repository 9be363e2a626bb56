//! Records with fewer samples: a part of a log, every n-th sample, or averages over blocks.

use std::sync::OnceLock;

use plant::Output;

use super::averages::{blocks, means, middles};
use super::early_steps::UnknownStep;
use super::record::{Record, RecordedCurrent, mean};

impl Record {
    /// A part of the record, as if it had been recorded on its own. The noise is that of the whole record.
    pub fn slice(&self, samples: std::ops::Range<usize>) -> Record {
        self.part(&samples.collect::<Vec<_>>())
    }

    /// Every `step`-th sample of the record, as if the samples between had not been recorded.
    pub fn every(&self, step: usize) -> Record {
        self.part(&(0..self.len()).step_by(step).collect::<Vec<_>>())
    }

    /// Every `step`-th sample of the log. The current and the wheel's angle still use all samples.
    pub fn thinned(&self, step: usize) -> Record {
        let mut thin = self.every(step);
        let kept = (0..self.len()).step_by(step);
        if self.channel(Output::WheelSpeed).is_some() {
            let whole = self.wheel_angles();
            thin.past.wheel_angle_rad = OnceLock::from(kept.map(|k| whole[k]).collect::<Vec<_>>());
        }
        if let RecordedCurrent::Known(input) = &self.current {
            if !self.current_a.is_empty() {
                let means = self.current_a.chunks(step);
                thin.current_a = means.map(mean).collect();
            }
            thin.current = RecordedCurrent::Known(input.clone());
            thin.unknown_steps = self.unknown_steps.clone();
        }
        thin
    }

    /// The log as averages over `block` samples, each corrected to the value in the middle of its block
    /// (see [`super::averages`]), with the noise of such values. The current and the wheel's angle still use all samples.
    pub fn averaged(&self, block: usize) -> Record {
        let blocks = blocks(self.len(), block);
        let kinks = self.kinks();
        let outputs = Output::ALL.map(|output| {
            let channel = self.channel(output)?;
            Some(middles(&channel.samples, &blocks, &kinks))
        });
        let current_a = (!self.current_a.is_empty()).then(|| means(&self.current_a, &blocks));
        let mut averaged = Record::of_samples(
            &self.name,
            self.kind,
            means(&self.time_s, &blocks),
            outputs,
            current_a,
            self.current_is_measured,
        );
        if let (RecordedCurrent::Known(input), false) = (&self.current, self.current_a.is_empty()) {
            averaged.current = RecordedCurrent::Known(input.clone());
            averaged.step_times = self.step_times;
            averaged.unknown_steps = self.unknown_steps.clone();
        }
        if self.channel(Output::WheelSpeed).is_some() {
            averaged.turned_rad = Some(means(self.wheel_angles(), &blocks));
        }
        averaged.turned_noise_rad = self.turned_noise_rad;
        averaged.window_s = self.window_s;
        averaged.passes_over_the_top = self.passes_over_the_top;
        averaged.averaged_over = block * self.averaged_over;
        averaged
    }

    fn part(&self, samples: &[usize]) -> Record {
        let pick = |series: &[f64]| samples.iter().map(|&k| series[k]).collect::<Vec<f64>>();
        let outputs =
            Output::ALL.map(|output| self.channel(output).map(|channel| pick(&channel.samples)));
        let current_a = (!self.current_a.is_empty()).then(|| pick(&self.current_a));
        let mut part = Record::of_samples(
            &self.name,
            self.kind,
            pick(&self.time_s),
            outputs,
            current_a,
            self.current_is_measured,
        );
        for channel in &mut part.channels {
            if let Some(whole) = self.channel(channel.output) {
                channel.noise_std = whole.noise_std;
                channel.quantum = whole.quantum;
            }
        }
        part.weight = pick(&self.weight);
        part.window_s = self.window_s;
        part.turned_rad = self.turned_rad.as_deref().map(pick);
        part.turned_noise_rad = self.turned_noise_rad;
        part.teeth = self.teeth;
        part.averaged_over = self.averaged_over;
        part.clock_jitter_s = self.clock_jitter_s;
        part.step_times = self.step_times;
        for step in &self.unknown_steps {
            // The first sample of this part that shows the step.
            let at = part
                .time_s
                .partition_point(|&time_s| time_s < step.sample_s);
            let (Some(&sample_s), Some(&before_s)) =
                (part.time_s.get(at), part.time_s.get(at.wrapping_sub(1)))
            else {
                continue;
            };
            match part.unknown_steps.last_mut() {
                Some(last) if last.sample_s == sample_s => last.change_a += step.change_a,
                _ => part.unknown_steps.push(UnknownStep {
                    sample_s,
                    change_a: step.change_a,
                    interval_s: sample_s - before_s,
                    margin_s: step.margin_s,
                    guess: 0.5,
                }),
            }
        }
        part
    }
}
