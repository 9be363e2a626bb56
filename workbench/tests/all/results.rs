//! Results that are written as JSON and read again are unchanged.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use workbench::{
    ComparisonReport, DesignReport, DiagnosisReport, ExperimentCurves, Preset, SimulationSettings,
};

use crate::bench::{session, silent};

/// Whether two numbers are equal up to the last digit, which the reader of JSON may round.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(0.0), b.as_f64().unwrap_or(0.0));
            (a - b).abs() <= 1e-15 * a.abs().max(b.abs())
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            let mut entries = a.iter();
            a.len() == b.len() && entries.all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        (a, b) => a == b,
    }
}

/// Writes, reads, writes again; returns the JSON and what was read.
fn there_and_back<T: Serialize + DeserializeOwned>(result: &T) -> (Value, T) {
    let text = serde_json::to_string(result).expect("JSON");
    let back: T = serde_json::from_str(&text).expect("what was written");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let again = serde_json::to_value(&back).expect("JSON");
    assert!(same(&json, &again), "{json}\n{again}");
    (json, back)
}

fn assert_keys(json: &Value, keys: &[&str]) {
    for key in keys {
        assert!(json.get(key).is_some(), "{key} is not in {json}");
    }
}

#[test]
fn results_come_back() {
    let mut session = session();
    let fitted = session.identify(&silent()).expect("a fit");
    let (json, back) = there_and_back::<ComparisonReport>(&fitted);
    assert_keys(&json, &["parameters", "rmse", "fit_percent", "where"]);
    assert!(json["rmse"]["swing/angle"].is_number(), "{json}");
    assert_eq!(back.places.len(), fitted.places.len());
    assert_eq!(back.rmse.iter().count(), fitted.rmse.iter().count());
    there_and_back::<Vec<ExperimentCurves>>(&fitted.curves);

    let diagnosis = session.diagnose(&silent()).expect("a diagnosis");
    let (json, back) = there_and_back::<DiagnosisReport>(&diagnosis);
    assert_keys(
        &json,
        &[
            "verdict",
            "steps",
            "suspects",
            "ambiguous_between",
            "next_experiment",
            "where",
        ],
    );
    assert_eq!(back.verdict, diagnosis.verdict);
    // A diagnosis that was read back can still be applied.
    let mut other = session.clone();
    let applied = session.apply(&diagnosis);
    other.apply(&back);
    assert_eq!(applied.added, ["body-coulomb-friction"]);
    let effects = |session: &workbench::Session| session.model().expect("a model").effects.clone();
    assert_eq!(effects(&session), effects(&other));
    there_and_back(&applied);

    let design = session.design().expect("a design");
    let (json, _) = there_and_back::<DesignReport>(&design.report().expect("a report"));
    assert_keys(&json, &["A", "B", "Ad", "Bd", "gains", "dare_residual"]);
    there_and_back(
        &design
            .generate(Some(Preset::ThesisBench))
            .expect("a controller"),
    );
    let settings = SimulationSettings {
        seed: 3,
        bench: Some(session.bench()),
        ..Default::default()
    };
    let loops = design.simulate(&settings, &silent()).expect("closed loops");
    let (json, _) = there_and_back(&loops);
    assert_eq!(json["seed"], 3);
    assert_eq!(json["measured_swings"]["swings"][0]["experiment"], "swing");
}
