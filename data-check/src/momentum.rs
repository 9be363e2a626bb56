//! With everything free, wheel and body exchange momentum: Θ α̈ + j_w φ̈ + G sin α = 0, apart from the
//! friction of the pivot. Neither the current nor any effect of the motor enters.

use std::f64::consts::{PI, TAU};

use bench_files::Channel;
use plant::Kind;

use crate::body::{Body, Cause};
use crate::finding::{Finding, FindingId, Severity};
use crate::regression::LeastSquares;
use crate::slips::{DEGREES, RPM, short, slip};
use crate::spin_ups;
use crate::swing;
use crate::thresholds::bench::SHARE_OF_INERTIA;
use crate::thresholds::fit::{EXPLAINED, STANDARD_ERRORS};
use crate::thresholds::momentum::{
    AGREE, CLEAR, IMPOSSIBLE_TURNS, LEAST_LEFT, LEFT_OVER, MOST_TURNS, WRONG_ZERO_RAD, ZERO_RAD,
};
use crate::units::Settled;
use crate::view::{Facts, View};

/// The other units in which an angle could be, as the factor by which it is then read too large.
const OTHERS: [f64; 3] = [DEGREES, 1e3, 1.0 / TAU];

pub(crate) fn check(view: &View, facts: &Facts, settled: &mut Settled, out: &mut Vec<Finding>) {
    let Some(body) = Body::of(view) else { return };
    // Of an angle that runs against its rate, one has the wrong sign, which `kinematics` names. Gravity would seem to push
    // such a body up.
    if let (Some(angle), Some(rate)) = (view.samples(Channel::Angle), view.samples(Channel::Rate))
        && let Some((ratio, _)) = view.ratio_to_derivative(angle, rate)
        && ratio.correlation < -EXPLAINED
    {
        return;
    }
    let speed = view.samples(Channel::WheelSpeed);
    let current = view.samples(Channel::Current);
    let causes = [
        speed.map(Cause::Wheel),
        current.map(|current| Cause::Current(current, speed)),
    ];
    let [by_wheel, by_current] = causes.map(|cause| cause.map(|cause| Fits::of(&body, &cause)));
    // The equation without the motor comes first: no effect of a motor can look like a wrong unit in it.
    for fits in [&by_wheel, &by_current].into_iter().flatten() {
        match fits.unit() {
            Some(1.0) => settled.add(view, body.channel),
            Some(factor) => {
                out.push(unit_of_angle(
                    view,
                    &body,
                    factor,
                    &format!(
                        "gravity does not act as the sine of the angle, but as the sine of the angle {}",
                        divided_by(factor)
                    ),
                ));
                return;
            }
            None => {}
        }
    }
    let found_before = out.len();
    let is_left = speed.is_some_and(|speed| body.leaves_the_wheel(speed));
    if is_left
        && let Some(fit) = body.fit_gravity()
        && fit.explained > EXPLAINED
    {
        gravity(view, &body, &fit, 0, out);
    }
    if let (
        Some(Fits {
            as_read: Some(best),
            ..
        }),
        false,
    ) = (&by_wheel, is_left)
    {
        exchange(view, &body, best, facts, settled, out);
    }
    if out.len() > found_before {
        return;
    }
    if let Some(Fits {
        as_read: Some(best),
        ..
    }) = &by_current
    {
        torque(view, &body, best, facts, settled, out);
    }
    if out.len() == found_before
        && view.kind() == Kind::Driven
        && body.channel == Channel::Angle
        && body.turns() > MOST_TURNS
        && !settled.has(view, Channel::Angle)
    {
        let sentence = format!(
            "the body would go round {} times, but its motion does not show gravity in every turn",
            short(body.turns())
        );
        let finding = unit_of_angle(view, &body, DEGREES, &sentence);
        out.push(Finding {
            severity: match body.turns() > IMPOSSIBLE_TURNS {
                true => Severity::Refuse,
                // A motor with a long lever, or a log without the wheel in which gravity is hidden.
                false => Severity::Warn,
            },
            ..finding
        });
    }
}

/// The fits with the angle as read and in other units.
struct Fits {
    as_read: Option<LeastSquares>,
    others: Vec<(f64, LeastSquares)>,
}

impl Fits {
    fn of(body: &Body, cause: &Cause) -> Fits {
        let others = OTHERS
            .into_iter()
            .filter_map(|scale| Some((scale, body.fit(cause, scale)?)));
        Fits {
            as_read: body.fit(cause, 1.0),
            others: others.collect(),
        }
    }

    /// The factor by which the angle is read too large: far from the equilibrium, the torque on a body follows the sine of
    /// its true angle only. `None` where the motion is too small to tell.
    fn unit(&self) -> Option<f64> {
        let left = |fit: &LeastSquares| 1.0 - fit.explained;
        let (scale, best) = self
            .others
            .iter()
            .max_by(|a, b| a.1.explained.total_cmp(&b.1.explained))?;
        let as_read = self.as_read.as_ref();
        let of_read = as_read.map_or(1.0, left);
        // What does not feel the motor either is no pendulum in any unit.
        let is_better = left(best) < LEFT_OVER * of_read && of_read > LEAST_LEFT;
        if best.explained > EXPLAINED && is_better && shows(best, 0) {
            return Some(*scale);
        }
        let is_read = of_read < LEFT_OVER * left(&self.in_degrees()?)
            && of_read < 1.0 - EXPLAINED
            && as_read.is_some_and(|fit| shows(fit, 0));
        is_read.then_some(1.0)
    }

    fn in_degrees(&self) -> Option<LeastSquares> {
        let found = self.others.iter().find(|(scale, _)| *scale == DEGREES);
        found.map(|(_, fit)| fit.clone())
    }
}

fn shows(fit: &LeastSquares, column: usize) -> bool {
    fit.coefficients[column].abs() > STANDARD_ERRORS * fit.std[column]
}

fn is_clear(fit: &LeastSquares, column: usize) -> bool {
    shows(fit, column) && fit.partial(column) > CLEAR
}

fn is(factor: f64, size: f64) -> bool {
    (factor / size - 1.0).abs() < 0.01
}

/// What the exchange of momentum tells: the period, the zero of the angle, the sign and the share of the wheel.
fn exchange(
    view: &View,
    body: &Body,
    fit: &LeastSquares,
    facts: &Facts,
    settled: &mut Settled,
    out: &mut Vec<Finding>,
) {
    if fit.explained < EXPLAINED {
        return;
    }
    // α̈ = −(j_w/Θ) φ̈ + …
    let share = -fit.coefficients[0];
    gravity(view, body, fit, 1, out);
    if !shows(fit, 0) {
        return;
    }
    if share < 0.0 {
        out.push(
            Finding::refusal(
                FindingId::WheelSign,
                "wheel and body accelerate in the same sense, but a motor between them turns them in \
                 opposite senses: one of them has the wrong sign (factor -1)",
            )
            .in_experiment(view.name())
            .with_channel("wheel_speed")
            .with_factor(-1.0)
            .with_fix(
                "sign = { wheel_speed = -1 }, and sign = { current = -1 } too where the current goes with \
                 it (or the signs of angle and rate)",
            ),
        );
        return;
    }
    if let (true, Some(expected)) = (is_clear(fit, 0), facts.wheel_share) {
        match slip(share / expected) {
            Some(factor) if is(factor, DEGREES) => {
                let sentence = too_much_inertia(share / expected, "the bench's wheel");
                out.push(unit_of_angle(view, body, DEGREES, &sentence));
                return;
            }
            Some(factor) => {
                let finding = against_the_bench(view, share / expected, 1.0 / factor);
                let (or_constant, or_mend) =
                    spin_ups::ten_times(share / expected, facts.torque_constant);
                out.push(Finding {
                    sentence: finding.sentence.clone() + &or_constant,
                    fix: finding.fix.clone() + &or_mend,
                    ..finding
                });
                return;
            }
            None if (share / expected).ln().abs() < AGREE => {
                settled.add(view, Channel::WheelSpeed);
                settled.add(view, body.channel);
            }
            None => {}
        }
    }
    if share > 1.0 && SHARE_OF_INERTIA.contains(&(share / DEGREES)) {
        let sentence = too_much_inertia(share, "the whole pendulum");
        out.push(unit_of_angle(view, body, DEGREES, &sentence));
    } else if fit.partial(0) > CLEAR
        && share < SHARE_OF_INERTIA.start
        && SHARE_OF_INERTIA.contains(&(share * RPM))
    {
        out.push(
            Finding::warning(
                FindingId::WheelSpeedFactor,
                format!(
                    "the body moves as if the wheel had {} % of the inertia of the whole pendulum: is the \
                     wheel's speed in rpm?",
                    short(100.0 * share)
                ),
            )
            .in_experiment(view.name())
            .with_channel("wheel_speed")
            .with_factor(RPM)
            .with_fix("units = { wheel_speed = \"rpm\" }"),
        );
    }
}

fn too_much_inertia(times: f64, whose: &str) -> String {
    format!(
        "the body moves as if the wheel had {} times the inertia of {}",
        short(times),
        whose
    )
}

/// The wheel's share of the inertia in this log contradicts that of the bench.
fn against_the_bench(view: &View, times: f64, factor: f64) -> Finding {
    let stated = format!(
        "the body moves as if the wheel had {} times the inertia that spin-ups and [known] say",
        short(times)
    );
    let unit = if is(factor, RPM) {
        "rpm"
    } else if is(factor, DEGREES) {
        "deg/s"
    } else if is(factor, 1e3) {
        "mrad/s"
    } else if is(factor, 1.0 / TAU) {
        "rev/s"
    } else {
        ""
    };
    let finding = match unit {
        "" => Finding::refusal(
            FindingId::WheelSpeedFactor,
            format!(
                "{stated}: the spin-ups' speed is {} times too large against this log, or this log's has the wrong unit",
                short(1.0 / factor)
            ),
        )
        .with_fix(if is(factor, 1.0 / RPM) {
            "units = { wheel_speed = \"rpm\" } at the spin-ups, or take it out here"
        } else {
            "units = { wheel_speed = … }"
        }),
        unit => Finding::refusal(
            FindingId::WheelSpeedFactor,
            format!("{stated}: the wheel's speed is in {unit}"),
        )
        .with_fix(format!("units = {{ wheel_speed = \"{unit}\" }}")),
    };
    finding
        .in_experiment(view.name())
        .with_channel("wheel_speed")
        .with_factor(factor)
}

/// What gravity tells: the period, and where the angle is counted from. The columns of sine and cosine begin with the
/// column `first`.
fn gravity(view: &View, body: &Body, fit: &LeastSquares, first: usize, out: &mut Vec<Finding>) {
    let (sine, cosine) = (fit.coefficients[first], fit.coefficients[first + 1]);
    if body.channel == Channel::Angle && view.kind() == Kind::Driven {
        // −ω² sin(α − c) = −ω² cos c sin α + ω² sin c cos α
        let zero = cosine.atan2(-sine);
        let is_seen = shows(fit, first) || shows(fit, first + 1);
        let unsure = fit.std[first].hypot(fit.std[first + 1]) / sine.hypot(cosine);
        let beyond = |limit: f64| zero.abs() > limit + STANDARD_ERRORS * unsure;
        if is_seen && beyond(ZERO_RAD) {
            let severity = match beyond(WRONG_ZERO_RAD) {
                true => Severity::Refuse,
                false => Severity::Warn,
            };
            out.push(Finding {
                severity,
                ..counted_from(view, zero)
            });
            return;
        }
    }
    // −ω² sin α brings a body back to 0 and drives it away from π.
    if view.kind() == Kind::Balance && sine > 0.0 && is_clear(fit, first) {
        out.push(
            Finding::refusal(
                FindingId::AngleZero,
                "gravity brings the body back to where its angle says upright: it hangs there and does not balance",
            )
            .in_experiment(view.name())
            .with_channel("angle")
            .with_fix("offset = { angle = 3.14159265 } and kind = \"driven\""),
        );
        return;
    }
    if is_clear(fit, first) {
        let period_s = TAU / sine.abs().sqrt();
        swing::period(view, period_s, out);
    }
}

/// The angle at which the body hangs is not 0, but `zero`.
fn counted_from(view: &View, zero: f64) -> Finding {
    let is_upright = (zero.abs() - PI).abs() < ZERO_RAD;
    let (offset, whence) = if is_upright {
        ("3.14159265".to_owned(), "upright")
    } else {
        (short(-zero), "elsewhere")
    };
    Finding::refusal(
        FindingId::AngleZero,
        format!(
            "gravity pulls the body towards {} rad of the angle and not towards 0: the angle is counted from {whence}, \
             and must be 0 hanging",
            short(zero)
        ),
    )
    .in_experiment(view.name())
    .with_channel("angle")
    .with_fix(format!("offset = {{ angle = {offset} }}"))
}

/// What the motor's torque tells against gravity's, where both are known: D α̈ = −G sin α − τ u + friction of the wheel.
/// Their ratio knows no inertia.
fn torque(
    view: &View,
    body: &Body,
    fit: &LeastSquares,
    facts: &Facts,
    settled: &mut Settled,
    out: &mut Vec<Finding>,
) {
    if fit.explained < EXPLAINED || !is_clear(fit, 0) || !is_clear(fit, 1) {
        return;
    }
    if view.kind() == Kind::Driven && body.channel == Channel::Angle && fit.coefficients[1] > 0.0 {
        out.push(counted_from(view, PI));
        return;
    }
    let found_before = out.len();
    swing::period(view, TAU / fit.coefficients[1].abs().sqrt(), out);
    let (Some(gravity), Some(torque_constant)) = (facts.gravity_torque_n_m, facts.torque_constant)
    else {
        return;
    };
    if out.len() > found_before {
        return;
    }
    let ratio = fit.coefficients[0] / fit.coefficients[1] * gravity / torque_constant;
    let stated = format!(
        "an ampere turns the body {} times as much against gravity as torque_constant says",
        short(ratio)
    );
    match slip(ratio) {
        Some(factor) if is(factor, DEGREES) || is(factor, 1.0 / TAU) => {
            out.push(unit_of_angle(view, body, factor, &stated));
        }
        Some(factor) if is(factor, 1e-3) => out.push(
            Finding::refusal(
                FindingId::CurrentFactor,
                format!("{stated}: the current is in mA"),
            )
            .in_experiment(view.name())
            .with_channel("current")
            .with_factor(1e3)
            .with_fix("units = { current = \"mA\" }"),
        ),
        Some(-1.0) => out.push(
            Finding::refusal(
                FindingId::CurrentSign,
                "a positive current turns the body in the positive sense, but the motor turns the wheel so, and the \
                 body against it: one of the two has the wrong sign (factor -1)",
            )
            .in_experiment(view.name())
            .with_channel("current")
            .with_factor(-1.0)
            .with_fix("sign = { current = -1 } (or the signs of angle and rate)"),
        ),
        None if ratio > 0.0 && ratio.ln().abs() < AGREE => {
            settled.add(view, Channel::Current);
            settled.add(view, body.channel);
        }
        _ => {}
    }
}

fn divided_by(factor: f64) -> String {
    if factor > 1.0 {
        format!("divided by {}", short(factor))
    } else {
        format!("times {}", short(1.0 / factor))
    }
}

/// The body's angle, or a rate without an angle, in another unit.
fn unit_of_angle(view: &View, body: &Body, factor: f64, sentence: &str) -> Finding {
    let is_angle = body.channel == Channel::Angle;
    let unit = if is(factor, DEGREES) {
        ["deg", "deg/s"]
    } else if is(factor, 1e3) {
        ["mrad", "mrad/s"]
    } else {
        ["rev", "rev/s"]
    };
    let (id, unit) = if is_angle {
        (FindingId::AngleFactor, unit[0])
    } else {
        (FindingId::RateFactor, unit[1])
    };
    let (key, words) = (
        body.channel.key(),
        match unit {
            "deg" => "degrees",
            "deg/s" => "degrees a second",
            "rev" => "turns",
            other => other,
        },
    );
    let rate = if is_angle && view.samples(Channel::Rate).is_some() {
        " (and the rate's unit likewise, where the rate agrees with the angle)"
    } else if !is_angle && is(factor, 1e3) {
        " (or units = { time = \"ms\" })"
    } else {
        ""
    };
    Finding::refusal(id, format!("{sentence}: the {key} is in {words}"))
        .in_experiment(view.name())
        .with_channel(key)
        .with_factor(factor)
        .with_fix(format!("units = {{ {key} = \"{unit}\" }}{rate}"))
}
