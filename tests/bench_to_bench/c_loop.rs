//! The loop of the library in C beside that of the firmware in Rust, bit for bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serial_frame::{Command as Order, Task};
use simulate::RawSample;

use super::done;
use super::firmware::{self, Firmware};
use super::line::UPRIGHT_COUNT;

#[path = "../../codegen/tests/all/c99/mutants.rs"]
mod mutants;
use mutants::{Damage, mutants};

/// The stand-ins.
pub fn stand_ins() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench_to_bench/arduino")
}

/// Runs a compiler in a folder; it must say nothing.
pub fn compile(compiler: &str, folder: &Path, arguments: &[&str]) {
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

/// The thesis' model with these sections in place of its own hardware, and the features of the firmware for it.
pub struct Variant {
    pub name: &'static str,
    pub hardware: &'static str,
    pub features: &'static str,
    pub wheel: &'static str,
}

pub const VARIANTS: [Variant; 4] = [
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

    /// Writes the module in a language into a folder in this one.
    pub fn emitted(&self, folder: &Path, language: &str) -> PathBuf {
        let (model, out) = (self.model(folder), folder.join(language));
        let [model, place] = [&model, &out].map(|path| path.to_str().expect("a path"));
        let preset = ["--preset", "thesis-bench", "--language", language];
        done(&[&["generate", model, "--out", place][..], &preset].concat());
        out
    }

    /// The library in C, and in it the program of its loop.
    pub fn in_c(&self, folder: &Path) -> (PathBuf, PathBuf) {
        let library = self.emitted(folder, "c");
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
        arguments.extend(["flywheel.c", "-o", "../on-host"]);
        arguments.push(program.to_str().expect("a path"));
        compile("gcc", &library.join("src"), &arguments);
        let program = library.join("on-host");
        (library, program)
    }

    /// The loop in Rust, kept under this name.
    fn in_rust(&self, folder: &Path) -> PathBuf {
        firmware::compiled(&self.emitted(folder, "rust"), self.name, self.features)
    }
}

/// What reaches a firmware: a body that stands upright or sways, sensors that fail, ticks that come late, and a program that
/// commands, repeats itself and falls silent, over a line that damages some bytes and brings others that nobody sent.
pub struct Course {
    random: ChaCha8Rng,
    /// Steps in which the sensors do not answer yet.
    silent_steps: u32,
    step: u32,
    now_us: u32,
    lean: f64,
    order: Order,
    /// Whether a new current comes in every other step.
    is_busy: bool,
    wheel: u16,
}

impl Course {
    pub fn new(seed: u64) -> Course {
        let order = Order {
            // A command that was under way before the firmware began.
            task: Task::Balance,
            wish: 7,
            every: 3,
            lease_ms: 60_000,
        };
        Course {
            random: ChaCha8Rng::seed_from_u64(seed),
            silent_steps: if seed.is_multiple_of(2) { 3 } else { 0 },
            step: 0,
            // The clock wraps within the course.
            now_us: u32::MAX - 20_000_000,
            lean: 0.0,
            order,
            is_busy: false,
            wheel: 773,
        }
    }

    /// The time of the next tick, what the sensors say, and the bytes that came.
    pub fn next(&mut self) -> (u32, Option<RawSample>, Vec<u8>) {
        let random = &mut self.random;
        // Half a sample time late is borne.
        let delay_us = match random.random_range(0..5_000) {
            0 => random.random_range(0..5_000),
            1 => random.random(),
            _ => random.random_range(0..=500),
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
        self.step += 1;
        let is_read = self.step > self.silent_steps && random.random_range(0..3_000) > 0;
        (self.now_us, is_read.then_some(sample), self.bytes())
    }

    fn bytes(&mut self) -> Vec<u8> {
        let random = &mut self.random;
        if random.random_range(0..3_000) == 0 {
            self.is_busy = !self.is_busy;
        }
        match random.random_range(0..4_000) {
            _ if self.step == 5 => self.order.frame().bytes().to_vec(),
            // Long enough for the attitude.
            _ if self.step < 600 => vec![],
            // Noise, and ends of frames.
            0..40 => {
                let count = random.random_range(0..60);
                let noise = (0..count).map(|_| random.next_u32() as u8 & 0x13);
                noise.collect()
            }
            40..50 => {
                self.order.wish = self.order.wish.wrapping_add(random.random_range(0..2));
                self.order.task = match random.random_range(0..4) {
                    0 => Task::Watch,
                    1 => Task::Balance,
                    _ => drive(random.random()),
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
            // Whole, but for its last code, which leads beyond the end.
            90..120 => {
                self.order.wish = self.order.wish.wrapping_add(1);
                let mut bytes = self.order.frame().bytes().to_vec();
                let mut last = 0;
                while last + usize::from(bytes[last]) < bytes.len() - 1 {
                    last += usize::from(bytes[last]);
                }
                bytes[last] += random.random_range(1..3);
                bytes
            }
            2_000.. if self.is_busy && matches!(self.order.task, Task::Drive { .. }) => {
                // Any current, or eighths of an ampere.
                let current_ua = match random.random_range(0..4) {
                    0 => 125_000 * random.random_range(-20..20),
                    _ => random.random_range(-2_500_000..2_500_000),
                };
                self.order.task = drive(current_ua);
                self.order.frame().bytes().to_vec()
            }
            _ => vec![],
        }
    }
}

fn drive(current_ua: i32) -> Task {
    Task::Drive { current_ua }
}

/// Whether a program of the loop in C has, for any current, the word that the loop in Rust computes (`word_of` in
/// `firmware/core/src/orders.rs`): 2⁻²⁹ A on the thesis' bench, finer than any duty shows.
fn has_words_of_currents(program: &Path, folder: &Path) -> bool {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let ends = [0, 1, -1, 4_000_000, -4_000_000, i32::MAX, i32::MIN];
    let eighths = (-40..=40).map(|eighth| 125_000 * eighth);
    let any = (0..20_000).map(|_| random.random::<i32>() >> random.random_range(0..12));
    let currents: Vec<i32> = ends.into_iter().chain(eighths).chain(any).collect();
    let told = folder.join("currents");
    let bytes: Vec<u8> = currents.iter().flat_map(|ua| ua.to_le_bytes()).collect();
    fs::write(&told, bytes).expect("written");
    let output = Command::new(program)
        .arg("currents")
        .stdin(fs::File::open(&told).expect("currents"))
        .output()
        .expect("it starts");
    let word = |ua: &i32| {
        let word = (i64::from(*ua) << 29) / 1_000_000;
        word.clamp(i64::from(-i32::MAX), i64::from(i32::MAX)) as i32
    };
    let wanted: Vec<u8> = currents
        .iter()
        .flat_map(|ua| word(ua).to_le_bytes())
        .collect();
    output.stdout == wanted
}

/// Frames, duties and trips of the loop in C are those of the loop in Rust, whatever comes, for each sensor of body and wheel.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn the_loop_in_c_is_the_loop_in_rust() {
    for (seed, variant) in (1..).zip(&VARIANTS) {
        let folder = tempfile::tempdir().expect("a folder");
        let (_, c) = variant.in_c(folder.path());
        let has_words = has_words_of_currents(&c, folder.path());
        assert!(has_words, "{}", variant.name);
        let rust = variant.in_rust(folder.path());
        let [mut rust, mut c] = [rust, c].map(|program| Firmware::start(&program));
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

/// Damages that change nothing: initial values that nothing reads, because the first command or the first step brings its own
/// before; and the version of a frame, which is not zero, taken for one that needs no look.
const WITHOUT_EFFECT: [&str; 8] = [
    "self->wish = 0; -> 1",
    "self->lease_ms = 0; -> 1",
    "self->came_us = 0; -> 1",
    "self->current = 0; -> 1",
    "self->is_new = 0; -> 1",
    "self->was_armed = 0; -> 1",
    "self->time_us = 0; -> 1",
    "for (uint8_t place = 1; place < FLYWHEEL_FRAME_BYTES - 1u; place++) { -> 2",
];

/// Whether a damage is one of these, or makes another number than zero of a boolean's one: the loop asks whether it is zero.
fn has_no_effect(line: &str) -> bool {
    let line = line.trim();
    let is_boolean = ["has_", "is_", "was_"]
        .iter()
        .any(|start| line.starts_with(&format!("self->{start}")));
    WITHOUT_EFFECT.contains(&line) || (is_boolean && line.ends_with(" = 1; -> 2"))
}

/// The loop in C, damaged in any number, cast or operator: its frames or duties differ, or the compiler notices, or makes the
/// same program of it. `FLYWHEEL_DAMAGE=TEXT` damages only lines that contain the text.
#[test]
#[ignore = "run apart: some minutes"]
fn any_damage_to_the_loop_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (library, c) = VARIANTS[0].in_c(folder.path());
    let rust = VARIANTS[0].in_rust(folder.path());
    let told = |seed: u64| folder.path().join(format!("told-{seed}"));
    for seed in [11, 12] {
        let mut course = Course::new(seed);
        let messages = (0..100_000).flat_map(|_| {
            let (now_us, sample, came) = course.next();
            firmware::message(now_us, sample.as_ref(), &came)
        });
        fs::write(told(seed), messages.collect::<Vec<u8>>()).expect("written");
    }
    // A damaged loop may have no end.
    let said = |program: &Path, seed: u64| {
        let told = fs::File::open(told(seed)).expect("what is told");
        let output = Command::new("timeout")
            .arg("60")
            .arg(program)
            .stdin(told)
            .output()
            .expect("it starts");
        output.stdout
    };
    let wanted = [11, 12].map(|seed| (seed, said(&rust, seed)));
    let is_wanted = |program: &Path| {
        let mut both = wanted.iter();
        has_words_of_currents(program, folder.path())
            && both.all(|(seed, wanted)| wanted.len() > 500_000 && said(program, *seed) == *wanted)
    };
    assert!(is_wanted(&c));

    let source = library.join("src");
    let file = source.join("flywheel_loop.c");
    let whole = fs::read_to_string(&file).expect("the loop");
    compile(
        "gcc",
        &source,
        &["-std=c99", "-c", "flywheel.c", "-o", "flywheel.o"],
    );
    let program = stand_ins().join("on_host.c");
    let program = program.to_str().expect("a path");
    let object = |text: &str| {
        fs::write(&file, text).expect("written");
        let compiled = Command::new("gcc")
            .current_dir(&source)
            .args([
                "-std=c99",
                "-O1",
                "-Wall",
                "-Wextra",
                "-Wconversion",
                "-Werror",
            ])
            .args(["-c", "flywheel_loop.c", "-o", "loop.o"])
            .output()
            .expect("gcc starts");
        let is_compiled = compiled.status.success();
        is_compiled.then(|| fs::read(source.join("loop.o")).expect("an object"))
    };
    let own = object(&whole).expect("no warning");
    let kinds = [Damage::Operators, Damage::Casts, Damage::Numbers];
    let damaged: Vec<_> = kinds
        .iter()
        .flat_map(|kind| mutants(&whole, *kind))
        .collect();
    assert!(damaged.len() > 150, "{}", damaged.len());
    let (mut unnoticed, mut same) = (vec![], 0);
    let only = std::env::var("FLYWHEEL_DAMAGE").unwrap_or_default();
    for (line, text) in damaged.iter().filter(|(line, _)| line.contains(&only)) {
        match object(text) {
            None => continue,
            Some(found) if found == own => {
                same += 1;
                continue;
            }
            Some(_) => {}
        }
        let arguments = [
            "-std=c99",
            "-I",
            ".",
            "-DWHEEL=wheel_adc",
            "-DWHEEL_TYPE=uint16_t",
        ];
        let files = ["flywheel.o", program, "-o", "../damaged"];
        compile("gcc", &source, &[&arguments[..], &files[..]].concat());
        if !has_no_effect(line) && is_wanted(&library.join("damaged")) {
            println!("unnoticed: {line}");
            unnoticed.push(line);
        }
    }
    println!("{} damages, {same} of them the same program", damaged.len());
    assert!(unnoticed.is_empty(), "{unnoticed:#?}");
}
