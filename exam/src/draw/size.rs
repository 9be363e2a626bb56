//! The logs of a bench, and the amplitude at which a hidden term has the drawn size.

use identify::{
    Effort, FitProblem, Minimum, PredictedSeries, Record, final_windows, refit, traces,
};
use plant::Model;

use super::experiments::Choice;
use super::shape::TermShape;
use crate::bench_plan::{ChannelNoise, ExamLog, is_usable, record};
use crate::truth::{Hidden, Truth};

/// The logs of a seed as the fit uses them, with and without noise. The stated noise level is the true one.
pub struct Made {
    /// The bench that the exam gives to the diagnosis.
    pub noisy: FitProblem,
    /// The same bench without noise. The channels keep the noise level as their scale.
    pub clean: FitProblem,
}

/// Simulates the logs of a bench; `None` if they do not form a usable bench.
pub fn make(truth: &Truth, choice: &Choice, noise: &ChannelNoise, seed: u64) -> Option<Made> {
    let mut records = vec![];
    let mut logs: Vec<ExamLog> = vec![];
    for (index, plan) in choice.plans.iter().enumerate() {
        let log = record(
            truth,
            plan,
            noise,
            seed.wrapping_mul(64).wrapping_add(index as u64),
        );
        if !is_usable(plan, &log) {
            continue;
        }
        let outputs = [
            Some(log.measured[0].clone()),
            choice.has_rate.then(|| log.measured[1].clone()),
            Some(log.measured[2].clone()),
        ];
        records.push(Record::new(
            &plan.name,
            plan.kind,
            log.time_s.clone(),
            outputs,
            Some(log.current_a.clone()),
            false,
        ));
        logs.push(log);
    }
    let noisy = FitProblem::from_records(records, choice.known, choice.measured).ok()?;
    let mut clean = noisy.clone();
    for (record, log) in clean.records.iter_mut().zip(&logs) {
        for channel in &mut record.channels {
            let index = channel.output as usize;
            channel.samples = log.clean[index].clone();
            channel.noise_std = noise.std[index];
            channel.quantum = None;
        }
    }
    Some(Made { noisy, clean })
}

/// Largest root mean square error over all series in units of noise.
pub fn worst(records: &[&Record], traces: &[Vec<PredictedSeries>]) -> f64 {
    records
        .iter()
        .zip(traces)
        .flat_map(|(record, traces)| {
            record
                .channels
                .iter()
                .zip(traces)
                .map(|(channel, trace)| trace.rmse / channel.noise_std)
        })
        .fold(0.0, f64::max)
}

/// The base model, refitted to the logs without noise.
pub struct BaseFit {
    /// The fit.
    pub minimum: Minimum,
    /// For every record and channel: the prediction compared with the measurement.
    pub traces: Vec<Vec<PredictedSeries>>,
}

/// The trace of the hidden terms after the base model has been refitted, in units of noise.
fn size_of(clean: &FitProblem, truth: &Truth) -> Option<f64> {
    let fit = base_fit(clean, truth)?;
    Some(worst(&clean.all_records(), &fit.traces))
}

/// Refits the base model to the logs without noise, from the true parameters.
pub fn base_fit(clean: &FitProblem, truth: &Truth) -> Option<BaseFit> {
    let records = clean.all_records();
    let model = Model::base();
    let [a, b, c, d] = truth.base;
    let mut values = vec![a, b, c, d, truth.body_viscous, truth.wheel_viscous];
    for (value, known) in values.iter_mut().zip(clean.known) {
        *value = known.unwrap_or(*value);
    }
    let windows = records
        .iter()
        .map(|record| final_windows(record, &values))
        .collect();
    let effort = Effort {
        evaluations: 15,
        tolerance: 1e-3,
        ..Effort::FULL
    };
    let minimum = refit(
        &records,
        &model,
        values,
        windows,
        &clean.free(&model),
        effort,
    );
    if !minimum.cost.is_finite() {
        return None;
    }
    let traces = records
        .iter()
        .zip(&minimum.windows)
        .map(|(record, windows)| traces(record, windows, &model, &minimum.values))
        .collect();
    Some(BaseFit { minimum, traces })
}

/// The amplitude at which a term has the drawn size. The secant method in logarithms finds it.
pub fn sized(
    truth: &Truth,
    choice: &Choice,
    noise: &ChannelNoise,
    seed: u64,
    shape: &TermShape,
    wanted: f64,
) -> Option<(Hidden, f64)> {
    const ROUNDS: usize = 8;
    // Largest factor from the first guess. No real bench lies beyond it, and a lag of nanoseconds would make the
    // simulation take hours.
    const FARTHEST: f64 = 1e4;
    let mut s = shape.guess;
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..ROUNDS {
        if (s / shape.guess).ln().abs() > FARTHEST.ln() {
            return None;
        }
        let hidden = (shape.make)(s);
        let there = truth.with(vec![hidden.clone()]);
        let found = make(&there, choice, noise, seed).and_then(|made| size_of(&made.clean, &there));
        let Some(found) = found.filter(|found| found.is_finite() && *found > 0.0) else {
            s *= 0.1;
            continue;
        };
        if (found / wanted).ln().abs() < 0.1 {
            return Some((hidden, found));
        }
        let slope = match before {
            Some((s0, found0)) if (s / s0).ln().abs() > 1e-6 => {
                ((found / found0).ln() / (s / s0).ln()).clamp(0.5, 3.0)
            }
            _ => 1.0,
        };
        before = Some((s, found));
        s *= ((wanted / found).ln() / slope).clamp(-4.0, 4.0).exp();
    }
    None
}
