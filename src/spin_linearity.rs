//! The measured spin-ups of a bench with the nonlinear and the linear model over them (thesis
//! figure 3.6): table, JSON and figure.

use bench_files::Bench;
use figures::{Line, Panel, Quantity, Role};
use identify::{Effort, Output, Record};
use plant::Kind;
use serde::Serialize;
use simulate::SimulateError;
use simulate::linear_validity::{MeasuredSpinUp, SpinUpOverMeasurement, spin_up_over_measurement};

use crate::failure::Failure;
use crate::model_design::ModelDesign;
use crate::report::numbers::{percent, significant};
use crate::report::table::{Align, Table};

/// A column of a table: its name and its values.
type Column<'a> = (&'static str, &'a [f64]);

/// The spin-ups of a bench with both models over them.
pub struct SpinLinearity(Vec<(String, SpinUpOverMeasurement)>);

/// One spin-up, for programs.
#[derive(Serialize)]
pub struct SpinUpJson {
    experiment: String,
    largest_wheel_speed_rad_s: f64,
    /// RMS of measurement − model, over the largest speed.
    nonlinear_error: f64,
    linear_error: f64,
}

impl SpinLinearity {
    /// Fits the start of every spin-up with a wheel speed and a known current, and nothing else, to
    /// the model.
    pub fn of(bench: &Bench, designed: &ModelDesign) -> Result<SpinLinearity, SimulateError> {
        let (model, values) = (&designed.model, &designed.values);
        let mut found = Vec::new();
        for experiment in &bench.experiments {
            if experiment.kind != Kind::SpinUp || experiment.log.current_a.is_none() {
                continue;
            }
            let record = Record::from_experiment(experiment);
            let Some(channel) = record.channel(Output::WheelSpeed) else {
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
            let mut whole_rad_s = vec![f64::NAN; record.len()];
            for window in fitted.windows.iter().flatten() {
                identify::simulate(&record, window, model, values, |k, reading, _| {
                    whole_rad_s[k] = reading.wheel_speed_rad_s;
                });
            }
            let measured = MeasuredSpinUp {
                time_s: &record.time_s,
                wheel_speed_rad_s: &channel.samples,
                current_a: &record.current_a,
                whole_rad_s: &whole_rad_s,
            };
            let over = spin_up_over_measurement(model, values, &measured)?;
            found.push((record.name.clone(), over));
        }
        Ok(SpinLinearity(found))
    }

    /// Whether the bench has no such spin-up.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The table.
    pub fn text(&self) -> String {
        let mut table = Table::new(&[
            ("spin-up", Align::Left),
            ("largest speed", Align::Right),
            ("nonlinear", Align::Right),
            ("linear", Align::Right),
        ]);
        for (name, over) in &self.0 {
            table.row([
                name.clone(),
                format!("{} rad/s", significant(over.largest_rad_s, 3)),
                percent(over.whole_error),
                percent(over.linear_error),
            ]);
        }
        format!(
            "\nMeasured spin-ups against both models: RMS error, of the largest speed\n{}",
            table.text()
        )
    }

    /// For programs.
    pub fn json(&self) -> Vec<SpinUpJson> {
        let spin_ups = self.0.iter().map(|(name, over)| SpinUpJson {
            experiment: name.clone(),
            largest_wheel_speed_rad_s: over.largest_rad_s,
            nonlinear_error: over.whole_error,
            linear_error: over.linear_error,
        });
        spin_ups.collect()
    }

    /// Measurement, nonlinear and linear model, one panel a spin-up.
    pub fn figure(&self, model: &str) -> Result<String, Failure> {
        let lines: Vec<[Line; 3]> = self
            .0
            .iter()
            .map(|(_, over)| {
                let line = |name, role, y| Line {
                    name,
                    role,
                    x: &over.time_s,
                    y,
                };
                [
                    line("linear model", Role::Other(0), &over.linear_rad_s[..]),
                    line("measurement", Role::Measurement, &over.measured_rad_s),
                    line("nonlinear model", Role::Model, &over.whole_rad_s),
                ]
            })
            .collect();
        let notes: Vec<String> = self
            .0
            .iter()
            .map(|(name, over)| {
                format!(
                    "{name}: off by {} (nonlinear), {} (linear)",
                    percent(over.whole_error),
                    percent(over.linear_error)
                )
            })
            .collect();
        let panels: Vec<Panel> = lines
            .iter()
            .zip(&notes)
            .map(|(lines, note)| Panel {
                quantity: Quantity {
                    name: "wheel speed",
                    unit: "rad/s",
                },
                lines,
                limits: &[],
                note,
            })
            .collect();
        Ok(figures::series(&figures::Series {
            title: &format!("{model}: where the linear model leaves the measured spin-up"),
            subtitle: "Body clamped; RMS error of each model, of the largest speed",
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &panels,
            ..Default::default()
        })?)
    }

    /// Name and columns of each spin-up's table.
    pub fn columns(&self) -> Vec<(&str, [Column<'_>; 4])> {
        let tables = self.0.iter().map(|(name, over)| {
            (
                name.as_str(),
                [
                    ("time_s", &over.time_s[..]),
                    ("measured_wheel_speed_rad_s", &over.measured_rad_s),
                    ("nonlinear_wheel_speed_rad_s", &over.whole_rad_s),
                    ("linear_wheel_speed_rad_s", &over.linear_rad_s),
                ],
            )
        });
        tables.collect()
    }
}
