//! From a bench to identified parameters: what is known, what the logs can tell, what is open.

use std::borrow::Cow;

use bench_files::{Bench, Known};
use plant::{
    BASE_PARAMETERS, Driving, EffectId, GRAVITY_TORQUE, Kind, Model, Role, StartFrom,
    TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA,
};
use rayon::prelude::*;

use crate::cogging::cogging_start;
use crate::contradiction::{Contradiction, body_inertia_contradiction, contradictions};
use crate::fit::{Fit, Trace, finish, fit_from_scratch, joined, refit, traces};
use crate::pushes::{
    Push, PushModel, find_disturbances, find_pushes, is_slow, leave_out, samples_in_window,
};
use crate::record::{BALANCE_WINDOW_S, Output, Record};
use crate::sensitivity::Window;
use crate::solver::{Effort, Minimum, cost};
use crate::start::{base_values, driving_samples, ratios};

/// Why a bench cannot be identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// No experiment has a usable channel.
    #[error("the bench has no experiment from which anything could be identified")]
    NoExperiments,
    /// The minimisation found no finite simulation.
    #[error(
        "the model could not be simulated from any start that the logs suggest; check units, signs \
         and kinds of the experiments in bench.toml (first suspect: {suspect})"
    )]
    NotFinite {
        /// The experiment with the largest misfit at the start.
        suspect: String,
    },
}

/// A bench prepared for fits: its records, and which parameters are given.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The experiments, in the order of bench.toml.
    pub records: Vec<Record>,
    /// Values of the base parameters (positions 0 to 3) that are known or fix the scale.
    pub known: [Option<f64>; 4],
    /// Whether torques of the body are known in N m; else they are per unit of Θ.
    pub body_scale_known: bool,
    /// Whether torques of the wheel are known in N m; else they are per unit of j_w.
    pub wheel_scale_known: bool,
    /// Whether an experiment moves body and wheel together, so that they share one scale.
    pub coupled: bool,
    /// Masses and lengths, for the inertia of the body alone.
    pub masses: Known,
}

impl Setup {
    /// Prepares a bench that was loaded from disk.
    ///
    /// # Errors
    /// [`IdentifyError::NoExperiments`] if nothing in it can be used.
    pub fn new(bench: &Bench) -> Result<Setup, IdentifyError> {
        let records: Vec<Record> = bench
            .experiments
            .par_iter()
            .map(Record::from_experiment)
            .filter(|record| !record.channels.is_empty() && !record.is_empty())
            .collect();
        let mut known = [None; 4];
        known[TOTAL_INERTIA] = bench.known.total_inertia;
        known[WHEEL_INERTIA] = bench.known.wheel_inertia;
        known[GRAVITY_TORQUE] = bench.known.gravity_torque().ok();
        known[TORQUE_CONSTANT] = bench.known.torque_constant;
        Setup::from_records(records, known, bench.known)
    }

    /// Prepares records with what is known of the base parameters.
    ///
    /// # Errors
    /// [`IdentifyError::NoExperiments`] if there is no record.
    pub fn from_records(
        records: Vec<Record>,
        known: [Option<f64>; 4],
        masses: Known,
    ) -> Result<Setup, IdentifyError> {
        if records.is_empty() {
            return Err(IdentifyError::NoExperiments);
        }
        let coupled = records.iter().any(|record| {
            matches!(record.kind, Kind::Balance | Kind::Driven)
                && !matches!(record.current, crate::record::RecordedCurrent::Unknown)
        });
        let body = known[TOTAL_INERTIA].is_some() || known[GRAVITY_TORQUE].is_some();
        let recorded = records.iter().any(|record| {
            record.kind != Kind::FreeSwing
                && !matches!(record.current, crate::record::RecordedCurrent::Unknown)
        });
        let wheel =
            known[WHEEL_INERTIA].is_some() || (known[TORQUE_CONSTANT].is_some() && recorded);
        let (body, wheel) = if coupled {
            (body || wheel, body || wheel)
        } else {
            (body, wheel)
        };
        let mut known = known;
        if !body {
            known[TOTAL_INERTIA] = Some(1.0);
        }
        if !wheel && !coupled {
            known[WHEEL_INERTIA] = Some(1.0);
        }
        let mut records = records;
        // Pushes spoil the first guess and the guess decides what is a push: twice around is enough,
        // since a push is a matter of factors and the guess one of percents.
        for _ in 0..2 {
            let all: Vec<&Record> = records.iter().collect();
            let (base, body_friction, wheel_friction) = base_values(&ratios(&all), &known);
            let model = PushModel {
                base,
                body_friction,
                wheel_friction,
            };
            for record in &mut records {
                let pushes = find_disturbances(record, &model);
                leave_out(record, &pushes, BALANCE_WINDOW_S);
            }
        }
        Ok(Setup {
            records,
            known,
            body_scale_known: body,
            wheel_scale_known: wheel,
            coupled,
            masses,
        })
    }

    /// The records as the fits take them.
    pub fn all_records(&self) -> Vec<&Record> {
        self.records.iter().collect()
    }

    /// The same bench without the pushes that a fitted model finds besides those that the first
    /// guess of its parameters found; `None` if there are no others.
    pub fn with_more_pushes(&self, model: &Model, values: &[f64]) -> Option<Setup> {
        let push_model = PushModel::of(model, values);
        let mut again = self.clone();
        let mut changed = false;
        for record in &mut again.records {
            let before = record.weight.clone();
            let pushes = find_disturbances(record, &push_model);
            leave_out(record, &pushes, BALANCE_WINDOW_S);
            for (weight, before) in record.weight.iter_mut().zip(before) {
                changed |= *weight < before;
                *weight = weight.min(before);
            }
        }
        changed.then_some(again)
    }

    /// The same bench with driven logs in windows of [`BALANCE_WINDOW_S`]; `None` where none would change.
    ///
    /// The teeth of a motor make a long run of the wheel depend on every standstill in between: at the
    /// crest of a tooth it may turn back or pass, by less than any sensor shows. A free run then says
    /// nothing about the model, as in a balance log.
    pub fn in_windows(&self) -> Option<Setup> {
        let mut cut = self.clone();
        let mut changed = false;
        for record in &mut cut.records {
            let is_cut = record.kind == Kind::Driven
                && record.channel(Output::WheelSpeed).is_some()
                && record.window_s > BALANCE_WINDOW_S;
            if is_cut {
                record.window_s = BALANCE_WINDOW_S;
                changed = true;
            }
        }
        changed.then_some(cut)
    }

    /// The bench as a model can be compared with it: [`Setup::in_windows`] for one with cogging.
    pub fn suited_to(&self, model: &Model) -> Cow<'_, Setup> {
        let cut = if model.find(|info| info.ripple.is_some()).is_some() {
            self.in_windows()
        } else {
            None
        };
        cut.map_or(Cow::Borrowed(self), Cow::Owned)
    }

    /// The same bench with its logs thinned to about `per_period` samples in a period of the pendulum, where
    /// a current acts to twice as many, and for each record the step by which it was thinned. A swing
    /// that is sampled a thousand times in a period says no more about the shape of a missing effect than one
    /// that is sampled a hundred times. Of the current every sample counts.
    ///
    /// The period is that of the samples: a model that lacks something need not have it.
    pub fn thinned(&self, per_period: f64) -> (Setup, Vec<usize>) {
        let period_s = plant::period_s(&self.start_values(&Model::base()));
        let mut thin = self.clone();
        let steps: Vec<usize> = self
            .records
            .iter()
            .map(|record| {
                let (Some(first), Some(last)) = (record.time_s.first(), record.time_s.last())
                else {
                    return 1;
                };
                let interval_s = (last - first) / record.len().max(2) as f64;
                let wanted_s = match record.kind {
                    Kind::FreeSwing => period_s / per_period,
                    _ => 0.5 * period_s / per_period,
                };
                ((wanted_s / interval_s).floor() as usize).max(1)
            })
            .collect();
        for (record, &step) in thin.records.iter_mut().zip(&steps) {
            if step > 1 {
                *record = record.thinned(step);
            }
        }
        (thin, steps)
    }

    /// Whether any experiment moves the body, and whether any moves the wheel.
    pub fn moved(&self) -> (bool, bool) {
        let body = self.records.iter().any(|record| {
            record.kind != Kind::SpinUp
                && (record.channel(Output::Angle).is_some()
                    || record.channel(Output::Rate).is_some())
        });
        let wheel = self.records.iter().any(|record| {
            record.kind == Kind::SpinUp
                || (record.kind != Kind::FreeSwing
                    && (record.channel(Output::WheelSpeed).is_some() || body))
        });
        (body, wheel)
    }

    /// The positions of the parameter vector that a fit of `model` moves: everything that is not
    /// known or a whole number and that some experiment can show.
    pub fn free(&self, model: &Model) -> Vec<usize> {
        let (body, wheel) = self.moved();
        let infos = model.parameters();
        (0..infos.len())
            .filter(|&position| {
                let shown = match position {
                    TOTAL_INERTIA | GRAVITY_TORQUE => body,
                    WHEEL_INERTIA => wheel,
                    TORQUE_CONSTANT => {
                        wheel
                            && self.records.iter().any(|record| {
                                record.kind != Kind::FreeSwing && !record.current_a.is_empty()
                            })
                    }
                    _ => {
                        let effect = model.effect_at(position);
                        match effect.map(|effect| effect.info().role) {
                            Some(Role::Wheel | Role::Motor) => wheel,
                            _ => body,
                        }
                    }
                };
                let given = self.known.get(position).is_some_and(Option::is_some);
                shown && !given && !infos[position].is_whole
            })
            .collect()
    }

    /// The unit of a parameter of `model` as the bench allows it: "… per kg m2" where the scale of
    /// its torques is not known.
    pub fn unit(&self, model: &Model, position: usize) -> String {
        let info = model.parameters()[position];
        let is_wheel = match position {
            TOTAL_INERTIA | GRAVITY_TORQUE => false,
            WHEEL_INERTIA | TORQUE_CONSTANT => true,
            _ => model
                .effect_at(position)
                .is_some_and(|effect| matches!(effect.info().role, Role::Wheel | Role::Motor)),
        };
        let known = if is_wheel {
            self.wheel_scale_known
        } else {
            self.body_scale_known
        };
        if info.is_torque && !known {
            format!("{} per kg m2", info.unit)
        } else {
            info.unit.to_owned()
        }
    }

    /// A parameter vector for `model` from which a fit can start: base parameters from the samples,
    /// effects at the first of their stated starts.
    pub fn start_values(&self, model: &Model) -> Vec<f64> {
        let (base, body_friction, wheel_friction) =
            base_values(&ratios(&self.all_records()), &self.known);
        let mut values = base.to_vec();
        // The stated starts are torques of a bench of Θ ≈ 2e-3 kg m².
        for &effect in model.effects() {
            match (effect.info().start_from, effect.info().role) {
                (StartFrom::Damping, Role::Wheel) => values.push(wheel_friction),
                (StartFrom::Damping, _) => values.push(body_friction),
                _ => values.extend(self.scaled(effect, effect.info().starts[0], &base)),
            }
        }
        values
    }

    /// Parameters from which the fit of an effect may start on this bench, beside base parameters `base`:
    /// those that it states, and those that the logs suggest.
    pub fn starts(
        &self,
        records: &[&Record],
        effect: EffectId,
        base: &[f64; BASE_PARAMETERS.len()],
    ) -> Vec<Vec<f64>> {
        let stated = effect.info().starts.iter();
        let mut starts: Vec<Vec<f64>> = stated
            .map(|start| self.scaled(effect, start, base))
            .collect();
        if let StartFrom::Driving(of) = effect.info().start_from {
            starts.extend(of(&Driving {
                samples: driving_samples(records),
                torque_constant: base[TORQUE_CONSTANT],
                ohm: self.scale(Role::Motor, base),
            }));
        }
        starts
    }

    /// A stated start, what it has of torques scaled to the size of the bench.
    fn scaled(
        &self,
        effect: EffectId,
        start: &[f64],
        base: &[f64; BASE_PARAMETERS.len()],
    ) -> Vec<f64> {
        let info = effect.info();
        let scale = self.scale(info.role, base);
        let parameters = info.parameters.iter().zip(start);
        parameters
            .map(|(info, value)| {
                if info.is_torque {
                    value * scale
                } else {
                    *value
                }
            })
            .collect()
    }

    /// The size of the bench against the one for which the library states its starts, Θ = 2.3e-3 and
    /// j_w = 1.4e-4 kg m² (thesis). What a motor is supplied with does not grow with the wheel, but stands per
    /// unit of inertia where the torque constant, which is its back-EMF, does.
    fn scale(&self, role: Role, base: &[f64; BASE_PARAMETERS.len()]) -> f64 {
        match role {
            Role::Body => base[TOTAL_INERTIA] / 2.3e-3,
            Role::Motor if self.wheel_scale_known => 1.0,
            Role::Wheel | Role::Motor => base[WHEEL_INERTIA] / 1.4e-4,
            Role::Sensor => 1.0,
        }
    }
}

/// An identified model with everything that is said about it.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The fit.
    pub fit: Fit,
    /// For each record the comparison of each of its channels.
    pub traces: Vec<Vec<Trace>>,
    /// For each record the pushes that nobody recorded, sized with the fitted model.
    pub pushes: Vec<Vec<Push>>,
    /// What the logs leave open, one sentence each.
    pub statements: Vec<String>,
}

/// Fits `model` to all experiments of the bench. `previous` may hold the values and windows of a
/// neighbouring fit of the same model, from which the fit then starts.
///
/// # Errors
/// [`IdentifyError::NotFinite`] if no start leads anywhere.
pub fn identify(
    setup: &Setup,
    model: &Model,
    previous: Option<(Vec<f64>, Vec<Vec<Window>>)>,
) -> Result<Identification, IdentifyError> {
    let suited = setup.suited_to(model);
    let setup = suited.as_ref();
    let records = setup.all_records();
    let free = setup.free(model);
    let minimum = match previous {
        Some((values, windows)) => {
            // The fit before may have been over other windows.
            let windows = joined(&records, &values, &windows);
            refit(&records, model, values, windows, &free, Effort::FULL)
        }
        None => {
            // The base model first: effects are small against inertia and gravity.
            let base = Model::base();
            let first = fit_from_scratch(
                &records,
                &base,
                setup.start_values(&base),
                &setup.free(&base),
            );
            if *model == base {
                first
            } else {
                extend(setup, &records, &base, &first, model)
            }
        }
    };
    if !minimum.cost.is_finite() {
        let suspect = records
            .first()
            .map_or(String::new(), |record| record.name.clone());
        return Err(IdentifyError::NotFinite { suspect });
    }
    Ok(identification(setup, model, minimum, None))
}

/// What a fit that was made before says of the bench. `None` where it is not a fit of this bench as the model
/// reads it: where other windows or other samples counted.
pub fn describe(setup: &Setup, fit: &Fit) -> Option<Identification> {
    let setup = setup.suited_to(&fit.model);
    let records = setup.all_records();
    let minimum = &fit.minimum;
    let samples = |windows: &[Vec<Window>]| -> Vec<Vec<std::ops::Range<usize>>> {
        let of_record = |list: &Vec<Window>| list.iter().map(|w| w.samples.clone()).collect();
        windows.iter().map(of_record).collect()
    };
    let own = joined(&records, &fit.values, &minimum.windows);
    let again = cost(&records, &fit.model, &fit.values, &minimum.windows);
    let is_own = samples(&own) == samples(&minimum.windows)
        && (again - minimum.cost).abs() <= SAME_COST * minimum.cost;
    let (model, minimum) = (&fit.model, minimum.clone());
    is_own.then(|| identification(&setup, model, minimum, Some(fit.clone())))
}

/// Relative difference of two costs that are the same but for rounding.
const SAME_COST: f64 = 1e-9;

/// Everything that is said about a minimum of a setup that suits its model; `fit`: the minimum with its
/// standard errors, where they are known.
fn identification(
    setup: &Setup,
    model: &Model,
    minimum: Minimum,
    fit: Option<Fit>,
) -> Identification {
    let records = setup.all_records();
    let free = setup.free(model);
    // Nothing of this needs another part of it, and one long log would keep one core busy alone.
    let ((fit, contradicted), (traces, pushes)) = rayon::join(
        || {
            let on_bound: Vec<usize> = free
                .iter()
                .zip(&minimum.on_bound)
                .filter_map(|(&position, &on_bound)| on_bound.then_some(position))
                .collect();
            rayon::join(
                || fit.unwrap_or_else(|| finish(&records, model, &free, minimum.clone())),
                || contradictions(setup, model, &minimum.values, &minimum.windows, &on_bound),
            )
        },
        || {
            let push_model = PushModel::of(model, &minimum.values);
            let traces: Vec<Vec<Trace>> = records
                .par_iter()
                .zip(&minimum.windows)
                .map(|(record, windows)| traces(record, windows, model, &minimum.values))
                .collect();
            let pushes: Vec<Vec<Push>> = records
                .par_iter()
                .map(|record| find_pushes(record, &push_model))
                .collect();
            (traces, pushes)
        },
    );
    let mut statements = statements(setup, &fit);
    statements.extend(contradicted.iter().map(Contradiction::sentence));
    statements.extend(body_inertia_contradiction(setup, &fit));
    statements.extend(cautions(&records, &traces));
    Identification {
        fit,
        traces,
        pushes,
        statements,
    }
}

/// Parameter values of `model` that continue those of `from`: shared parameters keep their values,
/// an effect that replaces another takes over what it shares with it, the rest starts as given.
pub fn carry_over(from: &Model, values: &[f64], model: &Model, start: &[f64]) -> Vec<f64> {
    model
        .parameters()
        .iter()
        .enumerate()
        .map(|(position, info)| match from.position_of(info.name) {
            Some(at) => values[at],
            None => start[position],
        })
        .collect()
}

/// Fits `model` from a minimum of the smaller model `from`, trying every stated start of the
/// effects that are new, and keeps the best.
pub fn extend(
    setup: &Setup,
    records: &[&Record],
    from: &Model,
    minimum: &Minimum,
    model: &Model,
) -> Minimum {
    let free = setup.free(model);
    let base = [0, 1, 2, 3].map(|position| minimum.values[position]);
    let starts = |effect: EffectId| -> Vec<Vec<f64>> {
        match effect.info().start_from {
            StartFrom::Ripple => cogging_start(records, from, minimum)
                .map(|start| start.parameters_of(effect))
                .into_iter()
                .collect(),
            _ => setup.starts(records, effect, &base),
        }
    };
    let new: Vec<EffectId> = model
        .effects()
        .iter()
        .copied()
        .filter(|&effect| !from.has(effect))
        .collect();
    let starts: Vec<(EffectId, Vec<Vec<f64>>)> = new
        .into_iter()
        .map(|effect| (effect, starts(effect)))
        .collect();
    let tries = starts.iter().map(|(_, starts)| starts.len()).max();
    let tries = tries.unwrap_or(1).max(1);
    let mut best: Option<Minimum> = None;
    for attempt in 0..tries {
        let mut start = vec![0.0; model.parameter_count()];
        for (effect, starts) in &starts {
            let at = model.position(*effect).unwrap_or(0);
            if let Some(chosen) = starts.get(attempt).or(starts.last()) {
                start[at..at + chosen.len()].copy_from_slice(chosen);
            }
        }
        let values = carry_over(from, &minimum.values, model, &start);
        let effort = if tries == 1 {
            Effort::FULL
        } else {
            Effort::ROUGH
        };
        let candidate = refit(
            records,
            model,
            values,
            minimum.windows.clone(),
            &free,
            effort,
        );
        if best.as_ref().is_none_or(|best| candidate.cost < best.cost) {
            best = Some(candidate);
        }
    }
    match best {
        Some(best) if tries > 1 => refit(
            records,
            model,
            best.values,
            best.windows,
            &free,
            Effort::FULL,
        ),
        Some(best) => best,
        None => minimum.clone(),
    }
}

/// Relative standard error above which a parameter counts as not identified by these logs.
const OPEN_RELATIVE_STD: f64 = 1.0;

/// Where the numbers of the comparison must not be taken at face value.
fn cautions(records: &[&Record], traces: &[Vec<Trace>]) -> Vec<String> {
    let mut out = vec![];
    for (record, traces) in records.iter().zip(traces) {
        if record.kind == Kind::Driven && record.window_s.is_finite() {
            let why = if record.passes_over_the_top {
                "the body passes over the top, where the least difference grows"
            } else {
                "with the cogging of the motor a long run depends on every tooth at which the wheel turned back"
            };
            out.push(format!(
                "{}: {why}, so that the model is compared over windows of {BALANCE_WINDOW_S} s, each from a \
                 start of its own, as in a balance log",
                record.name
            ));
        }
        if is_slow(record) {
            let in_window = samples_in_window(record);
            // `Record::windows` makes no window shorter than this.
            let least = record.windows(0.0).first().map_or(0, |window| window.len());
            out.push(format!(
                "{}: {BALANCE_WINDOW_S} s hold only {in_window:.0} samples, so that windows of {least} \
                 samples are compared, of which a start of their own takes up to three: the fit percent \
                 says little here; what looks like a push, but is no larger than the error of motor and \
                 gravity, cannot be told from the answer to an earlier one: it is left out of the fit, but not \
                 reported",
                record.name
            ));
        }
        for trace in traces.iter().filter(|trace| trace.fit_percent < 0.0) {
            out.push(format!(
                "{}/{}: the model is worse than the mean of the measurement (fit {:.0} %): it lacks \
                 something essential there, and the standard errors do not cover that",
                record.name,
                trace.output.name(),
                trace.fit_percent
            ));
        }
    }
    out
}

fn statements(setup: &Setup, fit: &Fit) -> Vec<String> {
    let mut out = vec![];
    let (body, wheel) = setup.moved();
    if !body {
        out.push(
            "no log moves the body: total_inertia, gravity_torque and body friction are not \
             identified; a free swing would give them"
                .to_owned(),
        );
    }
    if !wheel {
        out.push(
            "no log moves the wheel: wheel_inertia, torque_constant and wheel friction are not \
             identified; spin-ups would give them"
                .to_owned(),
        );
    }
    if body && !setup.body_scale_known {
        out.push(
            "no torque of the body is known (masses and lengths, or gravity_torque, are missing): \
             its torques are identified per unit of inertia only, with total_inertia = 1 kg m2"
                .to_owned(),
        );
    }
    if wheel && !setup.wheel_scale_known && !setup.coupled {
        out.push(
            "no torque of the wheel is known (torque_constant is missing, or the current was not \
             recorded): its torques are identified per unit of inertia only, with wheel_inertia = \
             1 kg m2"
                .to_owned(),
        );
    }
    let infos = fit.model.parameters();
    for (index, &position) in fit.unknowns.free.iter().enumerate() {
        let info = infos[position];
        let value = fit.values[position];
        if fit.minimum.on_bound[index] {
            out.push(format!(
                "{} lies on the bound {value} of its range: the logs would like to go beyond it, \
                 so something that the model lacks takes its place",
                info.name
            ));
            continue;
        }
        match fit.std(position) {
            Some(std) if std < OPEN_RELATIVE_STD * value.abs() => {}
            Some(std) => out.push(format!(
                "{} = {value:.3e} ± {std:.1e} {} cannot be told from zero with these logs",
                info.name, info.unit
            )),
            None => out.push(format!(
                "{} leaves no trace in these logs and is not identified",
                info.name
            )),
        }
    }
    for position in [WHEEL_INERTIA, TORQUE_CONSTANT] {
        if wheel && setup.known[position].is_none() && !fit.unknowns.free.contains(&position) {
            out.push(format!(
                "{} is not identified by these logs",
                BASE_PARAMETERS[position].name
            ));
        }
    }
    out
}
