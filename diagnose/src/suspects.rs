//! Which effects of the library could be missing, and what each of them promises.

use identify::{
    Effort, Minimum, Output, Record, RecordedCurrent, Setup, Unknowns, carry_over,
    fit_from_scratch, joined, promise, refit, scaled_start,
};
use plant::{EffectId, Kind, Model, Role};
use rayon::prelude::*;

use crate::candidate::Candidate;

/// A start from which an effect may be fitted.
#[derive(Clone, Debug)]
struct Start {
    effect: EffectId,
    model: Model,
    values: Vec<f64>,
    /// Cost that one full step from here promises, in the windows of the score test.
    promised_cost: f64,
}

/// What a search works on.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    /// The bench with what is known of it.
    pub setup: &'a Setup,
    /// Its records.
    pub records: Vec<&'a Record>,
    /// Length of the short windows in s, where the model as it was drifts away from the logs.
    pub window_s: Option<f64>,
    /// The effects that are tried.
    pub suspects: &'a [EffectId],
}

/// Most suspects that are fitted in one round; the score test has sorted out the others.
pub const MOST_FITS: usize = 8;
/// A suspect that promises less than this share of the best one's gain is not fitted.
const LEAST_SHARE: f64 = 0.1;
/// Least gain of a suspect in χ²: the 1e-5 point for two parameters, so that even twenty suspects on
/// white noise pass it once in five thousand benches.
pub const LEAST_GAIN: f64 = 23.0;

/// Whether any record of the bench can show the effect at all.
pub fn applicable(setup: &Setup, effect: EffectId) -> bool {
    let info = effect.info();
    setup.records.iter().any(|record| {
        let commanded = matches!(record.current, RecordedCurrent::Known(_));
        let sees = match info.role {
            Role::Body => record.kind != Kind::SpinUp,
            Role::Wheel => record.kind != Kind::FreeSwing,
            Role::Motor => {
                let electrical = matches!(
                    effect,
                    EffectId::InputDelay | EffectId::MotorLag | EffectId::BackEmfLimit
                );
                record.kind != Kind::FreeSwing
                    && commanded
                    && !(electrical && record.current_is_measured)
            }
            Role::Sensor => match effect {
                EffectId::AngleOffset => record.channel(Output::Angle).is_some(),
                _ => record.channel(Output::Rate).is_some(),
            },
        };
        sees && info.shows_in.contains(&record.kind)
    })
}

/// The starts of an effect on top of a fitted model.
fn starts(bench: &Bench, from: &Candidate, point: &Minimum, effect: EffectId) -> Vec<Start> {
    let (setup, records) = (bench.setup, &bench.records);
    let model = from.model.with(effect);
    let Some(at) = model.position(effect) else {
        return vec![];
    };
    let base = [0, 1, 2, 3].map(|position| point.values[position]);
    let info = effect.info();
    let mut parameter_sets: Vec<Vec<f64>> = info
        .starts
        .iter()
        .map(|start| scaled_start(effect, start, &base))
        .collect();
    // An effect that is linear in its one amplitude is scored where it is absent.
    if let (Some(absent), [_]) = (info.absent, info.starts)
        && info.parameters.len() == 1
        && info.replaces.is_empty()
    {
        parameter_sets = vec![absent.to_vec()];
    }
    if effect == EffectId::WheelCogging {
        parameter_sets = cogging_starts(records, from);
    }
    parameter_sets
        .into_iter()
        .map(|chosen| {
            let mut start = vec![0.0; model.parameter_count()];
            start[at..at + chosen.len()].copy_from_slice(&chosen);
            let values = carry_over(&from.model, &point.values, &model, &start);
            let unknowns = Unknowns::new(&model, &setup.free(&model));
            let promised = promise(records, &model, &values, &point.windows, &unknowns);
            Start {
                effect,
                model: model.clone(),
                values,
                promised_cost: promised.promised_cost,
            }
        })
        .collect()
}

/// Starts for cogging: the orders whose trace is largest in the wheel speed.
///
/// A torque a sin(nφ + ψ) on a wheel that turns at φ̇ leaves the speed error
/// a/(j_w n φ̇) cos(nφ + ψ): for every whole order n up to 60 the residual is projected on
/// cos(nφ)/φ̇ and sin(nφ)/φ̇, with φ from the fitted model, and the three best orders are returned.
/// A cogging order is a whole number: a common multiple of poles and slots.
fn cogging_starts(records: &[&Record], from: &Candidate) -> Vec<Vec<f64>> {
    const HIGHEST_ORDER: usize = 60;
    let wheel_inertia = from.minimum.values[plant::WHEEL_INERTIA];
    let mut gains: Vec<(f64, Vec<f64>)> = vec![];
    let mut series: Vec<(f64, f64, f64)> = vec![];
    for ((record, windows), traces) in records.iter().zip(&from.minimum.windows).zip(&from.traces) {
        if record.kind != Kind::SpinUp {
            continue;
        }
        for (channel, trace) in record.channels.iter().zip(traces) {
            for window in windows {
                identify::simulate(
                    record,
                    window,
                    &from.model,
                    &from.minimum.values,
                    |k, _, state| {
                        let error = channel.samples[k] - trace.predicted[k];
                        let speed = state.wheel_speed_rad_s;
                        // Below a turn in ten seconds the trace is no longer a ripple.
                        if error.is_finite() && speed.abs() > 0.6 {
                            series.push((state.wheel_angle_rad, speed, error / channel.noise_std));
                        }
                    },
                );
            }
        }
    }
    for order in 1..=HIGHEST_ORDER {
        let n = order as f64;
        let (mut cc, mut ss, mut cs, mut ce, mut se) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for &(angle, speed, error) in &series {
            let (sin, cos) = (n * angle).sin_cos();
            let (c, s) = (cos / speed, sin / speed);
            cc += c * c;
            ss += s * s;
            cs += c * s;
            ce += c * error;
            se += s * error;
        }
        let determinant = cc * ss - cs * cs;
        if determinant <= 0.0 {
            continue;
        }
        let (a, b) = (
            (ss * ce - cs * se) / determinant,
            (cc * se - cs * ce) / determinant,
        );
        let gain = a * ce + b * se;
        let noise = records
            .iter()
            .filter(|record| record.kind == Kind::SpinUp)
            .flat_map(|record| &record.channels)
            .map(|channel| channel.noise_std)
            .fold(0.0, f64::max);
        // cos(nφ + ψ) = cos ψ cos nφ − sin ψ sin nφ, and φ̈ = −(a/j_w) sin(nφ + ψ) integrates to
        // +a/(j_w n φ̇) cos(nφ + ψ).
        let amplitude = a.hypot(b) * noise * wheel_inertia * n;
        gains.push((gain, vec![amplitude.max(1e-12), n, (-b).atan2(a)]));
    }
    gains.sort_by(|x, y| y.0.total_cmp(&x.0));
    gains.truncate(3);
    gains.into_iter().map(|(_, start)| start).collect()
}

/// Fits an effect on top of `from`, from the two starts that promise most: first in the windows of
/// the score test, then over the whole logs.
fn fit_best(
    bench: &Bench,
    from: &Candidate,
    point: &Minimum,
    mut starts: Vec<Start>,
) -> Option<Candidate> {
    let (setup, records) = (bench.setup, &bench.records);
    starts.sort_by(|a, b| a.promised_cost.total_cmp(&b.promised_cost));
    let mut best: Option<(Minimum, Start)> = None;
    for start in starts.into_iter().take(2) {
        let minimum = refit(
            records,
            &start.model,
            start.values.clone(),
            point.windows.clone(),
            &setup.free(&start.model),
            if bench.window_s.is_some() {
                Effort::FULL
            } else {
                Effort::ROUGH
            },
        );
        if best
            .as_ref()
            .is_none_or(|(best, _)| minimum.cost < best.cost)
        {
            best = Some((minimum, start));
        }
    }
    let (rough, start) = best?;
    let free = setup.free(&start.model);
    let windows = records
        .iter()
        .zip(&rough.windows)
        .map(|(record, shorter)| joined(record, &rough.values, shorter))
        .collect();
    let mut minimum = refit(
        records,
        &start.model,
        rough.values.clone(),
        windows,
        &free,
        Effort::FULL,
    );
    if minimum.cost > from.minimum.cost {
        let again = fit_from_scratch(records, &start.model, rough.values.clone(), &free);
        if again.cost < minimum.cost {
            minimum = again;
        }
    }
    // A larger model never fits worse than one that it contains: where the effect can be absent,
    // the smaller model's minimum is one of its points.
    if minimum.cost > from.minimum.cost
        && let (Some(absent), Some(at)) = (
            start.effect.info().absent,
            start.model.position(start.effect),
        )
        && start.effect.info().replaces.is_empty()
    {
        let mut values = start.values.clone();
        values[at..at + absent.len()].copy_from_slice(absent);
        let again = refit(
            records,
            &start.model,
            values,
            from.minimum.windows.clone(),
            &free,
            Effort::FULL,
        );
        if again.cost < minimum.cost {
            minimum = again;
        }
    }
    let mut added = from.added.clone();
    added.retain(|effect| start.model.has(*effect));
    added.push(start.effect);
    Some(Candidate::new(
        setup,
        records,
        added,
        start.model,
        minimum,
        bench.window_s.map(|_| rough),
    ))
}

/// Tries every applicable effect on top of `from`: a score test for all, a full refit for those
/// that promise something.
pub fn try_all(bench: &Bench, from: &Candidate, most: usize) -> Vec<Candidate> {
    let suspects: Vec<EffectId> = bench
        .suspects
        .iter()
        .copied()
        .filter(|&effect| from.model.with(effect) != from.model && applicable(bench.setup, effect))
        .collect();
    let point = match &from.windowed {
        Some(windowed) => windowed,
        None => &from.minimum,
    };
    let mut screened: Vec<(f64, Vec<Start>)> = suspects
        .par_iter()
        .map(|&effect| {
            let starts = starts(bench, from, point, effect);
            let best = starts
                .iter()
                .map(|start| start.promised_cost)
                .fold(f64::INFINITY, f64::min);
            (point.cost - best, starts)
        })
        .collect();
    // Where an effect and one that contains it are both suspects, the simpler one goes first: the
    // larger one is tried on top of it in the next round.
    let gains: Vec<(EffectId, f64)> = screened
        .iter()
        .filter_map(|(gain, starts)| Some((starts.first()?.effect, *gain)))
        .collect();
    screened.retain(|(_, starts)| {
        starts.first().is_some_and(|start| {
            !start.effect.info().replaces.iter().any(|contained| {
                gains
                    .iter()
                    .any(|(effect, gain)| effect.name() == *contained && *gain > LEAST_GAIN)
            })
        })
    });
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best_gain = screened.first().map_or(0.0, |(gain, _)| *gain);
    screened.retain(|(gain, _)| *gain > LEAST_GAIN.max(LEAST_SHARE * best_gain));
    screened.truncate(most.min(MOST_FITS));
    screened
        .into_par_iter()
        .filter_map(|(_, starts)| fit_best(bench, from, point, starts))
        .collect()
}

/// Refits a candidate without one of its effects.
pub fn without(bench: &Bench, from: &Candidate, effect: EffectId) -> Candidate {
    let (setup, records) = (bench.setup, &bench.records);
    let model = from.model.without(effect);
    let free = setup.free(&model);
    let again = |minimum: &Minimum| -> Minimum {
        let start = vec![0.0; model.parameter_count()];
        let values = carry_over(&from.model, &minimum.values, &model, &start);
        let windows = minimum.windows.clone();
        refit(records, &model, values, windows, &free, Effort::FULL)
    };
    let minimum = again(&from.minimum);
    let windowed = from.windowed.as_ref().map(again);
    let mut added = from.added.clone();
    added.retain(|&present| present != effect);
    Candidate::new(setup, records, added, model, minimum, windowed)
}
