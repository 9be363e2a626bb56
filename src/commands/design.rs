//! `flywheel design MODEL`

use std::path::{Path, PathBuf};

use bench_files::{DesignSection, ModelFile};
use serde::Serialize;
use workbench::{
    ControlDesign, DesignReport, DesignSweep, ExpectationSettings, ExportLanguage, LateLoop,
    LoopExpectations, NamedLoop, Session, Swept, loop_drawings, weights_of_excursions,
};

use crate::arguments::{JsonOutput, out_beside};
use crate::failure::Failure;
use crate::report::{Report, WithFigures, listed, write_files};
use crate::views::{design, designs};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Weights of angle (1/rad²), rate (s²/rad²), wheel speed (s²/rad²) and current (1/A²) in place of [design]
    #[arg(long, value_name = "A,B,C,R", value_parser = four, conflicts_with = "excursions")]
    pub weights: Option<[f64; 4]>,
    /// Weights by Bryson's rule, from the allowed angle (rad), rate (rad/s), wheel speed (rad/s) and current (A); "inf"
    /// gives a quantity no weight
    #[arg(long, value_name = "A,B,C,R", value_parser = four)]
    pub excursions: Option<[f64; 4]>,
    /// Time between two commands in s, in place of [design]
    #[arg(long, value_name = "S")]
    pub sample_time: Option<f64>,
    /// Largest current in A, in place of [design]
    #[arg(long, value_name = "A")]
    pub current_limit: Option<f64>,
    /// Delay of the current in s, in addition to the delay in the model
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    pub delay: f64,
    /// A bench whose logs show the noise of the sensors [default: the noise of the thesis' bench]
    #[arg(long, value_name = "BENCH")]
    pub bench: Option<PathBuf>,
    /// Other models to compare with, each designed by the [design] section of its own file
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub compare: Vec<PathBuf>,
    /// Repeat the design at COUNT values of KEY between FROM and TO, evenly spaced on a logarithmic scale (on a linear
    /// one if FROM is 0), and write a CSV and a figure; KEY is angle-weight, rate-weight, wheel-speed-weight,
    /// current-weight, sample-time, current-limit or delay
    #[arg(long, value_name = "KEY=FROM:TO:COUNT", value_parser = sweep)]
    pub sweep: Vec<(Swept, Vec<f64>)>,
    /// Write parameters and matrices as a file for another program
    #[arg(long, value_name = "LANGUAGE", value_parser = language, value_delimiter = ',')]
    pub export: Vec<ExportLanguage>,
    /// Folder for the figures [default: out beside MODEL]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// All results of the command, for the JSON.
#[derive(Serialize)]
struct Everything<'a> {
    #[serde(flatten)]
    report: &'a DesignReport,
    expectations: &'a LoopExpectations,
    late_loop: &'a LateLoop,
    compare: Vec<Compared<'a>>,
    sweeps: &'a [DesignSweep],
}

/// One of the designs that are compared.
#[derive(Serialize)]
struct Compared<'a> {
    name: &'a str,
    report: &'a DesignReport,
    expectations: &'a LoopExpectations,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| out_beside(&arguments.model));
    bench_files::can_write_into(&out)?;
    let designed = designed(arguments)?;
    let settings = ExpectationSettings {
        delay_s: arguments.delay,
        noise: match &arguments.bench {
            Some(bench) => Session::open(bench)?.sensor_noise(),
            None => Default::default(),
        },
    };
    let first = whole(&designed, &settings)?;
    let late_loop = designed.late_loop(&settings)?;
    let others = arguments.compare.iter().map(|path| {
        let other = ControlDesign::read(path)?;
        Ok((other.name().to_owned(), path, whole(&other, &settings)?))
    });
    let others: Vec<(String, &PathBuf, (DesignReport, LoopExpectations))> =
        others.collect::<Result<_, Failure>>()?;
    let sweeps = arguments.sweep.iter();
    let sweeps: Vec<DesignSweep> = sweeps
        .map(|(swept, values)| designed.sweep(*swept, values, &settings))
        .collect();

    let mut files = first.0.drawings()?;
    let name = designed.name();
    files.extend(loop_drawings("", &[named(name, &first)])?);
    let names = names_of(name, &arguments.model, &others);
    let mut all = vec![named(&names[0], &first)];
    all.extend(
        names[1..]
            .iter()
            .zip(&others)
            .map(|(name, (_, _, found))| named(name, found)),
    );
    if all.len() > 1 {
        files.extend(loop_drawings("compare-", &all)?);
    }
    for sweep in &sweeps {
        files.push(sweep.table()?);
        files.push(sweep.drawing(name)?);
    }
    files.extend(
        arguments
            .export
            .iter()
            .map(|language| designed.export(*language)),
    );
    let figures = write_files(&out, &files)?;

    let mut text = design::text(&first.0);
    text.push_str(&designs::expectations(&first.1));
    text.push_str(&designs::late(&late_loop));
    if all.len() > 1 {
        text.push_str(&designs::side_by_side(&all));
    }
    for sweep in &sweeps {
        text.push_str(&designs::sweep(sweep));
    }
    text.push_str("\nFigures\n");
    text.push_str(&listed(&figures));
    let compare = all[1..].iter();
    let result = &Everything {
        report: &first.0,
        expectations: &first.1,
        late_loop: &late_loop,
        compare: compare
            .map(|one| Compared {
                name: one.name,
                report: one.report,
                expectations: one.expectations,
            })
            .collect(),
        sweeps: &sweeps,
    };
    Report::new(text, &WithFigures { result, figures })
}

/// The design of the model with the options of the command in place of the values of its [design].
fn designed(arguments: &Arguments) -> Result<ControlDesign, Failure> {
    let mut file = ModelFile::read(&arguments.model)?;
    let mut wishes = match file.design {
        Some(wishes) => wishes,
        // The model has no [design], as after an identification.
        None if arguments.weights.is_some() || arguments.excursions.is_some() => DesignSection {
            sample_time_s: given(arguments.sample_time, "--sample-time S", &arguments.model)?,
            state_weights: [0.0; 3],
            current_weight: 1.0,
            current_limit_a: given(
                arguments.current_limit,
                "--current-limit A",
                &arguments.model,
            )?,
            friction_linearisation_speed_rad_s: None,
            bias_time_constant_s: None,
        },
        None => return Ok(ControlDesign::of(file)?),
    };
    let weights = match arguments.excursions {
        Some(excursions) => Some(
            weights_of_excursions(excursions)
                .map_err(|reason| Failure::new(format!("--excursions: {reason}")))?,
        ),
        None => arguments.weights,
    };
    if let Some([angle, rate, wheel_speed, current]) = weights {
        wishes.state_weights = [angle, rate, wheel_speed];
        wishes.current_weight = current;
    }
    wishes.sample_time_s = arguments.sample_time.unwrap_or(wishes.sample_time_s);
    wishes.current_limit_a = arguments.current_limit.unwrap_or(wishes.current_limit_a);
    file.design = Some(wishes);
    Ok(ControlDesign::of(file)?)
}

fn given(value: Option<f64>, option: &str, model: &Path) -> Result<f64, Failure> {
    value.ok_or_else(|| {
        Failure::in_file(
            model,
            format!("the model has no [design]; state {option}, too"),
        )
    })
}

fn whole(
    designed: &ControlDesign,
    settings: &ExpectationSettings,
) -> Result<(DesignReport, LoopExpectations), Failure> {
    Ok((designed.report()?, designed.expectations(settings)?))
}

fn named<'a>(name: &'a str, found: &'a (DesignReport, LoopExpectations)) -> NamedLoop<'a> {
    NamedLoop {
        name,
        report: &found.0,
        expectations: &found.1,
    }
}

/// A different name for each design: the name of its model, or the model's path where two models have the same name.
fn names_of(
    first: &str,
    model: &Path,
    others: &[(String, &PathBuf, (DesignReport, LoopExpectations))],
) -> Vec<String> {
    let mut names = vec![first.to_owned()];
    names.extend(others.iter().map(|(name, _, _)| name.clone()));
    let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
    if distinct.len() == names.len() {
        return names;
    }
    let paths = others.iter().map(|(_, path, _)| path.as_path());
    std::iter::once(model)
        .chain(paths)
        .map(|path| path.display().to_string())
        .collect()
}

fn four(text: &str) -> Result<[f64; 4], String> {
    let numbers = text.split(',').map(|part| {
        let number: Result<f64, _> = part.trim().parse();
        number.map_err(|_| format!("\"{}\" is no number", part.trim()))
    });
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| {
        format!(
            "{count} numbers are given, and four are needed: angle, rate, wheel speed, current, as in \
             25,0.5,5e-4,1"
        )
    })
}

/// Largest number of values of a sweep.
const MOST_VALUES: usize = 1000;

fn sweep(text: &str) -> Result<(Swept, Vec<f64>), String> {
    let form = "KEY=FROM:TO:COUNT, as in current-weight=0.1:10:21";
    let (key, range) = text.split_once('=').ok_or(format!("the form is {form}"))?;
    let swept = Swept::ALL.into_iter().find(|one| one.name() == key);
    let names = || Swept::ALL.map(Swept::name).join(", ");
    let swept = swept.ok_or_else(|| format!("\"{key}\" is none of {}", names()))?;
    let parts: Vec<&str> = range.split(':').collect();
    let [from, to, count] = parts[..] else {
        return Err(format!("the form is {form}"));
    };
    let number = |part: &str| -> Result<f64, String> {
        let number = part
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite() && *number >= 0.0);
        number.ok_or(format!(
            "\"{part}\" is no number; zero or a positive number is needed"
        ))
    };
    let (from, to) = (number(from)?, number(to)?);
    let count: usize = count
        .parse()
        .map_err(|_| format!("COUNT is \"{count}\"; a whole number of values is needed"))?;
    if !(2..=MOST_VALUES).contains(&count) || to <= from {
        return Err(format!(
            "FROM < TO and a COUNT of 2 to {MOST_VALUES} are needed"
        ));
    }
    let share = |index: usize| index as f64 / (count - 1) as f64;
    let value = |index: usize| match from {
        0.0 => to * share(index),
        from => from * (to / from).powf(share(index)),
    };
    Ok((swept, (0..count).map(value).collect()))
}

fn language(text: &str) -> Result<ExportLanguage, String> {
    match text {
        "python" => Ok(ExportLanguage::Python),
        "matlab" => Ok(ExportLanguage::Matlab),
        _ => Err(format!(
            "\"{text}\" is no language of an export; python or matlab is needed"
        )),
    }
}
