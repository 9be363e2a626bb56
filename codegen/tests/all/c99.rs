//! The emitted C does what the emitted Rust does, bit for bit, and compiles without a warning.

use std::fs;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use codegen::hardware::{BiasObserverSpec, BodySensor};
use codegen::{EmittedCrate, EmittedFile, c99, generate};
use generated::{Angle, Controller, Current, Rate, Sample, WheelSpeed, control, wheel_speed};
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use numbers::Expected;

#[path = "c99/damage.rs"]
mod damage;
#[path = "c99/monitor.rs"]
mod monitor;
#[path = "c99/numbers.rs"]
mod numbers;
use crate::{benches, thesis};

/// The committed crate, as files.
fn committed() -> EmittedCrate {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    let mut paths = vec!["certificate.json".to_string()];
    for entry in fs::read_dir(folder.join("src")).expect("generated/src") {
        let name = entry.expect("an entry").file_name();
        paths.push(format!("src/{}", name.to_str().expect("a name in UTF-8")));
    }
    paths.sort();
    let files = paths.into_iter().map(|path| EmittedFile {
        contents: fs::read_to_string(folder.join(&path)).expect("an emitted file"),
        path,
    });
    EmittedCrate {
        files: files.collect(),
    }
}

/// A bench that uses everything which the emitted module can do: sensors askew and with bias, an accelerometer away
/// from the pivot, a mounting angle, an observer of the angle's bias.
fn with_everything() -> EmittedCrate {
    mounted_at(0.05)
}

/// The same at another mounting angle (rad).
fn mounted_at(mounting_angle_rad: f64) -> EmittedCrate {
    let mut spec = thesis::spec();
    let askew = Matrix3::new(1.0, 0.02, -0.01, -0.03, 0.98, 0.015, 0.01, -0.02, 1.03);
    let BodySensor::Inertial(attitude) = &mut spec.hardware.body else {
        panic!("the bench of the thesis is inertial");
    };
    attitude.gyro.matrix *= askew;
    attitude.gyro.bias_counts = Vector3::new(3.5, -7.25, 11.0);
    attitude.accel.matrix *= askew.transpose();
    attitude.accel.bias_counts = Vector3::new(-20.5, 13.0, 40.25);
    attitude.lever_arm_m = [0.07, -0.02];
    attitude.mounting_angle_rad = mounting_angle_rad;
    spec.hardware.bias_observer = Some(BiasObserverSpec {
        decay: 0.99,
        direct: [0.1, 1e-2, 1e-4],
        from_states: [-1e-3, -1e-4, -1e-6],
        from_current: 1e-5,
        limit_rad: 0.02,
    });
    generate(&spec).expect("an emitted crate")
}

/// The field of the sample in which the wheel's sensor stands.
fn wheel_field(emitted: &EmittedCrate) -> &'static str {
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
    ("flywheel_quaternion(&controller.attitude, answer + 4);", ""),
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

/// Writes the C of an emitted crate, and the harness beside it.
fn written(emitted: &EmittedCrate, folder: &Path) -> EmittedCrate {
    let wheel = wheel_field(emitted);
    let translated = c99::emit(emitted).expect("a translation");
    translated.write(folder).expect("written");
    let mut harness = include_str!("c99/harness.c").replace("wheel_adc", wheel);
    if monitor::has_monitor(emitted) {
        harness = changed(&harness, &monitor::IN_C).replace("WHEEL", wheel);
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

const WARNINGS: [&str; 6] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Werror",
];

/// Compiles the harness so that an overflow, a wrong shift or an index outside of an array ends the program.
fn compile(folder: &Path, optimisation: &str) -> Result<(), String> {
    let result = Command::new("gcc")
        .current_dir(folder.join("src"))
        .args(WARNINGS)
        .args([
            optimisation,
            "-fsanitize=undefined",
            "-fsanitize-undefined-trap-on-error",
            "-o",
            "../harness",
            "flywheel.c",
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

/// One thing that a firmware does.
#[derive(Clone, Copy)]
struct Call {
    what: u8,
    gyro: [i16; 3],
    accel: [i16; 3],
    wheel_adc: u16,
    words: [i32; 3],
}

impl Call {
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![self.what];
        for word in self.gyro.into_iter().chain(self.accel) {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.wheel_adc.to_le_bytes());
        for word in self.words {
            bytes.extend(word.to_le_bytes());
        }
        bytes
    }

    /// What the committed Rust answers.
    fn answer(&self, controller: &mut Controller) -> [i32; 8] {
        let sample = Sample {
            gyro: self.gyro,
            accel: self.accel,
            mag: None,
            wheel_adc: self.wheel_adc,
        };
        let [a, b, c] = self.words;
        let first = match self.what {
            0 => {
                *controller = Controller::new();
                0
            }
            1 => i32::from(controller.arm()),
            2 => {
                controller.disarm();
                0
            }
            3 => {
                controller.fault();
                0
            }
            4 => i32::from(controller.step(&sample).0),
            5 => {
                let current = Current::from_bits(a);
                i32::from(controller.step_with_current(&sample, current).0)
            }
            7 => wheel_speed(self.wheel_adc).to_bits(),
            _ => {
                let (angle, rate) = (Angle::from_bits(a), Rate::from_bits(b));
                control(angle, rate, WheelSpeed::from_bits(c)).to_bits()
            }
        };
        let attitude = controller.attitude();
        let [w, x, y, z] = attitude.quaternion().map(|part| part.to_bits());
        let (angle, rate) = (attitude.angle().to_bits(), attitude.rate().to_bits());
        [first, controller.status() as i32, angle, rate, w, x, y, z]
    }
}

/// A body that sways about upright with noise, so that the controller aligns, arms, runs and trips; words at their
/// ends; and any words at all. Each for some hundreds of steps.
struct Calls {
    random: ChaCha8Rng,
    mode: u8,
    left: u32,
    lean_rad: f64,
    rate_rad_s: f64,
    falls: bool,
    is_weightless: bool,
    /// Which sensor alone is at the end of its range in the last steps.
    clips: Option<Clipped>,
    /// Whether the gyroscope's reading stands still in the last steps, and its reading before.
    sticks: bool,
    gyro: [i16; 3],
    /// By how much the accelerometer's other axes are off, counts: within what may be gravity.
    sideways: [i16; 2],
    /// What every call of these steps is, where it is one and the same.
    calls: Option<u8>,
}

/// A sensor at the end of its range.
#[derive(Clone, Copy)]
enum Clipped {
    Gyro,
    Accel,
}

impl Calls {
    fn new(seed: u64) -> Calls {
        Calls {
            random: ChaCha8Rng::seed_from_u64(seed),
            mode: 0,
            left: 0,
            lean_rad: 0.0,
            rate_rad_s: 0.0,
            falls: false,
            is_weightless: false,
            clips: None,
            sticks: false,
            gyro: [0; 3],
            sideways: [0; 2],
            calls: None,
        }
    }

    fn any<const N: usize>(&mut self) -> [i16; N] {
        let ends = [i16::MIN, i16::MIN + 1, -1, 0, 1, i16::MAX - 1, i16::MAX];
        std::array::from_fn(|_| match self.mode {
            1 => ends[self.random.random_range(0..ends.len())],
            _ => self.random.random(),
        })
    }

    fn next(&mut self) -> Call {
        if self.left == 0 {
            self.mode = [0, 0, 0, 1, 2][self.random.random_range(0..5)];
            self.left = self.random.random_range(200..3000);
            self.lean_rad = self.random.random_range(-0.05..0.05);
            self.rate_rad_s = self.random.random_range(-0.02..0.02);
            self.falls = self.random.random_range(0..3) == 0;
            self.is_weightless = !self.falls && self.random.random_range(0..4) == 0;
            self.calls = [None, None, Some(4), Some(5)][self.random.random_range(0..4)];
            // Seldom, since a controller that trips here does not run in what comes next.
            self.clips = match self.left % 16 {
                0 => Some(Clipped::Gyro),
                1 => Some(Clipped::Accel),
                _ => None,
            };
            self.sticks = self.left % 16 == 2;
            self.sideways = match self.left % 2 {
                0 => [0; 2],
                _ if self.is_weightless => [0; 2],
                _ => std::array::from_fn(|_| self.random.random_range(-350..350)),
            };
        }
        self.left -= 1;
        let any = match self.random.random_range(0..1000) {
            0 => 0,
            1..40 => 1,
            40 => 2,
            41 => 3,
            42..80 => 5,
            80..110 => 6,
            110..120 => 7,
            _ => 4,
        };
        let what = self.calls.unwrap_or(any);
        let (gyro, accel, wheel_adc) = if self.mode == 0 {
            let mut noise = |size: f64| self.random.random_range(-size..size);
            let gyro = [noise(3.0), noise(3.0), 916.7 * self.rate_rad_s + noise(3.0)];
            let (sin, cos) = self.lean_rad.sin_cos();
            let gravity = if self.is_weightless { 100.0 } else { 4096.0 };
            let accel = [gravity * cos, -gravity * sin, 0.0].map(|part| part + noise(8.0));
            // An encoder's count may change by that much, and from step to step.
            let wheel = 773.0 + noise(14.0);
            // It sways, or falls.
            let stiffness = if self.falls { -20.0 } else { 9.0 };
            self.rate_rad_s += 0.001 * (noise(1.0) - stiffness * self.lean_rad);
            self.lean_rad += 0.001 * self.rate_rad_s;
            let mut gyro = gyro.map(|part| part.round() as i16);
            let mut accel = accel.map(|part| part.round() as i16);
            accel[1] += self.sideways[0];
            accel[2] += self.sideways[1];
            if self.sticks && self.left < 100 {
                gyro = self.gyro;
            }
            self.gyro = gyro;
            // Longer than a controller that runs bears it.
            if self.left < 100 {
                match self.clips {
                    Some(Clipped::Gyro) => gyro[0] = i16::MAX,
                    Some(Clipped::Accel) => accel[1] = i16::MIN,
                    None => {}
                }
            }
            (gyro, accel, wheel as u16)
        } else {
            (self.any(), self.any(), self.random.random())
        };
        let words = match self.mode {
            1 => [i32::MIN, i32::MAX, 0]
                .map(|end: i32| end.wrapping_add(self.random.random_range(-1..2))),
            // The largest current, step after step.
            _ if self.calls == Some(5) => [i32::MAX; 3],
            _ => self.random.random(),
        };
        Call {
            what,
            gyro,
            accel,
            wheel_adc,
            words,
        }
    }
}

/// What a program that speaks the harness's language answers; it ends where the program does.
fn answers(program: &mut Command, seed: u64, calls: usize) -> Vec<[i32; 8]> {
    let mut source = Calls::new(seed);
    answers_to(program, (0..calls).map(move |_| source.next()))
}

/// The same for these calls.
fn answers_to(
    program: &mut Command,
    calls: impl Iterator<Item = Call> + Send + 'static,
) -> Vec<[i32; 8]> {
    let mut child = program
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the harness runs");
    let mut input = BufWriter::new(child.stdin.take().expect("standard input"));
    let writer = std::thread::spawn(move || {
        for call in calls {
            // A harness that has ended says so by what it does not answer.
            if input.write_all(&call.bytes()).is_err() {
                return;
            }
        }
    });
    let mut output = BufReader::new(child.stdout.take().expect("standard output"));
    let mut answers = vec![];
    let mut bytes = [0; 32];
    while output.read_exact(&mut bytes).is_ok() {
        answers.push(answer(&bytes));
    }
    drop(output);
    let _ = child.kill();
    let _ = child.wait();
    writer.join().expect("the writer");
    answers
}

/// The words of an answer.
fn answer(bytes: &[u8; 32]) -> [i32; 8] {
    std::array::from_fn(|word| {
        let word = &bytes[4 * word..4 * word + 4];
        i32::from_le_bytes(word.try_into().expect("four bytes"))
    })
}

/// Where two programs first differ.
fn difference(c: &[[i32; 8]], rust: &[[i32; 8]]) -> Option<String> {
    let place = (0..rust.len()).find(|&index| c.get(index) != Some(&rust[index]))?;
    Some(format!(
        "call {place}: C {:?}, Rust {:?}",
        c.get(place),
        rust[place]
    ))
}

/// What the committed crate, compiled into this test, answers.
fn committed_answers(seed: u64, calls: usize) -> Vec<[i32; 8]> {
    let (mut controller, mut source) = (Controller::new(), Calls::new(seed));
    (0..calls)
        .map(|_| source.next().answer(&mut controller))
        .collect()
}

/// Builds an emitted crate with a harness in Rust that speaks the same language.
fn rust_harness(emitted: &EmittedCrate, folder: &Path) -> Command {
    emitted.write(&folder.join("crate")).expect("written");
    let harness = folder.join("harness-in-rust");
    fs::create_dir_all(harness.join("src")).expect("a folder");
    let (wheel, source) = (wheel_field(emitted), include_str!("c99/harness.rs"));
    let mut source = match wheel {
        "wheel_speed" => source.replace("wheel_adc: word(13) as u16", "wheel_speed: word(13)"),
        _ => source.to_owned(),
    }
    .replace("wheel_adc", wheel);
    if monitor::has_monitor(emitted) {
        source = changed(&source, &monitor::IN_RUST).replace("WHEEL", wheel);
    }
    if wheel == "wheel_count" {
        source = changed(&source, &WHEEL_IN_RUST);
    }
    if has_body_encoder(emitted) {
        source = changed(&source, &BODY_IN_RUST);
    }
    fs::write(harness.join("src/main.rs"), source).expect("written");
    let manifest = "[package]\nname = \"harness\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
                    [dependencies]\ngenerated = { path = \"../crate\" }\n\n[workspace]\n";
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

#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn c_and_rust_answer_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    written(&committed(), folder.path());
    let mut seen = [0; 10];
    for (optimisation, seed) in [("-O0", 1), ("-O2", 2), ("-Os", 3)] {
        compile(folder.path(), optimisation).expect("no warning");
        let calls = if optimisation == "-O0" {
            200_000
        } else {
            900_000
        };
        let rust = committed_answers(seed, calls);
        let c = answers(
            &mut Command::new(folder.path().join("harness")),
            seed,
            calls,
        );
        assert_eq!(difference(&c, &rust), None, "seed {seed}");
        for answer in rust {
            seen[answer[1] as usize] += 1;
        }
    }
    // The comparison is worth something where the controller has done everything that it can.
    for status in [0, 1, 2, 3, 5, 6, 7, 8, 9] {
        assert!(seen[status] > 100, "status {status}: {seen:?}");
    }
}

#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn c_and_rust_answer_alike_on_a_bench_that_uses_everything() {
    let folder = tempfile::tempdir().expect("a folder");
    let emitted = with_everything();
    written(&emitted, folder.path());
    compile(folder.path(), "-O2").expect("no warning");
    let (seed, calls) = (5, 300_000);
    let rust = answers(&mut rust_harness(&emitted, folder.path()), seed, calls);
    assert_eq!(rust.len(), calls, "the harness in Rust has ended");
    let c = answers(
        &mut Command::new(folder.path().join("harness")),
        seed,
        calls,
    );
    assert_eq!(difference(&c, &rust), None, "seed {seed}");
}

/// Every wheel sensor's counts, one after another: the speed that a firmware hands to the monitor and to its frames.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn every_count_of_the_wheel_has_one_speed() {
    let folder = tempfile::tempdir().expect("a folder");
    written(&committed(), folder.path());
    compile(folder.path(), "-O1").expect("no warning");
    let asked = |wheel_adc: u16| Call {
        what: 7,
        gyro: [0; 3],
        accel: [0; 3],
        wheel_adc,
        words: [0; 3],
    };
    let c = answers_to(
        &mut Command::new(folder.path().join("harness")),
        (0..=u16::MAX).map(asked),
    );
    assert_eq!(c.len(), 1 << 16);
    for (count, answer) in (0..=u16::MAX).zip(c) {
        assert_eq!(answer[0], wheel_speed(count).to_bits(), "count {count}");
    }
}

/// The other sensors of the wheel, a voltage drive, and an encoder on the pivot.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn c_and_rust_answer_alike_on_other_benches() {
    let others = benches::all().into_iter().skip(1);
    for (seed, spec) in (20..).zip(others.chain(benches::with_body_encoders().into_iter().skip(1)))
    {
        let folder = tempfile::tempdir().expect("a folder");
        let emitted = generate(&spec).expect("an emitted crate");
        written(&emitted, folder.path());
        compile(folder.path(), "-O2").expect("no warning");
        let calls = 150_000;
        let rust = answers(&mut rust_harness(&emitted, folder.path()), seed, calls);
        assert_eq!(rust.len(), calls, "the harness in Rust has ended");
        let mut harness = Command::new(folder.path().join("harness"));
        let c = answers(&mut harness, seed, calls);
        assert_eq!(difference(&c, &rust), None, "seed {seed}");
        let running = rust.iter().filter(|answer| answer[1] == 2).count();
        assert!(running > 1000, "seed {seed}: it ran in {running} steps");
    }
}

#[test]
#[cfg_attr(not(have_cross_gcc), ignore = "needs the cross compilers")]
fn every_core_compiles_it_without_a_warning_and_without_memcpy() {
    let others = [
        benches::with_driver(),
        benches::with_wheel_encoder(8),
        benches::with_body_encoder(thesis::spec()),
    ];
    let others = others.map(|spec| generate(&spec).expect("an emitted crate"));
    for emitted in [committed()].into_iter().chain(others) {
        every_core_compiles(&emitted);
    }
}

fn every_core_compiles(emitted: &EmittedCrate) {
    let folder = tempfile::tempdir().expect("a folder");
    written(emitted, folder.path());
    for (compiler, options) in [
        ("avr-gcc", &["-mmcu=atmega328p"][..]),
        ("arm-none-eabi-gcc", &["-mcpu=cortex-m0", "-mthumb"]),
        ("arm-none-eabi-gcc", &["-mcpu=cortex-m4", "-mthumb"]),
        (
            "riscv64-unknown-elf-gcc",
            &["-march=rv32imc", "-mabi=ilp32"],
        ),
        ("xtensa-lx106-elf-gcc", &[]),
    ] {
        for (file, optimisation) in [
            ("flywheel.c", "-Os"),
            ("flywheel.c", "-O2"),
            ("flywheel_loop.c", "-Os"),
            ("flywheel_loop.c", "-O2"),
        ] {
            let result = Command::new(compiler)
                .current_dir(folder.path().join("src"))
                .args(options)
                .args(WARNINGS)
                .args([optimisation, "-ffreestanding", "-c", file, "-o", "it.o"])
                .output()
                .expect("the compiler runs");
            let said = String::from_utf8_lossy(&result.stderr);
            assert!(result.status.success(), "{compiler} {options:?}: {said}");
            let object = fs::read(folder.path().join("src/it.o")).expect("an object");
            let calls_memcpy = object.windows(6).any(|name| name == b"memcpy");
            assert!(!calls_memcpy, "{compiler} {options:?} calls memcpy");
        }
    }
}

#[test]
fn every_number_of_the_c_is_one_of_the_rust() {
    let others = benches::all()
        .into_iter()
        .chain(benches::with_body_encoders());
    let others = others.map(|spec| generate(&spec).expect("an emitted crate"));
    for emitted in [committed(), with_everything()].into_iter().chain(others) {
        let c = c99::emit(&emitted).expect("a translation");
        let file = |path| c.file(path).expect("a file");
        let (header, source) = (file("src/flywheel.h"), file("src/flywheel.c"));
        assert_eq!(Expected::of(&emitted).difference(header, source), None);
    }
}
