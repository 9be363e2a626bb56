//! The programs that run an emitted crate and its C; `harness.rs` and `harness.c`, fitted to the bench.

use std::fs;
use std::path::Path;
use std::process::Command;

use codegen::{EmittedCrate, c99};

use super::monitor;

/// The field of the sample in which the wheel's sensor stands.
pub fn wheel_field(emitted: &EmittedCrate) -> &'static str {
    let controller = emitted.file("src/controller.rs").expect("a controller");
    let fields = ["wheel_adc", "wheel_speed", "wheel_count"];
    let is_own = |field: &&str| controller.contains(&format!("pub {field}:"));
    fields
        .into_iter()
        .find(is_own)
        .expect("a sensor of the wheel")
}

/// Whether an encoder on the pivot shows the body.
fn has_body_encoder(emitted: &EmittedCrate) -> bool {
    let controller = emitted.file("src/controller.rs").expect("a controller");
    controller.contains("pub body_count:")
}

/// What is other in the harnesses of a body with an encoder: its lean, along the accelerometer's y, becomes a count about
/// 773, and there is no quaternion.
const BODY_IN_C: [(&str, &str); 5] = [
    (
        "!read_all(sample.gyro, sizeof sample.gyro) || !read_all(sample.accel, sizeof sample.accel)",
        "!read_all(inertial, sizeof inertial)",
    ),
    (
        "int32_t words[3];",
        "int32_t words[3];\n        int16_t inertial[6];",
    ),
    (
        "switch (what) {",
        "sample.body_count = (uint16_t)(773 + inertial[4] / 6);\n        switch (what) {",
    ),
    (
        "flywheel_quaternion(&controller.attitude, answer + 4);",
        "answer[4] = 0;",
    ),
    ("&controller.attitude)", "&controller)"),
];
const BODY_IN_RUST: [(&str, &str); 3] = [
    (
        "gyro: [word(1), word(3), word(5)],\n            accel: [word(7), word(9), word(11)],\n            mag: None,",
        "body_count: (773 + i32::from(word(9)) / 6) as u16,",
    ),
    (
        "let attitude = controller.attitude();",
        "let attitude = &controller;",
    ),
    (
        "let [w, x, y, z] = attitude.quaternion().map(|part| part.to_bits());",
        "let [w, x, y, z] = [0; 4];",
    ),
];

/// What is other in the harnesses where an encoder shows the wheel's speed: its turns are counted apart from the
/// controller's, as a firmware counts them.
const WHEEL_IN_C: [(&str, &str); 3] = [
    (
        "uint8_t what;",
        "uint8_t what;\n    flywheel_encoder_t encoder;\n    flywheel_encoder_init(&encoder);",
    ),
    (
        "flywheel_wheel_speed(sample.wheel_count)",
        "flywheel_wheel_speed(flywheel_encoder_turned(&encoder, &FLYWHEEL_WHEEL_ENCODER))",
    ),
    (
        "switch (what) {",
        "flywheel_encoder_update(&encoder, sample.wheel_count, &FLYWHEEL_WHEEL_ENCODER);\n        switch (what) {",
    ),
];
const WHEEL_IN_RUST: [(&str, &str); 3] = [
    (
        "let mut bytes = ",
        "let mut encoder = generated::encoder::Encoder::new();\n    \
         let numbers = &generated::constants::WHEEL_ENCODER;\n    let mut bytes = ",
    ),
    (
        "wheel_speed(sample.wheel_count)",
        "wheel_speed(encoder.turned(numbers))",
    ),
    (
        "let first = ",
        "encoder.update(sample.wheel_count, numbers);\n        let first = ",
    ),
];

/// A harness's text with these changes, each of which it must take.
fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

/// A harness's text without the blocks that this bench cannot have: each begins with a line `BEGIN NAME` and ends with a line
/// `END`. The digest is of a state without encoders; the functions that are called directly are those of the filter.
fn fitted(text: &str, emitted: &EmittedCrate) -> String {
    let is_inertial = !has_body_encoder(emitted);
    let has_digest = is_inertial && wheel_field(emitted) != "wheel_count";
    let mut kept = String::new();
    let mut is_left_out = false;
    for line in text.lines() {
        if line.contains("BEGIN DIGEST") {
            is_left_out = !has_digest;
        } else if line.contains("BEGIN DIRECT") {
            is_left_out = !is_inertial;
        } else if line.contains("END") && line.len() < 12 {
            is_left_out = false;
        } else if !is_left_out {
            kept += line;
            kept.push('\n');
        }
    }
    match has_digest {
        true => kept,
        false => kept.replace("digest(&controller)", "0"),
    }
}

/// Writes the C of an emitted crate, and the harness beside it.
pub fn written(emitted: &EmittedCrate, folder: &Path) -> EmittedCrate {
    let wheel = wheel_field(emitted);
    let translated = c99::emit(emitted).expect("a translation");
    translated.write(folder).expect("written");
    let mut harness = fitted(include_str!("harness.c"), emitted).replace("wheel_adc", wheel);
    if monitor::has_monitor(emitted) {
        harness = changed(&harness, &monitor::IN_C).replace("FIELD", wheel);
    }
    if wheel == "wheel_count" {
        harness = changed(&harness, &WHEEL_IN_C);
    }
    if has_body_encoder(emitted) {
        harness = changed(&harness, &BODY_IN_C);
    }
    fs::write(folder.join("src/harness.c"), harness).expect("written");
    translated
}

pub const WARNINGS: [&str; 6] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Werror",
];

/// Compiles the harness so that an overflow, a wrong shift or an index outside of an array ends the program.
pub fn compile(folder: &Path, optimisation: &str) -> Result<(), String> {
    let result = Command::new("gcc")
        .current_dir(folder.join("src"))
        .args(WARNINGS)
        .args([
            optimisation,
            "-fsanitize=undefined",
            "-fsanitize-undefined-trap-on-error",
            "-o",
            "../harness",
            "harness.c",
        ])
        .output()
        .expect("gcc runs");
    if result.status.success() {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&result.stderr).into_owned())
    }
}

/// Builds an emitted crate with a harness in Rust that speaks the same language.
pub fn rust_harness(emitted: &EmittedCrate, folder: &Path) -> Command {
    emitted.write(&folder.join("crate")).expect("written");
    let harness = folder.join("harness-in-rust");
    fs::create_dir_all(harness.join("src")).expect("a folder");
    let (wheel, source) = (
        wheel_field(emitted),
        fitted(include_str!("harness.rs"), emitted),
    );
    let mut source = match wheel {
        "wheel_speed" => source.replace("wheel_adc: word(13) as u16", "wheel_speed: word(13)"),
        _ => source,
    }
    .replace("wheel_adc", wheel);
    if monitor::has_monitor(emitted) {
        source = changed(&source, &monitor::IN_RUST).replace("FIELD", wheel);
    }
    if wheel == "wheel_count" {
        source = changed(&source, &WHEEL_IN_RUST);
    }
    if has_body_encoder(emitted) {
        source = changed(&source, &BODY_IN_RUST);
    }
    fs::write(harness.join("src/main.rs"), source).expect("written");
    let manifest = "[package]\nname = \"harness\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
                    [dependencies]\ngenerated = { path = \"../crate\" }\n\n[workspace]\n\n\
                    [profile.dev]\nopt-level = 2\n";
    fs::write(harness.join("Cargo.toml"), manifest).expect("written");
    // The versions that this workspace uses are at hand.
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.lock");
    fs::copy(lock, harness.join("Cargo.lock")).expect("copied");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c99-harness");
    let result = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--target-dir"])
        .arg(&target)
        .current_dir(&harness)
        .env_remove("RUSTFLAGS")
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&result.stderr);
    assert!(result.status.success(), "{said}");
    Command::new(target.join("debug/harness"))
}
