//! The measured free swings of a bench with the nonlinear and the linear model over them (thesis
//! figure 3.5): table, JSON and figure.

use bench_files::Bench;
use figures::{Line, Panel, Quantity, Role};
use identify::{Effort, Output, Record};
use plant::Kind;
use serde::Serialize;
use simulate::SimulateError;
use simulate::linear_validity::{
    LinearRange, MeasuredPeriod, MeasuredSwing, SwingOverMeasurement, linear_range,
    over_measurement,
};

use crate::failure::Failure;
use crate::model_design::ModelDesign;
use crate::report::numbers::{percent, significant};
use crate::report::table::{Align, Table};

/// Periods over which a swing is compared.
pub const PERIODS: usize = 10;
/// Error of the period at which the linear model counts as no longer good.
const PERIOD_SHARE: f64 = 0.01;

/// A column of a table: its name and its values.
type Column<'a> = (&'static str, &'a [f64]);

/// The free swings of a bench with both models over them.
pub struct SwingLinearity {
    swings: Vec<(String, SwingOverMeasurement)>,
    range: Option<LinearRange>,
}

/// For programs.
#[derive(Serialize)]
pub struct SwingLinearityJson {
    swings: Vec<SwingJson>,
    /// Error of the period that counts as good.
    period_share: f64,
    linear_period_s: Option<f64>,
    /// Smallest and largest amplitude at which the period was measured.
    measured_amplitudes_rad: Option<[f64; 2]>,
    /// Amplitudes between which the measured period is that of the linear model.
    period_good_between_rad: Option<[f64; 2]>,
    /// The next larger amplitude measured, where it no longer is.
    period_off_from_rad: Option<f64>,
}

#[derive(Serialize)]
struct SwingJson {
    experiment: String,
    amplitude_rad: f64,
    /// RMS of measurement − model over the first periods, over the amplitude.
    nonlinear_error: f64,
    linear_error: f64,
}

impl SwingLinearity {
    /// Fits the start of every free swing that has an angle, and nothing else, to the model.
    pub fn of(bench: &Bench, designed: &ModelDesign) -> Result<SwingLinearity, SimulateError> {
        let (model, values) = (&designed.model, &designed.values);
        let mut swings = Vec::new();
        let mut periods = Vec::new();
        for experiment in &bench.experiments {
            if experiment.kind != Kind::FreeSwing {
                continue;
            }
            let record = Record::from_experiment(experiment);
            let Some(channel) = record.channel(Output::Angle) else {
                continue;
            };
            let windows = vec![identify::final_windows(&record, values)];
            let fitted = identify::refit(
                &[&record],
                model,
                values.clone(),
                windows,
                &[],
                Effort::FULL,
            );
            let mut whole_rad = vec![f64::NAN; record.len()];
            let mut start = None;
            for window in fitted.windows.iter().flatten() {
                identify::simulate(&record, window, model, values, |k, reading, state| {
                    whole_rad[k] = reading.angle_rad;
                    if k == 0 {
                        start = Some([state.angle_rad, state.rate_rad_s]);
                    }
                });
            }
            let Some(start) = start else { continue };
            let measured = MeasuredSwing {
                time_s: &record.time_s,
                angle_rad: &channel.samples,
                whole_rad: &whole_rad,
                start,
            };
            let over = over_measurement(model, values, &measured, PERIODS)?;
            swings.push((record.name.clone(), over));
            let found = identify::decay(&record).map_or(Vec::new(), |decay| decay.periods);
            periods.extend(found.iter().map(|at| MeasuredPeriod {
                amplitude_rad: at.amplitude_rad,
                period_s: at.value,
                std_s: at.std,
            }));
        }
        Ok(SwingLinearity {
            swings,
            range: linear_range(model, values, &periods, PERIOD_SHARE)?,
        })
    }

    /// Whether the bench has no such swing.
    pub fn is_empty(&self) -> bool {
        self.swings.is_empty()
    }

    /// The table and what the periods say.
    pub fn text(&self) -> String {
        let mut table = Table::new(&[
            ("free swing", Align::Left),
            ("amplitude", Align::Right),
            ("nonlinear", Align::Right),
            ("linear", Align::Right),
        ]);
        for (name, swing) in &self.swings {
            table.row([
                name.clone(),
                degrees(swing.amplitude_rad),
                percent(swing.whole_error),
                percent(swing.linear_error),
            ]);
        }
        format!(
            "\nMeasured free swings against both models: RMS error over ten periods, of the amplitude\n{}  {}\n",
            table.text(),
            self.range_sentence()
        )
    }

    /// One sentence on the amplitudes at which the linear model has the measured period.
    fn range_sentence(&self) -> String {
        let Some(range) = &self.range else {
            return "no swing is long and clean enough to measure its period".to_owned();
        };
        let (least, most) = range.measured_rad;
        let measured = format!("measured from {} to {}", degrees(least), degrees(most));
        let period = format!("{} s", significant(range.linear_period_s, 4));
        let share = percent(PERIOD_SHARE);
        match range.good_rad {
            None => format!(
                "the period is nowhere within {share} of the linear model's {period} ({measured})"
            ),
            Some((from, to)) => {
                let end = match range.off_from_rad {
                    Some(off) => format!(", off from {} on", degrees(off)),
                    None => String::new(),
                };
                format!(
                    "the period is within {share} of the linear model's {period} from {} to {}{end} ({measured})",
                    degrees(from),
                    degrees(to)
                )
            }
        }
    }

    /// For programs.
    pub fn json(&self) -> SwingLinearityJson {
        let swings = self.swings.iter().map(|(name, swing)| SwingJson {
            experiment: name.clone(),
            amplitude_rad: swing.amplitude_rad,
            nonlinear_error: swing.whole_error,
            linear_error: swing.linear_error,
        });
        SwingLinearityJson {
            swings: swings.collect(),
            period_share: PERIOD_SHARE,
            linear_period_s: self.range.map(|range| range.linear_period_s),
            measured_amplitudes_rad: self.range.map(|range| range.measured_rad.into()),
            period_good_between_rad: self
                .range
                .and_then(|range| range.good_rad)
                .map(<[f64; 2]>::from),
            period_off_from_rad: self.range.and_then(|range| range.off_from_rad),
        }
    }

    /// Measurement, nonlinear and linear model, one panel a swing.
    pub fn figure(&self, model: &str) -> Result<String, Failure> {
        let in_degrees = |series: &[f64]| -> Vec<f64> {
            series.iter().map(|angle| angle.to_degrees()).collect()
        };
        let series: Vec<[Vec<f64>; 3]> = self
            .swings
            .iter()
            .map(|(_, swing)| {
                [
                    in_degrees(&swing.linear_rad),
                    in_degrees(&swing.measured_rad),
                    in_degrees(&swing.whole_rad),
                ]
            })
            .collect();
        let lines: Vec<[Line; 3]> = self
            .swings
            .iter()
            .zip(&series)
            .map(|((_, swing), [linear, measured, whole])| {
                let line = |name, role, y| Line {
                    name,
                    role,
                    x: &swing.time_s,
                    y,
                };
                [
                    line("linear model", Role::Other(0), linear),
                    line("measurement", Role::Measurement, measured),
                    line("nonlinear model", Role::Model, whole),
                ]
            })
            .collect();
        let notes: Vec<String> = self
            .swings
            .iter()
            .map(|(name, swing)| {
                format!(
                    "{name}: off by {} (nonlinear), {} (linear)",
                    percent(swing.whole_error),
                    percent(swing.linear_error)
                )
            })
            .collect();
        let panels: Vec<Panel> = lines
            .iter()
            .zip(&notes)
            .map(|(lines, note)| Panel {
                quantity: Quantity {
                    name: "angle",
                    unit: "°",
                },
                lines,
                limits: &[],
                note,
            })
            .collect();
        Ok(figures::series(&figures::Series {
            title: &format!("{model}: where the linear model leaves the measured swing"),
            subtitle: &format!("First {PERIODS} periods; {}", self.range_sentence()),
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &panels,
            ..Default::default()
        })?)
    }

    /// Name and columns of each swing's table.
    pub fn columns(&self) -> Vec<(&str, [Column<'_>; 4])> {
        self.swings
            .iter()
            .map(|(name, swing)| {
                (
                    name.as_str(),
                    [
                        ("time_s", &swing.time_s[..]),
                        ("measured_angle_rad", &swing.measured_rad),
                        ("nonlinear_angle_rad", &swing.whole_rad),
                        ("linear_angle_rad", &swing.linear_rad),
                    ],
                )
            })
            .collect()
    }
}

fn degrees(angle_rad: f64) -> String {
    format!("{:.1}°", angle_rad.to_degrees())
}
