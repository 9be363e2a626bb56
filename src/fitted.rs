//! A model beside the measurements of a bench: the tables, the JSON and the figures that `identify`,
//! `compare`, `add` and `remove` share.

use std::collections::BTreeSet;
use std::path::PathBuf;

use bench_files::{ModelFile, Parameter};
use identify::{Fit, Identification, Push, Record, Trace};
use plant::Model;
use serde::Serialize;

use crate::bench_folder::{BenchFolder, file_name};
use crate::failure::Failure;
use crate::report::json::{self, Keyed};
use crate::report::numbers::{significant, with_prefix, with_uncertainty};
use crate::report::table::{Align, Table};

/// A model and what it says about every experiment.
pub struct Fitted<'a> {
    folder: &'a BenchFolder,
    /// The structure of the model.
    pub model: Model,
    /// Its parameters as model.toml has them.
    pub parameters: Vec<Parameter>,
    /// For each record, each of its channels.
    pub traces: Vec<Vec<Trace>>,
    /// For each record, the pushes that nobody recorded.
    pub pushes: Vec<Vec<Push>>,
    /// What the logs leave open.
    pub statements: Vec<String>,
}

/// The JSON of `identify` and `compare`.
#[derive(Serialize)]
pub struct FittedJson {
    bench: String,
    model: PathBuf,
    effects: Vec<&'static str>,
    parameters: Vec<json::Parameter>,
    /// RMSE in SI units, by "experiment/channel".
    rmse: Keyed,
    fit_percent: Keyed,
    /// Standard deviation of each sensor's noise in SI units.
    sensor_noise: Keyed,
    pushes: Vec<PushJson>,
    statements: Vec<String>,
    notes: Vec<NoteJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    figures: Vec<PathBuf>,
}

#[derive(Serialize)]
struct PushJson {
    experiment: String,
    time_s: f64,
    impulse_nms: f64,
    impulse_std_nms: f64,
}

#[derive(Serialize)]
struct NoteJson {
    /// Null for what concerns the whole bench.
    experiment: Option<String>,
    note: String,
}

impl<'a> Fitted<'a> {
    /// What an identification found.
    pub fn from_identification(folder: &'a BenchFolder, found: Identification) -> Fitted<'a> {
        Fitted {
            folder,
            model: found.fit.model.clone(),
            parameters: parameters_of(folder, &found.fit),
            traces: found.traces,
            pushes: found.pushes,
            statements: found.statements,
        }
    }

    /// A model as model.toml has it, with what it says about the experiments.
    pub fn from_model_file(
        folder: &'a BenchFolder,
        file: &ModelFile,
        traces: Vec<Vec<Trace>>,
        pushes: Vec<Vec<Push>>,
    ) -> Fitted<'a> {
        Fitted {
            folder,
            model: file.model(),
            parameters: file.parameters.clone(),
            traces,
            pushes,
            statements: Vec::new(),
        }
    }

    fn records(&self) -> &[Record] {
        &self.folder.setup.records
    }

    /// Every channel of every record with its noise and its comparison.
    fn channels(&self) -> impl Iterator<Item = (&Record, f64, &Trace)> {
        self.records()
            .iter()
            .zip(&self.traces)
            .flat_map(|(record, traces)| {
                record
                    .channels
                    .iter()
                    .zip(traces)
                    .map(move |(channel, trace)| (record, channel.noise_std, trace))
            })
    }

    /// One number for each "experiment/channel".
    pub fn keyed(&self, value: impl Fn(f64, &Trace) -> f64) -> Keyed {
        Keyed(
            self.channels()
                .map(|(record, noise, trace)| {
                    (
                        format!("{}/{}", record.name, trace.output.name()),
                        value(noise, trace),
                    )
                })
                .collect(),
        )
    }

    /// For programs.
    pub fn json(&self, figures: Vec<PathBuf>) -> FittedJson {
        FittedJson {
            bench: self.folder.bench.name.clone(),
            model: self.folder.model_path.clone(),
            effects: self.model.effects().iter().map(|e| e.name()).collect(),
            parameters: self
                .parameters
                .iter()
                .map(|parameter| json::Parameter {
                    name: parameter.name.clone(),
                    value: parameter.value,
                    std: parameter.std,
                    unit: parameter.unit.clone(),
                })
                .collect(),
            rmse: self.keyed(|_, trace| trace.rmse),
            fit_percent: self.keyed(|_, trace| trace.fit_percent),
            sensor_noise: self.keyed(|noise, _| noise),
            pushes: self
                .records()
                .iter()
                .zip(&self.pushes)
                .flat_map(|(record, pushes)| {
                    pushes.iter().map(|push| PushJson {
                        experiment: record.name.clone(),
                        time_s: push.time_s,
                        impulse_nms: push.impulse_nms,
                        impulse_std_nms: push.impulse_std_nms,
                    })
                })
                .collect(),
            statements: self.statements.clone(),
            notes: self.notes(),
            figures,
        }
    }

    fn notes(&self) -> Vec<NoteJson> {
        let bench = &self.folder.bench;
        let general = bench.notes.iter().map(|note| NoteJson {
            experiment: None,
            note: note.clone(),
        });
        let special = bench.experiments.iter().flat_map(|experiment| {
            experiment.report.notes.iter().map(|note| NoteJson {
                experiment: Some(experiment.name.clone()),
                note: note.to_string(),
            })
        });
        general.chain(special).collect()
    }

    /// The line that names the bench, and what there is to know about its files.
    pub fn head(&self) -> String {
        let samples: usize = self.records().iter().map(Record::len).sum();
        let mut text = format!(
            "{}: {} experiments, {samples} samples\n",
            self.folder.bench.name,
            self.records().len(),
        );
        for note in self.notes() {
            match note.experiment {
                Some(experiment) => text.push_str(&format!("  {experiment}: {}\n", note.note)),
                None => text.push_str(&format!("  {}\n", note.note)),
            }
        }
        text
    }

    /// The parameters.
    pub fn parameter_table(&self) -> String {
        let effects: Vec<&str> = self.model.effects().iter().map(|e| e.name()).collect();
        let mut table = Table::new(&[
            ("parameter", Align::Left),
            ("value ± standard error", Align::Left),
            ("unit", Align::Left),
            ("from", Align::Left),
        ]);
        for parameter in &self.parameters {
            table.row([
                parameter.name.clone(),
                with_uncertainty(parameter.value, parameter.std),
                parameter.unit.clone(),
                shortened(&parameter.source, 44),
            ]);
        }
        format!("\nModel: {}\n{}", effects.join(", "), table.text())
    }

    /// Model against measurement, channel by channel.
    pub fn error_table(&self) -> String {
        let mut table = Table::new(&[
            ("experiment", Align::Left),
            ("channel", Align::Left),
            ("RMSE", Align::Right),
            ("sensor noise", Align::Right),
            ("fit", Align::Right),
        ]);
        for (record, noise, trace) in self.channels() {
            let unit = trace.output.unit();
            table.row([
                record.name.clone(),
                trace.output.name().to_owned(),
                with_prefix(trace.rmse, unit),
                with_prefix(noise, unit),
                format!("{:.2} %", trace.fit_percent),
            ]);
        }
        format!("\nModel against measurement\n{}", table.text())
    }

    /// Pushes and open questions, where there are any.
    pub fn remarks(&self) -> String {
        let mut text = String::new();
        let mut table = Table::new(&[
            ("push in", Align::Left),
            ("at", Align::Right),
            ("impulse on the body", Align::Left),
        ]);
        for (record, pushes) in self.records().iter().zip(&self.pushes) {
            for push in pushes {
                table.row([
                    record.name.clone(),
                    format!("{:.3} s", push.time_s),
                    format!(
                        "({}) mN m s",
                        with_uncertainty(1e3 * push.impulse_nms, Some(1e3 * push.impulse_std_nms))
                    ),
                ]);
            }
        }
        if !table.is_empty() {
            text.push_str("\nPushes that no column records, left out of the fit\n");
            text.push_str(&table.text());
        }
        if !self.statements.is_empty() {
            text.push_str("\nWhat these logs leave open\n");
            for statement in &self.statements {
                text.push_str(&format!("  - {statement}\n"));
            }
        }
        text
    }

    /// Draws every experiment: overlay and residual on one time axis.
    pub fn figures(&self) -> Result<Vec<PathBuf>, Failure> {
        let mut used = BTreeSet::new();
        let mut paths = Vec::new();
        for (index, record) in self.records().iter().enumerate() {
            let svg = self.figure(index)?;
            let mut name = file_name(&record.name);
            // Two names may differ only in what a file name cannot hold.
            while !used.insert(name.clone()) {
                name.push_str("-2");
            }
            let path = self.folder.out.join(format!("compare-{name}.svg"));
            figures::write_svg(&path, &svg)?;
            paths.push(path);
        }
        Ok(paths)
    }

    fn figure(&self, index: usize) -> Result<String, Failure> {
        let (record, traces) = (&self.records()[index], &self.traces[index]);
        let notes: Vec<String> = traces
            .iter()
            .map(|trace| {
                format!(
                    "RMSE {}, fit {} %",
                    with_prefix(trace.rmse, trace.output.unit()),
                    significant(trace.fit_percent, 4)
                )
            })
            .collect();
        let channels: Vec<figures::Channel> = record
            .channels
            .iter()
            .zip(traces)
            .zip(&notes)
            .map(|((channel, trace), note)| figures::Channel {
                quantity: figures::Quantity {
                    name: match trace.output {
                        identify::Output::Angle => "angle",
                        identify::Output::Rate => "rate",
                        identify::Output::WheelSpeed => "wheel speed",
                    },
                    unit: trace.output.unit(),
                },
                measurement: &channel.samples,
                model: &trace.predicted,
                sensor_std: channel.noise_std,
                note,
            })
            .collect();
        let labels: Vec<String> = self.pushes[index]
            .iter()
            .map(|push| format!("{} N m s", with_prefix(push.impulse_nms, "").trim_end()))
            .collect();
        let markers: Vec<figures::Marker> = self.pushes[index]
            .iter()
            .zip(&labels)
            .map(|(push, label)| figures::Marker {
                at: push.time_s,
                label,
            })
            .collect();
        let effects: Vec<&str> = self.model.effects().iter().map(|e| e.name()).collect();
        Ok(figures::overlay(&figures::Overlay {
            title: &format!("{}: {}", self.folder.bench.name, record.name),
            subtitle: &format!("Model with {}", effects.join(", ")),
            time_s: &record.time_s,
            channels: &channels,
            regions: &[],
            markers: &markers,
            zoom_s: None,
        })?)
    }
}

/// The parameters of a fit for model.toml: those that were given and those that were found; those
/// that no log can show are left out.
fn parameters_of(folder: &BenchFolder, fit: &Fit) -> Vec<Parameter> {
    let setup = &folder.setup;
    let infos = fit.model.parameters();
    (0..infos.len())
        .filter_map(|position| {
            let free = fit.unknowns.free.iter().position(|&at| at == position);
            let given = setup.known.get(position).is_some_and(Option::is_some);
            let unit = setup.unit(&fit.model, position);
            let source = match free {
                Some(unknown) => setup
                    .records
                    .iter()
                    .filter(|record| {
                        identify::relevant(record, &fit.model, &fit.unknowns).contains(&unknown)
                    })
                    .map(|record| record.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
                None if given && unit.ends_with("per kg m2") => {
                    "set to 1: torques are per unit of inertia".to_owned()
                }
                None if given => "[known] in bench.toml".to_owned(),
                None => return None,
            };
            Some(Parameter {
                name: infos[position].name.to_owned(),
                value: fit.values[position],
                std: fit.std(position),
                unit,
                source,
            })
        })
        .collect()
}

fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(width - 1).collect();
    short.push('…');
    short
}
