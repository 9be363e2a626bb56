//! Attacks on a controller with an encoder on the pivot and one on the wheel: words, texts, manifest or certificate are
//! changed. At least one claim must fail for each attack.

use std::fs;
use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::prove::{Emitted, settle};
use checker::{ClaimOutcome, ProofSettings};
use serde_json::{Value, json};

use crate::benches::{CURRENT, PIVOT_ENCODER, WHEEL_ENCODER, designed};

/// The engines that neither compile nor take long.
const QUICK: ProofSettings = ProofSettings {
    cases: 300,
    seed: 6,
    audited_texts: true,
    compiled: false,
    smt: false,
    kani: false,
    closed_loop: false,
    python: false,
    filter_ranges: false,
    filter_length: false,
};

const CONSTANTS: &str = "src/constants.rs";
const SUPERVISOR: &str = "src/supervisor.rs";
const CONTROLLER: &str = "src/controller.rs";

/// A change of one file.
enum Change {
    /// A number of a constant, by its name and its field: the factor and the summand of the new one.
    Number(&'static str, &'static str, f64, i64),
    /// A text of a file, and what takes its place.
    Text(&'static str, &'static str, &'static str),
    /// A place in the certificate.
    Stated(&'static str, Value),
    /// An additional file.
    File(&'static str, &'static str),
}

use Change::{File, Number, Stated, Text};

fn attacks() -> Vec<(&'static str, Vec<Change>)> {
    let pivot_window = || Stated("/hardware/body_encoder/window", json!(7));
    vec![
        (
            "half the rate",
            vec![Number("BODY_RATE_LINE", "scale", 0.5, 0)],
        ),
        (
            "the pivot's window, in the source",
            vec![Number("BODY_ENCODER", "window", 0.5, 0)],
        ),
        ("the pivot's window, as stated", vec![pivot_window()]),
        (
            "the pivot's window, in both",
            vec![Number("BODY_ENCODER", "window", 0.5, 0), pivot_window()],
        ),
        (
            "every turn of the pivot is a motion",
            vec![Number("BODY_ENCODER", "jump", 0.0, 2000)],
        ),
        (
            "half of what gravity takes",
            vec![Number("HOLDING_LINE", "scale", 0.5, 0)],
        ),
        (
            "a count may stand still two steps longer",
            vec![Number("LIMITS", "frozen_steps", 1.0, 2)],
        ),
        (
            "under a fiftieth more",
            vec![Number("LIMITS", "left_over", 1.02, 0)],
        ),
        (
            "armed beyond the angle that the current holds",
            vec![Number("LIMITS", "angle_arm", 1.5, 0)],
        ),
        (
            "armed without rest",
            vec![Number("LIMITS", "still_steps", 0.0, 15)],
        ),
        (
            "an angle that ends early",
            vec![Number("BODY_ANGLE_LINE", "low", 0.1, 0)],
        ),
        (
            "a rate that ends early",
            vec![Number("BODY_RATE_LINE", "high", 0.1, 0)],
        ),
        (
            "a rate that ends early, as stated",
            vec![
                Number("BODY_RATE_LINE", "high", 0.0, 4 << 25),
                Number("BODY_RATE_LINE", "low", 0.0, -(4 << 25)),
                Stated("/inputs/1/range", json!("4")),
            ],
        ),
        (
            "a wheel that shows half",
            vec![Number("WHEEL_SPEED_LINE", "scale", 0.5, 0)],
        ),
        (
            "the wheel's window, as stated",
            vec![Stated("/hardware/wheel_speed/encoder/window", json!(1))],
        ),
        (
            "four times the counts of a turn, as stated",
            vec![Stated(
                "/hardware/body_encoder/counts_per_turn",
                json!("16384"),
            )],
        ),
        (
            "upright elsewhere",
            vec![Text(
                CONSTANTS,
                "BODY_ZERO: i32 = 2_048",
                "BODY_ZERO: i32 = 2_060",
            )],
        ),
        (
            "another type of a constant",
            vec![Text(CONSTANTS, "BODY_ZERO: i32", "BODY_ZERO: i64")],
        ),
        (
            "the time between two steps",
            vec![Text(
                CONSTANTS,
                "SAMPLE_TIME_US: u32 = 1_000",
                "SAMPLE_TIME_US: u32 = 2_000",
            )],
        ),
        (
            "twice as often, as stated",
            vec![Stated("/sample_time_s", json!("0.0005"))],
        ),
        (
            "a statement for some machines",
            vec![Text(
                SUPERVISOR,
                "    let left = counters.current",
                "    #[cfg(debug_assertions)]\n    let left = counters.current",
            )],
        ),
        (
            "a narrow difference",
            vec![Text(
                SUPERVISOR,
                "counters.current as i64 - shown.held as i64",
                "(counters.current - shown.held) as i64",
            )],
        ),
        (
            "other numbers of the status",
            vec![Text(SUPERVISOR, "Ready = 1", "Ready = 10")],
        ),
        (
            "a receiver that is a copy",
            vec![Text(
                CONTROLLER,
                "pub fn disarm(&mut self)",
                "pub fn disarm(mut self)",
            )],
        ),
        (
            "a method that all may call",
            vec![Text(CONTROLLER, "    fn trip(", "    pub fn trip(")],
        ),
        (
            "a name that hides another",
            vec![Text(
                CONTROLLER,
                "        let before = self.body.count();",
                "        let before = sample.body_count as i32;",
            )],
        ),
        (
            "turns in another order",
            vec![Text(
                "src/encoder.rs",
                "self.newest = [turn, self.newest[0]",
                "self.newest = [self.newest[0], turn",
            )],
        ),
        (
            "overflow that wraps",
            vec![Text(
                "Cargo.toml",
                "[dependencies]",
                "[profile.release]\noverflow-checks = false\n\n[dependencies]",
            )],
        ),
        (
            "a feature of the crate of numbers",
            vec![Text(
                "Cargo.toml",
                "default-features = false",
                "default-features = false, features = [\"std\"]",
            )],
        ),
        (
            "flags for the compiler",
            vec![File(
                ".cargo/config.toml",
                "[build]\nrustflags = [\"--cfg\", \"kani\"]\n",
            )],
        ),
        (
            "a program that builds",
            vec![File("build.rs", "fn main() {}\n")],
        ),
        ("the claims of nothing", vec![Stated("/claims", json!([]))]),
    ]
}

/// The text with another number in the field of a constant.
fn with_number(text: &str, constant: &str, field: &str, factor: f64, more: i64) -> String {
    let start = text
        .find(&format!("pub const {constant}:"))
        .expect(constant);
    let name = format!("    {field}: ");
    let at = start + text[start..].find(&name).expect(field) + name.len();
    let end = at + text[at..].find(',').expect("a comma");
    let number: i64 = text[at..end].replace('_', "").parse().expect("a number");
    let found = (number as f64 * factor) as i64 + more;
    assert_ne!(found, number, "{constant}.{field}");
    format!("{}{found}{}", &text[..at], &text[end..])
}

/// The claims that fail for the changed folder; the error if the folder cannot be read.
fn failing(folder: &Path) -> Vec<String> {
    let read = |why: String| vec![format!("not read: {why}")];
    let emitted = match Emitted::read(folder) {
        Ok(emitted) => emitted,
        Err(why) => return read(why.to_string()),
    };
    let certificate = match Certificate::parse(&emitted.certificate) {
        Ok(certificate) => certificate,
        Err(why) => return read(why.to_string()),
    };
    let rows = settle(&emitted, &certificate, &QUICK);
    let failed = rows
        .into_iter()
        .filter(|row| matches!(row.outcome, ClaimOutcome::Failed(_)));
    failed.map(|row| row.id).collect()
}

#[test]
fn none_of_them_passes() {
    let design = designed(&[PIVOT_ENCODER, WHEEL_ENCODER, CURRENT]);
    let controller = design.generate(None).expect("emitted");
    let home = tempfile::tempdir().expect("a folder");
    let sound = home.path().join("sound");
    controller.write(&sound).expect("written");
    assert_eq!(failing(&sound), Vec::<String>::new());
    let mut passed = Vec::new();
    for (index, (what, changes)) in attacks().into_iter().enumerate() {
        let folder = home.path().join(index.to_string());
        controller.write(&folder).expect("written");
        for change in changes {
            let edit = |file: &str, edit: &dyn Fn(&str) -> String| {
                let path = folder.join(file);
                let text = fs::read_to_string(&path).expect(file);
                let found = edit(&text);
                assert_ne!(found, text, "{what}: {file}");
                fs::write(path, found).expect(file);
            };
            match change {
                Number(constant, field, factor, more) => edit(CONSTANTS, &|text| {
                    with_number(text, constant, field, factor, more)
                }),
                Text(file, from, to) => edit(file, &|text| text.replacen(from, to, 1)),
                Stated(pointer, value) => edit("certificate.json", &|text| {
                    let mut stated: Value = serde_json::from_str(text).expect("JSON");
                    *stated.pointer_mut(pointer).expect(pointer) = value.clone();
                    stated.to_string()
                }),
                File(file, text) => {
                    let path = folder.join(file);
                    fs::create_dir_all(path.parent().expect("a folder")).expect(file);
                    fs::write(path, text).expect(file);
                }
            }
        }
        let claims = failing(&folder);
        println!("{what}: {claims:?}");
        if claims.is_empty() {
            passed.push(what);
        }
    }
    assert!(passed.is_empty(), "nothing noticed: {passed:#?}");
}
