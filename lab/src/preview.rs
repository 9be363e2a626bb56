//! A dropped log as the eye sees it, before anything is known of it for certain.

use std::path::Path;

use bench_files::{Channel, Table};
use data_check::{Choices, units_of};
use serde_json::{Value, json};

use crate::picture::{View, thinned};

/// Rows that are looked at.
const MOST_ROWS: usize = 200_000;
/// Width for which a preview is drawn.
const PIXELS: usize = 600;

/// The columns that are used, over the time in s or, where no column is the time, over the line; with the units that
/// each channel may have.
pub fn of(file: &Path, choices: &Choices) -> Value {
    let Ok(table) = Table::read(file, MOST_ROWS) else {
        return json!({"time": "", "curves": []});
    };
    let column = |channel: &str| {
        let choice = choices.columns.iter().find(|one| one.channel == channel)?;
        let index = table.names.iter().position(|name| *name == choice.column)?;
        Some((choice, &table.columns[index]))
    };
    let (time, name) = match (column("time"), choices.time_step_s) {
        (Some((choice, values)), _) => {
            let seconds = match choice.unit.as_deref() {
                Some("ms") => 1e-3,
                Some("us") => 1e-6,
                Some("ns") => 1e-9,
                _ => 1.0,
            };
            (
                values.iter().map(|value| value * seconds).collect(),
                "time (s)",
            )
        }
        (None, step) => {
            let rows = table.columns.first().map_or(0, Vec::len);
            let step_s = step.unwrap_or(1.0);
            let times: Vec<f64> = (0..rows).map(|row| row as f64 * step_s).collect();
            (times, if step.is_some() { "time (s)" } else { "line" })
        }
    };
    // A line without a time has no place in the picture.
    let shown: Vec<usize> = (0..time.len())
        .filter(|row| time[*row].is_finite())
        .collect();
    let time: Vec<f64> = shown.iter().map(|row| time[*row]).collect();
    let view = View {
        from_s: time.first().copied().unwrap_or_default(),
        to_s: time.last().copied().unwrap_or_default(),
        pixels: PIXELS,
    };
    let used = choices
        .columns
        .iter()
        .filter(|choice| choice.channel != "time");
    let curves = used.filter_map(|choice| {
        let (_, values) = column(&choice.channel)?;
        let values: Vec<f64> = shown.iter().map(|row| values[*row]).collect();
        let curve = thinned(&time, &values, &view);
        let gap = |value: f64| value.is_finite().then_some(value);
        Some(json!({
            "channel": choice.channel,
            "column": choice.column,
            "unit": choice.unit.as_deref().or_else(|| si_of(&choice.channel)),
            "x": curve.time_s,
            "y": curve.value.into_iter().map(gap).collect::<Vec<_>>(),
        }))
    });
    json!({
        "time": name,
        "curves": curves.collect::<Vec<_>>(),
        "units": Channel::ALL.map(|channel| json!([channel.key(), units_of(channel)])),
    })
}

fn si_of(channel: &str) -> Option<&'static str> {
    Channel::from_key(channel).and_then(|channel| units_of(channel).first().copied())
}
