//! Statements about the quantities that the logs do not determine, and about numbers of a comparison that can mislead:
//! one sentence each.

use bench_files::numbers::{number, with_uncertainty};
use plant::{BASE_PARAMETERS, Kind, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use crate::bench::FitProblem;
use crate::errors::{Fit, without_value};
use crate::fit::PredictedSeries;
use crate::records::{BALANCE_WINDOW_S, Record};
use crate::residuals::{is_slow, samples_in_window};

/// Relative standard error above which a parameter counts as not identified.
pub(crate) const OPEN_RELATIVE_STD: f64 = 1.0;

/// Relative standard error above which the reader is told that an inertia is known roughly only. The gain of a
/// controlled loop changes by the share by which the inertia is wrong. Judgement: a tenth is about what a weighed and
/// measured wheel gives without any log.
const ROUGH_RELATIVE_STD: f64 = 0.1;

/// Warnings where the numbers of the comparison can mislead.
pub(crate) fn cautions(records: &[&Record], traces: &[Vec<PredictedSeries>]) -> Vec<String> {
    let mut out = vec![];
    for (record, traces) in records.iter().zip(traces) {
        if record.averaged_over > 1 {
            out.push(format!(
                "{}: the log is far denser than its motion; it is used as {} averages over {} samples each, and \
                 errors and sensor noise are those of the averages",
                record.name,
                record.len(),
                record.averaged_over
            ));
        }
        if record.kind == Kind::Driven && record.window_s.is_finite() {
            let why = if record.passes_over_the_top {
                "the body passes over the top, where the smallest difference grows"
            } else {
                "with the cogging of the motor, a long run depends on every tooth at which the wheel turned back"
            };
            out.push(format!(
                "{}: {why}; the model is therefore compared over windows of {BALANCE_WINDOW_S} s, each with its \
                 own start, as in a balance log",
                record.name
            ));
        }
        if is_slow(record) {
            let in_window = samples_in_window(record);
            // `Record::windows` makes no window shorter than this.
            let least = record.windows(0.0).first().map_or(0, |window| window.len());
            out.push(format!(
                "{}: {BALANCE_WINDOW_S} s hold only {in_window:.0} samples, so windows of {least} samples \
                 are compared, and the start of each window uses up to three of them: the fit percentage says \
                 little here. A push that is no larger than the error of motor and gravity cannot be distinguished \
                 from the response to an earlier push: it is left out of the fit, and not reported",
                record.name
            ));
        }
        for trace in traces.iter().filter(|trace| trace.fit_percent < 0.0) {
            out.push(format!(
                "{}/{}: the model is worse than the mean of the measurement (fit {:.0} %): it lacks an essential \
                 effect there, and the standard errors do not cover that",
                record.name,
                trace.output.name(),
                trace.fit_percent
            ));
        }
    }
    out
}

/// The parameters that no fit can find with these logs and direct measurements: one sentence each. It takes no fit to
/// say.
pub fn left_open(problem: &FitProblem) -> Vec<String> {
    let mut out = problem.notes.clone();
    let (body, wheel) = problem.moved();
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
    if body && !problem.body_scale_known {
        out.push(
            "no torque on the body is known (masses and lengths, or gravity_torque, are missing): \
             torques on the body are identified per unit of inertia only, with total_inertia = 1 kg m2"
                .to_owned(),
        );
    }
    if wheel && !problem.wheel_scale_known && !problem.coupled {
        out.push(
            "no torque on the wheel is known (torque_constant is missing, or the current was not \
             recorded): torques on the wheel are identified per unit of inertia only, with wheel_inertia = \
             1 kg m2"
                .to_owned(),
        );
    }
    out
}

/// An inertia that the logs determine, but only roughly: beside an effect that acts like it, mostly.
fn rough_inertia(position: usize, value: f64, std: f64) -> String {
    let info = BASE_PARAMETERS[position];
    let remedy = if position == WHEEL_INERTIA {
        "spin-ups at several currents in both directions and a coast-down to standstill"
    } else {
        "free swings at a small and at a large angle, with masses and lengths or gravity_torque under [known],"
    };
    format!(
        "{} = {} {} is known to {:.0} % only: something else in the model acts much like it in these logs; {remedy} \
         would tell them apart",
        info.name,
        with_uncertainty(value, Some(std)),
        info.unit,
        100.0 * std / value.abs(),
    )
}

pub(crate) fn statements(problem: &FitProblem, fit: &Fit) -> Vec<String> {
    let mut out = left_open(problem);
    let (_, wheel) = problem.moved();
    let infos = fit.model.parameters();
    let without_value = without_value(problem, fit);
    for (index, &position) in fit.unknowns.free.iter().enumerate() {
        let info = infos[position];
        let effect = fit.model.effect_at(position);
        if effect.is_some_and(|effect| effect.info().learned.is_some()) {
            // A curve may well be zero at a knot.
            continue;
        }
        let value = fit.values[position];
        let is_open = fit
            .std(position)
            .is_none_or(|std| std >= OPEN_RELATIVE_STD * value.abs());
        let is_inertia = [TOTAL_INERTIA, WHEEL_INERTIA].contains(&position);
        if is_inertia && is_open && problem.hides_wheel_inertia() {
            if position == WHEEL_INERTIA {
                out.push(
                    "no log shows how the wheel answers to a current, and its reaction on the body does not stand out: \
                     wheel_inertia is not identified, torques on the wheel are known per unit of it only, and \
                     total_inertia up to it; a log with the wheel's speed and a current would give it"
                        .to_owned(),
                );
            }
            continue;
        }
        if let Some(one) = without_value.iter().find(|one| one.position == position) {
            out.push(format!("{} has {}", info.name, one.why));
            continue;
        }
        if fit.minimum.on_bound[index] {
            out.push(format!(
                "{} lies on the bound {} of its possible range, and the logs would fit better beyond it: the model \
                 probably lacks an effect",
                info.name,
                number(value)
            ));
            continue;
        }
        let is_rough = |std: &f64| is_inertia && *std >= ROUGH_RELATIVE_STD * value.abs();
        match fit.std(position) {
            Some(std) if !is_open => {
                if is_rough(&std) {
                    out.push(rough_inertia(position, value, std));
                }
            }
            Some(std) => out.push(format!(
                "{} = {} {} cannot be distinguished from zero with these logs",
                info.name,
                with_uncertainty(value, Some(std)),
                info.unit
            )),
            None => out.push(format!(
                "{} has no influence on these logs and is not identified",
                info.name
            )),
        }
    }
    for position in [WHEEL_INERTIA, TORQUE_CONSTANT] {
        if wheel && problem.known[position].is_none() && !fit.unknowns.free.contains(&position) {
            out.push(format!(
                "{} is not identified by these logs",
                BASE_PARAMETERS[position].name
            ));
        }
    }
    out
}
