//! A model beside the measurements of a bench: the tables, the JSON and the figures that `identify`,
//! `compare`, `add` and `remove` share.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bench_files::{Correlation, ModelFile, Parameter};
use identify::{FailureMap, Fit, Identification, Push, Quantity, Record, Region, Trace, Window};
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
    /// How their errors hang together.
    pub correlation: Option<Correlation>,
    /// For each record, each of its channels.
    pub traces: Vec<Vec<Trace>>,
    /// For each record, the pushes that nobody recorded.
    pub pushes: Vec<Vec<Push>>,
    /// What the logs leave open.
    pub statements: Vec<String>,
    /// Where the model fails.
    pub failure: FailureMap,
}

/// Correlation from which two parameters are named: less than a fifth of the variance of one is then its
/// own (1 − 0.9²).
const STRONG_CORRELATION: f64 = 0.9;
/// Most figures of broken-down residuals that are drawn.
const MOST_BREAKDOWNS: usize = 4;

/// The JSON of `identify` and `compare`.
#[derive(Serialize)]
pub struct FittedJson {
    bench: String,
    model: PathBuf,
    effects: Vec<&'static str>,
    parameters: Vec<json::Parameter>,
    /// How the errors of the parameters hang together, as in model.toml.
    correlation: Option<json::Correlation>,
    /// RMSE in SI units, by "experiment/channel".
    rmse: Keyed,
    fit_percent: Keyed,
    /// Standard deviation of each sensor's noise in SI units.
    sensor_noise: Keyed,
    #[serde(rename = "where")]
    places: Vec<PlaceJson>,
    pushes: Vec<PushJson>,
    statements: Vec<String>,
    notes: Vec<NoteJson>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    figures: Vec<PathBuf>,
}

/// A place where the model fails.
#[derive(Serialize)]
pub struct PlaceJson {
    experiment: String,
    channel: &'static str,
    coordinate: &'static str,
    from: f64,
    to: f64,
    share_of_error: f64,
    /// "missing torque" or "output": in which residual it was seen.
    residual: &'static str,
    /// Whether there is anything beyond noise.
    significant: bool,
}

/// A push that nobody recorded.
#[derive(Serialize)]
pub struct PushJson {
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
        let fit = &found.fit;
        Fitted {
            failure: identify::breakdown(
                &folder.setup.records,
                &fit.minimum.windows,
                &found.traces,
                &fit.model,
                &fit.values,
            ),
            folder,
            model: found.fit.model.clone(),
            parameters: parameters_of(folder, &found.fit),
            correlation: correlation_of(&found.fit),
            traces: found.traces,
            pushes: found.pushes,
            statements: found.statements,
        }
    }

    /// A model as model.toml has it (`values`: its parameter vector), with what it says about the
    /// experiments from the starts in `windows`.
    pub fn from_model_file(
        folder: &'a BenchFolder,
        file: &ModelFile,
        values: &[f64],
        windows: &[Vec<Window>],
        traces: Vec<Vec<Trace>>,
        pushes: Vec<Vec<Push>>,
    ) -> Fitted<'a> {
        let records = &folder.setup.records;
        Fitted {
            failure: identify::breakdown(records, windows, &traces, &file.model(), values),
            folder,
            model: file.model(),
            parameters: file.parameters.clone(),
            correlation: file.correlation.clone(),
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
            parameters: json::parameters(&self.parameters),
            correlation: json::correlation(self.correlation.as_ref()),
            rmse: self.keyed(|_, trace| trace.rmse),
            fit_percent: self.keyed(|_, trace| trace.fit_percent),
            sensor_noise: self.keyed(|noise, _| noise),
            places: self.places(),
            pushes: self.pushes_json(),
            statements: self.statements.clone(),
            notes: self.notes(),
            figures,
        }
    }

    /// Where the model fails, for programs.
    pub fn places(&self) -> Vec<PlaceJson> {
        let regions = self.failure.regions.iter();
        regions
            .map(|region| PlaceJson {
                experiment: region.experiment.clone(),
                channel: region.channel,
                coordinate: region.coordinate.name(),
                from: region.from,
                to: region.to,
                share_of_error: region.share_of_error,
                residual: residual_name(region.quantity),
                significant: region.is_significant,
            })
            .collect()
    }

    /// The pushes that nobody recorded, for programs.
    pub fn pushes_json(&self) -> Vec<PushJson> {
        self.records()
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
            .collect()
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
        format!(
            "\nModel: {}\n{}{}",
            effects.join(", "),
            table.text(),
            self.strong_correlations()
        )
    }

    /// A line for every two parameters whose errors hardly move alone.
    fn strong_correlations(&self) -> String {
        let Some(correlation) = &self.correlation else {
            return String::new();
        };
        let names = &correlation.parameters;
        let mut text = String::new();
        for (row, a) in names.iter().enumerate() {
            for b in &names[row + 1..] {
                let found = correlation.between(a, b);
                if found.abs() >= STRONG_CORRELATION {
                    let how = if found > 0.0 {
                        "together"
                    } else {
                        "against each other"
                    };
                    text.push_str(&format!(
                        "  the errors of {a} and {b} go {how}: correlation {found:.4}\n"
                    ));
                }
            }
        }
        text
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

    /// Where the model fails, the plainest place first.
    pub fn place_table(&self) -> String {
        let regions = &self.failure.regions;
        if !regions.iter().any(|region| region.is_significant) {
            return "\nWhere the model fails\n  nowhere beyond the noise of the sensors\n"
                .to_owned();
        }
        let mut table = Table::new(&[
            ("experiment/channel", Align::Left),
            ("seen in", Align::Left),
            ("where", Align::Left),
            ("of its error", Align::Right),
        ]);
        for region in regions.iter().filter(|region| region.is_significant) {
            table.row([
                format!("{}/{}", region.experiment, region.channel),
                residual_name(region.quantity).to_owned(),
                place(region),
                format!("{:.0} %", 100.0 * region.share_of_error),
            ]);
        }
        format!("\nWhere the model fails\n{}", table.text())
    }

    /// Pushes and open questions, where there are any.
    pub fn remarks(&self) -> String {
        let mut text = String::new();
        let per = if self.folder.setup.body_scale_known {
            ""
        } else {
            " per kg m2"
        };
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
                        "({}) mN m s{per}",
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
            text.push_str("\nWhat these logs leave open, or contradict\n");
            for statement in &self.statements {
                text.push_str(&format!("  - {statement}\n"));
            }
        }
        text
    }

    /// Draws every experiment: overlay and residual on one time axis.
    pub fn figures(&self) -> Result<Vec<PathBuf>, Failure> {
        self.figures_in(&self.folder.out)
    }

    /// As [`Fitted::figures`], into another folder.
    pub fn figures_in(&self, out: &Path) -> Result<Vec<PathBuf>, Failure> {
        let mut used = BTreeSet::new();
        let mut paths = Vec::new();
        for (index, record) in self.records().iter().enumerate() {
            let svg = self.figure(index)?;
            let mut name = file_name(&record.name);
            // Two names may differ only in what a file name cannot hold.
            while !used.insert(name.clone()) {
                name.push_str("-2");
            }
            let path = out.join(format!("compare-{name}.svg"));
            figures::write_svg(&path, &svg)?;
            paths.push(path);
        }
        for (name, svg) in self.breakdown_figures() {
            let path = out.join(format!("where-{name}.svg"));
            figures::write_svg(&path, &svg)?;
            paths.push(path);
        }
        Ok(paths)
    }

    /// The residuals in which the model's failure is plainest, each over every coordinate.
    fn breakdown_figures(&self) -> Vec<(String, String)> {
        let mut shown: Vec<(&str, &str, Quantity)> = Vec::new();
        for region in self.failure.regions.iter().filter(|r| r.is_significant) {
            let residual = (region.experiment.as_str(), region.channel, region.quantity);
            if !shown.contains(&residual) && shown.len() < MOST_BREAKDOWNS {
                shown.push(residual);
            }
        }
        shown
            .into_iter()
            .map(|(experiment, channel, quantity)| {
                let parts: Vec<&identify::Breakdown> = self
                    .failure
                    .breakdowns
                    .iter()
                    .filter(|part| {
                        part.experiment == experiment
                            && part.channel == channel
                            && part.quantity == quantity
                    })
                    .collect();
                let what = residual_name(quantity);
                let name = file_name(&format!("{experiment} {channel} {what}"));
                (
                    name,
                    self.breakdown_figure(experiment, channel, what, &parts),
                )
            })
            .collect()
    }

    fn breakdown_figure(
        &self,
        experiment: &str,
        channel: &str,
        what: &str,
        parts: &[&identify::Breakdown],
    ) -> String {
        let bins: Vec<Vec<figures::ResidualBin>> = parts
            .iter()
            .map(|part| {
                // Bins are shared by all experiments; those that this one never visits say nothing.
                let visited = part.bins.iter().filter(|bin| bin.count > 0.0);
                let bins = visited.map(|bin| figures::ResidualBin {
                    from: bin.from,
                    until: bin.to,
                    mean: bin.mean,
                    mean_std: bin.mean_std,
                    share_of_error: bin.share,
                });
                bins.collect()
            })
            .collect();
        let panels: Vec<figures::BreakdownPanel> = parts
            .iter()
            .zip(&bins)
            .map(|(part, bins)| figures::BreakdownPanel {
                coordinate: figures::Quantity {
                    name: spoken(part.coordinate.name()),
                    unit: part.coordinate.unit(),
                },
                residual: figures::Quantity {
                    name: "residual",
                    unit: match part.quantity {
                        Quantity::MissingTorque => "N m",
                        Quantity::Output => identify::Output::ALL
                            .iter()
                            .find(|output| output.name() == part.channel)
                            .map_or("", |output| output.unit()),
                    },
                },
                bins,
                sensor_std: part.noise_std,
                note: "",
            })
            .collect();
        figures::breakdown(&figures::Breakdown {
            title: &format!(
                "{}: {what} in {experiment} ({})",
                self.folder.bench.name,
                spoken(channel)
            ),
            subtitle: "What the model leaves unexplained, over each coordinate",
            panels: &panels,
        })
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
        // Where samples are left out (pushes), the model claims nothing.
        let models: Vec<Vec<f64>> = traces
            .iter()
            .map(|trace| {
                let samples = trace.predicted.iter().zip(&record.weight);
                samples
                    .map(|(model, weight)| if *weight > 0.0 { *model } else { f64::NAN })
                    .collect()
            })
            .collect();
        let channels: Vec<figures::Channel> = record
            .channels
            .iter()
            .zip(traces.iter().zip(&models))
            .zip(&notes)
            .map(|((channel, (trace, model)), note)| figures::Channel {
                quantity: figures::Quantity {
                    name: match trace.output {
                        identify::Output::Angle => "angle",
                        identify::Output::Rate => "rate",
                        identify::Output::WheelSpeed => "wheel speed",
                    },
                    unit: trace.output.unit(),
                },
                measurement: &channel.samples,
                model,
                sensor_std: channel.noise_std,
                note,
            })
            .collect();
        let labels: Vec<String> = self.pushes[index]
            .iter()
            .map(|push| with_prefix(push.impulse_nms, "N m s"))
            .collect();
        let markers: Vec<figures::Marker> = self.pushes[index]
            .iter()
            .zip(&labels)
            .map(|(push, label)| figures::Marker {
                at: push.time_s,
                label,
            })
            .collect();
        let in_time: Vec<(&Region, String)> = self
            .failure
            .regions
            .iter()
            .filter(|region| {
                region.is_significant
                    && region.experiment == record.name
                    && region.coordinate == identify::Coordinate::Time
            })
            .map(|region| {
                let label = format!("{:.0} % of the error", 100.0 * region.share_of_error);
                (region, label)
            })
            .collect();
        let regions: Vec<figures::Region> = in_time
            .iter()
            .map(|(region, label)| figures::Region {
                from: region.from,
                until: region.to,
                label,
            })
            .collect();
        let effects: Vec<&str> = self.model.effects().iter().map(|e| e.name()).collect();
        Ok(figures::overlay(&figures::Overlay {
            title: &format!("{}: {}", self.folder.bench.name, record.name),
            subtitle: &format!("Model with {}", effects.join(", ")),
            time_s: &record.time_s,
            channels: &channels,
            regions: &regions,
            markers: &markers,
            zoom_s: None,
        })?)
    }
}

fn residual_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::MissingTorque => "missing torque",
        Quantity::Output => "output",
    }
}

/// A name of the contract as it is spoken.
fn spoken(name: &str) -> &str {
    match name {
        "wheel_speed" => "wheel speed",
        "wheel_angle" => "wheel angle",
        other => other,
    }
}

/// Middle of a region in the unit of its coordinate.
pub fn middle_of(region: &Region) -> f64 {
    0.5 * (region.from + region.to)
}

/// A region in words: "angle 0.1 to 0.2 rad".
pub fn place(region: &Region) -> String {
    format!(
        "{} {} to {} {}",
        spoken(region.coordinate.name()),
        significant(region.from, 3),
        significant(region.to, 3),
        region.coordinate.unit()
    )
}

/// The parameters of a fit for model.toml: those that were given and those that were found; those
/// that no log can show are left out.
pub fn parameters_of(folder: &BenchFolder, fit: &Fit) -> Vec<Parameter> {
    let setup = &folder.setup;
    let infos = fit.model.parameters();
    // A negative one is a contradiction, which the statements name, and no parameter.
    let derived = identify::body_inertia(setup, fit).filter(|(value, _)| *value > 0.0);
    let derived = derived.map(|(value, std)| Parameter {
        name: "body_inertia".to_owned(),
        value,
        std,
        unit: "kg m2".to_owned(),
        source: "total_inertia less wheel, masses, lengths".to_owned(),
    });
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
                None if infos[position].is_whole => "chosen: a whole number".to_owned(),
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
        .chain(derived)
        .collect()
}

/// The correlations of a fit for model.toml. Parameters that were given or derived have none.
pub fn correlation_of(fit: &Fit) -> Option<Correlation> {
    let infos = fit.model.parameters();
    let (positions, matrix) = fit.correlation()?;
    Some(Correlation {
        parameters: positions
            .iter()
            .map(|&position| infos[position].name.to_owned())
            .collect(),
        matrix: matrix
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
    })
}

fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short: String = text.chars().take(width - 1).collect();
    short.push('…');
    short
}
