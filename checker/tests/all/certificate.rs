//! A certificate that was altered by hand is rejected, whatever was altered.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::{certificate_consistent, closed_loop_for_all_time, hardware_words};
use checker::prove::{Emitted, settle};
use checker::{ClaimOutcome, Module, ProofSettings};
use serde_json::Value;

const SETTINGS: ProofSettings = ProofSettings {
    cases: 100,
    seed: 7,
    audited_texts: true,
    compiled: false,
    smt: false,
    kani: false,
    closed_loop: true,
    python: false,
    filter_ranges: true,
    filter_length: false,
};

fn emitted() -> Emitted {
    Emitted::read(Path::new("../generated")).unwrap()
}

fn module() -> Module {
    Module::read(Path::new("../generated")).unwrap()
}

/// Every place in a JSON value, as JSON pointers.
fn places(value: &Value, path: &str, found: &mut Vec<String>) {
    found.push(path.to_owned());
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                places(value, &format!("{path}/{name}"), found);
            }
        }
        Value::Array(values) => {
            for (index, value) in values.iter().enumerate() {
                places(value, &format!("{path}/{index}"), found);
            }
        }
        _ => {}
    }
}

/// Other values for one place.
fn alterations(value: &Value) -> Vec<Value> {
    match value {
        Value::String(text) => {
            let mut others = vec![Value::String(format!("{text}x"))];
            if let Ok(number) = text.parse::<f64>() {
                let raised = if number == 0.0 {
                    1e-6
                } else {
                    number * 1.000_001
                };
                others = vec![
                    Value::String(format!("{raised:e}")),
                    Value::String(format!("{:e}", number * 0.9 - 1e-9)),
                ];
            }
            others
        }
        Value::Number(number) => {
            let number = number.as_i64().unwrap();
            vec![Value::from(number + 1), Value::from(number - 1)]
        }
        Value::Null => vec![Value::String("0.001".to_owned())],
        Value::Array(values) => {
            let mut shorter = values.clone();
            shorter.pop();
            let mut longer = values.clone();
            longer.extend(values.last().cloned());
            vec![Value::Array(shorter), Value::Array(longer)]
        }
        Value::Object(fields) => {
            let mut longer = fields.clone();
            longer.insert("more".to_owned(), Value::Null);
            let mut others = vec![Value::Object(longer)];
            for name in fields.keys() {
                let mut shorter = fields.clone();
                shorter.remove(name);
                others.push(Value::Object(shorter));
            }
            others
        }
        Value::Bool(value) => vec![Value::Bool(!value)],
    }
}

/// A number of the hardware, plainly altered.
fn coarser(place: &str, value: &Value) -> Option<Value> {
    let number: f64 = value.as_str()?.parse().ok()?;
    let other = if number == 0.0 { 1e-3 } else { 1.01 * number };
    let is_hardware = place.starts_with("/hardware/");
    is_hardware.then(|| Value::String(format!("{other:e}")))
}

/// Why a certificate is rejected; `None` if it is not. Quick checks come first, and all claims are
/// settled for what they let pass.
fn rejection(emitted: &Emitted, module: &Module, text: &str) -> Option<String> {
    let certificate = match Certificate::parse(text) {
        Ok(certificate) => certificate,
        Err(error) => return Some(error.to_string()),
    };
    let law = EmittedLaw::read(module).unwrap();
    let mut files: Vec<_> = module
        .texts()
        .iter()
        .map(|(path, _)| path.clone())
        .collect();
    files.push("Cargo.toml".to_owned());
    let stated = certificate.closed_loop.as_ref()?;
    let quick = certificate_consistent::check(&certificate, module, &law, &files)
        .and_then(|()| hardware_words::check(&certificate, module, &law))
        .and_then(|()| closed_loop_for_all_time::check(&certificate, stated, &law).map(|_| ()));
    if let Err(why) = quick {
        return Some(why);
    }
    // The bounds of the loop take seconds; they are asked where nothing else says anything.
    let quick = ProofSettings {
        closed_loop: false,
        ..SETTINGS
    };
    [quick, SETTINGS].iter().find_map(|settings| {
        let results = settle(emitted, &certificate, settings);
        let failed = results
            .iter()
            .find(|result| matches!(result.outcome, ClaimOutcome::Failed(_)));
        failed.map(|result| result.outcome.detail())
    })
}

#[test]
fn the_committed_certificate_holds() {
    let emitted = emitted();
    assert_eq!(rejection(&emitted, &module(), &emitted.certificate), None);
}

/// Alters every place of the certificate, by every alteration or by one of them in turn, and holds that all are rejected.
fn all_are_rejected(by_every_alteration: bool) {
    let emitted = emitted();
    let module = module();
    let whole: Value = serde_json::from_str(&emitted.certificate).unwrap();
    let mut found = Vec::new();
    places(&whole, "", &mut found);
    let (mut tried, mut accepted) = (0, Vec::new());
    for (number, place) in found.iter().enumerate() {
        let mut others = alterations(whole.pointer(place).unwrap());
        if !by_every_alteration {
            let turn = number % others.len();
            others = vec![others.swap_remove(turn)];
        }
        for other in others {
            // Of an empty list there is no shorter one.
            if other == *whole.pointer(place).unwrap() {
                continue;
            }
            let mut altered = whole.clone();
            *altered.pointer_mut(place).unwrap() = other.clone();
            // A certificate without a closed loop claims less; nothing in it is false.
            if altered["closed_loop"].is_null() {
                continue;
            }
            tried += 1;
            if rejection(&emitted, &module, &altered.to_string()).is_some() {
                continue;
            }
            // A number of the hardware is stated more finely than the word that comes of it, which may
            // then be the same: it must be another one at a hundredth, or a thousandth of the unit.
            if let Some(coarser) = coarser(place, whole.pointer(place).unwrap()) {
                *altered.pointer_mut(place).unwrap() = coarser;
                if rejection(&emitted, &module, &altered.to_string()).is_some() {
                    continue;
                }
            }
            accepted.push(format!("{place}: {other}"));
        }
    }
    eprintln!("{tried} alterations of {} places", found.len());
    assert!(10 * tried > 9 * found.len(), "{tried} of {}", found.len());
    assert!(accepted.is_empty(), "accepted: {accepted:#?}");
}

#[test]
fn an_alteration_of_every_place_is_rejected() {
    all_are_rejected(false);
}

#[test]
#[ignore = "minutes: cargo test -p checker --test all every_alteration -- --ignored"]
fn every_alteration_is_rejected() {
    all_are_rejected(true);
}

#[test]
fn without_a_closed_loop_its_claim_is_not_run() {
    let emitted = emitted();
    let mut whole: Value = serde_json::from_str(&emitted.certificate).unwrap();
    whole["closed_loop"] = Value::Null;
    let certificate = Certificate::parse(&whole.to_string()).unwrap();
    let results = settle(&emitted, &certificate, &SETTINGS);
    let row = results
        .iter()
        .find(|result| result.id == "closed-loop-for-all-time")
        .unwrap();
    assert!(matches!(row.outcome, ClaimOutcome::NotRun(_)), "{row:?}");
}

#[test]
fn an_error_names_line_and_column() {
    let error = Certificate::parse("{\n  \"generator\": 1\n}").unwrap_err();
    assert!(
        error.to_string().starts_with("certificate.json:2:16: "),
        "{error}"
    );
}
