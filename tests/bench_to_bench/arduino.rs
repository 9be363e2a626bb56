//! The same with the library in C: its loop beside that of the firmware in Rust, bit for bit; and the emitted sketch, compiled
//! with stand-ins for Arduino's core, from bench to bench.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serial_frame::{Command as Order, Task};
use simulate::RawSample;

use super::firmware::{self, Firmware};
use super::hand::{Scene, Truth};
use super::line::{Faults, SimulatedBench, UPRIGHT_COUNT};
use super::{done, pivot, recorded};

/// The stand-ins.
fn stand_ins() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench_to_bench/arduino")
}

/// Runs a compiler in a folder; it must say nothing.
fn compile(compiler: &str, folder: &Path, arguments: &[&str]) {
    let output = Command::new(compiler)
        .current_dir(folder)
        .args(arguments)
        .args(["-O1", "-Wall", "-Wextra", "-Werror"])
        .args(["-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"])
        .output()
        .expect("the compiler starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{compiler} {arguments:?}: {said}");
}

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

/// Compiles the sketch of a library, as Arduino does, with the stand-ins: a program that speaks the language of
/// `firmware/on-host`.
fn compiled(library: &Path, board: &[&str]) -> PathBuf {
    let sketch = fs::read_to_string(library.join("examples/flywheel/flywheel.ino"));
    let sketch = sketch.expect("the sketch");
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

/// The thesis' model with these sections in place of its own hardware, and the features of the firmware for it.
struct Variant {
    name: &'static str,
    hardware: &'static str,
    features: &'static str,
    wheel: &'static str,
}

const VARIANTS: [Variant; 4] = [
    Variant {
        name: "c-first",
        hardware: "",
        features: "",
        wheel: "wheel_adc",
    },
    Variant {
        name: "c-pivot",
        hardware: PIVOT,
        features: "pivot-encoder",
        wheel: "wheel_adc",
    },
    Variant {
        name: "c-wheel-encoder",
        hardware: "[hardware.wheel_speed]\nkind = \"encoder\"\npart = \"AS5600\"\nwindow = 8\n",
        features: "wheel-encoder",
        wheel: "wheel_count",
    },
    Variant {
        name: "c-driver",
        hardware: "[hardware.wheel_speed]\nkind = \"driver\"\nscale = 0.1047\nlargest = 700.0\n",
        features: "wheel-driver",
        wheel: "wheel_speed",
    },
];
const PIVOT: &str = "[hardware.angle]\nkind = \"encoder\"\npart = \"AS5600\"\nzero = 773\n";

impl Variant {
    fn model(&self, folder: &Path) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let thesis = fs::read_to_string(root.join("models/thesis-4.4.toml")).expect("a model");
        let mut text = String::new();
        let mut is_dropped = false;
        for line in thesis.lines() {
            if line.starts_with('[') {
                is_dropped = line.starts_with("[hardware") && !self.hardware.is_empty();
            }
            if !is_dropped {
                text += line;
                text.push('\n');
            }
        }
        let path = folder.join("model.toml");
        fs::write(&path, text + self.hardware).expect("written");
        path
    }

    /// The loop in Rust and the loop in C.
    fn compiled(&self, folder: &Path) -> [PathBuf; 2] {
        let model = self.model(folder);
        let (module, library) = (folder.join("module"), folder.join("library"));
        for (out, language) in [(&module, "rust"), (&library, "c")] {
            let [model, out] = [&model, out].map(|path| path.to_str().expect("a path"));
            done(&[
                "generate",
                model,
                "--preset",
                "thesis-bench",
                "--language",
                language,
                "--out",
                out,
            ]);
        }
        let mut arguments = vec!["-std=c99", "-Wconversion", "-Wpedantic", "-I", "."];
        let wheel = format!("-DWHEEL={}", self.wheel);
        arguments.push(&wheel);
        arguments.push(match self.wheel {
            "wheel_speed" => "-DWHEEL_TYPE=int16_t",
            _ => "-DWHEEL_TYPE=uint16_t",
        });
        if self.hardware == PIVOT {
            arguments.push("-DBODY_COUNT");
        }
        let program = stand_ins().join("on_host.c");
        arguments.extend(["flywheel.c", "flywheel_loop.c", "-o", "../on-host"]);
        arguments.push(program.to_str().expect("a path"));
        compile("gcc", &library.join("src"), &arguments);
        let rust = firmware::compiled(&module, self.name, self.features);
        [rust, library.join("on-host")]
    }
}

/// What reaches a firmware: a body that stands upright or sways, sensors that fail, ticks that come late, and a program that
/// commands, repeats itself and falls silent, over a line that damages some bytes and brings others that nobody sent.
struct Course {
    random: ChaCha8Rng,
    now_us: u32,
    lean: f64,
    order: Order,
    wheel: u16,
}

impl Course {
    fn new(seed: u64) -> Course {
        let order = Order {
            task: Task::Watch,
            wish: 0,
            every: 1,
            lease_ms: 0,
        };
        Course {
            random: ChaCha8Rng::seed_from_u64(seed),
            // The clock wraps within the course.
            now_us: u32::MAX - 20_000_000,
            lean: 0.0,
            order,
            wheel: 773,
        }
    }

    /// The time of the next tick, what the sensors say, and the bytes that came.
    fn next(&mut self) -> (u32, Option<RawSample>, Vec<u8>) {
        let random = &mut self.random;
        let delay_us = match random.random_range(0..5_000) {
            0 => random.random_range(0..5_000),
            1 => random.random(),
            _ => random.random_range(0..300),
        };
        self.now_us = self.now_us.wrapping_add(1_000).wrapping_add(delay_us);
        self.lean = 0.999 * self.lean + random.random_range(-0.2..0.2);
        self.wheel = self.wheel.wrapping_add_signed(random.random_range(-2..=2));
        let mut count = |least: i32| random.random_range(-least..=least);
        let lean = self.lean.round() as i32;
        let mut gyro = [count(3) as i16, count(3) as i16, count(3) as i16];
        let accel = [4096 + count(8), 10 * lean + count(8), count(8)].map(|word| word as i16);
        let mut body = (i32::from(UPRIGHT_COUNT) + lean + count(1)) as u16;
        let mut wheel = self.wheel;
        if random.random_range(0..2_000) == 0 {
            (gyro, body, wheel) = (random.random(), random.random(), random.random());
            self.wheel = 773;
        }
        let sample = RawSample {
            body,
            gyro,
            accel,
            mag: None,
            wheel: i32::from(wheel),
        };
        let is_read = random.random_range(0..3_000) > 0;
        (self.now_us, is_read.then_some(sample), self.bytes())
    }

    fn bytes(&mut self) -> Vec<u8> {
        let random = &mut self.random;
        match random.random_range(0..4_000) {
            // Noise, and ends of frames.
            0..40 => {
                let count = random.random_range(0..60);
                (0..count).map(|_| random.next_u32() as u8 & 0x13).collect()
            }
            40..50 => {
                self.order.wish = self.order.wish.wrapping_add(random.random_range(0..2));
                self.order.task = match random.random_range(0..4) {
                    0 => Task::Watch,
                    1 => Task::Balance,
                    2 => Task::Drive {
                        current_ua: random.random(),
                    },
                    _ => Task::Drive {
                        current_ua: random.random_range(-300_000..300_000),
                    },
                };
                self.order.every = [0, 1, 1, 5, 255][random.random_range(0..5)];
                self.order.lease_ms = [0, 300, 1_000, 60_000][random.random_range(0..4)];
                self.order.frame().bytes().to_vec()
            }
            50..90 => {
                let mut bytes = self.order.frame().bytes().to_vec();
                if random.random_range(0..4) == 0 {
                    let place = random.random_range(0..bytes.len());
                    bytes[place] = random.next_u32() as u8;
                }
                bytes
            }
            _ => vec![],
        }
    }
}

/// Frames, duties and trips of the loop in C are those of the loop in Rust, whatever comes, for each sensor of body and wheel.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn the_loop_in_c_is_the_loop_in_rust() {
    for (seed, variant) in (1..).zip(&VARIANTS) {
        let folder = tempfile::tempdir().expect("a folder");
        let programs = variant.compiled(folder.path());
        let [mut rust, mut c] = programs.map(|program| Firmware::start(&program));
        let mut course = Course::new(seed);
        let (mut frames, mut driven, mut statuses) = (0, 0, [0; 10]);
        let mut receiver = serial_frame::Receiver::new();
        for step in 0..150_000 {
            let (now_us, sample, came) = course.next();
            let wanted = rust.tick(now_us, sample.as_ref(), &came);
            let wanted = wanted.expect("the firmware runs");
            let found = c.tick(now_us, sample.as_ref(), &came);
            let found = found.unwrap_or_else(|error| {
                panic!("{}, seed {seed}, step {step}: {error}", variant.name)
            });
            assert_eq!(found, wanted, "{}, seed {seed}, step {step}", variant.name);
            driven += usize::from(wanted.0 != 32_768);
            for frame in wanted.1.iter().filter_map(|byte| receiver.telemetry(*byte)) {
                frames += 1;
                statuses[usize::from(frame.expect("a whole frame").status)] += 1;
            }
        }
        println!(
            "{}: {frames} frames, {driven} driven, {statuses:?}",
            variant.name
        );
        assert!(
            frames > 10_000 && driven > 500,
            "{frames} frames, {driven} driven"
        );
        // Not aligned, ready, running, tripped by a fault.
        let [not_aligned, ready, running, .., fault] = statuses;
        let seen = [not_aligned, ready, running, fault];
        assert!(seen.iter().all(|count| *count > 100), "{statuses:?}");
    }
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
    let second = folder.path().join("library");
    let model = VARIANTS[1].model(folder.path());
    let [model, out] = [&model, &second].map(|path| path.to_str().expect("a path"));
    let preset = ["--preset", "thesis-bench", "--language", "c"];
    done(&[&["generate", model, "--out", out][..], &preset].concat());
    let on = SimulatedBench::start(&compiled(&second, ESP32C3), &truth, Faults::NONE);
    on.scene(Scene::Upright { from_rad: 0.05 });
    let balance = ["--experiment", "balance", "--seconds", "3"];
    let record = recorded(folder.path(), &on, &balance);
    assert_eq!(record["logs"][0]["end"], "complete", "{record}");
}
