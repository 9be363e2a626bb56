//! The current of a balance log compared with the law stated in `[controller]`, u = −K (α − π, α̇, φ̇).

use std::f64::consts::PI;

use bench_files::{Bench, Channel, Controller};
use identify::commands_per_row;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::regression::{LeastSquares, least_squares};
use crate::slips::{short, slip};
use crate::thresholds::law::{
    CLIPPED, EXPLAINED, LATEST, LONGEST_STEP_S, RATIO, SPARSE, STANDARD_ERRORS,
};
use crate::units::Settled;
use crate::view::View;

const NAMES: [(&str, Channel); 3] = [
    ("angle", Channel::Angle),
    ("rate", Channel::Rate),
    ("wheel_speed", Channel::WheelSpeed),
];

pub(crate) fn check(bench: &Bench, view: &View, settled: &mut Settled, out: &mut Vec<Finding>) {
    let (Some(controller), Kind::Balance) = (bench.controller, view.kind()) else {
        return;
    };
    sample_time(view, &controller, out);
    let Some(ratios) = ratios(view, &controller) else {
        return;
    };
    let finding = |refused: bool, sentence: String| {
        let make = if refused {
            Finding::refusal
        } else {
            Finding::warning
        };
        make(FindingId::Gains, sentence).in_experiment(view.name())
    };
    let slips: Vec<Option<f64>> = ratios.iter().map(|ratio| ratio.and_then(slip)).collect();
    // If all gains are wrong by the same factor, the current is.
    if let Some(factor) = slips[0]
        && slips.iter().all(|slip| *slip == Some(factor))
    {
        let (likely, fix) = if factor == -1.0 {
            (
                "the current, or every gain, has the wrong sign",
                "sign = { current = -1 }, or gains with the other sign (u = −K x)",
            )
        } else {
            (
                "the current is in another unit",
                "units = { current = \"mA\" }",
            )
        };
        out.push(
            finding(
                true,
                format!(
                    "the logged current is {} times the current that the stated gains give for the logged states (−K x): {likely}",
                    short(factor)
                ),
            )
            .with_channel("current")
            .with_factor(factor)
            .with_fix(fix),
        );
        return;
    }
    for (k, (channel, of)) in NAMES.iter().enumerate() {
        let Some(ratio) = ratios[k] else { continue };
        if let Some(factor) = slips[k] {
            // If a state is read too large, its gain comes out too small.
            let (sentence, column_factor) = (
                format!(
                    "the logged current follows the {} with {} times the stated gain {}: the gain or the column \
                     has another unit or sign",
                    channel.replace('_', " "),
                    short(ratio),
                    short(controller.gains[k])
                ),
                1.0 / factor,
            );
            out.push(
                finding(true, sentence)
                    .with_channel(channel)
                    .with_factor(column_factor)
                    .with_fix(fix_of(channel, column_factor, &controller.gains, k, ratio)),
            );
        } else if !(1.0 / RATIO..RATIO).contains(&ratio) {
            out.push(
                finding(
                    false,
                    format!(
                        "the logged current follows the {} with {} times the stated gain {}",
                        channel.replace('_', " "),
                        short(ratio),
                        short(controller.gains[k])
                    ),
                )
                .with_channel(channel)
                .with_factor(ratio)
                .with_fix("state the gains under [controller] that ran while the log was taken"),
            );
        } else {
            // A wrong unit of the current would show in all gains alike.
            settled.add(view, *of);
            settled.add(view, Channel::Current);
        }
    }
}

/// The measured gains of angle, rate and wheel speed as multiples of the stated ones, as far as the log shows them.
fn ratios(view: &View, controller: &Controller) -> Option<[Option<f64>; 3]> {
    let (Some(angle), Some(rate), Some(speed), Some(current)) = (
        view.samples(Channel::Angle),
        view.samples(Channel::Rate),
        view.samples(Channel::WheelSpeed),
        view.samples(Channel::Current),
    ) else {
        return None;
    };
    let fit = |late: usize| -> Option<LeastSquares> {
        let rows: Vec<([f64; 4], f64)> = (late..current.len())
            .filter(|&k| current[k].abs() < CLIPPED * controller.current_limit_a)
            .map(|k| (k - late, current[k]))
            .map(|(k, u)| ([angle[k] - PI, rate[k], speed[k], 1.0], u))
            .collect();
        least_squares(&rows, 1.0)
    };
    let fits = (0..=LATEST).filter_map(fit);
    let best = fits.max_by(|a, b| a.explained.total_cmp(&b.explained))?;
    if best.explained < EXPLAINED {
        return None;
    }
    Some([0, 1, 2].map(|k| {
        let found = best.coefficients[k];
        let stands_out = found.abs() > STANDARD_ERRORS * best.std[k];
        let ratio = found / -controller.gains[k];
        (stands_out && ratio.is_finite()).then_some(ratio)
    }))
}

/// Whether each state has the sign against the current that the stated gains say; `None` where the log does not show it.
pub(crate) fn signs(bench: &Bench, view: &View) -> [(Channel, Option<bool>); 3] {
    let controller = bench.controller.filter(|_| view.kind() == Kind::Balance);
    let ratios = controller.and_then(|controller| ratios(view, &controller));
    let ratios = ratios.unwrap_or_default();
    [0, 1, 2].map(|k| (NAMES[k].1, ratios[k].map(|ratio| ratio > 0.0)))
}

fn fix_of(channel: &str, factor: f64, gains: &[f64; 3], k: usize, ratio: f64) -> String {
    let near = |size: f64| (factor / size).ln().abs() < 0.01;
    let gain = short(gains[k] * ratio);
    let column = if factor == -1.0 {
        format!("sign = {{ {channel} = -1 }}")
    } else if near(crate::slips::RPM) && channel != "angle" {
        format!("units = {{ {channel} = \"rpm\" }}")
    } else if near(crate::slips::DEGREES) && channel != "angle" {
        format!("units = {{ {channel} = \"deg/s\" }}")
    } else if near(crate::slips::DEGREES) {
        format!("units = {{ {channel} = \"deg\" }}")
    } else {
        format!("units = {{ {channel} = … }}")
    };
    format!("{column} if the column is wrong, or the gain {gain} in SI if the gain is")
}

/// Checks the sampling interval. A log has every sample of the controller or every n-th. If the time is read a thousand
/// times too large, the interval is long enough for a body to fall over many times.
fn sample_time(view: &View, controller: &Controller, out: &mut Vec<Finding>) {
    let sample_time_s = controller.sample_time_s;
    let ratio = view.step_s / sample_time_s;
    // Nobody logs only every hundredth sample of a controller, and no bench balances with steps of half a second.
    if view.step_s < LONGEST_STEP_S || ratio < SPARSE {
        sparse_commands(view, controller, out);
        return;
    }
    out.push(
        Finding::refusal(
            FindingId::TimeFactor,
            format!(
                "{} s lie between two samples, but the controller ran every {} s: the time is in ms",
                short(view.step_s),
                short(sample_time_s)
            ),
        )
        .in_experiment(view.name())
        .with_channel("time")
        .with_factor(1e3)
        .with_fix("units = { time = \"ms\" }"),
    );
}

/// Says of a log that it does not show every command, so that no fit uses it.
fn sparse_commands(view: &View, controller: &Controller, out: &mut Vec<Finding>) {
    let Some(commands) = commands_per_row(view.experiment, Some(controller)) else {
        return;
    };
    out.push(
        Finding::warning(
            FindingId::SparseCommands,
            format!(
                "{} s lie between two rows, but the controller gave a command every {} s: what acted between the rows is \
                 unknown, and no fit uses the log",
                short(view.step_s),
                short(controller.sample_time_s)
            ),
        )
        .in_experiment(view.name())
        .with_channel("current")
        .with_factor(commands)
        .with_fix(
            "log every command, or the current that flowed with current_meaning = \"measured\"; or mend sample_time \
             under [controller]",
        ),
    );
}
