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
            "self.state = step_imu(&self.state, gyro, accel, &FILTER);",
            "let next = step_imu(&self.state, gyro, accel, &FILTER);\n        let angle = pivot_angle(next.quaternion, MOUNTING_ANGLE);\n        if angle > 0x10_0000 || angle < -0x10_0000 {\n            self.state = next;\n        }",
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
            "self.state = step_imu(&self.state, gyro, accel, &FILTER);",
            "let next = step_imu(&self.state, gyro, accel, &FILTER);\n        let angle = pivot_angle(next.quaternion, MOUNTING_ANGLE);\n        if angle > 0x10_0000 || angle < -0x10_0000 {\n            self.state = next;\n        }",
        ),
        // One unit beyond one of the branches of a root.
        ("src/root.rs", "if n < 0x100_0000 {", "if n < 0x100_0001 {"),
        ("src/root.rs", "    y + mul_high", "    y - mul_high"),
    ];
    for (file, from, to) in attacks {
        let outcome = run(&damaged(file, from, to));
        assert!(
            matches!(outcome, ClaimOutcome::Failed(_)),
            "{to}: {outcome:?}"
        );
    }
    // A crate that does not compile fails; nothing is run of it.
    let outcome = run(&damaged("src/root.rs", "let rest =", "let other ="));
    let ClaimOutcome::Failed(why) = &outcome else {
        panic!("{outcome:?}");
    };
    assert!(why.contains("does not compile"), "{why}");
}
