//! What a log shows of the time before a sample: the angle of the wheel, and how far the body has moved.

use plant::Output;

use super::noise::{resolution, without_floor};
use super::past::{Past, Travel};
use super::record::{Record, mean};

/// Time in s over which the rate is averaged before the body's travel is integrated from it. A balanced body moves over
/// tenths of a second; the noise of single samples would add to the length of its path.
const TRAVEL_AVERAGE_S: f64 = 0.02;

impl Record {
    /// States the wheel's angle in rad as measured at every sample, unwrapped. Missing samples lie on the straight line
    /// between their neighbours. Nothing changes where none was measured.
    pub fn set_wheel_angles(&mut self, measured_rad: &[f64]) {
        let at: Vec<usize> = (0..measured_rad.len())
            .filter(|&k| measured_rad[k].is_finite())
            .collect();
        if at.len() < 2 || measured_rad.len() != self.len() {
            return;
        }
        let between = |k: usize| {
            let after = at.partition_point(|&known| known < k);
            match (after.checked_sub(1).map(|before| at[before]), at.get(after)) {
                (_, Some(&after)) if after == k => measured_rad[k],
                (Some(before), Some(&after)) => {
                    let share = (self.time_s[k] - self.time_s[before])
                        / (self.time_s[after] - self.time_s[before]);
                    measured_rad[before] + share * (measured_rad[after] - measured_rad[before])
                }
                (Some(before), None) => measured_rad[before],
                (None, after) => after.map_or(0.0, |&after| measured_rad[after]),
            }
        };
        let angles: Vec<f64> = (0..self.len()).map(between).collect();
        let noise_rad = without_floor(&angles, &self.kinks()).map_or(0.0, |noise| noise.std);
        self.turned_noise_rad = Some(noise_rad.max(resolution(&angles) / 12f64.sqrt()));
        self.turned_rad = Some(angles);
    }

    /// States the wheel's angle in rad at every sample, corrected by the teeth of its motor, with its standard deviation.
    pub(crate) fn set_corrected_wheel_angles(&mut self, angle_rad: Vec<f64>, std_rad: f64) {
        self.turned_rad = Some(angle_rad);
        self.turned_noise_rad = Some(std_rad);
        self.past = Past::default();
    }

    /// Standard deviation of the noise of the measured wheel angle, rad; `None` where it is the integral of the speed.
    pub fn wheel_angle_noise_rad(&self) -> Option<f64> {
        self.turned_noise_rad
    }

    /// The wheel's angle in rad at every sample, as measured; if only its speed was, the angle by which it has turned since
    /// the log began, the integral of the measured speed (trapezoidal rule; a missing sample repeats the one before). Zeros
    /// if neither was measured.
    pub fn wheel_angles(&self) -> &[f64] {
        if let Some(turned_rad) = &self.turned_rad {
            return turned_rad;
        }
        self.past.wheel_angle_rad.get_or_init(|| {
            let Some(channel) = self.channel(Output::WheelSpeed) else {
                return vec![0.0; self.len()];
            };
            let mut last = 0.0;
            let mut angle = 0.0;
            (0..self.len())
                .map(|k| {
                    let speed = if channel.samples[k].is_finite() {
                        channel.samples[k]
                    } else {
                        last
                    };
                    if k > 0 {
                        angle += 0.5 * (last + speed) * (self.time_s[k] - self.time_s[k - 1]);
                    }
                    last = speed;
                    angle
                })
                .collect()
        })
    }

    /// That angle at one sample; 0 beyond the end of the log.
    pub fn wheel_angle_before(&self, sample: usize) -> f64 {
        self.wheel_angles().get(sample).copied().unwrap_or(0.0)
    }

    /// Angles in rad by which the body moves from each sample before `end` to the next, as measured, backwards from `end`.
    /// They are the rate times the interval; the rate is averaged over [`TRAVEL_AVERAGE_S`], and its mean offset against
    /// the angle is subtracted. Without a rate, they are differences of the angle averaged over nine samples.
    pub fn body_travel_before(&self, end: usize) -> impl Iterator<Item = f64> {
        let travel = self.past.travel_rad.get_or_init(|| self.travel());
        let end = end.min(travel.step_rad.len());
        let offset = travel.disagreement_rad.get(end).copied().unwrap_or(0.0) / end.max(1) as f64;
        travel.step_rad[..end]
            .iter()
            .rev()
            .map(move |step| step + offset)
    }

    fn travel(&self) -> Travel {
        const HALF_AVERAGE: usize = 4;
        let last = self.len().saturating_sub(1);
        let by_angle: Option<Vec<f64>> = self.channel(Output::Angle).map(|channel| {
            let near = |k: usize| {
                let span = k.saturating_sub(HALF_AVERAGE)..(k + HALF_AVERAGE + 1).min(last + 1);
                let finite = channel.samples[span]
                    .iter()
                    .filter(|value| value.is_finite());
                finite.clone().sum::<f64>() / finite.count().max(1) as f64
            };
            (0..last).map(|k| near(k + 1) - near(k)).collect()
        });
        let by_rate: Option<Vec<f64>> = self.channel(Output::Rate).map(|channel| {
            let ends = self.time_s.first().zip(self.time_s.last());
            let span_s = ends.map_or(0.0, |(first, last)| last - first);
            let half =
                (0.5 * TRAVEL_AVERAGE_S * last as f64 / span_s.max(TRAVEL_AVERAGE_S)) as usize;
            let step = |k: usize| {
                let around = k.saturating_sub(half)..(k + 2 + half).min(last + 1);
                let rate = mean(&channel.samples[around]);
                if rate.is_finite() {
                    rate * (self.time_s[k + 1] - self.time_s[k])
                } else {
                    0.0
                }
            };
            (0..last).map(step).collect()
        });
        let mut disagreement_rad = vec![];
        if let (Some(by_angle), Some(by_rate)) = (&by_angle, &by_rate) {
            let mut sum = 0.0;
            disagreement_rad.push(sum);
            for (by_angle, by_rate) in by_angle.iter().zip(by_rate) {
                sum += by_angle - by_rate;
                disagreement_rad.push(sum);
            }
        }
        Travel {
            step_rad: by_rate.or(by_angle).unwrap_or_default(),
            disagreement_rad,
        }
    }
}
