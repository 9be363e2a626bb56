//! A diagnosis in words, as JSON and as figures: what `diagnose` and `demo` say about the effects
//! that a model lacks.

use std::path::PathBuf;

use diagnose::{Diagnosis, Step, Suspect, Verdict};
use identify::{Fit, Identification, Record};
use plant::EffectId;
use serde::Serialize;

use crate::bench_folder::BenchFolder;
use crate::failure::Failure;
use crate::fitted::{Fitted, PlaceJson, PushJson, middle_of, parameters_of, place};
use crate::report::json::{self, Keyed};
use crate::report::numbers::{significant, with_prefix, with_uncertainty};
use crate::report::table::{Align, Table};
use crate::swing_decay::{self, DecayJson, SwingDecay, swing_decays};

/// A diagnosis of a bench.
pub struct Diagnosed<'a> {
    folder: &'a BenchFolder,
    /// What was found.
    pub found: Diagnosis,
    /// The model of the last step beside the measurements.
    pub last: Fitted<'a>,
    /// How the free swings die out, beside the model of the last step.
    decays: Vec<SwingDecay<'a>>,
}

/// The JSON of the contract, with what else there is to say.
#[derive(Serialize)]
pub struct DiagnosisJson {
    bench: String,
    verdict: &'static str,
    sentence: String,
    steps: Vec<StepJson>,
    suspects: Vec<SuspectJson>,
    ambiguous_between: Vec<Vec<&'static str>>,
    next_experiment: String,
    #[serde(rename = "where")]
    places: Vec<PlaceJson>,
    /// The largest structured remainder, in units of its sensor's noise.
    remainder: f64,
    sensor_noise: Keyed,
    pushes: Vec<PushJson>,
    /// How each free swing dies out, as measured.
    decay: Vec<DecayJson>,
    /// What the logs leave open, one sentence each.
    statements: Vec<String>,
    figures: Vec<PathBuf>,
}

#[derive(Serialize)]
struct StepJson {
    effect: Option<&'static str>,
    parameters: Vec<json::Parameter>,
    rmse: Keyed,
    fit_percent: Keyed,
    validation_fit_percent: f64,
    /// RMSE of experiments that the parameters have not seen.
    validation_rmse: Keyed,
}

/// A suspect.
#[derive(Serialize)]
pub struct SuspectJson {
    /// The effect.
    pub effect: &'static str,
    probability: f64,
    validation_fit_percent: f64,
    /// Those of the effect alone.
    pub parameters: Vec<json::Parameter>,
    rmse: Keyed,
    /// One sentence.
    pub fingerprint: String,
}

impl DiagnosisJson {
    /// The suspects that are more probable than not.
    pub fn likely_suspects(&self) -> impl Iterator<Item = &SuspectJson> {
        self.suspects
            .iter()
            .filter(|suspect| suspect.probability > 0.5)
    }
}

impl<'a> Diagnosed<'a> {
    /// Diagnoses a fitted model; `say` is told what is going on.
    pub fn new(
        folder: &'a BenchFolder,
        identified: &Identification,
        say: &dyn Fn(&str),
    ) -> Result<Diagnosed<'a>, Failure> {
        let fit = &identified.fit;
        let found = diagnose::diagnose(&folder.setup, &fit.model, fit.minimum.clone(), say);
        let Some(step) = found.last() else {
            return Err(Failure::in_file(
                &folder.bench.folder,
                "the diagnosis has no step: nothing could be fitted",
            ));
        };
        say("locating what remains");
        let setup = &folder.setup;
        let last = if found.steps.len() == 1 {
            identified.clone()
        } else if let Some(known) = identify::describe(setup, &step.fit) {
            known
        } else {
            // The diagnosis has read the logs differently: without pushes that only it found.
            let start = (step.fit.values.clone(), step.fit.minimum.windows.clone());
            identify::identify(setup, &step.fit.model, Some(start))
                .map_err(|error| Failure::in_file(&folder.bench.folder, error))?
        };
        let last = Fitted::from_identification(folder, last);
        Ok(Diagnosed {
            folder,
            found,
            decays: swing_decays(&folder.setup.records, &last.traces),
            last,
        })
    }

    fn records(&self) -> &[Record] {
        &self.folder.setup.records
    }

    /// Name, noise and unit of every series.
    fn series(&self) -> Vec<(String, f64, &'static str)> {
        let records = self.records().iter();
        records
            .flat_map(|record| {
                record.channels.iter().map(|channel| {
                    (
                        format!("{}/{}", record.name, channel.output.name()),
                        channel.noise_std,
                        channel.output.unit(),
                    )
                })
            })
            .collect()
    }

    fn keyed(&self, values: impl IntoIterator<Item = f64>) -> Keyed {
        let names = self.series().into_iter().map(|(name, ..)| name);
        Keyed(names.zip(values).collect())
    }

    /// The verdict as a sentence or two.
    pub fn sentence(&self) -> String {
        let found = &self.found;
        let added = names(
            &found
                .steps
                .iter()
                .filter_map(|step| step.effect)
                .collect::<Vec<_>>(),
        );
        let noise = if found.remainder > 0.0 {
            format!(
                "noise, with structure of at most {} of a sensor's noise",
                significant(found.remainder, 2)
            )
        } else {
            "nothing but noise".to_owned()
        };
        match found.verdict {
            Verdict::NothingMissing => {
                format!("Nothing is missing: what the model leaves in the measurements is {noise}.")
            }
            Verdict::Explained => format!(
                "Explained: the model lacks {added}. What remains in the measurements is then \
                 {noise}."
            ),
            Verdict::Ambiguous => {
                let sets: Vec<String> = found
                    .ambiguous_between
                    .iter()
                    .map(|set| set_name(set))
                    .collect();
                let beside = match added.as_str() {
                    "" => String::new(),
                    added => format!(" What all of them share was added: {added}."),
                };
                format!(
                    "Ambiguous: something is missing, but these logs cannot tell {}.{beside}",
                    sets.join(" from ")
                )
            }
            Verdict::Unexplained => {
                let missing = match added.as_str() {
                    "" => "something".to_owned(),
                    added => format!("the model lacks {added}, and beyond that something"),
                };
                format!(
                    "Unexplained: {missing} remains{}: {} times the noise of the sensor. No effect \
                     in the library accounts for it.",
                    self.remains_at(),
                    significant(found.remainder, 2)
                )
            }
        }
    }

    /// " at about 0.15 rad (angle 0.1 to 0.2 rad in free swing 52 deg)".
    fn remains_at(&self) -> String {
        let plainest = self.last.failure.regions.first();
        plainest.map_or(String::new(), |region| {
            format!(
                " at about {} {} ({} in {})",
                significant(middle_of(region), 2),
                region.coordinate.unit(),
                place(region),
                region.experiment
            )
        })
    }

    /// Everything in words.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n{}\n", self.last.head(), self.sentence());
        text.push_str(&self.staircase_table());
        text.push_str(&self.suspect_table());
        let found = &self.found;
        if !found.ambiguous_between.is_empty() {
            text.push_str("\nEqually good explanations\n");
            for set in &found.ambiguous_between {
                text.push_str(&format!("  - {}\n", set_name(set)));
            }
        }
        if !found.next_experiment.is_empty() {
            text.push_str(&format!("\nNext experiment\n  {}\n", found.next_experiment));
        }
        text.push_str(&swing_decay::text(&self.decays));
        text + &self.last.place_table() + &self.last.remarks()
    }

    fn step_name(&self, step: &Step) -> String {
        match step.effect {
            None => "as it was".to_owned(),
            Some(effect) => format!("+ {}", effect.name()),
        }
    }

    /// The error of every series after each step, down to the sensor's noise.
    pub fn staircase_table(&self) -> String {
        let steps = &self.found.steps;
        let names: Vec<String> = steps.iter().map(|step| self.step_name(step)).collect();
        let mut heads = vec![("RMSE of experiment/channel", Align::Left)];
        heads.extend(names.iter().map(|name| (name.as_str(), Align::Right)));
        heads.push(("sensor noise", Align::Right));
        let mut table = Table::new(&heads);
        let errors: Vec<Vec<f64>> = steps.iter().map(|step| step.candidate.rmse()).collect();
        let held_out: Vec<Keyed> = steps.iter().map(held_out).collect();
        let series = self.series();
        for (index, (name, noise, unit)) in series.iter().enumerate() {
            let mut row = vec![name.clone()];
            row.extend(errors.iter().map(|errors| with_prefix(errors[index], unit)));
            row.push(with_prefix(*noise, unit));
            table.row(row);
            let unseen: Vec<String> = held_out
                .iter()
                .map(|keyed| match keyed.0.iter().find(|(key, _)| key == name) {
                    Some((_, rmse)) => with_prefix(*rmse, unit),
                    None => "–".to_owned(),
                })
                .collect();
            if unseen.iter().any(|cell| cell != "–") {
                let mut row = vec!["  held out".to_owned()];
                row.extend(unseen);
                row.push(String::new());
                table.row(row);
            }
        }
        let mut row = vec!["mean fit, held out".to_owned()];
        row.extend(
            steps
                .iter()
                .map(|step| percent(step.validation_fit_percent)),
        );
        row.push(String::new());
        table.row(row);
        format!(
            "\nThe error, step by step (held out: predicted by the other experiments)\n{}",
            table.text()
        )
    }

    fn suspect_table(&self) -> String {
        if self.found.suspects.is_empty() {
            return "\nSuspects\n  none: no effect of the library promises anything\n".to_owned();
        }
        let mut table = Table::new(&[
            ("suspect", Align::Left),
            ("probability", Align::Right),
            ("fit, held out", Align::Right),
            ("parameters", Align::Left),
        ]);
        let mut words = String::new();
        for suspect in &self.found.suspects {
            let parameters: Vec<String> = self
                .own_parameters(suspect)
                .iter()
                .map(|parameter| {
                    let value = with_uncertainty(parameter.value, parameter.std);
                    format!("{} {value} {}", parameter.name, parameter.unit)
                        .trim_end()
                        .to_owned()
                })
                .collect();
            table.row([
                suspect.effect.name().to_owned(),
                probability(suspect.probability),
                percent(suspect.validation_fit_percent),
                parameters.join(", "),
            ]);
            words.push_str(&format!(
                "  {}: {}\n",
                suspect.effect.name(),
                suspect.fingerprint
            ));
        }
        format!("\nSuspects\n{}\n{words}", table.text())
    }

    /// The parameters that are the suspect's own.
    fn own_parameters(&self, suspect: &Suspect) -> Vec<bench_files::Parameter> {
        let own = suspect.effect.info().parameters;
        let mut parameters = parameters_of(self.folder, &suspect.fit);
        parameters.retain(|parameter| own.iter().any(|info| info.name == parameter.name));
        parameters
    }

    /// For programs.
    pub fn json(&self, figures: Vec<PathBuf>) -> DiagnosisJson {
        let found = &self.found;
        let parameters = |fit: &Fit| json::parameters(&parameters_of(self.folder, fit));
        DiagnosisJson {
            bench: self.folder.bench.name.clone(),
            verdict: found.verdict.name(),
            sentence: self.sentence(),
            steps: found
                .steps
                .iter()
                .map(|step| StepJson {
                    effect: step.effect.map(EffectId::name),
                    parameters: parameters(&step.fit),
                    rmse: self.keyed(step.candidate.rmse()),
                    fit_percent: self.keyed(
                        step.candidate
                            .traces
                            .iter()
                            .flatten()
                            .map(|trace| trace.fit_percent),
                    ),
                    validation_fit_percent: step.validation_fit_percent,
                    validation_rmse: held_out(step),
                })
                .collect(),
            suspects: found
                .suspects
                .iter()
                .map(|suspect| SuspectJson {
                    effect: suspect.effect.name(),
                    probability: suspect.probability,
                    validation_fit_percent: suspect.validation_fit_percent,
                    parameters: json::parameters(&self.own_parameters(suspect)),
                    rmse: self.keyed(suspect.rmse.iter().copied()),
                    fingerprint: suspect.fingerprint.clone(),
                })
                .collect(),
            ambiguous_between: found
                .ambiguous_between
                .iter()
                .map(|set| set.iter().map(|effect| effect.name()).collect())
                .collect(),
            next_experiment: found.next_experiment.clone(),
            places: self.last.places(),
            remainder: found.remainder,
            sensor_noise: self.keyed(self.series().iter().map(|(_, noise, _)| *noise)),
            pushes: self.last.pushes_json(),
            decay: swing_decay::json(&self.decays),
            statements: self.last.statements.clone(),
            figures,
        }
    }

    /// Draws the staircase, the suspects, and the last model against every experiment.
    pub fn figures(&self) -> Result<Vec<PathBuf>, Failure> {
        let out = &self.folder.out;
        let mut paths = vec![out.join("staircase.svg"), out.join("suspects.svg")];
        figures::write_svg(&paths[0], &self.staircase_figure()?)?;
        figures::write_svg(&paths[1], &self.suspect_figure())?;
        let bench = &self.folder.bench.name;
        paths.extend(swing_decay::figures(&self.decays, bench, out)?);
        paths.extend(self.last.figures()?);
        Ok(paths)
    }

    fn staircase_figure(&self) -> Result<String, Failure> {
        let steps = &self.found.steps;
        let names: Vec<String> = steps.iter().map(|step| self.step_name(step)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let errors: Vec<Vec<f64>> = steps.iter().map(|step| step.candidate.rmse()).collect();
        let unseen: Vec<Keyed> = steps.iter().map(held_out).collect();
        let series = self.series();
        let mut lines: Vec<(&str, bool, Vec<f64>)> = Vec::new();
        for (index, (name, noise, _)) in series.iter().enumerate() {
            let seen = errors.iter().map(|errors| errors[index] / noise).collect();
            lines.push((name, false, seen));
            let unseen: Vec<f64> = unseen
                .iter()
                .map(|keyed| {
                    let found = keyed.0.iter().find(|(key, _)| key == name);
                    found.map_or(f64::NAN, |(_, rmse)| rmse / noise)
                })
                .collect();
            if unseen.iter().any(|ratio| ratio.is_finite()) {
                lines.push((name, true, unseen));
            }
        }
        let traces: Vec<figures::StaircaseTrace> = lines
            .iter()
            .map(|(name, held_out, ratios)| figures::StaircaseTrace {
                name,
                held_out: *held_out,
                rmse_over_floor: ratios,
            })
            .collect();
        Ok(figures::staircase(&figures::Staircase {
            title: &format!(
                "{}: the error after each added effect",
                self.folder.bench.name
            ),
            subtitle: &self.sentence(),
            steps: &names,
            traces: &traces,
        })?)
    }

    fn suspect_figure(&self) -> String {
        let suspects: Vec<figures::Suspect> = self
            .found
            .suspects
            .iter()
            .map(|suspect| figures::Suspect {
                name: suspect.effect.name(),
                probability: suspect.probability,
                evidence: &suspect.fingerprint,
            })
            .collect();
        figures::suspects(&figures::Suspects {
            title: &format!("{}: what the model lacks", self.folder.bench.name),
            subtitle: &self.sentence(),
            suspects: &suspects,
        })
    }
}

/// The RMSE of experiments that the step's parameters have not seen.
fn held_out(step: &Step) -> Keyed {
    let series = step.held_out.iter();
    Keyed(
        series
            .map(|series| {
                (
                    format!("{}/{}", series.experiment, series.output.name()),
                    series.rmse,
                )
            })
            .collect(),
    )
}

/// Effects in words; empty for none.
fn names(effects: &[EffectId]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    names.join(" and ")
}

/// Effects that act together.
fn set_name(effects: &[EffectId]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    names.join(" + ")
}

fn percent(value: f64) -> String {
    if value.is_finite() {
        format!("{value:.2} %")
    } else {
        "–".to_owned()
    }
}

/// A probability; what rounds to nothing or to certainty is said as a bound.
fn probability(value: f64) -> String {
    if value < 0.005 {
        "< 1 %".to_owned()
    } else if value > 0.995 {
        "> 99 %".to_owned()
    } else {
        format!("{:.0} %", 100.0 * value)
    }
}
