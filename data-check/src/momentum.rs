//! With everything free, wheel and body exchange momentum: Θ α̈ + j_w φ̈ + G sin α = 0, apart from the
//! friction of the pivot. Neither the current nor any effect of the motor enters.

use bench_files::Channel;
use identify::bumps;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::regression::least_squares;
use crate::slips::{DEGREES, RPM, short};
use crate::view::View;
use crate::wheel::SHARE_OF_INERTIA;

/// Standard errors by which the exchange of momentum must show before its sign is reported.
const STANDARD_ERRORS: f64 = 8.0;
/// Smallest number of rows for two coefficients; with fewer, a fit explains much by chance.
const FEWEST_ROWS: usize = 20;
/// Share of the body's acceleration that wheel and gravity must explain before the sign is reported.
const EXPLAINED: f64 = 0.8;
/// Partial share of the wheel above which noise hardly draws its coefficient towards 0.
const CLEAR: f64 = 0.9;
/// Another unit of the angle is taken for right if its residual is below this share of the residual with the stated
/// unit.
const LEFT_OVER: f64 = 0.1;

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    if !matches!(view.kind(), Kind::Balance | Kind::Driven) {
        return;
    }
    let (Some(speed), Some(angle)) = (
        view.samples(Channel::WheelSpeed),
        view.samples(Channel::Angle),
    ) else {
        return;
    };
    let rate = view.samples(Channel::Rate);
    // The angle as read, and as it would be if its column were in degrees.
    let [as_read, in_degrees] = [1.0, DEGREES].map(|scale| {
        let fits = view.bump_lengths_s().filter_map(|length_s| {
            let mut rows = vec![];
            bumps(&view.record, length_s, |integral| {
                let acceleration = match rate {
                    Some(rate) => -integral(&|k| rate[k], 1),
                    None => integral(&|k| angle[k], 2),
                };
                let wheel = -integral(&|k| speed[k], 1);
                let gravity = integral(&|k| (angle[k] / scale).sin(), 0);
                rows.push(([wheel, gravity], acceleration));
            });
            // Neighbouring bumps overlap by half.
            least_squares(&rows, 2.0)
        });
        let fits = fits.filter(|fit| fit.rows >= FEWEST_ROWS);
        fits.max_by(|a, b| a.explained.total_cmp(&b.explained))
    });
    // Far from its equilibrium, the torque on a body follows the sine of its true angle only.
    if let (Some(as_read), Some(in_degrees)) = (&as_read, &in_degrees)
        && in_degrees.explained > EXPLAINED
        && 1.0 - in_degrees.explained < LEFT_OVER * (1.0 - as_read.explained)
    {
        out.push(degrees(
            view,
                "gravity does not act as the sine of the angle, but as the sine of the angle divided by 57.3",
        ));
        return;
    }
    let Some(best) = as_read else { return };
    let (coefficient, std) = (best.coefficients[0], best.std[0]);
    if coefficient.abs() < STANDARD_ERRORS * std || best.explained < EXPLAINED {
        return;
    }
    // α̈ = −(j_w/Θ) φ̈ + …
    let share = -coefficient;
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
    } else if share > 1.0 && SHARE_OF_INERTIA.contains(&(share / DEGREES)) {
        out.push(degrees(
            view,
            &format!(
                "the body moves as if the wheel had {} times the inertia of the whole pendulum",
                short(share)
            ),
        ));
    } else if best.partial(0) > CLEAR
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

fn degrees(view: &View, sentence: &str) -> Finding {
    Finding::refusal(
        FindingId::AngleFactor,
        format!("{sentence}: the angle is in degrees"),
    )
    .in_experiment(view.name())
    .with_channel("angle")
    .with_factor(DEGREES)
    .with_fix("units = { angle = \"deg\" } (and units = { rate = \"deg/s\" } where the rate agrees with it)")
}
