//! The score test: the gain that each suspect promises, and the starting points for its fit.

use identify::{
    KnownScore, MAX_UNKNOWNS, Minimum, Nuisance, Output, Record, ScoreStep, Unknowns, Window,
    carry_over, cogging_start, guessed, score_test, settled, shaped_start,
};
use parallel::parallel_map;
use plant::{EffectId, Model, Role, StartFrom};

use crate::applicable::refines;
use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::economy::MOST_LOCALS;

/// A starting point for the fit of an effect.
#[derive(Clone, Debug)]
pub struct Start {
    /// The effect.
    pub effect: EffectId,
    /// The model with the effect.
    pub model: Model,
    /// Values of all parameters of that model, in SI units.
    pub values: Vec<f64>,
    /// Cost (χ²) that one full Gauss-Newton step from here promises, in the windows of the score test.
    pub promised_cost: f64,
    /// The windows from which the fit starts, if they differ from those of the fitted model.
    pub windows: Option<Vec<Vec<Window>>>,
}

/// Whether an effect is scored at zero amplitude: it is linear in its only parameter there, and replaces no other
/// effect.
pub fn is_scored_where_absent(effect: EffectId) -> bool {
    let info = effect.info();
    info.absent.is_some()
        && info.starts.len() == 1
        && info.parameters.len() == 1
        && info.replaces.is_empty()
}

/// The starting points of the effects that are scored at zero amplitude. The motion is then that of the fitted
/// model, so one simulation carries the sensitivities to many effects at once. The score of each effect
/// is computed with the amplitudes of the others held at zero.
pub fn absent_starts(
    bench: &SearchBench,
    from: &Candidate,
    point: &Minimum,
    known: KnownScore,
    effects: &[EffectId],
) -> Vec<Start> {
    let (problem, records) = (bench.problem, &bench.records);
    let room = MAX_UNKNOWNS
        .saturating_sub(problem.free(&from.model).len() + MOST_LOCALS)
        .max(1);
    let with = |model: &Model, values: &[f64], effect: EffectId| {
        let larger = model.with(effect);
        let mut start = vec![0.0; larger.parameter_count()];
        if let (Some(at), Some([absent])) = (larger.position(effect), effect.info().absent) {
            start[at] = *absent;
        }
        let values = carry_over(model, values, &larger, &start);
        (larger, values)
    };
    parallel_map(effects.chunks(room), |group| {
        let (mut model, mut values) = (from.model.clone(), point.values.clone());
        for &effect in group {
            (model, values) = with(&model, &values, effect);
        }
        let unknowns = Unknowns::new(&model, &problem.free(&model));
        let windows = &point.windows;
        let score_test = score_test(records, &model, &values, windows, &unknowns, Some(known));
        let own: Vec<Option<usize>> = group.iter().map(|&e| model.position(e)).collect();
        group
            .iter()
            .map(|&effect| {
                let moves: Vec<bool> = unknowns
                    .free
                    .iter()
                    .map(|&at| model.position(effect) == Some(at) || !own.contains(&Some(at)))
                    .collect();
                let promised_cost = score_test.step(&values, &unknowns, &moves).cost;
                let (model, values) = with(&from.model, &point.values, effect);
                Start {
                    effect,
                    model,
                    values,
                    promised_cost,
                    windows: None,
                }
            })
            .collect::<Vec<_>>()
    })
    .into_iter()
    .flatten()
    .collect()
}

/// The starting points of an effect on top of the model of `known`. That model was fitted over the whole logs
/// (`whole`) and in the windows of the score test (`point`).
pub fn starts(
    bench: &SearchBench,
    whole: &Minimum,
    point: &Minimum,
    known: KnownScore,
    effect: EffectId,
) -> Vec<Start> {
    let (problem, records) = (bench.problem, &bench.records);
    let model = known.model.with(effect);
    let Some(at) = model.position(effect) else {
        return vec![];
    };
    let base = [0, 1, 2, 3].map(|position| point.values[position]);
    let info = effect.info();
    let mut parameter_sets = problem.starts(records, effect, &base);
    if let (Some(absent), true) = (info.absent, is_scored_where_absent(effect)) {
        parameter_sets = vec![absent.to_vec()];
    }
    if info.polar.is_some() {
        // A small vector in any direction promises the same.
        parameter_sets.truncate(1);
    }
    if let Some((amplitude, _)) = info.product {
        for set in &mut parameter_sets {
            set[amplitude] = HARDLY_THERE * base[plant::GRAVITY_TORQUE];
        }
    }
    if let (EffectId::External(_), Some(stated)) = (effect, parameter_sets.first()) {
        // A torque over a narrow range is not found from a start elsewhere; the missing torque shows where it is.
        parameter_sets.extend(shaped_start(records, known.model, whole, effect, stated));
    }
    let mut needs_settling = false;
    if matches!(info.start_from, StartFrom::Ripple) {
        let start = cogging_start(records, known.model, whole);
        let missed = point.cost - bench.noise_cost();
        let least = bench.thresholds.least_gain;
        needs_settling = start
            .as_ref()
            .is_some_and(|start| start.gain > least.max(bench.thresholds.least_part * missed));
        parameter_sets = start.map(|start| start.parameters).into_iter().collect();
    }
    let torque_constant = base[plant::TORQUE_CONSTANT];
    if info.is_limit {
        parameter_sets.retain(|set| is_reached(effect, records, set, torque_constant));
    }
    // A refinement is tried on top of the effect that it refines, with several shapes. A shape is useful if it
    // promises a gain as it stands, with only the other parameters adapted. A step that also changes the shape
    // promises gains that do not hold far from the fit. The last shape is nearest to the refined effect and may
    // still change.
    let is_taking_over = refines(effect, known.model);
    let own = at..at + info.parameters.len();
    let last = parameter_sets.len().saturating_sub(1);
    parameter_sets
        .into_iter()
        .enumerate()
        .filter_map(|(index, chosen)| {
            let mut start = vec![0.0; model.parameter_count()];
            start[at..at + chosen.len()].copy_from_slice(&chosen);
            let mut values = carry_over(known.model, &point.values, &model, &start);
            // A refinement starts with the parameter of the effect that it refines. The promised gain is then that of its
            // additional part alone.
            if let (Some((one, other)), true) = (info.limit, is_taking_over) {
                values[at + one] = values[at + other];
            }
            let unknowns = Unknowns::new(&model, &problem.free(&model));
            // Windows that start on the wrong side of a cogging tooth would promise no gain.
            let windows = if needs_settling {
                &settled(records, &model, &values, point.windows.clone())
            } else {
                &point.windows
            };
            // A limit that is not reached in a record does not change the prediction there.
            let leaves_no_trace = |record: &Record| {
                info.is_limit && !is_reached(effect, &[record], &chosen, torque_constant)
            };
            let known = KnownScore {
                leaves_no_trace: &leaves_no_trace,
                ..known
            };
            let score_test = score_test(records, &model, &values, windows, &unknowns, Some(known));
            let all = vec![true; unknowns.free.len()];
            let step = score_test.step(&values, &unknowns, &all);
            let promised_cost = step.cost;
            if is_taking_over && index < last {
                let infos = model.parameters();
                let moves: Vec<bool> = unknowns
                    .free
                    .iter()
                    .map(|&at| !(own.contains(&at) && infos[at].logarithmic))
                    .collect();
                let held_cost = score_test.step(&values, &unknowns, &moves).cost;
                if point.cost - held_cost < bench.least_gain {
                    return None;
                }
            }
            if let Some((amplitude, phase)) = info.polar {
                turn(&mut values, (at + amplitude, at + phase), &unknowns, &step);
            }
            Some(Start {
                effect,
                model: model.clone(),
                values,
                promised_cost,
                windows: None,
            })
        })
        .collect()
}

/// Brings an amplitude and its phase to the vector to which a step points from a small one. The step is
/// linear in the vector and not in its phase, which may have to turn far.
fn turn(
    values: &mut [f64],
    (amplitude, phase): (usize, usize),
    unknowns: &Unknowns,
    step: &ScoreStep,
) {
    let of = |position: usize| {
        let at = unknowns.free.iter().position(|&free| free == position);
        at.map_or(0.0, |at| step.step[at])
    };
    let along = values[amplitude] + of(amplitude);
    let across = values[amplitude] * of(phase);
    if along.is_finite() && across.is_finite() {
        values[phase] += across.atan2(along);
        values[amplitude] = along.hypot(across);
    }
}

/// A starting point for an effect that shifts the angle's zero. The zero (`angle_zero_rad`, in rad) and the inertia,
/// gravity and friction are those that the free swings show directly.
pub fn zero_start(
    bench: &SearchBench,
    point: &Minimum,
    absent: &Start,
    angle_zero_rad: f64,
) -> Start {
    let model = absent.model.clone();
    let shown = bench.problem.start_values(&model);
    let mut values = absent.values.clone();
    values[..plant::BASE_PARAMETERS.len()].copy_from_slice(&shown[..plant::BASE_PARAMETERS.len()]);
    for &effect in model.effects() {
        let info = effect.info();
        let Some(at) = model.position(effect) else {
            continue;
        };
        match info.start_from {
            StartFrom::AngleZero => values[at] = angle_zero_rad,
            StartFrom::Damping if info.role == Role::Body => values[at] = shown[at],
            _ => {}
        }
    }
    let unknowns = Unknowns::new(&model, &bench.problem.free(&model));
    let all = vec![true; unknowns.free.len()];
    // The body's starting angle is the measured one minus the zero.
    let mut windows = vec![];
    for (record, fitted) in bench.records.iter().zip(&point.windows) {
        windows.push(guessed(record, &values, fitted));
    }
    for (record, windows) in bench.records.iter().zip(&mut windows) {
        let nuisances = Nuisance::of(record);
        if let Some(at) = nuisances.iter().position(|&local| local == Nuisance::Angle) {
            for window in windows {
                window.nuisances[at] -= angle_zero_rad;
            }
        }
    }
    let score_test = score_test(&bench.records, &model, &values, &windows, &unknowns, None);
    Start {
        effect: absent.effect,
        promised_cost: score_test.step(&values, &unknowns, &all).cost,
        model,
        values,
        windows: Some(windows),
    }
}

/// Whether any record reaches the limit with these parameters `p`. `torque_constant` is in N m/A.
fn is_reached(effect: EffectId, records: &[&Record], p: &[f64], torque_constant: f64) -> bool {
    records.iter().any(|record| {
        record.channel(Output::WheelSpeed).is_some_and(|channel| {
            let mut at = channel.samples.iter().zip(&record.current_a);
            at.any(|(speed, current)| effect.is_reached(p, *current, *speed, torque_constant))
        })
    })
}

/// Amplitude, in units of the gravity torque, at which the score of a stretched cable is computed. Its torque is
/// linear in the amplitude and in the product of the amplitude with another parameter. At zero amplitude the
/// product would have no influence. At this value the phase after a hundred swings changes by less than 1e-3 rad.
const HARDLY_THERE: f64 = 1e-6;

/// The starting points of a refinement on top of a `model` that has the effect to be refined. `fit` is the fit of
/// that model in the windows of the score test, `whole` that of the smaller model over the whole logs.
pub fn refined_starts(
    bench: &SearchBench,
    whole: &Minimum,
    (model, fit): (&Model, &Minimum),
    effect: EffectId,
) -> Vec<Start> {
    let unknowns = Unknowns::new(model, &bench.problem.free(model));
    let score_test = score_test(
        &bench.records,
        model,
        &fit.values,
        &fit.windows,
        &unknowns,
        None,
    );
    let known = KnownScore {
        model,
        values: &fit.values,
        unknowns: &unknowns,
        score_test: &score_test,
        leaves_no_trace: &|_| false,
    };
    let mut starts = starts(bench, whole, fit, known, effect);
    for start in &mut starts {
        start.windows = Some(fit.windows.clone());
    }
    starts.retain(|start| fit.cost - start.promised_cost >= bench.least_gain);
    starts
}
