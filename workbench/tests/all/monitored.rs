//! A controller with a monitor: emitted, audited, proved; and what damage to it does.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::prove::{ClaimResult, Emitted, settle};
use checker::{ClaimOutcome, ProofSettings};
use workbench::{ControlDesign, ControllerOptions};

fn emitted() -> Emitted {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/thesis-4.4.toml");
    let design = ControlDesign::read(&path).expect("the model of the thesis");
    let controller = design
        .generate_with(&ControllerOptions {
            has_monitor: true,
            ..ControllerOptions::default()
        })
        .expect("emitted");
    let folder = tempfile::tempdir().expect("a folder");
    controller.write(folder.path()).expect("written");
    Emitted::read(folder.path()).expect("a crate")
}

fn settled(emitted: &Emitted, compiled: bool) -> Vec<ClaimResult> {
    let certificate = Certificate::parse(&emitted.certificate).expect("a certificate");
    let settings = ProofSettings {
        cases: 3_000,
        compiled,
        smt: false,
        kani: false,
        python: false,
        closed_loop: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    settle(emitted, &certificate, &settings)
}

/// The outcomes of a claim, engine by engine.
fn of<'a>(rows: &'a [ClaimResult], id: &str) -> Vec<&'a ClaimOutcome> {
    let rows = rows.iter().filter(|row| row.id == id);
    rows.map(|row| &row.outcome).collect()
}

#[test]
fn a_monitor_is_proved() {
    let rows = settled(&emitted(), true);
    let failed: Vec<_> = rows
        .iter()
        .filter(|row| matches!(row.outcome, ClaimOutcome::Failed(_)))
        .map(|row| format!("{}: {}", row.id, row.outcome.why()))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(matches!(
        of(&rows, "texts-audited")[..],
        [ClaimOutcome::Proved(_)]
    ));
    assert!(matches!(
        of(&rows, "compiled-agrees")[..],
        [ClaimOutcome::Tested(..)]
    ));
    assert!(matches!(
        of(&rows, "monitor-total")[..],
        [ClaimOutcome::Proved(_)]
    ));
    assert!(matches!(
        of(&rows, "monitor-silent")[..],
        [ClaimOutcome::Proved(_), ClaimOutcome::Tested(..)]
    ));
}

/// A word that is off, in either direction, and a certificate or source that says otherwise.
#[test]
fn a_damaged_monitor_is_noticed() {
    let whole = emitted();
    let words = "src/monitor_words.rs";
    let (_, text) = whole
        .sources
        .iter()
        .find(|(path, _)| path == words)
        .expect("its words");
    let value = |field: &str| {
        let at = text.rfind(&format!("{field}: ")).expect("a field") + field.len() + 2;
        let end = text[at..].find(',').expect("its end") + at;
        text[at..end].to_owned()
    };
    for field in ["leak", "shift", "wheel_limit", "body_limit"] {
        let old = value(field);
        let number: i64 = old.replace('_', "").parse().expect("a number");
        for new in [number + 3, number - 3] {
            let mut damaged = whole.clone();
            for (path, text) in &mut damaged.sources {
                if path == words {
                    let (from, to) = (format!("{field}: {old},"), format!("{field}: {new},"));
                    assert!(text.contains(&from), "{from}");
                    *text = text.replace(&from, &to);
                }
            }
            let rows = settled(&damaged, false);
            assert!(
                of(&rows, "monitor-silent")
                    .iter()
                    .any(|outcome| matches!(outcome, ClaimOutcome::Failed(_))),
                "{field}: {new}"
            );
        }
    }
    // The certificate is silent about it.
    let mut silent = whole.clone();
    let mut json: serde_json::Value =
        serde_json::from_str(&silent.certificate).expect("a certificate");
    json.as_object_mut().expect("an object").remove("monitor");
    silent.certificate = json.to_string();
    let rows = settled(&silent, false);
    assert!(matches!(
        of(&rows, "monitor-total")[..],
        [ClaimOutcome::Failed(_)]
    ));
}
