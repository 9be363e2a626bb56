//! The marks as CSV.

use plant::EffectId;

use crate::marks::Entry;

/// The names of effects joined by a plus sign; "nothing" if there are none.
fn joined(effects: &[EffectId]) -> String {
    if effects.is_empty() {
        return "nothing".to_owned();
    }
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    names.join(" + ")
}

fn finished(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, csv::Error> {
    writer
        .into_inner()
        .map_err(|error| csv::Error::from(std::io::Error::other(error.to_string())))
}

/// One row per bench: hidden terms, verdict, mark. Sizes and remainder are in units of noise.
///
/// # Errors
/// [`csv::Error`] if a row cannot be written.
pub fn benches_csv(entries: &[Entry]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "bench",
        "hidden",
        "size_over_noise",
        "trace_beside_others_over_noise",
        "noise_angle_rad",
        "noise_rate_rad_s",
        "noise_wheel_speed_rad_s",
        "experiments",
        "observations",
        "verdict",
        "named",
        "first_suspect",
        "probability",
        "second_suspect",
        "remainder_over_noise",
        "ties",
        "mark",
        "seconds",
    ])?;
    let list = |values: &[f64]| {
        let texts: Vec<String> = values.iter().map(|value| format!("{value:.3}")).collect();
        texts.join(" ")
    };
    for entry in entries {
        let paper = &entry.paper;
        let suspect = |index: usize| paper.suspects.get(index);
        let noise = |index: usize| {
            entry
                .noise
                .get(index)
                .map_or(String::new(), |noise| format!("{noise:.3e}"))
        };
        let ties: Vec<String> = paper.ties.iter().map(|(set, _)| joined(set)).collect();
        writer.write_record([
            entry.label.clone(),
            entry.truth.join(" + "),
            list(&entry.sizes),
            list(&paper.shown),
            noise(0),
            noise(1),
            noise(2),
            entry.experiments.join("; "),
            entry.observations.to_string(),
            paper.verdict.name().to_owned(),
            joined(&paper.named),
            suspect(0).map_or(String::new(), |(effect, _)| effect.name().to_owned()),
            suspect(0).map_or(String::new(), |(_, probability)| {
                format!("{probability:.4}")
            }),
            suspect(1).map_or(String::new(), |(effect, _)| effect.name().to_owned()),
            format!("{:.3}", paper.remainder),
            ties.join("; "),
            paper.mark.name().to_owned(),
            format!("{:.2}", paper.seconds),
        ])?;
    }
    finished(writer)
}

/// One row for every added parameter that has a true value, SI.
///
/// # Errors
/// [`csv::Error`] if a row cannot be written.
pub fn intervals_csv(entries: &[Entry]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "bench",
        "parameter",
        "true_si",
        "value_si",
        "std_si",
        "inside_95",
    ])?;
    for entry in entries {
        for interval in &entry.paper.intervals {
            writer.write_record([
                entry.label.clone(),
                interval.name.to_owned(),
                format!("{:.6e}", interval.truth),
                format!("{:.6e}", interval.value),
                format!("{:.3e}", interval.std),
                interval.covers().to_string(),
            ])?;
        }
    }
    finished(writer)
}
