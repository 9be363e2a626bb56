//! How the free swings of a bench die out, measured and by the model: table, JSON and figures.

use std::path::{Path, PathBuf};

use figures::{DecayPanel, DecayPoint, Quantity};
use identify::{AtAmplitude, Decay, DecayLaw, Estimate, Record, Trace};
use rayon::prelude::*;
use serde::Serialize;

use crate::bench_folder::file_name;
use crate::failure::Failure;
use crate::report::numbers::{significant, with_uncertainty};
use crate::report::table::{Align, Table};

/// A free swing: what was measured of its decay, and what the model says.
pub struct SwingDecay<'a> {
    record: &'a Record,
    measured: Decay,
    model: Option<Decay>,
}

/// For programs.
#[derive(Serialize)]
pub struct DecayJson {
    experiment: String,
    /// The laws dA/dt = −(C + V A + Q A²) that were fitted, the best first.
    laws: Vec<LawJson>,
    /// Change of the small-swing period from the largest to the smallest amplitude.
    period_drift_percent: f64,
    period_drift_percent_std: f64,
}

#[derive(Serialize)]
struct LawJson {
    /// rad/s; null for a term that the law does not have, here and below.
    dry: Option<f64>,
    /// 1/s.
    viscous: Option<f64>,
    /// 1/(rad s).
    quadratic: Option<f64>,
    relative_rms: f64,
}

const TERMS: [(&str, &str); 3] = [("C", "rad/s"), ("V", "1/s"), ("Q", "1/(rad s)")];

/// The free swings that are long enough to show a decay.
pub fn swing_decays<'a>(records: &'a [Record], traces: &[Vec<Trace>]) -> Vec<SwingDecay<'a>> {
    records
        .par_iter()
        .zip(traces)
        .filter_map(|(record, traces)| {
            let measured = identify::decay(record)?;
            let mut simulated = record.clone();
            for (channel, trace) in simulated.channels.iter_mut().zip(traces) {
                channel.samples.clone_from(&trace.predicted);
            }
            Some(SwingDecay {
                record,
                measured,
                model: identify::decay(&simulated),
            })
        })
        .collect()
}

/// The table of all of them; empty text where there is none.
pub fn text(decays: &[SwingDecay]) -> String {
    let mut table = Table::new(&[
        ("experiment", Align::Left),
        ("best law for the amplitude", Align::Left),
        ("leaves", Align::Right),
        ("small-swing period drifts by", Align::Left),
    ]);
    for decay in decays {
        let (law, rest) = match decay.measured.laws.first() {
            Some(law) => (
                law_text(law),
                format!("{} %", significant(100.0 * law.relative_rms, 2)),
            ),
            None => ("–".to_owned(), "–".to_owned()),
        };
        let Estimate { value, std } = decay.measured.period_drift_percent;
        table.row([
            decay.record.name.clone(),
            law,
            rest,
            format!("{} %", with_uncertainty(value, Some(std))),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "\nHow the free swings die out, without any model: dA/dt = −(C + V A + Q A²)\n{}",
        table.text()
    )
}

fn law_text(law: &DecayLaw) -> String {
    let terms = TERMS.iter().zip(law.coefficients).zip(law.has);
    let terms: Vec<String> = terms
        .filter(|(_, has)| *has)
        .map(|(((name, unit), found), _)| {
            let value = with_uncertainty(found.value, Some(found.std));
            format!("{name} = {value} {unit}")
        })
        .collect();
    terms.join(", ")
}

/// For programs.
pub fn json(decays: &[SwingDecay]) -> Vec<DecayJson> {
    decays
        .iter()
        .map(|decay| DecayJson {
            experiment: decay.record.name.clone(),
            laws: decay
                .measured
                .laws
                .iter()
                .map(|law| {
                    let term =
                        |index: usize| law.has[index].then_some(law.coefficients[index].value);
                    LawJson {
                        dry: term(0),
                        viscous: term(1),
                        quadratic: term(2),
                        relative_rms: law.relative_rms,
                    }
                })
                .collect(),
            period_drift_percent: decay.measured.period_drift_percent.value,
            period_drift_percent_std: decay.measured.period_drift_percent.std,
        })
        .collect()
}

/// Draws decay rate and small-swing period of each over the amplitude.
pub fn figures(decays: &[SwingDecay], bench: &str, out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut paths = Vec::new();
    for decay in decays {
        let path = out.join(format!("decay-{}.svg", file_name(&decay.record.name)));
        figures::write_svg(&path, &figure(decay, bench)?)?;
        paths.push(path);
    }
    Ok(paths)
}

fn figure(decay: &SwingDecay, bench: &str) -> Result<String, Failure> {
    let points = |series: &[AtAmplitude]| -> Vec<DecayPoint> {
        let points = series.iter().map(|at| DecayPoint {
            amplitude: at.amplitude_rad,
            value: at.value,
            std: at.std,
        });
        points.collect()
    };
    let line = |series: Option<&[AtAmplitude]>| -> (Vec<f64>, Vec<f64>) {
        let series = series.unwrap_or_default().iter();
        series.map(|at| (at.amplitude_rad, at.value)).unzip()
    };
    let (measured, model) = (&decay.measured, decay.model.as_ref());
    let rates = points(&measured.rates);
    let periods = points(&measured.small_swing_periods);
    let rate_line = line(model.map(|model| &model.rates[..]));
    let period_line = line(model.map(|model| &model.small_swing_periods[..]));
    let law = measured.laws.first().map_or(String::new(), law_text);
    let drift = measured.period_drift_percent;
    let drift = format!("drift {} %", with_uncertainty(drift.value, Some(drift.std)));
    Ok(figures::decay(&figures::Decay {
        title: &format!("{bench}: how {} dies out", decay.record.name),
        subtitle: "Constant over A: viscous. Rising towards small swings: dry friction. Rising with A: drag",
        amplitude: Quantity {
            name: "amplitude",
            unit: "rad",
        },
        panels: &[
            DecayPanel {
                quantity: Quantity {
                    name: "decay rate −Ȧ/A",
                    unit: "1/s",
                },
                points: &rates,
                model_amplitude: &rate_line.0,
                model: &rate_line.1,
                note: &law,
            },
            DecayPanel {
                quantity: Quantity {
                    name: "period, large-angle effect taken out",
                    unit: "s",
                },
                points: &periods,
                model_amplitude: &period_line.0,
                model: &period_line.1,
                note: &drift,
            },
        ],
    })?)
}
