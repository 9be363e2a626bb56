//! The wheel compared with its current, with the body, and with what a wheel and a motor can do.

use bench_files::{Bench, Channel, Note};
use identify::{Output, bumps};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::regression::{LeastSquares, least_squares};
use crate::slips::short;
use crate::spin_ups;
use crate::thresholds::fit::{EXPLAINED, STANDARD_ERRORS};
use crate::thresholds::wheel::{BELOW_ZERO, BENCH_CURRENT_A, BENCH_POWER_W, OVER_LIMIT};
use crate::view::{Facts, View, largest, median, range};

/// The response of a wheel to its current.
pub(crate) struct Answer {
    /// Acceleration per ampere, 1/s² A⁻¹.
    pub per_ampere: f64,
}

/// The responses in all logs that show one, with their fits.
pub(crate) type Answers<'v> = Vec<(&'v View<'v>, Answer, LeastSquares)>;

/// The response in one log; `None` if the log does not show it.
fn answer(view: &View) -> Option<(Answer, LeastSquares)> {
    if view.kind() == Kind::FreeSwing {
        return None;
    }
    let speed = view.samples(Channel::WheelSpeed)?;
    let current = view.samples(Channel::Current)?;
    if largest(current) == 0.0 {
        return None;
    }
    let found = view.bump_lengths_s().filter_map(|length_s| {
        let mut rows = vec![];
        bumps(&view.record, length_s, |bump| {
            let row = [bump.integral(current, 0), -bump.integral(speed, 0)];
            rows.push((row, -bump.integral(speed, 1)));
        });
        // Neighbouring bumps overlap by half.
        least_squares(&rows, 2.0)
    });
    let sharpness = |fit: &LeastSquares| (fit.coefficients[0] / fit.std[0]).abs();
    let best = found.max_by(|a, b| sharpness(a).total_cmp(&sharpness(b)))?;
    (sharpness(&best) > STANDARD_ERRORS).then(|| {
        let answer = Answer {
            per_ampere: best.coefficients[0],
        };
        (answer, best)
    })
}

pub(crate) fn answers<'v>(views: &[&'v View<'v>]) -> Answers<'v> {
    let found = views.iter().copied();
    found
        .filter_map(|view| answer(view).map(|(answer, fit)| (view, answer, fit)))
        .collect()
}

/// Whether the wheel speeds up with its current; `None` where the log does not show it for sure.
pub(crate) fn agrees(view: &View, answers: &Answers) -> Option<bool> {
    let mut answers = answers.iter();
    let (_, answer, fit) = answers.find(|(of, _, _)| of.name() == view.name())?;
    (fit.explained >= EXPLAINED).then_some(answer.per_ampere > 0.0)
}

pub(crate) fn check(
    bench: &Bench,
    views: &[&View],
    answers: &Answers,
    facts: &Facts,
    out: &mut Vec<Finding>,
) {
    // A sensor without a sign is wrong only where the current is negative.
    let mut against = answers
        .iter()
        .filter(|(_, answer, _)| answer.per_ampere < 0.0);
    let is_unsigned = against.all(|(view, _, _)| is_backwards(view) && is_never_negative(view));
    for (view, answer, fit) in answers {
        sign(view, answer, fit, is_unsigned, out);
    }
    // Only spin-ups are free of the body's motion.
    let of_spin_ups: Vec<(&View, f64)> = answers
        .iter()
        .filter(|(view, _, _)| view.kind() == Kind::SpinUp)
        .map(|(view, answer, _)| (*view, answer.per_ampere.abs()))
        .collect();
    let before = out.len();
    spin_ups::odd_one_out(&of_spin_ups, out);
    if out.len() == before {
        spin_ups::all_together(bench, views, &of_spin_ups, facts, out);
    }
    for view in views {
        size_of_current(bench, view, facts, out);
    }
}

/// Checks the sign: a driven wheel accelerates in the direction of its current. Otherwise friction would drive it.
fn sign(
    view: &View,
    answer: &Answer,
    fit: &LeastSquares,
    is_unsigned: bool,
    out: &mut Vec<Finding>,
) {
    if answer.per_ampere >= 0.0 || fit.explained < EXPLAINED {
        return;
    }
    // A tachometer that counts pulses does not know the direction.
    let unsigned = if is_unsigned {
        ". If the sensor of the wheel never shows a minus, the cure is instead sign = { wheel_speed = -1 } for this log \
         alone"
    } else {
        ""
    };
    out.push(
        Finding::refusal(
            FindingId::CurrentSign,
            "the wheel speeds up against its current: one of the two has the wrong sign (factor -1)",
        )
        .in_experiment(view.name())
        .with_channel("current")
        .with_factor(-1.0)
        .with_fix(format!(
            "sign = {{ current = -1 }} (or sign = {{ wheel_speed = -1 }}, if the wheel's speed is not \
             positive in the sense of the positive angle){unsigned}"
        )),
    );
}

/// Whether the usual current of a log is negative.
fn is_backwards(view: &View) -> bool {
    let current = view.samples(Channel::Current).unwrap_or_default();
    median(current.to_vec()).is_some_and(|usual| usual < 0.0)
}

/// Whether the wheel's speed never falls below 0 by more than its noise.
fn is_never_negative(view: &View) -> bool {
    let speed = view.samples(Channel::WheelSpeed).unwrap_or_default();
    range(speed).is_some_and(|(low, _)| low >= -BELOW_ZERO * view.noise(Output::WheelSpeed))
}

/// Checks for a current that no bench motor takes. A command without unit, such as a duty of 255, has no size that
/// would be too large.
fn size_of_current(bench: &Bench, view: &View, facts: &Facts, out: &mut Vec<Finding>) {
    let notes = &view.experiment.report.notes;
    if notes.contains(&Note::NormalisedCommand) {
        return;
    }
    let Some(current) = view.samples(Channel::Current) else {
        return;
    };
    let most = largest(current);
    let milliamperes = |finding: Finding| {
        finding
            .in_experiment(view.name())
            .with_channel("current")
            .with_factor(1e3)
            .with_fix("units = { current = \"mA\" }")
    };
    let limit = bench
        .controller
        .map(|controller| controller.current_limit_a);
    if let (Kind::Balance, Some(limit)) = (view.kind(), limit)
        && most > BENCH_CURRENT_A.min(OVER_LIMIT * limit)
    {
        out.push(milliamperes(Finding::refusal(
            FindingId::CurrentFactor,
            format!(
                "the current goes up to {} A, {} times current_limit: it is in mA",
                short(most),
                short(most / limit)
            ),
        )));
        return;
    }
    let power = match (facts.torque_constant, view.samples(Channel::WheelSpeed)) {
        (Some(torque_constant), Some(speed)) => {
            let products = speed.iter().zip(current);
            products
                .map(|(speed, current)| torque_constant * (speed * current).abs())
                .filter(|power| power.is_finite())
                .fold(0.0, f64::max)
        }
        _ => 0.0,
    };
    if most > BENCH_CURRENT_A && power > BENCH_POWER_W {
        out.push(milliamperes(Finding::refusal(
            FindingId::CurrentFactor,
            format!(
                "with {} A the motor would give {} W: the current is in mA",
                short(most),
                short(power)
            ),
        )));
    } else if most > BENCH_CURRENT_A {
        out.push(milliamperes(Finding::warning(
            FindingId::CurrentFactor,
            format!("the current goes up to {} A: is it in mA?", short(most)),
        )));
    }
}
