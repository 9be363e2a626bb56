//! The data for the page as JSON: the library's results, with texts for people beside the numbers.

use plant::{EffectId, Model, ParameterInfo};
use serde_json::{Value, json};
use workbench::numbers::{fit_percent, significant, with_prefix, with_uncertainty};
use workbench::{
    ComparisonReport, Error, FAILS_OVER_NOISE, FailurePlace, HardwareError, PerSeries, Preset,
    words,
};

use crate::desk::{Desk, OpenBench};
use crate::picture::lost;
use crate::why_facts;
use crate::work::CONTROLLER;

/// Range of the fine track of a slider, in standard errors to either side.
const FINE_ERRORS: f64 = 10.0;
/// Largest number of shaded stretches of an experiment.
const MOST_STRETCHES: usize = 100;
/// Largest number of runs of lost samples of a channel that are marked.
const MOST_LOST: usize = 100;

/// The state without curves and diagnosis.
pub fn state(desk: &Desk) -> Value {
    let (bench, running, failure) = {
        let state = desk.state();
        let running = state.running.as_ref().map(
            |running| json!({"number": running.number, "name": running.name, "says": running.says}),
        );
        (state.bench.clone(), running, state.failure.clone())
    };
    json!({
        "running": running,
        "failure": failure,
        "changed_outside": desk.changed_outside(),
        "bench": bench.map(|bench| open_bench(&bench)),
    })
}

fn open_bench(bench: &OpenBench) -> Value {
    let found = &bench.comparison;
    let model = bench.session.model();
    let tie = model.and_then(|model| model.tie.as_ref());
    let names = |set: &[EffectId]| -> Vec<&str> { set.iter().map(|one| one.name()).collect() };
    let wishes = model.and_then(|model| model.design);
    json!({
        "name": found.bench,
        "opened": bench.opened,
        "folder": bench.folder,
        "model_path": bench.session.model_path(),
        "experiments": experiments(found),
        "errors": error_table(found),
        "notes": found.notes,
        "statements": found.statements,
        "effects": found.effects,
        "base_effects": names(Model::base().effects()),
        "provisional": tie.map_or(vec![], |tie| names(&tie.provisional)),
        "rivals": tie.map_or(vec![], |tie| tie.rivals.iter().map(|set| names(set)).collect()),
        "sliders": sliders(bench),
        "places": found.places.iter().filter(|place| place.significant).map(place).collect::<Vec<_>>(),
        "staircase": staircase(bench),
        "undo": bench.undo.len(),
        "unsaved": bench.unsaved,
        "has_diagnosis": bench.diagnosis.is_some(),
        "design": wishes.unwrap_or_else(|| bench.session.usual_design()),
        "has_controller": bench.generated.is_some(),
        "has_proof": bench.proof.is_some(),
    })
}

fn experiments(found: &ComparisonReport) -> Vec<Value> {
    let logged = found.experiments.iter().zip(&found.curves);
    logged
        .map(|(logged, curves)| {
            let channels = curves.channels.iter().map(|channel| {
                json!({
                    "channel": channel.channel.name(),
                    "spoken": words::spoken(channel.channel.name()),
                    "unit": channel.channel.unit(),
                    "noise_std": channel.noise_std,
                    "lost": lost_samples(&curves.time_s, &channel.measured),
                })
            });
            let pushes = found.pushes.iter();
            let pushes = pushes.filter(|push| push.experiment == logged.name);
            let impulse_unit = if found.per_unit_of_inertia {
                "N m s per kg m2"
            } else {
                "N m s"
            };
            json!({
                "name": logged.name,
                "kind": logged.kind,
                "samples": logged.samples,
                "duration_s": logged.duration_s,
                "channels": channels.collect::<Vec<_>>(),
                "pushes": pushes.map(|push| json!({
                    "time_s": push.time_s,
                    "text": format!("push {}", with_prefix(push.impulse_nms, impulse_unit)),
                })).collect::<Vec<_>>(),
                "shading": shading(found, &logged.name),
            })
        })
        .collect()
}

/// The longest runs of lost samples of a channel, with their number altogether; `null` where none is lost.
fn lost_samples(time_s: &[f64], measured: &[f64]) -> Value {
    let mut runs = lost(time_s, measured);
    let samples: usize = runs.iter().map(|run| run.count).sum();
    if samples == 0 {
        return Value::Null;
    }
    runs.sort_by_key(|run| std::cmp::Reverse(run.count));
    let marked = runs.iter().take(MOST_LOST);
    json!({
        "samples": samples,
        "runs": runs.len(),
        "marked": marked.map(|run| [run.from_s, run.to_s]).collect::<Vec<_>>(),
    })
}

/// Where the model fails most in an experiment: the longest stretches of its time, and what they are; `null` where the
/// model does not fail.
fn shading(found: &ComparisonReport, experiment: &str) -> Value {
    let Some(mut shading) = found.shading(experiment) else {
        return Value::Null;
    };
    let length = |[from, to]: &[f64; 2]| to - from;
    shading
        .stretches_s
        .sort_by(|a, b| length(b).total_cmp(&length(a)));
    shading.stretches_s.truncate(MOST_STRETCHES);
    json!({"stretches": shading.stretches_s, "text": shading.text})
}

fn place(place: &FailurePlace) -> Value {
    json!({
        "experiment": place.experiment,
        "channel": place.channel,
        "text": words::place(place),
        "residual": words::residual(place.residual),
        "share": format!("{} %", significant(100.0 * place.share_of_error, 2)),
    })
}

/// The rows of the error table.
pub fn error_table(found: &ComparisonReport) -> Vec<Value> {
    let all = found.curves.iter().flat_map(|curves| {
        let name = &curves.experiment;
        curves.channels.iter().map(move |channel| (name, channel))
    });
    all.map(|(experiment, channel)| error_row(experiment, channel))
        .collect()
}

/// A row of the error table.
pub fn error_row(experiment: &str, channel: &workbench::ChannelCurves) -> Value {
    let unit = channel.channel.unit();
    json!({
        "experiment": experiment,
        "channel": channel.channel.name(),
        "spoken": words::spoken(channel.channel.name()),
        "rmse": channel.rmse,
        "rmse_text": with_prefix(channel.rmse, unit),
        "noise_text": with_prefix(channel.noise_std, unit),
        "fit_text": fit_percent(channel.fit_percent),
        "over_noise": channel.over_noise(),
        "over_noise_text": significant(channel.over_noise(), 3),
        "fails": channel.over_noise() > FAILS_OVER_NOISE,
    })
}

/// The description of a parameter of the model, by its name.
fn info_of(model: &Model, name: &str) -> Option<(&'static ParameterInfo, Option<&'static str>)> {
    let effects = model.effects().iter();
    let own = effects.flat_map(|effect| {
        let info = effect.info();
        info.parameters
            .iter()
            .map(move |one| (one, Some(info.name)))
    });
    let all: Vec<_> = own.collect();
    let found = all.into_iter().find(|(info, _)| info.name == name);
    found.or_else(|| {
        let infos = model.parameters();
        let info = infos.into_iter().find(|info| info.name == name)?;
        Some((info, None))
    })
}

fn sliders(bench: &OpenBench) -> Vec<Value> {
    let Some(file) = bench.session.model() else {
        return Vec::new();
    };
    let model = file.model();
    let parameters = bench.predictor.parameters();
    let known = parameters.iter().filter_map(|(name, value)| {
        let parameter = file.parameter(name)?;
        let (info, effect) = info_of(&model, name)?;
        let std = parameter.std.filter(|std| *std > 0.0 && std.is_finite());
        let errors = FINE_ERRORS * std.unwrap_or(0.0);
        // The value itself to either side; a value of zero without an error may become as large as is plausible.
        let wide = match value.abs().max(errors) {
            size if size > 0.0 => size,
            _ => info.plausible.1.abs(),
        };
        let fine = if errors > 0.0 { errors } else { 0.05 * wide };
        let track = |half: f64| {
            let (least, most) = info.bounds;
            [(value - half).max(least), (value + half).min(most)]
        };
        Some(json!({
            "name": name,
            "meaning": info.meaning,
            "effect": effect,
            "value": value,
            "std": std,
            "unit": parameter.unit,
            "source": parameter.source,
            "text": with_uncertainty(*value, std),
            "coarse": track(wide),
            "fine": track(fine),
            "whole": info.is_whole,
        }))
    });
    known.collect()
}

fn staircase(bench: &OpenBench) -> Value {
    let noise = &bench.comparison.sensor_noise;
    let rows = noise.iter().map(|(series, noise)| {
        let unit = series.channel.unit();
        let cells = bench.staircase.iter().map(|stair| {
            let rmse = stair.rmse.of(series);
            json!({
                "text": rmse.map_or("–".to_owned(), |rmse| with_prefix(rmse, unit)),
                "over_noise": rmse.map(|rmse| rmse / noise),
                "fails": rmse.is_some_and(|rmse| rmse > FAILS_OVER_NOISE * noise),
            })
        });
        json!({
            "series": series.to_string(),
            "noise_text": with_prefix(*noise, unit),
            "cells": cells.collect::<Vec<_>>(),
        })
    });
    let labels = bench.staircase.iter().map(|stair| stair.label.as_str());
    json!({
        "labels": labels.collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
    })
}

/// The effects of the library.
pub fn effects() -> Value {
    json!(workbench::effect_library())
}

/// The diagnosis, with the data for the pictures of its reasons.
pub fn diagnosis(bench: &OpenBench) -> Value {
    let Some(found) = &bench.diagnosis else {
        return Value::Null;
    };
    let report = &found.report;
    let suspects = report.suspects.iter().map(|suspect| {
        let parameters = suspect.parameters.iter().map(|one| {
            let text = with_uncertainty(one.value, one.std);
            format!("{} = {text} {}", one.name, one.unit)
        });
        let without = suspect.without_value.iter();
        let without = without.map(|one| format!("{}: {}", one.name, one.why));
        json!({
            "effect": suspect.effect,
            "probability": suspect.probability,
            "model": suspect.model,
            "parameters": parameters.chain(without).collect::<Vec<_>>(),
            "fingerprint": suspect.fingerprint,
            "takes_away": takes_away(&suspect.takes_away),
        })
    });
    // A diagnosis of another model is shown, but cannot be applied.
    let begins_here = found.first.effects == bench.comparison.effects;
    json!({
        "verdict": report.verdict.name(),
        "sentence": report.sentence,
        "missing_torque": report.missing_torque,
        "remains": report.remains.as_ref().map(|remains| remains.sentence()),
        "added": report.added(),
        "taken_out": report.taken_out(),
        "applied": found.applied,
        "current": begins_here || report.last_model.effects == bench.comparison.effects,
        "can_apply": !found.applied && begins_here && report.steps.len() > 1,
        "suspects": suspects.collect::<Vec<_>>(),
        "ambiguous_between": report.ambiguous_between,
        "next_experiment": report.next_experiment,
        "places": report.places.iter().filter(|one| one.significant).map(place).collect::<Vec<_>>(),
        "reasons": why_facts::reasons(&found.first, &report.last),
        "decay": report.decay.iter().filter_map(|swing| why_facts::decay(swing, None)).collect::<Vec<_>>(),
        "fingerprints": bench.fingerprints.iter().map(|one| why_facts::fingerprint(one)).collect::<Vec<_>>(),
        "recipe": report.recipe.as_ref().map(|recipe| why_facts::recipe(recipe, &report.ambiguous_between)),
    })
}

/// The three series with the largest removed share of their error; what is below a percent is nothing.
fn takes_away(shares: &PerSeries) -> Vec<Value> {
    let mut all: Vec<_> = shares
        .iter()
        .filter(|(_, share)| share.is_finite() && *share >= 0.01)
        .collect();
    all.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    all.iter()
        .take(3)
        .map(|(series, share)| {
            json!({"series": series.to_string(), "text": format!("{} %", significant(100.0 * share, 2))})
        })
        .collect()
}

/// What the generator needs to know of sensors and drive and the bench does not state, each with an example; and what is
/// assumed if that is taken from the bench of the thesis. Empty where nothing is missing, or something else stands against
/// a controller: the generator says that.
fn hardware(bench: &OpenBench) -> Value {
    let Ok(designed) = bench.session.design() else {
        return Value::Null;
    };
    match designed.module_spec(None) {
        Err(Error::Hardware {
            source: HardwareError::Missing { missing },
            ..
        }) => {
            let assumed = designed.module_spec(Some(Preset::ThesisBench));
            json!({
                "missing": missing,
                "bench_path": bench.folder.join("bench.toml"),
                "assumed": assumed.map(|spec| spec.assumed).unwrap_or_default(),
            })
        }
        _ => Value::Null,
    }
}

/// The emitted controller and its proof; where there is none, the sensors and the drive that it lacks.
pub fn controller(bench: &OpenBench) -> Value {
    let files = bench.generated.as_ref().map(|generated| {
        let files = generated.files();
        files
            .map(|(path, text)| json!({"path": path, "text": text}))
            .collect::<Vec<_>>()
    });
    json!({
        "folder": bench.folder.join(CONTROLLER),
        "files": files,
        "hardware": if bench.generated.is_some() { Value::Null } else { hardware(bench) },
        "assumed": bench.generated.as_ref().map(|generated| &generated.assumed),
        "warnings": bench.generated.as_ref().map(|generated| &generated.warnings),
        "claims": workbench::CLAIMS.iter().map(|claim| json!({
            "id": claim.id,
            "statement": claim.statement,
            "domain": claim.domain,
            "assumptions": claim.assumptions,
            "engine": claim.engine,
        })).collect::<Vec<_>>(),
        "proof": bench.proof,
        "passed": bench.proof.as_ref().map(|proof| proof.passed()),
    })
}
