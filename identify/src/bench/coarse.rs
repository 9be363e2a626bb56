//! The noise of coarse logs, estimated from the residual of the base model over short windows.
//!
//! Differences between samples separate noise from motion only where the motion is smooth from sample to sample.
//! They fail in a swing with a dozen samples per period, in a log whose current switches every few samples, and
//! in a log of fifty samples. There, a model gives the smooth curve: the base model with dry friction, fitted over
//! windows of a dozen samples, each with its own start. Such a fit follows the motion even if the model lacks an
//! effect. Its residual is not smaller than the noise.

use nalgebra::{DMatrix, DVector};
use plant::{EffectId, Kind, Model, period_s};

use super::problem::FitProblem;
use crate::fit::{Effort, Unknowns, Window, guess, minimise, normal_observed, relevant};
use crate::records::{NOISE_RELATIVE_STD_ROOT_N, NoiseEstimate, Record, noise_by_differences};

/// A log with fewer samples than this has too few differences: the noise estimate scatters by more than 10 %.
const FEW_SAMPLES: usize = 256;
/// Samples per period of a swing below which the curvature of the motion dominates differences of every order.
const FEW_PER_PERIOD: f64 = 20.0;
/// Samples between two steps of the current below which nearly every high-order difference contains a step.
const FEW_PER_STEP: f64 = 20.0;
/// Samples per window: four for each of its own unknowns.
const WINDOW_SAMPLES: f64 = 12.0;
/// Number of fits. Each is weighted with the noise from the residual of the one before, the first with the noise from
/// differences.
const ROUNDS: usize = 3;
/// An unknown counts as not determined if its information is below this share of the window's largest.
const SINGULAR: f64 = 1e-12;
/// The noise estimated from the model's residual replaces the estimate from differences, unless it is larger by more
/// than this many standard errors: then the residual contains misfit of the model.
const AGREE: f64 = 3.0;

impl FitProblem {
    /// Corrects the noise of records that are too coarse for an estimate from differences.
    pub(super) fn estimate_coarse_noise(&mut self) {
        let model = Model::base()
            .with(EffectId::BodyCoulombFriction)
            .with(EffectId::WheelCoulombFriction);
        let values = self.start_values(&model);
        let period_s = period_s(&values);
        let coarse: Vec<usize> = (0..self.records.len())
            .filter(|&at| is_coarse(&self.records[at], period_s))
            .collect();
        if coarse.is_empty() {
            return;
        }
        let free = self.free(&model);
        let unknowns = Unknowns::new(&model, &free);
        let differences: Vec<Vec<NoiseEstimate>> = coarse
            .iter()
            .map(|&at| {
                let record = &self.records[at];
                let kinks = record.kinks();
                let channels = record.channels.iter();
                channels
                    .map(|channel| noise_by_differences(&channel.samples, &kinks))
                    .collect()
            })
            .collect();
        let mut values = values;
        let mut windows: Vec<Vec<Window>> = coarse
            .iter()
            .map(|&at| short_windows(&self.records[at], &values))
            .collect();
        for _ in 0..ROUNDS {
            let records: Vec<&Record> = coarse.iter().map(|&at| &self.records[at]).collect();
            let found = minimise(&records, &model, values, windows, &unknowns, Effort::ROUGH);
            let left: Vec<Vec<f64>> = records
                .iter()
                .zip(&found.windows)
                .map(|(record, windows)| {
                    let shared = relevant(record, &model, &unknowns).len();
                    left_by(record, windows, &model, &found.values, shared)
                })
                .collect();
            (values, windows) = (found.values, found.windows);
            for ((&at, left), differences) in coarse.iter().zip(left).zip(&differences) {
                let channels = self.records[at].channels.iter_mut();
                for ((channel, left), known) in channels.zip(left).zip(differences) {
                    let scatter = NOISE_RELATIVE_STD_ROOT_N / (known.differences as f64).sqrt();
                    let agrees = left < known.std * (1.0 + AGREE * scatter);
                    channel.set_noise(if agrees { left } else { known.std });
                }
            }
        }
    }
}

/// Whether a record is too coarse for an estimate of its noise from differences.
fn is_coarse(record: &Record, period_s: f64) -> bool {
    let n = record.len();
    // The noise of a clock that jitters was found at the logged times.
    if record.kind == Kind::Balance || record.clock_jitter_s.is_some() || n < 2 {
        return false;
    }
    let interval_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
    let swings = record.kind != Kind::SpinUp && interval_s * FEW_PER_PERIOD > period_s;
    let steps = record.kinks().len();
    n < FEW_SAMPLES || swings || steps as f64 * FEW_PER_STEP > n as f64
}

/// Windows of a dozen samples, with starts guessed from the samples.
fn short_windows(record: &Record, values: &[f64]) -> Vec<Window> {
    let n = record.len();
    let interval_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
    let windows = record.windows(WINDOW_SAMPLES * interval_s);
    windows
        .into_iter()
        .map(|samples| guess(record, values, samples))
        .collect()
}

/// Standard deviation of the residual of each channel. The degrees of freedom are those left after the fit of the
/// windows' own unknowns and of the `shared` parameters: each channel loses the leverages of its own samples (the
/// diagonal of the hat matrix; Hoaglin & Welsch 1978).
fn left_by(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
    shared: usize,
) -> Vec<f64> {
    let nothing = Unknowns::new(model, &[]);
    let channels = record.channels.len();
    let (mut squares, mut counts) = (vec![0.0; channels], vec![0usize; channels]);
    let mut taken = vec![0.0; channels];
    for window in windows {
        let mut rows: Vec<(usize, DVector<f64>)> = vec![];
        let system = normal_observed(record, window, model, values, &nothing, &[], &mut |one| {
            squares[one.channel] += one.residual * one.residual;
            counts[one.channel] += 1;
            rows.push((one.channel, DVector::from_column_slice(one.sensitivity)));
        });
        // A combination of unknowns that the window does not determine uses no degree of freedom.
        let Some(inverse) = pseudo_inverse(&system.hessian) else {
            continue;
        };
        for (channel, row) in rows {
            taken[channel] += row.dot(&(&inverse * &row));
        }
    }
    let all = counts.iter().sum::<usize>().max(1) as f64;
    (0..channels)
        .map(|at| {
            let share = shared as f64 * counts[at] as f64 / all;
            let freedom = counts[at] as f64 - taken[at] - share;
            if freedom >= 1.0 {
                record.channels[at].noise_std * (squares[at] / freedom).sqrt()
            } else {
                f64::INFINITY
            }
        })
        .collect()
}

fn pseudo_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let largest = matrix.amax();
    matrix.clone().pseudo_inverse(SINGULAR * largest).ok()
}
