//! A model compared with the measurements: the output of `identify`, `compare`, `add`, `remove` and `diagnose`.

use plant::LearnedCoordinate;
use workbench::numbers::{fit_percent, number, with_prefix, with_uncertainty};
use workbench::words::{place, residual};
use workbench::{ComparisonReport, EffectChange, Parameter};

use super::findings;
use super::head_lines::head_lines;

use crate::report::table::{Align, Table};

/// Two parameters are listed if the correlation of their errors is at least this. If one of them were known, less than
/// a fifth of the other's variance would remain (1 − 0.9²).
const STRONG_CORRELATION: f64 = 0.9;

/// [`head_lines`] of a comparison, with the warnings about its data and the contradictions.
pub fn head(comparison: &ComparisonReport) -> String {
    let experiments = comparison.experiments.len();
    let samples = comparison.samples();
    let mut text = head_lines(&comparison.bench, experiments, samples, &comparison.notes);
    text.push_str(&findings::list(&comparison.findings));
    if !comparison.contradictions.is_empty() {
        text.push_str("\nWhat cannot all be right\n");
        for sentence in &comparison.contradictions {
            text.push_str(&format!("  - {sentence}\n"));
        }
    }
    text
}

/// Head, parameters, errors, places, remarks.
pub fn whole(comparison: &ComparisonReport) -> String {
    head(comparison)
        + &parameter_table(comparison)
        + &error_table(comparison)
        + &place_table(comparison)
        + &remarks(comparison)
}

/// The text for a model after an effect was added or removed, with the errors before and after.
pub fn changed(change: &EffectChange) -> String {
    let after = &change.after;
    head(after)
        + &parameter_table(after)
        + &provisional(change)
        + &difference_table(change)
        + &place_table(after)
        + &remarks(after)
}

fn provisional(change: &EffectChange) -> String {
    if change.provisional.is_empty() {
        return String::new();
    }
    let names = change.provisional.join(", ");
    format!("\nProvisional until an experiment has decided: {names}\n")
}

fn parameter_table(comparison: &ComparisonReport) -> String {
    let mut table = Table::new(&[
        ("parameter", Align::Left),
        ("value ± standard error", Align::Left),
        ("unit", Align::Left),
        ("from", Align::Left),
    ]);
    for parameter in &comparison.parameters {
        if is_of_curve(&parameter.name) {
            continue;
        }
        table.row([
            parameter.name.clone(),
            with_uncertainty(parameter.value, parameter.std),
            parameter.unit.clone(),
            shortened(&parameter.source, 44),
        ]);
    }
    format!(
        "\nModel: {}\n{}{}{}",
        comparison.effects.join(", "),
        table.text(),
        learned_curves(comparison),
        strong_correlations(comparison)
    )
}

/// Whether a parameter is the torque of a learned curve at one of its knots.
fn is_of_curve(name: &str) -> bool {
    name.starts_with("learned_")
}

/// A line for every learned curve; its numbers are in model.toml and in the JSON.
fn learned_curves(comparison: &ComparisonReport) -> String {
    let curves = LearnedCoordinate::ALL.into_iter().filter_map(|coordinate| {
        let prefix = format!("learned_{}_", coordinate.name());
        let own = comparison.parameters.iter().filter(|parameter| {
            let rest = parameter.name.strip_prefix(&prefix);
            rest.is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit()))
        });
        let own: Vec<&Parameter> = own.collect();
        let unit = &own.first()?.unit;
        let least = own
            .iter()
            .map(|one| one.value)
            .fold(f64::INFINITY, f64::min);
        let most = own
            .iter()
            .map(|one| one.value)
            .fold(f64::NEG_INFINITY, f64::max);
        Some(format!(
            "  {}: a curve over {} with {} knots, {} to {}; it explains nothing\n",
            coordinate.effect_name(),
            coordinate.words(),
            own.len(),
            with_prefix(least, unit),
            with_prefix(most, unit)
        ))
    });
    curves.collect()
}

/// One line for every two parameters with strongly correlated errors.
fn strong_correlations(comparison: &ComparisonReport) -> String {
    let Some(correlation) = &comparison.correlation else {
        return String::new();
    };
    let names = &correlation.parameters;
    let mut text = String::new();
    for (row, a) in names.iter().enumerate() {
        for b in &names[row + 1..] {
            if is_of_curve(a) || is_of_curve(b) {
                continue;
            }
            let found = correlation.between(a, b);
            if found.abs() >= STRONG_CORRELATION {
                let how = if found > 0.0 {
                    "together"
                } else {
                    "against each other"
                };
                text.push_str(&format!(
                    "  the errors of {a} and {b}\n    move {how}: correlation {found:.4}\n"
                ));
            }
        }
    }
    text
}

/// Model against measurement, channel by channel.
pub fn error_table(comparison: &ComparisonReport) -> String {
    let mut table = Table::new(&[
        ("experiment", Align::Left),
        ("channel", Align::Left),
        ("RMSE", Align::Right),
        ("sensor noise", Align::Right),
        ("fit", Align::Right),
    ]);
    for (series, rmse) in comparison.rmse.iter() {
        let unit = series.channel.unit();
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        table.row([
            series.experiment.clone(),
            series.channel.name().to_owned(),
            with_prefix(*rmse, unit),
            with_prefix(number(comparison.sensor_noise.of(series)), unit),
            fit_percent(number(comparison.fit_percent.of(series))),
        ]);
    }
    format!("\nModel against measurement\n{}", table.text())
}

fn difference_table(change: &EffectChange) -> String {
    let mut table = Table::new(&[
        ("experiment/channel", Align::Left),
        ("RMSE before", Align::Right),
        ("after", Align::Right),
        ("sensor noise", Align::Right),
        ("fit before", Align::Right),
        ("after", Align::Right),
    ]);
    let after = &change.after;
    for (series, rmse) in after.rmse.iter() {
        let unit = series.channel.unit();
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let size = |value: Option<f64>| with_prefix(number(value), unit);
        table.row([
            series.to_string(),
            size(change.rmse_before.of(series)),
            with_prefix(*rmse, unit),
            size(after.sensor_noise.of(series)),
            fit_percent(number(change.fit_percent_before.of(series))),
            fit_percent(number(after.fit_percent.of(series))),
        ]);
    }
    format!("\nModel against measurement\n{}", table.text())
}

/// Where the model fails, the most significant place first.
pub fn place_table(comparison: &ComparisonReport) -> String {
    let significant = comparison.places.iter().filter(|place| place.significant);
    let mut table = Table::new(&[
        ("experiment/channel", Align::Left),
        ("seen in", Align::Left),
        ("where", Align::Left),
        ("of its error", Align::Right),
    ]);
    for found in significant {
        table.row([
            format!("{}/{}", found.experiment, found.channel),
            residual(found.residual).to_owned(),
            place(found),
            format!("{:.0} %", 100.0 * found.share_of_error),
        ]);
    }
    if table.is_empty() {
        return "\nWhere the model fails\n  nowhere beyond the noise of the sensors\n".to_owned();
    }
    format!("\nWhere the model fails\n{}", table.text())
}

/// Pushes and open questions, if there are any.
pub fn remarks(comparison: &ComparisonReport) -> String {
    let mut text = String::new();
    let per = if comparison.per_unit_of_inertia {
        " per kg m2"
    } else {
        ""
    };
    let mut table = Table::new(&[
        ("push in", Align::Left),
        ("at", Align::Right),
        ("impulse on the body", Align::Left),
    ]);
    for push in &comparison.pushes {
        table.row([
            push.experiment.clone(),
            format!("{} s", number(push.time_s)),
            format!(
                "({}) mN m s{per}",
                with_uncertainty(1e3 * push.impulse_nms, Some(1e3 * push.impulse_std_nms))
            ),
        ]);
    }
    if !table.is_empty() {
        text.push_str("\nPushes that no column records, left out of the fit\n");
        text.push_str(&table.text());
    }
    let contradicts = |statement: &&String| comparison.contradictions.contains(statement);
    let mut open = comparison.statements.iter();
    let open: Vec<&String> = open.by_ref().filter(|one| !contradicts(one)).collect();
    if !open.is_empty() {
        text.push_str("\nWhat these logs leave open\n");
        for statement in open {
            text.push_str(&format!("  - {statement}\n"));
        }
    }
    text
}

fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(width - 1).collect();
    short.push('…');
    short
}
