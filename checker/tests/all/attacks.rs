//! Damaged crates that a proof must not let pass: each is the committed one with a piece of text
//! replaced.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::claims::compiled_agrees;
use checker::prove::{Emitted, ProofVerdict, settle, verdict};
use checker::{ClaimOutcome, ClaimResult, ProofSettings};

/// The quick engines.
const QUICK: ProofSettings = ProofSettings {
    cases: 200,
    seed: 3,
    audited_texts: true,
    compiled: false,
    smt: false,
    kani: false,
    closed_loop: false,
    python: false,
    filter_ranges: false,
    filter_length: false,
};

fn emitted() -> Emitted {
    Emitted::read(Path::new("../generated")).unwrap()
}

/// The crate with `from` replaced by `to` in one file.
fn damaged(file: &str, from: &str, to: &str) -> Emitted {
    let mut emitted = emitted();
    let text = match file {
        "Cargo.toml" => &mut emitted.cargo,
        "certificate.json" => &mut emitted.certificate,
        _ => {
            let found = emitted.sources.iter_mut().find(|(path, _)| path == file);
            &mut found.unwrap_or_else(|| panic!("no {file}")).1
        }
    };
    assert!(text.contains(from), "{file} has no `{from}`");
    *text = text.replacen(from, to, 1);
    emitted
}

fn rows(emitted: &Emitted, settings: &ProofSettings) -> Vec<ClaimResult> {
    let certificate = Certificate::parse(&emitted.certificate).unwrap();
    settle(emitted, &certificate, settings)
}

/// Claims that fail.
fn failing(emitted: &Emitted, settings: &ProofSettings) -> Vec<String> {
    match verdict(&rows(emitted, settings)) {
        ProofVerdict::Fails(claims) => claims,
        ProofVerdict::Holds | ProofVerdict::Unsettled(_) => Vec::new(),
    }
}

/// What the reader and rustc would read as two programs is not read at all.
#[test]
fn forms_that_rust_reads_in_another_way() {
    let forms = [
        // An operand without a type is an i32: this is −1, not 1.
        (
            "src/control.rs",
            "let command = (sum + HALF_UNIT) >> SHIFT;",
            "let command = ((sum + HALF_UNIT) >> SHIFT) * ((1 << 31) as i64 >> 31);",
        ),
        (
            "src/control.rs",
            "let limit = i64::from(CURRENT_LIMIT.to_bits());",
            "let limit = i64::from(CURRENT_LIMIT.to_bits()) * ((2147483647 + 1) as i64 >> 31);",
        ),
        // Two spellings of one name, one of them raw.
        (
            "src/control.rs",
            "let command = (sum + HALF_UNIT) >> SHIFT;",
            "let command = (sum + HALF_UNIT) >> SHIFT;\n    let r#command = 0 - command;",
        ),
        // Two spellings of one name, alike once Unicode has normalised them.
        (
            "src/control.rs",
            "let command = (sum + HALF_UNIT) >> SHIFT;",
            "let \u{212b} = (sum + HALF_UNIT) >> SHIFT;\n    let \u{c5} = 0 - \u{212b};\n    let command = \u{212b};",
        ),
        // A method that changes its receiver without saying `&mut self`.
        (
            "src/controller.rs",
            "pub fn disarm(&mut self)",
            "pub fn disarm(self: &mut Self)",
        ),
        // A module that takes the place of a type.
        ("src/lib.rs", "pub mod line;", "pub mod line;\npub mod i64;"),
        (
            "src/lib.rs",
            "pub use control::{",
            "pub use control::{r#control, ",
        ),
        // A constant that looks like one of a type.
        (
            "src/control.rs",
            "let limit = i64::from(CURRENT_LIMIT.to_bits());",
            "let limit = i64::from(CURRENT_LIMIT.to_bits()) + <i64>::MAX;",
        ),
        // Text that an editor shows elsewhere.
        (
            "src/control.rs",
            "/// Defined for every bit",
            "/// \u{202e}Defined for every bit",
        ),
    ];
    for (file, from, to) in forms {
        let mut crate_ = damaged(file, from, to);
        if to.contains("pub mod i64") {
            let text = format!(
                "{}\npub fn from(x: i32) -> i32 {{ x }}\n",
                crate_.sources[0].1
            );
            crate_.sources.push(("src/i64.rs".to_owned(), text));
        }
        // The reader notices without any digest.
        let settings = ProofSettings {
            audited_texts: false,
            ..QUICK
        };
        assert_eq!(failing(&crate_, &settings), ["source-understood"], "{to}");
    }
}

/// Whatever is added to, or changed in, a text that was audited makes it another text.
#[test]
fn texts_are_fixed() {
    assert_eq!(failing(&emitted(), &QUICK), [""; 0]);
    let changes = [
        // The sign of the wheel's speed is reversed at odd counts.
        (
            "src/controller.rs",
            "WheelSpeed::from_bits(on_line(adc as i32, &WHEEL_SPEED_LINE))",
            "let word = on_line(adc as i32, &WHEEL_SPEED_LINE);\n    WheelSpeed::from_bits(if (adc as i32 & 1) == 1 { -word } else { word })",
        ),
        // The filter stands still near upright.
        (
            "src/attitude.rs",
            "        self.state = state;\n        self.drift = drift;",
            "        self.drift = drift;\n        let angle = pivot_angle(state.quaternion, MOUNTING_ANGLE);\n        if angle > 0x10_0000 || angle < -0x10_0000 {\n            self.state = state;\n        }",
        ),
        // A method more, another default.
        (
            "src/controller.rs",
            "    /// The attitude filter.",
            "    /// Sets the observer.\n    pub fn set(&mut self, bias: i32) {\n        self.bias_state = bias;\n    }\n\n    /// The attitude filter.",
        ),
        (
            "src/attitude.rs",
            "        Attitude::new()\n",
            "        Attitude { state: super::filter::START }\n",
        ),
        (
            "src/control.rs",
            "pub fn control(",
            "#[inline]\npub fn control(",
        ),
        (
            "src/lib.rs",
            "pub mod line;",
            "pub mod line;\n\npub const X: i32 = 1;",
        ),
        (
            "src/constants.rs",
            "pub const FILTER",
            "pub const X: i32 = 1;\npub const FILTER",
        ),
    ];
    for (file, from, to) in changes {
        let claims = failing(&damaged(file, from, to), &QUICK);
        assert!(
            claims
                .iter()
                .any(|claim| claim == "texts-audited" || claim == "source-understood"),
            "{to}: {claims:?}"
        );
    }
}

/// What is compiled is not what was read: the run notices, though no engine that reads could.
#[test]
fn the_compiled_crate_is_compared_where_the_pendulum_operates() {
    let read = emitted();
    let module = read.module().unwrap();
    let run = |emitted: &Emitted| compiled_agrees::by_running(emitted, &module, 400, 5);
    match run(&read) {
        ClaimOutcome::Tested(cases, _) => assert!(cases > 20_000, "{cases}"),
        ClaimOutcome::NotRun(why) => {
            eprintln!("not run: {why}");
            return;
        }
        other => panic!("{other:?}"),
    }
    let attacks = [
        (
            "src/controller.rs",
            "WheelSpeed::from_bits(on_line(adc as i32, &WHEEL_SPEED_LINE))",
            "let word = on_line(adc as i32, &WHEEL_SPEED_LINE);\n    WheelSpeed::from_bits(if (adc as i32 & 1) == 1 { -word } else { word })",
        ),
        (
            "src/attitude.rs",
            "        self.state = state;\n        self.drift = drift;",
            "        self.drift = drift;\n        let angle = pivot_angle(state.quaternion, MOUNTING_ANGLE);\n        if angle > 0x10_0000 || angle < -0x10_0000 {\n            self.state = state;\n        }",
        ),
        // One unit beyond one of the branches of a root.
        (
            "src/root.rs",
            "if n < 0x2000_0000 {",
            "if n < 0x2000_0001 {",
        ),
    ];
    for (file, from, to) in attacks {
        match run(&damaged(file, from, to)) {
            ClaimOutcome::Failed(_) => {}
            ClaimOutcome::NotRun(why) => eprintln!("not run: {why}"),
            other => panic!("{to}: {other:?}"),
        }
    }
    // A crate that does not compile fails; nothing is run of it.
    let outcome = run(&damaged("src/root.rs", "let rest =", "let other ="));
    match &outcome {
        ClaimOutcome::Failed(why) => assert!(why.contains("does not compile"), "{why}"),
        ClaimOutcome::NotRun(why) => eprintln!("not run: {why}"),
        other => panic!("{other:?}"),
    }
}

/// Outcomes of a claim, by engine.
fn results(rows: &[ClaimResult], id: &str) -> Vec<&'static str> {
    let own = rows.iter().filter(|row| row.id == id);
    own.map(|row| row.outcome.word()).collect()
}

/// Numbers that agree in source and certificate and yet are those of no bench.
#[test]
fn numbers_that_no_bench_has() {
    let with = |file: &str, changes: &[(&str, &str)], pointer: &str, value: serde_json::Value| {
        let mut crate_ = emitted();
        let source = crate_.sources.iter_mut().find(|(path, _)| path == file);
        let text = &mut source.unwrap().1;
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            *text = text.replacen(from, to, 1);
        }
        let mut certificate: serde_json::Value = serde_json::from_str(&crate_.certificate).unwrap();
        *certificate.pointer_mut(pointer).unwrap() = value;
        crate_.certificate = certificate.to_string();
        failing(&crate_, &QUICK)
    };
    // A filter that never corrects.
    let claims = with(
        "src/constants.rs",
        &[("beta: 1_133_871", "beta: 0")],
        "/hardware/beta_rad_s",
        "0".into(),
    );
    assert!(claims.contains(&"hardware-words".to_owned()), "{claims:?}");
    // A gyroscope that turns the other way about the pivot: its third row reversed.
    let claims = with(
        "src/constants.rs",
        &[("z: [0, 0, 1_228_166_276]", "z: [0, 0, -1_228_166_276]")],
        "/hardware/gyroscope/matrix/2/2",
        "-0.001090830782496456".into(),
    );
    assert!(claims.contains(&"physical-signs".to_owned()), "{claims:?}");
}

#[test]
fn a_law_without_a_limit_or_with_a_branch_is_not_total() {
    let settings = ProofSettings {
        audited_texts: false,
        ..QUICK
    };
    let changes = [
        ("Current::from_bits(1_073_741_824)", "Current::from_bits(0)"),
        (
            "Current::from_bits(1_073_741_824)",
            "Current::from_bits(-5)",
        ),
        ("pub const CURRENT_LIMIT", "const CURRENT_LIMIT_2"),
        (
            "let command = (sum + HALF_UNIT) >> SHIFT;",
            "let command = if sum < 0 { 0 - ((sum + HALF_UNIT) >> SHIFT) } else { (sum + HALF_UNIT) >> SHIFT };",
        ),
    ];
    for (from, to) in changes {
        let claims = failing(&damaged("src/control.rs", from, to), &settings);
        let is_noticed = claims
            .iter()
            .any(|claim| claim == "control-total" || claim == "source-understood");
        assert!(is_noticed, "{to}: {claims:?}");
    }
}

/// What a certificate leaves out switches nothing off without a word.
#[test]
fn a_certificate_cannot_switch_claims_off() {
    let altered = |pointer: &str, value: serde_json::Value| {
        let mut crate_ = emitted();
        let mut certificate: serde_json::Value = serde_json::from_str(&crate_.certificate).unwrap();
        *certificate.pointer_mut(pointer).unwrap() = value;
        crate_.certificate = certificate.to_string();
        crate_
    };
    let settings = ProofSettings {
        closed_loop: true,
        ..QUICK
    };
    let rows_of = |crate_: &Emitted| rows(crate_, &settings);
    let few = rows_of(&altered("/closed_loop/terms", 1.into()));
    assert!(results(&few, "closed-loop-for-all-time").contains(&"failed"));

    let none = rows_of(&altered("/closed_loop", serde_json::Value::Null));
    let ProofVerdict::Unsettled(claims) = verdict(&none) else {
        panic!("{:?}", verdict(&none));
    };
    assert!(claims.contains(&"closed-loop-for-all-time".to_owned()));

    // Twelve parameters: those that the loop does not depend on do not matter.
    let mut certificate: serde_json::Value = serde_json::from_str(&emitted().certificate).unwrap();
    let mut parameters = certificate["parameters"].take();
    let list = parameters.as_array_mut().unwrap();
    for index in list.len()..12 {
        let mut more = list[0].clone();
        more["name"] = format!("extra_{index}").into();
        list.push(more);
    }
    let many = rows_of(&altered("/parameters", parameters));
    assert_eq!(results(&many, "stable-for-parameters"), ["proved"]);
}

/// A sensor whose range ends early, as the ±4 g of a BNO055 do, is no fault of the filter: beyond its end it shows nothing.
#[test]
fn a_range_that_ends_early_is_no_false_alarm() {
    let mut crate_ = damaged(
        "src/constants.rs",
        "accel_clip: [32_764, 32_764, 32_764]",
        "accel_clip: [8_000, 8_000, 8_000]",
    );
    let (_, text) = crate_
        .sources
        .iter_mut()
        .find(|(path, _)| path == "src/constants.rs")
        .unwrap();
    *text = text.replace(
        "mag_clip: [12_000, 12_000, 12_000]",
        "mag_clip: [900, 900, 900]",
    );
    let settings = ProofSettings {
        cases: 5_000,
        ..QUICK
    };
    assert_eq!(
        results(&rows(&crate_, &settings), "filter-accurate"),
        ["tested"]
    );
}
