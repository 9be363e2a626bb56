//! The attempts to explain a missing torque by one coordinate after the other.

use nalgebra::DVector;
use parallel::parallel_map;

use super::super::residual_torque::TorqueOn;
use super::super::structure::SIGNIFICANT;
use super::coordinate::{Coordinate, edges};
use super::failure_map::{
    BreakdownBin, ExplainedTorque, FailureMap, FailureRegion, ResidualBreakdown, ResidualKind,
};
use super::series::{Context, ResidualSeries};
use super::steps::{StepFit, fit_steps, shortest_run};

/// Two coordinates explain a torque equally well if the ratio of their shares exceeds this value: step functions
/// cannot resolve a smaller difference.
const AS_GOOD: f64 = 0.9;

/// The attempt to explain a torque by one coordinate.
struct Attempt {
    explained: ExplainedTorque,
    breakdowns: Vec<ResidualBreakdown>,
    regions: Vec<FailureRegion>,
}

impl Context<'_> {
    pub(super) fn break_torque_down(
        &self,
        on: TorqueOn,
        group: &[&ResidualSeries],
        map: &mut FailureMap,
    ) {
        let all_excess: f64 = group.iter().map(|series| series.excess()).sum();
        let coordinates: Vec<usize> = (0..Coordinate::ALL.len())
            .filter(|&index| {
                // The friction of the wheel does not depend on the position of the body.
                let of_body = matches!(
                    Coordinate::ALL[index],
                    Coordinate::Rate | Coordinate::Angle | Coordinate::Amplitude
                );
                on != TorqueOn::Wheel || !of_body
            })
            .collect();
        let mut attempts: Vec<Attempt> = parallel_map(coordinates, |index| {
            self.attempt(index, on, group, all_excess)
        });
        for attempt in &mut attempts {
            map.explained.push(attempt.explained);
            map.breakdowns.append(&mut attempt.breakdowns);
        }
        let best = attempts
            .iter()
            .map(|attempt| attempt.explained.share)
            .fold(0.0, f64::max);
        let chosen = attempts
            .iter_mut()
            .find(|attempt| best > 0.0 && attempt.explained.share >= AS_GOOD * best);
        if let Some(chosen) = chosen {
            map.regions.append(&mut chosen.regions);
        }
    }

    /// Attempts to explain the torque of a group of series by one coordinate.
    fn attempt(
        &self,
        index: usize,
        on: TorqueOn,
        group: &[&ResidualSeries],
        all_excess: f64,
    ) -> Attempt {
        let coordinate = Coordinate::ALL[index];
        let having: Vec<&ResidualSeries> = group
            .iter()
            .copied()
            .filter(|series| !self.places[series.record][index].is_empty())
            .collect();
        let sets: Vec<Vec<&ResidualSeries>> = if coordinate.is_common() {
            vec![having]
        } else {
            having.into_iter().map(|series| vec![series]).collect()
        };
        let (mut explained, mut mean, mut variance) = (0.0, 0.0, 0.0);
        let (mut breakdowns, mut regions) = (vec![], vec![]);
        for set in sets.iter().filter(|set| !set.is_empty()) {
            let seen: Vec<Vec<f64>> = set.iter().map(|series| self.seen(series, index)).collect();
            let all: Vec<f64> = seen.concat();
            let count = all.len();
            let Some(edges) = edges(coordinate, all, count) else {
                continue;
            };
            let at = |series: usize, interval: usize| {
                let series = set[series];
                (
                    self.places[series.record][index][interval],
                    self.speed(series, interval),
                )
            };
            let form = (!coordinate.is_speed(), coordinate == Coordinate::WheelAngle);
            let Some(fit) = fit_steps(set, &edges, form, &at) else {
                continue;
            };
            explained += fit.explained;
            mean += fit.of_noise.0;
            variance += fit.of_noise.1
                + set
                    .iter()
                    .map(|series| self.feedback(series).powi(2))
                    .sum::<f64>();
            // All logs that share the function share the region.
            let pooled: Vec<f64> = (0..edges.len() - 1)
                .map(|bin| fit.energy.iter().map(|energy| energy[bin]).sum())
                .collect();
            let run = shortest_run(&pooled, &edges);
            for (number, series) in set.iter().enumerate() {
                let excess = series.excess().max(1e-300);
                let experiment = self.records[series.record].name.clone();
                breakdowns.push(ResidualBreakdown {
                    experiment: experiment.clone(),
                    channel: series.channel,
                    quantity: ResidualKind::ResidualTorque,
                    coordinate,
                    noise_std: series.noise_std,
                    bins: bins_of(&fit, number, &edges, excess),
                });
                let energy = &fit.energy[number];
                let Some((from, to)) = run else {
                    continue;
                };
                let sum: f64 = energy[from..=to].iter().sum();
                if sum <= 0.0 {
                    continue;
                }
                // The square of a Gaussian variable has twice its squared mean as variance.
                let scatter: f64 = fit.noise_energy[number]
                    .iter()
                    .zip(&fit.count[number])
                    .filter(|(_, count)| **count > 0.0)
                    .map(|(own, _)| 2.0 * own.max(1.0).powi(2))
                    .sum();
                // A bin can be wider than the range that this log covers.
                let finite = || seen[number].iter().copied().filter(|x| x.is_finite());
                let lowest = finite().fold(f64::INFINITY, f64::min);
                let highest = finite().fold(f64::NEG_INFINITY, f64::max);
                regions.push(FailureRegion {
                    experiment,
                    channel: series.channel,
                    quantity: ResidualKind::ResidualTorque,
                    coordinate,
                    from: edges[from].max(lowest),
                    to: edges[to + 1].min(highest),
                    stretches_s: vec![],
                    share_of_error: (sum / excess).clamp(0.0, 1.0),
                    size: sum,
                    is_significant: energy.iter().sum::<f64>()
                        > SIGNIFICANT * scatter.sqrt().hypot(self.feedback(series)),
                });
            }
        }
        let gain = explained - mean;
        let significance = gain / variance.sqrt().max(1e-300);
        Attempt {
            explained: ExplainedTorque {
                on,
                coordinate,
                share: if significance > SIGNIFICANT {
                    gain / all_excess.max(gain)
                } else {
                    0.0
                },
                significance,
            },
            breakdowns,
            regions,
        }
    }
}

fn bins_of(fit: &StepFit, series: usize, edges: &[f64], excess: f64) -> Vec<BreakdownBin> {
    let bins = edges.len() - 1;
    let signed = fit.beta.len() > bins;
    (0..bins)
        .map(|bin| {
            let seen = fit.count[series][bin] > 0.0;
            let of = |values: &DVector<f64>, k: usize| if seen { values[k] } else { f64::NAN };
            BreakdownBin {
                from: edges[bin],
                to: edges[bin + 1],
                count: fit.count[series][bin],
                mean: of(&fit.beta, bin),
                mean_std: of(&fit.std, bin),
                along_motion: if signed {
                    of(&fit.beta, bins + bin)
                } else {
                    f64::NAN
                },
                along_motion_std: if signed {
                    of(&fit.std, bins + bin)
                } else {
                    f64::NAN
                },
                share: (fit.energy[series][bin] / excess).clamp(0.0, 1.0),
            }
        })
        .collect()
}
