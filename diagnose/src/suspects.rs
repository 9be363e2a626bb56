//! Which effects of the library could be missing, and what each of them promises.

use identify::{
    Effort, KnownPromise, Local, MAX_UNKNOWNS, Minimum, Output, Record, RecordedCurrent, Setup,
    Unknowns, Window, acts, carry_over, cogging_start, cost, fit_from_scratch, guessed, joined,
    promise, rate_against_angle, ratios, refit, settled,
};
use plant::{EffectId, Kind, Model, Role};
use rayon::prelude::*;

use crate::candidate::Candidate;
use crate::search::{LEAST_TRACE, leaves_nothing};

/// A start from which an effect may be fitted.
#[derive(Clone, Debug)]
struct Start {
    effect: EffectId,
    model: Model,
    values: Vec<f64>,
    /// Cost that one full step from here promises, in the windows of the score test.
    promised_cost: f64,
    /// The windows of the score test where they do not start as those of the fitted model.
    windows: Option<Vec<Vec<Window>>>,
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
    /// Least gain in χ² for which one of them is fitted.
    pub least_gain: f64,
}

impl<'a> Bench<'a> {
    /// A bench whose logs are read in one piece.
    pub fn whole(setup: &'a Setup, suspects: &'a [EffectId]) -> Bench<'a> {
        Bench {
            setup,
            records: setup.all_records(),
            window_s: None,
            suspects,
            least_gain: LEAST_GAIN,
        }
    }

    /// The cost that is expected of noise alone: one for every observation.
    fn noise_cost(&self) -> f64 {
        let observed = self.records.iter().map(|record| record.observations());
        observed.sum::<usize>() as f64
    }
}

/// Most unknowns that a window has of its own.
const MOST_LOCALS: usize = 6;
/// Most starts of one suspect that are fitted.
const MOST_STARTS: usize = 2;
/// Share of the cost in short windows whose gain makes a fit over the whole logs that brings nothing
/// worth a second schedule from short windows to long ones.
const MUCH: f64 = 0.1;
/// A fit that brings this share of what another start promises makes that start needless.
const KEPT_SHARE: f64 = 0.9;
/// Most suspects that are fitted in one round; the score test has sorted out the others.
pub const MOST_FITS: usize = 8;
/// A suspect that promises less than this share of the best one's gain is not fitted.
const LEAST_SHARE: f64 = 0.1;
/// An effect that takes less than this part of what the model misses in the experiments in which it
/// acts is not what is missing there: an unknown cause looks a little like everything. Beside what is
/// missing it may be real, and is found once that has been added.
const LEAST_PART: f64 = 0.01;
/// An effect goes before one that contains it if it promises at least this share of its gain.
const SIMPLER_SHARE: f64 = 0.9;
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

/// Standard errors by which a fault of the gyroscope must show against the angle.
const PLAIN_FAULT: f64 = 3.0;

/// Whether the measured angle itself, without any model of the motion, speaks against this fault of the
/// gyroscope: what the model lacks would only be laid at its door.
pub fn is_cleared(records: &[&Record], effect: EffectId) -> bool {
    let (fault, std) = match (effect, rate_against_angle(records)) {
        (EffectId::GyroScale, Some(found)) => (found.scale_error, found.scale_error_std),
        (EffectId::GyroBias, Some(found)) => (found.bias_rad_s, found.bias_std_rad_s),
        _ => return false,
    };
    fault.abs() < PLAIN_FAULT * std
}

/// The terms of a power series in the angle: a constant, a linear and a cubic torque. All three together fit
/// any smooth torque that depends on the angle, whatever it comes from (a stop, a magnet); that is a
/// curve through the measurements and no explanation of them.
const POWER_SERIES: [EffectId; 3] = [
    EffectId::AngleOffset,
    EffectId::BodyCableSpring,
    EffectId::BodySofteningSpring,
];

/// Whether an effect would complete the series in a model, whatever of it stood there before.
fn completes_series(model: &Model, effect: EffectId) -> bool {
    let with = model.with(effect);
    POWER_SERIES.contains(&effect) && POWER_SERIES.iter().all(|&term| with.has(term))
}

/// Whether an effect is scored where it is absent: it is linear in its one amplitude there, and takes
/// no other effect's place.
fn is_scored_where_absent(effect: EffectId) -> bool {
    let info = effect.info();
    info.absent.is_some()
        && info.starts.len() == 1
        && info.parameters.len() == 1
        && info.replaces.is_empty()
}

/// The starts of effects that are scored where they are absent. The motion there is that of the fitted
/// model, so that one simulation carries the sensitivities of many of them: the score of each is that
/// of the model in which the amplitudes of the others stay at zero.
fn absent_starts(
    bench: &Bench,
    from: &Candidate,
    point: &Minimum,
    known: KnownPromise,
    effects: &[EffectId],
) -> Vec<Start> {
    let (setup, records) = (bench.setup, &bench.records);
    let room = MAX_UNKNOWNS
        .saturating_sub(setup.free(&from.model).len() + MOST_LOCALS)
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
    effects
        .par_chunks(room)
        .flat_map(|group| {
            let (mut model, mut values) = (from.model.clone(), point.values.clone());
            for &effect in group {
                (model, values) = with(&model, &values, effect);
            }
            let unknowns = Unknowns::new(&model, &setup.free(&model));
            let windows = &point.windows;
            let promise = promise(records, &model, &values, windows, &unknowns, Some(known));
            let own: Vec<Option<usize>> = group.iter().map(|&e| model.position(e)).collect();
            group
                .iter()
                .map(|&effect| {
                    let moves: Vec<bool> = unknowns
                        .free
                        .iter()
                        .map(|&at| model.position(effect) == Some(at) || !own.contains(&Some(at)))
                        .collect();
                    let promised_cost = promise.step(&values, &unknowns, &moves).cost;
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
        .collect()
}

/// The starts of an effect on top of the model of `known`, fitted over the `whole` logs and, in the windows of
/// the score test, to `point`.
fn starts(
    bench: &Bench,
    whole: &Minimum,
    point: &Minimum,
    known: KnownPromise,
    effect: EffectId,
) -> Vec<Start> {
    let (setup, records) = (bench.setup, &bench.records);
    let model = known.model.with(effect);
    let Some(at) = model.position(effect) else {
        return vec![];
    };
    let base = [0, 1, 2, 3].map(|position| point.values[position]);
    let info = effect.info();
    let mut parameter_sets = setup.starts(records, effect, &base);
    if let (Some(absent), true) = (info.absent, is_scored_where_absent(effect)) {
        parameter_sets = vec![absent.to_vec()];
    }
    if effect == EffectId::BodyCableSpring {
        for set in &mut parameter_sets {
            set[0] = HARDLY_STRETCHED * base[plant::GRAVITY_TORQUE];
        }
    }
    let mut needs_settling = false;
    if effect == EffectId::WheelCogging {
        let start = cogging_start(records, known.model, whole);
        let missed = point.cost - records.iter().map(|r| r.observations() as f64).sum::<f64>();
        needs_settling = start
            .as_ref()
            .is_some_and(|start| start.gain > LEAST_GAIN.max(LEAST_PART * missed));
        parameter_sets = start.map(|start| start.parameters).into_iter().collect();
    }
    if effect == EffectId::BackEmfLimit {
        parameter_sets.retain(|set| is_reached(records, set, base[plant::TORQUE_CONSTANT]));
    }
    // On top of the effect that it refines, a shape is of use if it takes something of the misfit as it
    // stands, the rest of the parameters adapted to it. What a step promises that changes the shape as well
    // is no measure far from the fit. The last shape is nearest to what is refined, and may still change.
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
            // What refines another effect starts as that effect: what it promises is then what its own
            // part would add to a motion that is fitted already.
            if let (Some((one, other)), true) = (info.limit, is_taking_over) {
                values[at + one] = values[at + other];
            }
            let unknowns = Unknowns::new(&model, &setup.free(&model));
            // Windows that start on the wrong side of a tooth would promise nothing.
            let windows = if needs_settling {
                &settled(records, &model, &values, point.windows.clone())
            } else {
                &point.windows
            };
            // A limit that is not reached in a record leaves no trace there.
            let torque_constant = base[plant::TORQUE_CONSTANT];
            let leaves_no_trace = |record: &Record| {
                effect == EffectId::BackEmfLimit && !is_reached(&[record], &chosen, torque_constant)
            };
            let known = KnownPromise {
                leaves_no_trace: &leaves_no_trace,
                ..known
            };
            let promise = promise(records, &model, &values, windows, &unknowns, Some(known));
            let all = vec![true; unknowns.free.len()];
            let promised_cost = promise.step(&values, &unknowns, &all).cost;
            if is_taking_over && index < last {
                let infos = model.parameters();
                let moves: Vec<bool> = unknowns
                    .free
                    .iter()
                    .map(|&at| !(own.contains(&at) && infos[at].logarithmic))
                    .collect();
                let held_cost = promise.step(&values, &unknowns, &moves).cost;
                if point.cost - held_cost < bench.least_gain {
                    return None;
                }
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

/// A shifted zero of the angle beyond which a fit that does not know of it tells nothing: to first
/// order sin(α + b) is then wrong by half a percent.
const LARGE_ZERO_RAD: f64 = 0.1;

/// The start of an angle offset at the zero that the free swings themselves show, with the inertia,
/// gravity and friction that they show around it.
fn zero_start(bench: &Bench, point: &Minimum, absent: &Start, angle_zero_rad: f64) -> Start {
    let model = absent.model.clone();
    let shown = bench.setup.start_values(&model);
    let mut values = absent.values.clone();
    values[..plant::BASE_PARAMETERS.len()].copy_from_slice(&shown[..plant::BASE_PARAMETERS.len()]);
    for (effect, value) in [
        (EffectId::AngleOffset, Some(angle_zero_rad)),
        (EffectId::BodyViscousFriction, None),
    ] {
        if let Some(at) = model.position(effect) {
            values[at] = value.unwrap_or(shown[at]);
        }
    }
    let unknowns = Unknowns::new(&model, &bench.setup.free(&model));
    let all = vec![true; unknowns.free.len()];
    // The body starts as the samples show, less the zero.
    let mut windows = vec![];
    for (record, fitted) in bench.records.iter().zip(&point.windows) {
        windows.push(guessed(record, &values, fitted));
    }
    for (record, windows) in bench.records.iter().zip(&mut windows) {
        let locals = Local::of(record);
        if let Some(at) = locals.iter().position(|&local| local == Local::Angle) {
            for window in windows {
                window.locals[at] -= angle_zero_rad;
            }
        }
    }
    let promise = promise(&bench.records, &model, &values, &windows, &unknowns, None);
    Start {
        effect: EffectId::AngleOffset,
        promised_cost: promise.step(&values, &unknowns, &all).cost,
        model,
        values,
        windows: Some(windows),
    }
}

/// Whether the current of any record exceeds what a supply of these parameters (V, Ohm) could drive at
/// the measured wheel speed; where none does, the limit leaves no trace.
fn is_reached(records: &[&Record], supply: &[f64], torque_constant: f64) -> bool {
    records.iter().any(|record| {
        record.channel(Output::WheelSpeed).is_some_and(|channel| {
            let at = channel.samples.iter().zip(&record.current_a);
            at.into_iter().any(|(speed, current)| {
                let limit = (supply[0] - torque_constant * speed.abs()) / supply[1];
                current * speed > 0.0 && current.abs() > limit
            })
        })
    })
}

/// Stiffness of the hardly stretched cable at which the promise is computed, in gravity torques: the
/// phase of a hundred swings then changes by less than a thousandth of a radian.
const HARDLY_STRETCHED: f64 = 1e-6;

/// The effects beyond the diagnosed model after `effect` has been added to those of `from`, which made it
/// `model`.
fn added(from: &Candidate, model: &Model, effect: EffectId) -> Vec<EffectId> {
    let mut added = from.added.clone();
    added.retain(|present| model.has(*present));
    added.push(effect);
    added
}

/// The costs at which a fit on top of a candidate begins to matter. Once another one leaves nothing but
/// noise, an explanation that competes with it must take nearly as much of the misfit.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// In the windows of the score test.
    windows: f64,
    /// Over the whole logs.
    pub whole: f64,
}

impl Goal {
    /// Every fit matters.
    const ANY: Goal = Goal {
        windows: f64::INFINITY,
        whole: f64::INFINITY,
    };

    /// On top of `from`, beside a `leader` that leaves nothing.
    pub fn beside(from: &Candidate, leader: &Candidate) -> Goal {
        Goal {
            windows: within_reach(from.point().cost, leader.point().cost),
            whole: within_reach(from.minimum.cost, leader.minimum.cost),
        }
    }
}

/// The cost that takes [`KEPT_SHARE`] of what lies between two.
fn within_reach(from: f64, leader: f64) -> f64 {
    from - KEPT_SHARE * (from - leader)
}

/// A fit in the windows of the score test, and where it came from.
#[derive(Clone, Debug)]
struct Rough {
    minimum: Minimum,
    start: Start,
}

/// Fits an effect on top of `point` in the windows of the score test, from the starts that promise most.
/// `None` where that brings nothing: a fit that leaves the effect at nothing is that of the smaller model.
fn fit_roughly(bench: &Bench, point: &Minimum, mut starts: Vec<Start>, goal: f64) -> Option<Rough> {
    starts.sort_by(|a, b| a.promised_cost.total_cmp(&b.promised_cost));
    let effort = if bench.window_s.is_some() {
        Effort::SCORE
    } else {
        Effort::ROUGH
    };
    let mut best: Option<Rough> = None;
    for start in starts.into_iter().take(MOST_STARTS) {
        // What has been reached already, or nearly, no other start is tried for.
        let promised = KEPT_SHARE * (point.cost - start.promised_cost);
        if best.as_ref().is_some_and(|best| {
            point.cost - best.minimum.cost >= promised && !has_strayed(bench, best)
        }) {
            continue;
        }
        let minimum = refit(
            &bench.records,
            &start.model,
            start.values.clone(),
            start.windows.as_ref().unwrap_or(&point.windows).clone(),
            &bench.setup.free(&start.model),
            effort.towards(goal),
        );
        if best
            .as_ref()
            .is_none_or(|best| minimum.cost < best.minimum.cost)
        {
            best = Some(Rough { minimum, start });
        }
    }
    best.filter(|rough| point.cost - rough.minimum.cost >= bench.least_gain)
}

/// Cost, in that of the noise alone, above which a fit plainly misses something.
const STILL_MISSES: f64 = 2.0;

/// Whether a fit has come to the end of the range of one of its effect's own parameters and still misses
/// something: from another start it may come to a place that means something.
fn has_strayed(bench: &Bench, rough: &Rough) -> bool {
    let (start, minimum) = (&rough.start, &rough.minimum);
    let Some(at) = start.model.position(start.effect) else {
        return false;
    };
    let own = start.effect.info().parameters.iter();
    let is_at_end = own.zip(&minimum.values[at..]).any(|(info, value)| {
        let (low, high) = info.bounds;
        *value <= low || *value >= high
    });
    is_at_end && minimum.cost > STILL_MISSES * bench.noise_cost()
}

/// The parameters and windows from which the whole logs are fitted: those of the fit in short windows, or
/// those of the smaller model over the whole logs with the new effect's parameters, whichever lies nearer.
/// Where the free run drifts away the two are far apart, and a small effect moves neither.
fn whole_start(
    bench: &Bench,
    from: &Candidate,
    rough: &Minimum,
    start: &Start,
) -> (Vec<f64>, Vec<Vec<Window>>) {
    let records = &bench.records;
    let windows = joined(records, &rough.values, &rough.windows);
    if bench.window_s.is_none() {
        return (rough.values.clone(), windows);
    }
    let values = carry_over(
        &from.model,
        &from.minimum.values,
        &start.model,
        &rough.values,
    );
    let of = |values: &[f64], windows: &[Vec<Window>]| cost(records, &start.model, values, windows);
    if of(&values, &from.minimum.windows) < of(&rough.values, &windows) {
        (values, from.minimum.windows.clone())
    } else {
        (rough.values.clone(), windows)
    }
}

/// Fits an effect over the whole logs after [`fit_roughly`].
fn fit_whole(bench: &Bench, from: &Candidate, rough: Rough, goal: Goal) -> Candidate {
    let (setup, records) = (bench.setup, &bench.records);
    let point = from.point();
    let Rough {
        minimum: rough,
        start,
    } = rough;
    let free = setup.free(&start.model);
    let effort = Effort::FULL.towards(goal.whole);
    let (values, windows) = whole_start(bench, from, &rough, &start);
    let mut minimum = refit(records, &start.model, values, windows, &free, effort);
    // What brings much in short windows must bring something over the whole logs.
    let brings_much = point.cost - rough.cost > MUCH * point.cost;
    if minimum.cost > from.minimum.cost && brings_much && rough.cost <= goal.windows {
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
        let windows = from.minimum.windows.clone();
        let again = refit(records, &start.model, values, windows, &free, effort);
        if again.cost < minimum.cost {
            minimum = again;
        }
    }
    Candidate::new(
        setup,
        records,
        added(from, &start.model, start.effect),
        start.model,
        minimum,
        bench.window_s.map(|_| rough),
    )
}

/// Whether a start is that of an effect that takes the place of another one.
fn is_refinement(start: &Start) -> bool {
    !start.effect.info().replaces.is_empty()
}

/// Whether an effect takes the place of one that the model has.
fn refines(effect: EffectId, model: &Model) -> bool {
    let present = model.effects().iter();
    let names = effect.info().replaces;
    present
        .map(|one| one.name())
        .any(|name| names.contains(&name))
}

/// The best of those that were `reached` with effects that this one refines.
fn refined<T>(effect: EffectId, reached: &[(EffectId, T)], cost: impl Fn(&T) -> f64) -> Option<&T> {
    let replaces = effect.info().replaces;
    reached
        .iter()
        .filter(|(simpler, _)| replaces.contains(&simpler.name()))
        .map(|(_, reached)| reached)
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// The starts of a refinement on top of the fit of what it refines.
fn refined_starts(bench: &Bench, whole: &Minimum, simpler: &Rough, effect: EffectId) -> Vec<Start> {
    let (model, fit) = (&simpler.start.model, &simpler.minimum);
    let unknowns = Unknowns::new(model, &bench.setup.free(model));
    let promise = promise(
        &bench.records,
        model,
        &fit.values,
        &fit.windows,
        &unknowns,
        None,
    );
    let known = KnownPromise {
        model,
        values: &fit.values,
        unknowns: &unknowns,
        promise: &promise,
        leaves_no_trace: &|_| false,
    };
    let mut starts = starts(bench, whole, fit, known, effect);
    for start in &mut starts {
        start.windows = Some(fit.windows.clone());
    }
    starts.retain(|start| fit.cost - start.promised_cost >= bench.least_gain);
    starts
}

/// Fits the suspects that the score test has left in its windows, one after the other, those that promise most
/// first: what one reaches is known to the next, and each fit keeps the machine busy by itself. Then the
/// `refinements` of those on top of them. What remains takes what `least_gain` asks of an effect and a share
/// of what the best one takes, or is refined by what does.
fn fit_all_roughly(
    bench: &Bench,
    from: &Candidate,
    screened: Vec<Vec<Start>>,
    refinements: &[EffectId],
    least_gain: &dyn Fn(EffectId) -> f64,
    goal: Goal,
) -> Vec<(EffectId, Rough)> {
    let point = from.point();
    let noise = bench.noise_cost();
    let is_noise = |cost: f64| cost < (1.0 + LEAST_TRACE * LEAST_TRACE) * noise;
    let mut roughs: Vec<(EffectId, Rough)> = vec![];
    let gain = |rough: &Rough| point.cost - rough.minimum.cost;
    let best_gain = |roughs: &[(EffectId, Rough)]| {
        let gains = roughs.iter().map(|(_, rough)| gain(rough));
        gains.fold(0.0, f64::max)
    };
    // Beside what leaves nothing but noise, others matter only if they come near it.
    let near = |cost: f64| {
        if is_noise(cost) {
            within_reach(point.cost, cost)
        } else {
            f64::INFINITY
        }
    };
    let mut reach = goal.windows;
    for starts in screened {
        let Some(effect) = starts.first().map(|start| start.effect) else {
            continue;
        };
        let least = point.cost - least_gain(effect);
        let found = fit_roughly(bench, point, starts, reach.min(least));
        if let Some(rough) = found.filter(|rough| rough.minimum.cost <= least) {
            reach = reach.min(near(rough.minimum.cost));
            roughs.push((effect, rough));
        }
    }
    for &effect in refinements {
        let Some(simpler) = refined(effect, &roughs, |rough| rough.minimum.cost) else {
            continue;
        };
        // What takes little beside something else is not refined yet; what leaves nothing but noise is
        // once it has been chosen.
        let is_slight = gain(simpler) < LEAST_SHARE * best_gain(&roughs);
        if is_slight || is_noise(simpler.minimum.cost) {
            continue;
        }
        let starts = refined_starts(bench, &from.minimum, simpler, effect);
        // A refinement that comes out as what it refines is that.
        let least = point.cost - least_gain(effect);
        let least = least.min(simpler.minimum.cost - bench.least_gain);
        let found = fit_roughly(bench, &simpler.minimum, starts, reach.min(least));
        if let Some(rough) = found.filter(|rough| rough.minimum.cost <= least) {
            reach = reach.min(near(rough.minimum.cost));
            roughs.push((effect, rough));
        }
    }
    let best_gain = best_gain(&roughs);
    let is_plain = |rough: &Rough| gain(rough) >= LEAST_SHARE * best_gain;
    let refined_names: Vec<&str> = roughs
        .iter()
        .filter(|(_, rough)| is_plain(rough))
        .flat_map(|(effect, _)| effect.info().replaces)
        .copied()
        .collect();
    roughs.retain(|(effect, rough)| is_plain(rough) || refined_names.contains(&effect.name()));
    roughs
}

/// Fits over the whole logs what [`fit_all_roughly`] has left: what refines another effect last, otherwise those
/// that take most first.
fn fit_all_wholly(
    bench: &Bench,
    from: &Candidate,
    mut roughs: Vec<(EffectId, Rough)>,
    mut goal: Goal,
) -> Vec<Candidate> {
    roughs.sort_by(|(_, a), (_, b)| a.minimum.cost.total_cmp(&b.minimum.cost));
    roughs.sort_by_key(|(_, rough)| is_refinement(&rough.start));
    let mut candidates: Vec<Candidate> = vec![];
    let mut reached: Vec<(EffectId, f64)> = vec![];
    for (effect, rough) in roughs {
        let simpler = refined(effect, &reached, |cost| *cost);
        let least = simpler.map_or(f64::INFINITY, |cost| cost - bench.least_gain);
        let own = Goal {
            whole: goal.whole.min(least),
            ..goal
        };
        let candidate = fit_whole(bench, from, rough, own);
        reached.push((effect, candidate.minimum.cost));
        if leaves_nothing(&bench.records, &candidate) {
            let beside = Goal::beside(from, &candidate);
            goal.whole = goal.whole.min(beside.whole);
        }
        candidates.push(candidate);
    }
    candidates
}

/// How a round of trials is carried out.
pub struct Round<'a> {
    /// Most suspects that are fitted.
    pub most: usize,
    /// Sets of effects that need no fit any more.
    pub is_fitted: &'a (dyn Fn(&[EffectId]) -> bool + Sync),
    /// A candidate that leaves nothing, where there is one: what is found competes with it.
    pub leader: Option<&'a Candidate>,
    /// Only effects that act in experiments in which something remains.
    pub only_where_something_remains: bool,
}

/// Tries every applicable effect on top of `from`: a score test for all, a full refit for those
/// that promise something and whose set of effects is not fitted yet.
pub fn try_all(bench: &Bench, from: &Candidate, round: &Round) -> Vec<Candidate> {
    let shows_where_something_remains = |effect: EffectId| {
        let remainders = bench.records.iter().zip(from.remainders(&bench.records));
        remainders
            .filter(|(record, _)| acts(effect, record.kind))
            .any(|(_, remainders)| remainders.iter().any(|&left| left >= LEAST_TRACE))
    };
    let suspects: Vec<EffectId> = bench
        .suspects
        .iter()
        .copied()
        .filter(|&effect| from.model.with(effect) != from.model && applicable(bench.setup, effect))
        .filter(|&effect| !completes_series(&from.model, effect))
        .filter(|&effect| {
            !round.only_where_something_remains || shows_where_something_remains(effect)
        })
        .collect();
    let fitted = |effect: EffectId| {
        let mut set = added(from, &from.model.with(effect), effect);
        set.sort();
        (round.is_fitted)(&set)
    };
    // What refines another suspect is tried on top of that one's fit, far from which it says nothing.
    let (refinements, suspects): (Vec<EffectId>, Vec<EffectId>) =
        suspects.iter().partition(|&&effect| {
            let replaces = effect.info().replaces;
            let is_first = |simpler: &&EffectId| replaces.contains(&simpler.name());
            suspects
                .iter()
                .filter(is_first)
                .any(|&simpler| !fitted(simpler))
        });
    let point = from.point();
    let angle_zero_rad = ratios(&bench.records).angle_zero_rad.unwrap_or(0.0);
    // A cable is moved along with the effect, so that every effect needs a simulation of its own.
    let (absent, others): (Vec<EffectId>, Vec<EffectId>) =
        suspects.into_iter().partition(|&effect| {
            is_scored_where_absent(effect) && !from.model.has(EffectId::BodyCableSpring)
        });
    let unknowns = Unknowns::new(&from.model, &bench.setup.free(&from.model));
    let known = KnownPromise {
        model: &from.model,
        values: &point.values,
        unknowns: &unknowns,
        promise: &promise(
            &bench.records,
            &from.model,
            &point.values,
            &point.windows,
            &unknowns,
            None,
        ),
        leaves_no_trace: &|_| false,
    };
    let (scored, others) = rayon::join(
        || absent_starts(bench, from, point, known, &absent),
        || -> Vec<Vec<Start>> {
            others
                .par_iter()
                .map(|&effect| starts(bench, &from.minimum, point, known, effect))
                .collect()
        },
    );
    let mut screened: Vec<(f64, Vec<Start>)> = scored
        .into_iter()
        .map(|start| {
            let zero = (start.effect == EffectId::AngleOffset
                && angle_zero_rad.abs() > LARGE_ZERO_RAD)
                .then(|| zero_start(bench, point, &start, angle_zero_rad));
            [start].into_iter().chain(zero).collect()
        })
        .chain(others)
        .map(|starts| {
            let best = starts
                .iter()
                .map(|start| start.promised_cost)
                .fold(f64::INFINITY, f64::min);
            (point.cost - best, starts)
        })
        .collect();
    // Where an effect and one that contains it are both suspects and promise about the same, the
    // simpler one goes first: the larger one is tried on top of it in the next round.
    let gains: Vec<(EffectId, f64)> = screened
        .iter()
        .filter_map(|(gain, starts)| Some((starts.first()?.effect, *gain)))
        .collect();
    screened.retain(|(own, starts)| {
        starts.first().is_some_and(|start| {
            !start.effect.info().replaces.iter().any(|contained| {
                gains.iter().any(|(effect, gain)| {
                    effect.name() == *contained && *gain > LEAST_GAIN && *gain > SIMPLER_SHARE * own
                })
            })
        })
    });
    // What the model misses, in χ² beyond the noise, in the experiments in which an effect acts.
    let missed = |effect: EffectId| -> f64 {
        let records = bench.records.iter().zip(&known.promise.records);
        records
            .filter(|(record, _)| acts(effect, record.kind))
            .map(|(record, share)| (share.cost - record.observations() as f64).max(0.0))
            .sum()
    };
    screened.retain(|(gain, starts)| {
        let least = |start: &Start| LEAST_PART * missed(start.effect);
        starts.first().is_some_and(|start| *gain >= least(start))
    });
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A refinement that is fitted already takes the place of a term, and is no measure for what may act
    // beside that term.
    let is_fitted = |starts: &[Start]| starts.first().is_some_and(|start| fitted(start.effect));
    screened.retain(|(_, starts)| {
        let is_refinement = starts
            .first()
            .is_some_and(|start| added(from, &start.model, start.effect).len() == from.added.len());
        !(is_refinement && is_fitted(starts))
    });
    let best_gain = screened.first().map_or(0.0, |(gain, _)| *gain);
    let mut chosen = screened;
    chosen.retain(|(gain, _)| *gain > bench.least_gain.max(LEAST_SHARE * best_gain));
    chosen.truncate(round.most.min(MOST_FITS));
    chosen.retain(|(_, starts)| !is_fitted(starts));
    // What is simple comes first: it is fitted fast, and what it reaches need not be reached again.
    chosen.sort_by_key(|(_, starts)| starts.first().is_some_and(is_refinement));
    let goal = round
        .leader
        .map_or(Goal::ANY, |leader| Goal::beside(from, leader));
    let chosen = chosen.into_iter().map(|(_, starts)| starts).collect();
    let least_gain = |effect: EffectId| bench.least_gain.max(LEAST_PART * missed(effect));
    let refinements: Vec<EffectId> = refinements
        .into_iter()
        .filter(|&effect| !fitted(effect))
        .collect();
    let roughs = fit_all_roughly(bench, from, chosen, &refinements, &least_gain, goal);
    fit_all_wholly(bench, from, roughs, goal)
}

/// Refits a candidate without one of its effects. `known` is what an earlier fit of that set has reached:
/// `None` if this one is no better, as far as the short windows show where there are any.
pub fn without(
    bench: &Bench,
    from: &Candidate,
    effect: EffectId,
    known: &dyn Fn(&[EffectId]) -> Option<Candidate>,
) -> Option<Candidate> {
    let (setup, records) = (bench.setup, &bench.records);
    let model = from.model.without(effect);
    let free = setup.free(&model);
    let mut added = from.added.clone();
    added.retain(|&present| present != effect);
    let mut set = added.clone();
    set.sort();
    let known = known(&set);
    let again = |values: &[f64], windows: Vec<Vec<Window>>| -> Minimum {
        refit(
            records,
            &model,
            values.to_vec(),
            windows,
            &free,
            Effort::FULL,
        )
    };
    let carried = |minimum: &Minimum| -> Vec<f64> {
        let start = vec![0.0; model.parameter_count()];
        carry_over(&from.model, &minimum.values, &model, &start)
    };
    let windowed = from
        .windowed
        .as_ref()
        .map(|windowed| again(&carried(windowed), windowed.windows.clone()));
    let minimum = match &windowed {
        Some(windowed) => {
            let reached = known.and_then(|known| known.windowed);
            if reached.is_some_and(|reached| reached.cost - windowed.cost < LEAST_GAIN) {
                return None;
            }
            let windows = joined(records, &windowed.values, &windowed.windows);
            again(&windowed.values, windows)
        }
        None => again(&carried(&from.minimum), from.minimum.windows.clone()),
    };
    Some(Candidate::new(
        setup, records, added, model, minimum, windowed,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_series_is_not_completed_step_by_step() {
        let half = Model::base()
            .with(EffectId::AngleOffset)
            .with(EffectId::BodyCableSpring);
        assert!(completes_series(&half, EffectId::BodySofteningSpring));
        assert!(!completes_series(&half, EffectId::BodyQuadraticDrag));
        assert!(!completes_series(&Model::base(), EffectId::AngleOffset));
    }
}
