//! The residual of the free-running simulation in one channel, and where it is large.

use super::super::correlation::effective_samples;
use super::super::structure::structure;
use super::coordinate::{Coordinate, bin_of, edges};
use super::failure_map::{BreakdownBin, FailureRegion, ResidualBreakdown, ResidualKind};
use super::series::{Context, ResidualSeries};
use super::steps::shortest_run;

/// Structure in an output below this share of its noise is not reported. It raises the RMS error by less
/// than 5 % (√(1 + 1/9)), and the noise of a recorded current leaves about as much.
const IMMATERIAL: f64 = 1.0 / 3.0;

impl Context<'_> {
    /// Breaks one output down and returns its worst region: in the coordinate in which four fifths of the excess lie in
    /// the smallest share of the samples.
    pub(super) fn break_output_down(
        &self,
        series: &ResidualSeries,
        out: &mut Vec<ResidualBreakdown>,
    ) -> Option<FailureRegion> {
        let n = series.values.len();
        if n == 0 {
            return None;
        }
        let mut best: Option<(f64, FailureRegion)> = None;
        let found = structure(&series.values, 1.0, &[]);
        let is_significant = found.is_significant() && found.rms_over_noise > IMMATERIAL;
        let all: f64 = series.excess();
        // The values are correlated: within a bin, the share of independent values is that of the whole series.
        let worth = effective_samples(&series.values, &[]) / n as f64;
        for (index, &coordinate) in Coordinate::ALL.iter().enumerate() {
            let place = &self.places[series.record][index];
            // A torque that varies within a turn is smoothed by the integration to the output.
            if place.is_empty() || coordinate == Coordinate::WheelAngle {
                continue;
            }
            let Some(edges) = edges(coordinate, self.seen(series, index), n) else {
                continue;
            };
            let bins = edges.len() - 1;
            let (mut count, mut sum, mut squares) =
                (vec![0.0; bins], vec![0.0; bins], vec![0.0; bins]);
            for ((k, _), value) in series.looks.iter().zip(&series.values) {
                if let Some(bin) = bin_of(&edges, place[*k]) {
                    count[bin] += 1.0;
                    sum[bin] += value;
                    squares[bin] += value * value;
                }
            }
            let energy: Vec<f64> = squares.iter().zip(&count).map(|(s, n)| s - n).collect();
            let positive: f64 = energy.iter().map(|value| value.max(0.0)).sum();
            out.push(ResidualBreakdown {
                experiment: self.records[series.record].name.clone(),
                channel: series.channel,
                quantity: ResidualKind::Output,
                coordinate,
                noise_std: series.noise_std,
                bins: (0..bins)
                    .map(|bin| {
                        let mean = sum[bin] / count[bin];
                        let variance = (squares[bin] / count[bin] - mean * mean).max(0.0);
                        BreakdownBin {
                            from: edges[bin],
                            to: edges[bin + 1],
                            count: count[bin],
                            mean: mean * series.noise_std,
                            mean_std: (variance / (count[bin] * worth).max(1.0)).sqrt()
                                * series.noise_std,
                            along_motion: f64::NAN,
                            along_motion_std: f64::NAN,
                            share: energy[bin].max(0.0) / positive.max(1e-300),
                        }
                    })
                    .collect(),
            });
            if let Some((from, to)) = shortest_run(&energy, &edges) {
                let size: f64 = energy[from..=to].iter().map(|value| value.max(0.0)).sum();
                let part = count[from..=to].iter().sum::<f64>() / n as f64;
                let region = FailureRegion {
                    experiment: self.records[series.record].name.clone(),
                    channel: series.channel,
                    quantity: ResidualKind::Output,
                    coordinate,
                    from: edges[from],
                    to: edges[to + 1],
                    stretches_s: vec![],
                    share_of_error: (size / all.max(positive).max(1e-300)).clamp(0.0, 1.0),
                    size,
                    is_significant,
                };
                if best.as_ref().is_none_or(|(least, _)| part < *least) {
                    best = Some((part, region));
                }
            }
        }
        best.map(|(_, region)| region)
    }
}
