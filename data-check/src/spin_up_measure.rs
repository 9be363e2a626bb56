//! What the spin-ups of a bench say of its wheel, as the measure for logs in which everything is free.

use std::f64::consts::TAU;

use bench_files::{Bench, Channel};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::{short, slip};
use crate::thresholds::swing::{FREE_WHEEL, FREE_WHEEL_ERRORS};
use crate::units::Settled;
use crate::view::{Facts, View, median, small_swing_period_s};
use crate::wheel::Answers;

/// The wheel's share of the total inertia, j_w/Θ, from `[known]` or from the spin-ups; `None` where neither tells.
pub(crate) fn wheel_share(bench: &Bench, answers: &Answers, facts: &Facts) -> Option<f64> {
    let of_spin_ups = || Some(facts.torque_constant? / per_ampere(answers)?);
    let wheel = bench.known.wheel_inertia.or_else(of_spin_ups)?;
    let total = bench.known.total_inertia.or(facts.total_inertia())?;
    (wheel < total).then(|| wheel / total)
}

/// The usual acceleration of the wheel per ampere in the spin-ups, 1/s² A⁻¹.
fn per_ampere(answers: &Answers) -> Option<f64> {
    let spin_ups = answers
        .iter()
        .filter(|(view, _, _)| view.kind() == Kind::SpinUp);
    median(
        spin_ups
            .map(|(_, answer, _)| answer.per_ampere.abs())
            .collect(),
    )
}

/// Notes that speed and current of the spin-ups have the right units: they give the wheel's known inertia.
pub(crate) fn settle(answers: &Answers, facts: &Facts, settled: &mut Settled) {
    if facts.torque_constant.is_none() {
        return;
    }
    for (view, _, _) in answers {
        if view.kind() == Kind::SpinUp {
            settled.add(view, Channel::WheelSpeed);
            settled.add(view, Channel::Current);
        }
    }
}

/// Checks the current of logs in which everything is free. There the wheel accelerates by Θ/(Θ − j_w) times as much per
/// ampere as with a clamped body, which is less than twice: only a factor of 1000 leaves no doubt.
pub(crate) fn current(answers: &Answers, facts: &Facts, out: &mut Vec<Finding>) {
    let Some(usual) = per_ampere(answers) else {
        return;
    };
    let clamped = 1.0 - facts.wheel_share.unwrap_or(0.0);
    for (view, answer, _) in answers {
        if !matches!(view.kind(), Kind::Balance | Kind::Driven) {
            continue;
        }
        let ratio = answer.per_ampere.abs() * clamped / usual;
        let (unit, factor) = match slip(ratio) {
            Some(1e-3) => ("mA", 1e3),
            Some(1e3) => ("A", 1e-3),
            _ => continue,
        };
        out.push(
            Finding::refusal(
                FindingId::CurrentFactor,
                format!(
                    "the wheel accelerates {} times as much per ampere as in the spin-ups: the current is in {unit}, \
                     or theirs has the wrong unit",
                    short(ratio)
                ),
            )
            .in_experiment(view.name())
            .with_channel("current")
            .with_factor(factor)
            .with_fix(format!("units = {{ current = \"{unit}\" }}")),
        );
    }
}

/// Checks whether the wheel of a free swing is free to turn, where neither its speed nor its angle was logged. A free wheel
/// keeps its own motion, so that the period shows the inertia Θ − j_w instead of Θ. Where `[known]` states both inertias, the
/// two are compared with that of the period; where it has masses and lengths only, Θ is at least k² m_w + l² m_b + j_w.
pub(crate) fn free_wheel(
    bench: &Bench,
    views: &[View],
    answers: &Answers,
    facts: &Facts,
    out: &mut Vec<Finding>,
) {
    let of_spin_ups = || Some(facts.torque_constant? / per_ampere(answers)?);
    let wheel = bench.known.wheel_inertia.or_else(of_spin_ups);
    let (Some(gravity), Some(wheel)) = (facts.gravity_torque_n_m, wheel) else {
        return;
    };
    let total = bench
        .known
        .total_inertia
        .or_else(|| Some(facts.steiner_kg_m2? + bench.known.body_inertia? + wheel));
    for view in views {
        let beside = &view.experiment.beside;
        let is_logged = beside.wheel_speed_rad_s.is_some() || beside.wheel_angle_rad.is_some();
        let Some((period_s, std_s)) = small_swing_period_s(view).filter(|_| !is_logged) else {
            continue;
        };
        let inertia = gravity * (period_s / TAU).powi(2);
        let std = 2.0 * inertia * std_s / period_s;
        let below = |other: f64| other - inertia > FREE_WHEEL_ERRORS * std;
        let stated = match (total, facts.steiner_kg_m2) {
            (Some(total), _)
                if below(total) && (inertia - (total - wheel)).abs() < FREE_WHEEL * wheel =>
            {
                format!(
                    "{} kg m2, which is that of the pendulum ({}) without its wheel ({})",
                    short(inertia),
                    short(total),
                    short(wheel)
                )
            }
            (None, Some(steiner)) if below(steiner + wheel) => format!(
                "{} kg m2, and masses, lengths and the wheel's own inertia ({}) together give at least {}",
                short(inertia),
                short(wheel),
                short(steiner + wheel)
            ),
            _ => continue,
        };
        out.push(
            Finding::warning(
                FindingId::WheelTurns,
                format!(
                    "the period shows an inertia of {stated}: is the wheel free to turn? A free wheel does not swing \
                     with the body. Otherwise a mass or a length is wrong, or a spring acts at the pivot"
                ),
            )
            .in_experiment(view.name())
            .with_channel("wheel_speed")
            .with_fix(
                "lock the wheel to the body and repeat; or kind = \"driven\" and constants = { current = 0.0 } if it is free",
            ),
        );
    }
}
