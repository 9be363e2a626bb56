//! Where everything is free, wheel and body exchange momentum: Θ α̈ + j_w φ̈ + G sin α = 0 but for the
//! friction of the pivot. The current does not enter, and neither does any effect of the motor.

use bench_files::Channel;
use identify::bumps;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::regression::least_squares;
use crate::view::View;

/// Standard errors by which the exchange must stand out before its sign is believed.
const STANDARD_ERRORS: f64 = 8.0;
/// Share of the body's acceleration that wheel and gravity must explain for the same.
const EXPLAINED: f64 = 0.8;

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
    let fits = view.bump_lengths_s().filter_map(|length_s| {
        let mut rows = vec![];
        bumps(&view.record, length_s, |integral| {
            let acceleration = match rate {
                Some(rate) => -integral(&|k| rate[k], 1),
                None => integral(&|k| angle[k], 2),
            };
            let wheel = -integral(&|k| speed[k], 1);
            rows.push(([wheel, integral(&|k| angle[k].sin(), 0)], acceleration));
        });
        least_squares(&rows, 2.0)
    });
    let Some(best) = fits.max_by(|a, b| a.explained.total_cmp(&b.explained)) else {
        return;
    };
    let (share, std) = (best.coefficients[0], best.std[0]);
    if share < STANDARD_ERRORS * std || best.explained < EXPLAINED {
        return;
    }
    out.push(
        Finding::refusal(
            FindingId::WheelSign,
            "wheel and body accelerate in the same sense, but a motor between them turns them in opposite \
             senses: one of them has the wrong sign (factor -1)",
        )
        .in_experiment(view.name())
        .with_channel("wheel_speed")
        .with_factor(-1.0)
        .with_fix(
            "sign = { wheel_speed = -1 }, and sign = { current = -1 } too where the current goes with it \
             (or the signs of angle and rate)",
        ),
    );
}
