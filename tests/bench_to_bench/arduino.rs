//! The emitted sketch, compiled with stand-ins for Arduino's core, from bench to bench.

use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};

use super::c_loop::{Course, VARIANTS, Variant, compile, stand_ins};
use super::firmware::Firmware;
use super::hand::{Scene, Truth};
use super::line::{Faults, SimulatedBench};
use super::{done, pivot, recorded};

/// The chip and the version of Arduino's core for which a sketch is compiled.
const HUZZAH32: &[&str] = &[
    "-DARDUINO_ARCH_ESP32",
    "-DCONFIG_IDF_TARGET_ESP32=1",
    "-DESP_ARDUINO_VERSION_MAJOR=3",
];
const HUZZAH32_OLD_CORE: &[&str] = &["-DARDUINO_ARCH_ESP32", "-DCONFIG_IDF_TARGET_ESP32=1"];
const ESP32C3: &[&str] = &["-DARDUINO_ARCH_ESP32", "-DESP_ARDUINO_VERSION_MAJOR=3"];

/// Writes the library in C for a model.
fn library(model: &Path, out: &Path) {
    let [model, place] = [model, out].map(|path| path.to_str().expect("a path"));
    done(&["generate", model, "--language", "c", "--out", place]);
}

/// The sketch of a library.
fn sketch(library: &Path) -> String {
    fs::read_to_string(library.join("examples/flywheel/flywheel.ino")).expect("the sketch")
}

/// Compiles the sketch of a library, as Arduino does, with the stand-ins: a program that speaks the language of
/// `firmware/on-host`.
fn compiled(library: &Path, board: &[&str]) -> PathBuf {
    compiled_as(&sketch(library), library, board)
}

/// As [`compiled`], with a user's changes of the sketch.
fn compiled_as(sketch: &str, library: &Path, board: &[&str]) -> PathBuf {
    let source = library.join("src");
    fs::write(
        source.join("sketch.cpp"),
        format!("#include <Arduino.h>\n{sketch}"),
    )
    .expect("written");
    for file in ["flywheel", "flywheel_loop"] {
        let (from, to) = (format!("{file}.c"), format!("{file}.o"));
        compile("gcc", &source, &["-std=c99", "-c", &from, "-o", &to]);
    }
    let stand_ins = stand_ins();
    let board_source = stand_ins.join("stand_in.cpp");
    let [include, board_source] =
        [&stand_ins, &board_source].map(|path| path.to_str().expect("a path"));
    let mut arguments = vec!["-std=gnu++11", "-I", include, "-I", "."];
    arguments.extend(board);
    arguments.extend(["-o", "../sketch", "sketch.cpp", board_source]);
    arguments.extend(["flywheel.o", "flywheel_loop.o"]);
    compile("g++", &source, &arguments);
    library.join("sketch")
}

/// The way of `main.rs` with an Arduino board.
#[test]
#[cfg_attr(not(have_gxx), ignore = "needs g++")]
fn what_a_sketch_records_becomes_the_library_that_balances() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let first = folder.path().join("first");
    library(&root.join("models/thesis-4.4.toml"), &first);
    super::from_bench_to_bench(&compiled(&first, HUZZAH32), |model, out| {
        library(model, out);
        compiled(out, ESP32C3)
    });
}

/// Bring-up, by the older core, and an encoder on the pivot.
#[test]
#[cfg_attr(not(have_gxx), ignore = "needs g++")]
fn a_sketch_records_the_bring_up_and_another_sensor() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = super::bench_folder();
    let first = folder.path().join("library");
    library(&root.join("models/thesis-4.4.toml"), &first);
    let truth = Truth::with_dry_friction();
    let on = SimulatedBench::start(&compiled(&first, HUZZAH32_OLD_CORE), &truth, Faults::NONE);
    for (scene, experiment) in [
        (Scene::Swing { from_rad: 0.0 }, "hanging"),
        (Scene::Upright { from_rad: 0.1 }, "tilted"),
        (Scene::Clamped, "current-step"),
    ] {
        on.scene(scene);
        let record = recorded(folder.path(), &on, &["--experiment", experiment]);
        assert_eq!(record["logs"][0]["end"], "complete", "{record}");
    }
    drop(on);

    let folder = pivot::folder();
    let second = VARIANTS[1].emitted(folder.path(), "c");
    let on = SimulatedBench::start(&compiled(&second, ESP32C3), &truth, Faults::NONE);
    on.scene(Scene::Upright { from_rad: 0.05 });
    let balance = ["--experiment", "balance", "--seconds", "3"];
    let record = recorded(folder.path(), &on, &balance);
    assert_eq!(record["logs"][0]["end"], "complete", "{record}");
}

/// A motor that SimpleFOC drives, and whose speed it tells.
const SIMPLEFOC: Variant = Variant {
    name: "c-simplefoc",
    hardware: "[hardware.wheel_speed]\nkind = \"driver\"\nscale = 0.1\n
[hardware.drive]\npart = \"SimpleFOC voltage\"\nsupply_voltage = 24.0\nwinding_resistance = 1.2\n",
    features: "wheel-driver",
    wheel: "wheel_speed",
};

/// The sketch of a bench with [`SIMPLEFOC`], changed as the guide says: what it gives the motor as its target in each step
/// is the duty of the loop in C, and the motor's speed reaches the loop.
#[test]
#[cfg_attr(not(have_gxx), ignore = "needs g++")]
fn the_guides_text_for_simplefoc_gives_the_duties_of_the_loop() {
    let folder = tempfile::tempdir().expect("a folder");
    let (library, program) = SIMPLEFOC.in_c(folder.path());
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/arduino.md");
    let page = fs::read_to_string(page).expect("the guide");
    let mut blocks = page.split("```cpp\n").skip(1);
    let mut block = || {
        let (text, _) = blocks.next()?.split_once("```")?;
        Some(text)
    };
    let (drive, wheel, before) = (block(), block(), block());
    let emitted = sketch(&library);
    // One count, and one unit of the speed, are those that the head of the sketch states.
    let stated = |number: &str, unit: &str| {
        let is_stated = emitted.contains(&format!(" {number} {unit} per "));
        assert!(is_stated, "{number} {unit}: {emitted}");
        assert!(drive.is_some_and(|text| text.contains(&format!(" = {number}f;"))));
    };
    stated("0.000732444", "V");
    stated("0.1", "rad/s");
    let mut changed = emitted.clone();
    let mut put = |start: &str, end: &str, text: Option<&str>| {
        let from = changed.find(start).unwrap_or_else(|| panic!("no {start}"));
        let to = from + changed[from..].find(end).expect("its end");
        changed.replace_range(from..to, text.expect("a block of the guide"));
    };
    put("void begin_duty() {\n  ledcAttach(", "#else", drive);
    put("void begin_wheel()", "void setup()", wheel);
    put("void loop() {\n", "  for (", before);
    let board = [HUZZAH32, &["-DSIMPLEFOC"]].concat();
    let [mut sketch, mut alone] =
        [compiled_as(&changed, &library, &board), program].map(|program| Firmware::start(&program));
    let mut course = Course::new(5);
    let (mut driven, mut came) = (0, VecDeque::new());
    for step in 0..60_000 {
        let (_, sample, bytes) = course.next();
        came.extend(bytes);
        // What the sketch reads in one turn, on time: both then see the same before each step.
        let now: Vec<u8> = came.drain(..came.len().min(16)).collect();
        let told = |firmware: &mut Firmware| {
            let answer = firmware.tick(1_000 * step, sample.as_ref(), &now);
            answer.expect("it runs")
        };
        let wanted = told(&mut alone);
        assert_eq!(told(&mut sketch), wanted, "step {step}");
        driven += usize::from(wanted.0 != 32_768);
    }
    println!("{driven} steps driven");
    assert!(driven > 500, "{driven} driven");
}
