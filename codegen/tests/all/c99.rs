//! The emitted C does what the emitted Rust does, bit for bit, and compiles without a warning.

use std::fs;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use codegen::hardware::{BiasObserverSpec, BodySensor};
use codegen::{EmittedCrate, EmittedFile, c99, generate};
use generated::wheel_speed;
use nalgebra::{Matrix3, Vector3};

use calls::{Call, Calls};
use harnesses::{WARNINGS, compile, rust_harness, written};
use numbers::Expected;

#[path = "c99/calls.rs"]
mod calls;
#[path = "c99/damage.rs"]
mod damage;
#[path = "c99/harnesses.rs"]
pub mod harnesses;
#[path = "c99/monitor.rs"]
mod monitor;
#[path = "c99/mutants.rs"]
mod mutants;
#[path = "c99/numbers.rs"]
mod numbers;
use crate::{benches, thesis};

/// The committed crate, as files.
fn committed() -> EmittedCrate {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    let mut paths = vec!["Cargo.toml".to_string(), "certificate.json".to_string()];
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
    // Other ends for each axis.
    attitude.gyro_clip = [32_000, 31_000, 32_767];
    attitude.accel_clip = [31_000, 32_764, 31_500];
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

/// What the harness answers to a call: what the function returns, status, angle, rate, quaternion, and a digest of all words
/// of the state.
type Answer = [i32; 9];
const ANSWER_BYTES: usize = size_of::<Answer>();

/// What a program that speaks the harness's language answers; it ends where the program does.
fn answers(program: &mut Command, seed: u64, calls: usize) -> Vec<Answer> {
    let mut source = Calls::new(seed);
    answers_to(program, (0..calls).map(move |_| source.next()))
}

/// The same for these calls.
fn answers_to(
    program: &mut Command,
    calls: impl Iterator<Item = Call> + Send + 'static,
) -> Vec<Answer> {
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
    let mut bytes = [0; ANSWER_BYTES];
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
fn answer(bytes: &[u8; ANSWER_BYTES]) -> Answer {
    std::array::from_fn(|word| {
        let word = &bytes[4 * word..4 * word + 4];
        i32::from_le_bytes(word.try_into().expect("four bytes"))
    })
}

/// Where two programs first differ.
fn difference(c: &[Answer], rust: &[Answer]) -> Option<String> {
    let place = (0..rust.len()).find(|&index| c.get(index) != Some(&rust[index]))?;
    Some(format!(
        "call {place}: C {:?}, Rust {:?}",
        c.get(place),
        rust[place]
    ))
}

#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn c_and_rust_answer_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let emitted = committed();
    written(&emitted, folder.path());
    let mut seen = [0; 10];
    for (optimisation, seed) in [("-O0", 1), ("-O2", 2), ("-Os", 3)] {
        compile(folder.path(), optimisation).expect("no warning");
        let calls = if optimisation == "-O0" {
            200_000
        } else {
            900_000
        };
        let rust = answers(&mut rust_harness(&emitted, folder.path()), seed, calls);
        assert_eq!(rust.len(), calls, "the harness in Rust has ended");
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
