//! A module with the observer of the angle's bias: no number of the observer can be altered
//! unnoticed, neither in the source nor in the certificate nor in both.

use crate::emitted;

use checker::Module;
use checker::certificate::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::{bias_observer_stable, certificate_consistent, hardware_words};
use checker::prove::Emitted;
use serde_json::Value;

/// The module of the thesis bench with an observer of 1 s.
fn crate_with_observer() -> Emitted {
    let (_folder, out) = emitted::generated(&emitted::model_with("bias_time_constant = 1.0\n"));
    Emitted::read(&out).expect("an emitted crate")
}

/// Why a crate with this `src/constants.rs` and this certificate is rejected.
fn rejection(emitted: &Emitted, constants: &str, certificate: &Value) -> Option<String> {
    let sources: Vec<(&str, &str)> = emitted
        .sources
        .iter()
        .map(|(path, text)| match path.as_str() {
            "src/constants.rs" => (path.as_str(), constants),
            _ => (path.as_str(), text.as_str()),
        })
        .collect();
    let files: Vec<String> = sources
        .iter()
        .map(|(path, _)| (*path).to_owned())
        .chain(["Cargo.toml".to_owned()])
        .collect();
    let module = match Module::parse(&sources) {
        Ok(module) => module,
        Err(error) => return Some(error.to_string()),
    };
    let certificate = match Certificate::parse(&certificate.to_string()) {
        Ok(certificate) => certificate,
        Err(error) => return Some(error.to_string()),
    };
    let law = EmittedLaw::read(&module).expect("a law");
    certificate_consistent::check(&certificate, &module, &law, &files)
        .and_then(|()| hardware_words::check(&certificate, &module, &law))
        .and_then(|()| bias_observer_stable::check_loop(&certificate, &module, &law).map(drop))
        .err()
}

fn constants_of(emitted: &Emitted) -> &str {
    let found = emitted
        .sources
        .iter()
        .find(|(path, _)| path == "src/constants.rs");
    &found.expect("src/constants.rs").1
}

/// The place of each integer of `BIAS_OBSERVER` in the text, and its value.
fn words(text: &str) -> Vec<(std::ops::Range<usize>, i64)> {
    let start = text.find("pub const BIAS_OBSERVER").expect("the observer");
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = start;
    let end = text[start..]
        .find("};")
        .map_or(text.len(), |end| start + end);
    while at < end {
        let is_part = |byte: u8| byte.is_ascii_digit() || byte == b'_';
        let begins = bytes[at].is_ascii_digit() && !bytes[at - 1].is_ascii_alphanumeric();
        if begins {
            let length = bytes[at..]
                .iter()
                .take_while(|byte| is_part(**byte))
                .count();
            let from = at - usize::from(bytes[at - 1] == b'-');
            let digits = text[from..at + length].replace('_', "");
            found.push((from..at + length, digits.parse().expect("an integer")));
            at += length;
        }
        at += 1;
    }
    found
}

#[test]
fn what_is_emitted_holds() {
    let emitted = crate_with_observer();
    let certificate: Value = serde_json::from_str(&emitted.certificate).expect("JSON");
    let rejected = rejection(&emitted, constants_of(&emitted), &certificate);
    assert_eq!(rejected, None);
}

#[test]
fn every_altered_word_is_rejected() {
    let emitted = crate_with_observer();
    let certificate: Value = serde_json::from_str(&emitted.certificate).expect("JSON");
    let text = constants_of(&emitted);
    let words = words(text);
    assert_eq!(words.len(), 12, "{words:?}");
    for (place, value) in words {
        for other in [0, -value, value / 2, value * 2, value + 1, value - 1] {
            let mut altered = text.to_owned();
            altered.replace_range(place.clone(), &other.to_string());
            let rejected = rejection(&emitted, &altered, &certificate);
            assert!(rejected.is_some(), "{value} became {other}");
        }
    }
}

#[test]
fn every_altered_number_of_the_certificate_is_rejected() {
    let emitted = crate_with_observer();
    let whole: Value = serde_json::from_str(&emitted.certificate).expect("JSON");
    let mut places = vec!["decay".to_owned(), "from_current".to_owned()];
    places.push("limit_rad".to_owned());
    for i in 0..3 {
        places.extend([format!("direct/{i}"), format!("from_states/{i}")]);
    }
    for place in places {
        let pointer = format!("/bias_observer/{place}");
        let text = whole.pointer(&pointer).and_then(Value::as_str);
        let value: f64 = text.expect("a number").parse().expect("a number");
        for other in [0.0, -value, value * 1.000_001, value * 0.5] {
            let mut altered = whole.clone();
            *altered.pointer_mut(&pointer).expect("the place") = format!("{other:e}").into();
            let rejected = rejection(&emitted, constants_of(&emitted), &altered);
            assert!(rejected.is_some(), "{place}: {value} became {other}");
        }
    }
    let mut altered = whole.clone();
    altered["bias_observer"] = Value::Null;
    assert!(rejection(&emitted, constants_of(&emitted), &altered).is_some());
}

/// Source and certificate agree with each other, but the observer would not see the current.
#[test]
fn an_observer_of_another_plant_is_rejected() {
    let emitted = crate_with_observer();
    let mut certificate: Value = serde_json::from_str(&emitted.certificate).expect("JSON");
    certificate["bias_observer"]["from_current"] = "0".into();
    let text = constants_of(&emitted);
    let line = text
        .lines()
        .find(|line| line.trim().starts_with("from_current:"))
        .expect("the word");
    let altered = text.replace(line, "    from_current: 0,");
    let why = rejection(&emitted, &altered, &certificate).expect("rejected");
    assert!(
        why.contains("bias_observer.from_current does not observe"),
        "{why}"
    );
}
