//! A diagnosis in words.

use workbench::numbers::{fit_percent, with_prefix, with_uncertainty};
use workbench::words::set;
use workbench::{DiagnosisReport, HeldOutBy, SuspectEffect};

use super::{comparison, decay};
use crate::report::table::{Align, Table};

/// The whole text.
pub fn text(report: &DiagnosisReport) -> String {
    let last = &report.last;
    let mut text = format!("{}\n{}\n", comparison::head(last), report.sentence);
    if let Some(missing) = &report.missing_torque {
        text.push_str(&format!("Add the curve with: {}\n", missing.command));
    }
    // If there is a contradiction, the residual itself may be only noise.
    let shown = report.remains.as_ref();
    if let Some(remains) = shown.filter(|remains| remains.over_noise > 1.0) {
        text.push_str(&format!("{}\n", remains.sentence()));
    }
    text.push_str(&staircase_table(report));
    text.push_str(&suspect_table(report));
    if !report.ambiguous_between.is_empty() {
        text.push_str("\nEqually good explanations\n");
        for effects in &report.ambiguous_between {
            let name = set(effects.iter().map(String::as_str));
            text.push_str(&format!("  - {name}\n"));
        }
    }
    if !report.next_experiment.is_empty() {
        text.push_str(&format!(
            "\nNext experiment\n  {}\n",
            report.next_experiment
        ));
    }
    text.push_str(&decay::text(&report.decay));
    text + &comparison::place_table(last) + &comparison::remarks(last)
}

/// The error of every series after each step, down to the sensor's noise.
pub fn staircase_table(report: &DiagnosisReport) -> String {
    let steps = &report.steps;
    let names: Vec<String> = steps.iter().map(|step| step.name()).collect();
    let mut heads = vec![("RMSE of experiment/channel", Align::Left)];
    heads.extend(names.iter().map(|name| (name.as_str(), Align::Right)));
    heads.push(("sensor noise", Align::Right));
    let mut table = Table::new(&heads);
    for (series, noise) in report.sensor_noise.iter() {
        let unit = series.channel.unit();
        let size = |rmse: Option<f64>| match rmse {
            Some(rmse) => with_prefix(rmse, unit),
            None => "–".to_owned(),
        };
        let mut row = vec![series.to_string()];
        row.extend(steps.iter().map(|step| size(step.rmse.of(series))));
        row.push(with_prefix(*noise, unit));
        table.row(row);
        let unseen = steps.iter().map(|step| step.validation_rmse.of(series));
        let unseen: Vec<Option<f64>> = unseen.collect();
        if unseen.iter().any(Option::is_some) {
            let mut row = vec!["  held out".to_owned()];
            row.extend(unseen.into_iter().map(size));
            row.push(String::new());
            table.row(row);
        }
    }
    let mut row = vec!["mean fit, held out".to_owned()];
    row.extend(
        steps
            .iter()
            .map(|step| fit_percent(step.validation_fit_percent)),
    );
    row.push(String::new());
    table.row(row);
    let held_out = match report.held_out_by {
        HeldOutBy::Experiments => "predicted by the other experiments",
        HeldOutBy::SecondHalves => "the second half of each log, predicted by the first",
    };
    let worse: String = steps
        .iter()
        .filter(|step| step.held_out_worse)
        .map(|step| {
            format!(
                "{}: the held-out data are predicted worse with it\n",
                step.name()
            )
        })
        .collect();
    format!(
        "\nThe error, step by step (held out: {held_out})\n{}{worse}",
        table.text()
    )
}

fn suspect_table(report: &DiagnosisReport) -> String {
    if report.suspects.is_empty() {
        return "\nSuspects\n  none: no effect of the library promises a gain\n".to_owned();
    }
    let mut table = Table::new(&[
        ("suspect", Align::Left),
        ("probability", Align::Right),
        ("takes away", Align::Right),
        ("fit, held out", Align::Right),
        ("in the model with", Align::Left),
        ("its parameters", Align::Left),
    ]);
    let mut words = String::new();
    for suspect in &report.suspects {
        let mut parameters: Vec<String> = suspect
            .parameters
            .iter()
            .map(|parameter| {
                let value = with_uncertainty(parameter.value, parameter.std);
                let unit = match parameter.unit.as_str() {
                    "1" => "",
                    unit => unit,
                };
                format!("{} {value} {unit}", parameter.name)
                    .trim_end()
                    .to_owned()
            })
            .collect();
        let without = suspect.without_value.iter();
        parameters.extend(without.map(|one| format!("{}: {}", one.name, one.why)));
        table.row([
            suspect.effect.clone(),
            probability(suspect.probability),
            most_taken_away(suspect),
            fit_percent(suspect.validation_fit_percent),
            others_of(suspect),
            parameters.join(", "),
        ]);
        words.push_str(&format!("  {}: {}\n", suspect.effect, suspect.fingerprint));
    }
    format!("\nSuspects\n{}\n{words}", table.text())
}

/// The largest share of a series' error that the suspect alone removes.
fn most_taken_away(suspect: &SuspectEffect) -> String {
    let shares = suspect.takes_away.iter().map(|(_, share)| *share);
    fit_percent(100.0 * shares.fold(f64::NAN, f64::max))
}

/// The other effects of the suspect's model, without those of the base model.
fn others_of(suspect: &SuspectEffect) -> String {
    let always = ["body-viscous-friction", "wheel-viscous-friction"];
    let is_other = |name: &&str| *name != suspect.effect && !always.contains(name);
    let others = suspect.model.iter().map(String::as_str).filter(is_other);
    match set(others) {
        none if none.is_empty() => "–".to_owned(),
        others => others,
    }
}

/// A probability; one that rounds to 0 or 1 is given as a bound.
fn probability(value: f64) -> String {
    if value < 0.005 {
        "< 1 %".to_owned()
    } else if value > 0.995 {
        "> 99 %".to_owned()
    } else {
        format!("{:.0} %", 100.0 * value)
    }
}
