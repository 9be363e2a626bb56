//! The work of the lab, without a browser: the folder is its state.

use std::fs;

use serde_json::{Value, json};

use crate::bench;
use crate::running::Running;

fn number(state: &Value, key: &str, experiment: &str, channel: &str) -> f64 {
    let rows = state["bench"]["errors"].as_array().expect("rows");
    let row = rows
        .iter()
        .find(|row| row["experiment"] == experiment && row["channel"] == channel);
    row.and_then(|row| row[key].as_f64()).expect("an error")
}

fn rmse(state: &Value, experiment: &str, channel: &str) -> f64 {
    number(state, "rmse", experiment, channel)
}

/// Whether the model is as good as the sensor: the RMSE is the noise to within a tenth (thousands of samples tell it
/// to a hundredth; the noise itself is estimated).
fn is_noise(state: &Value) -> bool {
    let over = number(state, "over_noise", "swing", "angle");
    (0.9..1.1).contains(&over)
}

/// Where the model fails in the swing is shaded, and no more than half of its time and a bin of the breakdown (32 of
/// them); a spin-up that is predicted to the noise has no shade.
fn assert_shaded(state: &Value) {
    let experiments = state["bench"]["experiments"]
        .as_array()
        .expect("experiments");
    let of = |name: &str| {
        let mut all = experiments.iter();
        all.find(|one| one["name"] == name).expect("the experiment")
    };
    assert_eq!(of("spin-up")["shading"], json!(null));
    let swing = of("swing");
    let stretches: Vec<[f64; 2]> =
        serde_json::from_value(swing["shading"]["stretches"].clone()).expect("stretches");
    let shaded_s: f64 = stretches.iter().map(|[from, to]| to - from).sum();
    let duration_s = swing["duration_s"].as_f64().expect("a time");
    assert!(
        shaded_s > 0.0 && shaded_s < (0.5 + 1.0 / 32.0) * duration_s,
        "{shaded_s} of {duration_s}"
    );
}

fn effects(state: &Value) -> Vec<&str> {
    let effects = state["bench"]["effects"].as_array().expect("effects");
    effects.iter().filter_map(Value::as_str).collect()
}

/// Open, diagnose, add what is missing, take it back: the error falls to the sensor's noise and comes back, the
/// staircase grows and shrinks, and model.toml says the same at every step.
#[test]
fn the_missing_effect_is_found_added_and_taken_back() {
    let folder = bench::folder();
    let lab = Running::entered(Some(folder.path()));
    let model = || fs::read_to_string(folder.path().join("model.toml")).expect("a model");
    let base = lab.settled();
    assert_eq!(base["failure"], json!(null));
    assert!(!model().contains("body-coulomb-friction"));
    let before = rmse(&base, "swing", "angle");
    assert!(number(&base, "over_noise", "swing", "angle") > 2.0);
    assert_shaded(&base);

    lab.work(&json!({"task": "diagnose"}));
    let found = lab.ask("GET", "/api/diagnosis", "").json();
    assert_eq!(found["verdict"], "explained", "{found}");
    assert_eq!(found["added"], json!(["body-coulomb-friction"]));
    // What a person is to see: the residual before and after.
    assert!(
        found["reasons"][0]["before"]
            .as_array()
            .is_some_and(|bins| bins.len() > 3)
    );

    // And the first suspect's fingerprint: the torque that is missing without it, over the rate, and the same with it;
    // how the swing dies out without and with it.
    let drawn = &found["fingerprints"][0];
    assert_eq!(drawn["effect"], "body-coulomb-friction");
    let torques = drawn["reasons"].as_array().expect("torques");
    let over_rate = torques.iter().find(|one| one["coordinate"] == "rate");
    let over_rate = over_rate.expect("over the rate");
    // How far the torque is from zero: the sum of the squares in standard errors.
    let size = |key: &str| {
        let points = over_rate[key].as_array().expect("points").iter();
        let of = |point: &Value, part: usize| point[part].as_f64().expect("a number");
        points
            .map(|point| (of(point, 1) / of(point, 2)).powi(2))
            .sum::<f64>()
    };
    let (before_it, with_it) = (size("before"), size("after"));
    assert!(with_it < 0.3 * before_it, "{before_it} {with_it}");
    let mean = |key: &str| {
        let points = drawn["decay"][0][key].as_array().expect("points");
        points
            .iter()
            .map(|point| point[1].as_f64().expect("a rate"))
            .sum::<f64>()
            / points.len() as f64
    };
    let (measured, with, without) = (mean("rates"), mean("model_rates"), mean("other_rates"));
    assert!(
        (with - measured).abs() < 0.5 * (without - measured).abs(),
        "{measured} {with} {without}"
    );

    let added = lab.work(&json!({"task": "apply"}));
    assert!(effects(&added).contains(&"body-coulomb-friction"));
    assert!(model().contains("body-coulomb-friction"));
    assert!(is_noise(&added));
    assert_eq!(
        added["bench"]["staircase"]["labels"],
        json!(["base model", "+ body-coulomb-friction"])
    );

    let undone = lab.work(&json!({"task": "undo"}));
    assert!(!model().contains("body-coulomb-friction"));
    assert!((rmse(&undone, "swing", "angle") / before - 1.0).abs() < 1e-3);
    assert_eq!(
        undone["bench"]["staircase"]["labels"],
        json!(["base model"])
    );

    // The same by hand, and taken out by name.
    let added = lab.work(&json!({"task": "add", "effect": "body-coulomb-friction"}));
    assert!(is_noise(&added));
    let removed = lab.work(&json!({"task": "remove", "effect": "body-coulomb-friction"}));
    assert!((rmse(&removed, "swing", "angle") / before - 1.0).abs() < 1e-3);

    // Another lab on the same folder finds the same.
    let other = Running::entered(Some(folder.path()));
    let state = other.settled();
    assert_eq!(effects(&state), effects(&removed));
    assert!((rmse(&state, "swing", "angle") / before - 1.0).abs() < 1e-3);
}

/// Values set by hand are kept as they are; a fit from there finds the minimum again.
#[test]
fn values_are_kept_and_fitted_from() {
    let folder = bench::folder();
    let lab = Running::entered(Some(folder.path()));
    let slider = |state: &Value, name: &str| {
        let sliders = state["bench"]["sliders"]
            .as_array()
            .expect("sliders")
            .clone();
        sliders
            .into_iter()
            .find(|one| one["name"] == name)
            .expect("a slider")
    };
    let fitted = lab.settled();
    let inertia = slider(&fitted, "total_inertia")["value"]
        .as_f64()
        .expect("a value");
    let track = slider(&fitted, "total_inertia")["coarse"].clone();
    assert!(track[0].as_f64() <= Some(inertia) && Some(inertia) <= track[1].as_f64());

    let kept = lab.work(&json!({"task": "keep", "values": [["total_inertia", 1.05 * inertia]]}));
    assert_eq!(
        slider(&kept, "total_inertia")["value"],
        json!(1.05 * inertia)
    );
    assert_eq!(slider(&kept, "total_inertia")["std"], json!(null));
    assert!(rmse(&kept, "swing", "angle") > rmse(&fitted, "swing", "angle"));

    let again = lab.work(&json!({"task": "fit", "start": [["total_inertia", 1.02 * inertia]]}));
    let found = slider(&again, "total_inertia")["value"]
        .as_f64()
        .expect("a value");
    assert!((found / inertia - 1.0).abs() < 1e-4, "{found} {inertia}");
}

/// What another program writes into the folder is not written over.
#[test]
fn a_model_that_changes_outside_is_noticed() {
    let folder = bench::folder();
    let lab = Running::entered(Some(folder.path()));
    lab.settled();
    let path = folder.path().join("model.toml");
    let text = fs::read_to_string(&path).expect("a model") + "\n# by hand\n";
    fs::write(&path, &text).expect("written");
    assert_eq!(lab.settled()["changed_outside"], json!(["model.toml"]));
    let refused = lab.ask("POST", "/api/work", "{\"task\": \"undo\"}");
    assert_eq!(refused.status, 409);
    assert_eq!(fs::read_to_string(&path).expect("a model"), text);
    let read = lab.work(&json!({"task": "open", "path": folder.path()}));
    assert_eq!(read["changed_outside"], json!([]));

    // So is what is written into bench.toml: the sensors, for instance, that a message asks for.
    let path = folder.path().join("bench.toml");
    let text = fs::read_to_string(&path).expect("a bench") + "\n# by hand\n";
    fs::write(&path, text).expect("written");
    assert_eq!(lab.settled()["changed_outside"], json!(["bench.toml"]));
    let refused = lab.ask("POST", "/api/work", "{\"task\": \"diagnose\"}");
    assert_eq!(refused.status, 409);
    assert!(
        refused.body.contains("bench.toml changed"),
        "{}",
        refused.body
    );
}

/// A second task waits for nobody: it is refused; the first can be called off and leaves everything as it was.
#[test]
fn one_task_at_a_time_which_can_be_called_off() {
    let folder = bench::folder();
    let lab = Running::entered(Some(folder.path()));
    let before = lab.settled();
    assert_eq!(
        lab.ask("POST", "/api/work", "{\"task\": \"diagnose\"}")
            .status,
        202
    );
    let second = lab.ask("POST", "/api/work", "{\"task\": \"undo\"}");
    assert_eq!(second.status, 409, "{second:?}");
    assert_eq!(lab.ask("DELETE", "/api/work", "").status, 204);
    let after = lab.settled();
    assert_eq!(after["bench"]["has_diagnosis"], json!(false));
    assert_eq!(after["bench"]["errors"], before["bench"]["errors"]);
    // Who has called it off needs no message about it.
    assert_eq!(after["failure"], json!(null));
}

/// A controller for other weights, emitted, proved and written into the folder.
#[test]
fn a_controller_is_designed_emitted_and_written() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in demo::FILES {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let lab = Running::entered(Some(folder.path()));
    let state = lab.settled();
    let mut wishes = state["bench"]["design"].clone();
    wishes["current_weight"] = json!(2.0);
    let asked = |asked: Value| lab.ask("POST", "/api/design", &asked.to_string());
    let designed = asked(json!({"wishes": wishes}));
    assert_eq!(designed.status, 200, "{}", designed.body);
    let designed = designed.json();
    assert_eq!(designed["report"]["current_weight"], json!(2.0));
    assert_eq!(designed["responses"].as_array().map(Vec::len), Some(2));
    // Bryson's rule: what the weights allow gives the weights back.
    let allowed = &designed["expectations"]["excursions"];
    let allowed = ["angle_rad", "rate_rad_s", "wheel_speed_rad_s", "current_a"]
        .map(|key| allowed[key].clone());
    let same = asked(json!({"wishes": wishes, "excursions": allowed})).json();
    let gain = |designed: &Value| designed["report"]["gains"][0].as_f64().expect("a gain");
    assert!((gain(&same) / gain(&designed) - 1.0).abs() < 1e-9);
    // A delay beyond all bounds is told, not refused.
    let late = asked(json!({"wishes": wishes, "delay_s": 1.0})).json();
    assert_eq!(late["expectations"]["stable"], json!(false));
    assert_eq!(late["step"], json!(null));
    wishes["current_weight"] = json!(-1.0);
    assert_eq!(asked(json!({"wishes": wishes})).status, 422);
    assert_eq!(
        lab.ask("POST", "/api/design", &wishes.to_string()).status,
        422
    );
    for (language, begins) in [("python", "# "), ("matlab", "% ")] {
        let export = lab.ask("GET", &format!("/api/export/{language}"), "");
        assert!(
            export.status == 200 && export.body.starts_with(begins),
            "{export:?}"
        );
    }
    assert_eq!(lab.ask("GET", "/api/export/fortran", "").status, 400);

    wishes["current_weight"] = json!(2.0);
    lab.work(&json!({"task": "generate", "wishes": wishes}));
    let state = lab.work(&json!({"task": "write-controller"}));
    assert_eq!(state["failure"], json!(null));
    let written = folder.path().join("controller/certificate.json");
    let found = lab.ask("GET", "/api/controller", "").json();
    let files = found["files"].as_array().expect("files");
    let certificate = files
        .iter()
        .find(|file| file["path"] == "certificate.json")
        .expect("it");
    assert_eq!(
        certificate["text"],
        json!(fs::read_to_string(written).expect("written"))
    );
}
