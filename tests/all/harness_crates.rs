//! The harness crate of every kind of bench: it compiles as Kani gets it, and its properties hold on random words.

use std::fs;
use std::path::Path;
use std::process::Command;

use checker::claims::texts_audited;
use checker::prove::kani::write_crates;
use checker::prove::{ClaimOutcome, Emitted};

/// A stand-in of Kani's macros: each keeps its item. `stub` says in addition that the two functions have one signature,
/// as Kani demands it.
const MACROS: &str = r#"
use proc_macro::TokenStream;
macro_rules! kept { ($($name:ident)*) => { $(
    #[proc_macro_attribute]
    pub fn $name(_: TokenStream, item: TokenStream) -> TokenStream { item }
)* } }
kept! { proof solver requires ensures }
fn with(checked: String, item: TokenStream) -> TokenStream {
    let mut tokens: TokenStream = format!("const _: fn() = || {{ let _ = [{checked}]; }};").parse().unwrap();
    tokens.extend(item);
    tokens
}
#[proc_macro_attribute]
pub fn stub(two: TokenStream, item: TokenStream) -> TokenStream { with(two.to_string(), item) }
#[proc_macro_attribute]
pub fn stub_verified(one: TokenStream, item: TokenStream) -> TokenStream { with(one.to_string(), item) }
#[proc_macro_attribute]
pub fn proof_for_contract(one: TokenStream, item: TokenStream) -> TokenStream { with(one.to_string(), item) }
"#;

/// A stand-in of Kani's library; nothing of it is run.
const LIBRARY: &str = r#"
pub use kani_macros::*;
pub fn any<T>() -> T { unreachable!() }
pub fn assume(_: bool) {}
#[macro_export]
macro_rules! cover { ($condition:expr, $what:literal) => { let _: (bool, &str) = ($condition, $what); }; }
"#;

/// A bench: its sensors and its drive, and what a test of its own calls.
struct Bench {
    name: &'static str,
    hardware: &'static str,
    /// The fields of a sample, from the word `w`.
    sample: &'static str,
    /// Calls of properties that only such a bench has.
    more: &'static str,
}

const INERTIAL: &str = "gyro: [w as i16, (w >> 16) as i16, (w >> 32) as i16], accel: [(w >> 48) as i16, w as i16, 4096], mag: None";

const ENCODERS: &str = "for numbers in &properties::encoder::ENCODERS {
        properties::encoder::the_turn_is_exact(numbers, w as u16, core::array::from_fn(|i| (w >> (3 * i)) as i16));
        properties::encoder::counts_are_in_range(numbers, core::array::from_fn(|i| (w >> (2 * i)) as u16));
    }";

const BENCHES: [Bench; 4] = [
    Bench {
        name: "driver",
        hardware: "gyroscope.part = \"MPU-6050\"\ngyroscope.axes = [\"x\", \"y\", \"z\"]\naccelerometer.part = \"MPU-6050\"
accelerometer.axes = [\"x\", \"y\", \"z\"]\nangle.kind = \"inertial\"\nwheel_speed = { kind = \"driver\", scale = 0.05 }
drive = { part = \"ESCON 24/2\", kind = \"current\", amperes_per_count = 8.4e-5 }",
        sample: "wheel_speed: (w >> 8) as i16",
        more: "",
    },
    Bench {
        name: "wheel-encoder-and-voltage",
        hardware: "gyroscope.part = \"MPU-6050\"\ngyroscope.axes = [\"x\", \"y\", \"z\"]\naccelerometer.part = \"MPU-6050\"
accelerometer.axes = [\"x\", \"y\", \"z\"]\nangle.kind = \"inertial\"
wheel_speed = { kind = \"encoder\", part = \"AS5600\", window = 4 }
drive = { kind = \"voltage\", bits = 12, supply_voltage = 24.0, winding_resistance = 1.2 }",
        sample: "wheel_count: (w >> 8) as u16",
        more: ENCODERS,
    },
    Bench {
        name: "pivot-encoder-and-current",
        hardware: "angle = { kind = \"encoder\", part = \"AS5600\", zero = 2048 }
wheel_speed = { kind = \"converter\", slope = 0.9, offset = -691.0, low = 0, high = 1546 }
drive = { part = \"ESCON 24/2\", kind = \"current\", amperes_per_count = 8.4e-5 }",
        sample: "body_count: w as u16, wheel_adc: (w >> 8) as u16",
        more: ENCODERS,
    },
    Bench {
        name: "pivot-encoder-and-voltage",
        hardware: "angle = { kind = \"encoder\", counts_per_turn = 16384, bits = 14, zero = 7 }
wheel_speed = { kind = \"encoder\", part = \"AS5600\", window = 4 }
drive = { kind = \"voltage\", bits = 12, supply_voltage = 24.0, winding_resistance = 1.2 }",
        sample: "body_count: w as u16, wheel_count: (w >> 8) as u16",
        more: ENCODERS,
    },
];

impl Bench {
    fn is_inertial(&self) -> bool {
        !self.sample.contains("body_count")
    }

    /// Writes the model of the thesis with this bench's hardware, and generates its crate.
    fn generate(&self, folder: &Path) -> Emitted {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/thesis-4.4.toml");
        let whole = fs::read_to_string(path).unwrap();
        let (before, rest) = whole.split_once("[hardware.gyroscope]").unwrap();
        let (_, design) = rest.split_once("[design]").unwrap();
        let text = format!("{before}[hardware]\n{}\n\n[design]{design}", self.hardware);
        let model = folder.join(format!("{}.toml", self.name));
        fs::write(&model, text).unwrap();
        let out = folder.join(self.name);
        let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
            .arg("generate")
            .arg(&model)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{}: {said}", self.name);
        Emitted::read(&out).unwrap()
    }

    /// A test of the harness crate that calls the properties on random words; its generator is Knuth's of 64 bits.
    fn test(&self) -> String {
        let body = if self.is_inertial() { INERTIAL } else { "" };
        let comma = if body.is_empty() { "" } else { ", " };
        let sample = format!("generated::Sample {{ {body}{comma}{} }}", self.sample);
        format!(
            "use verify::properties;
fn of(w: u64) -> generated::Sample {{ {sample} }}
#[test]
fn properties_hold() {{
    let mut w = 1u64;
    let mut next = || {{ w = w.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); w ^ (w >> 29) }};
    let mut controller = generated::Controller::new();
    for step in 0..20_000u64 {{
        let w = next();
        {}
        properties::control::total(w as i32, (w >> 16) as i32, (w >> 32) as i32);
        properties::supervisor::counts_are_bounded((w % 50) as _, w & 64 == 0, 1 + (w >> 40) as i32);
        properties::step::duty_within_limits(&mut controller, &of(if step % 5 < 3 {{ w & 0xff }} else {{ w }}), w & 128 == 0);
        if step % 999 == 0 {{ properties::supervisor::a_fault_lasts(&mut controller, &[of(w), of(next())]); }}
    }}
}}
",
            self.more
        )
    }
}

/// Runs a command in a folder; what it says is the message of a failure.
fn run(root: &Path, command: &mut Command) {
    let output = command.current_dir(root).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let more = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{command:?}: {said}{more}");
}

/// What `prove` gives to Kani compiles, as a library and under Kani's flag with a stand-in of Kani: every name and
/// type of every harness is right for the crate that it was emitted with. Its texts are audited, and its properties hold
/// on random words.
fn holds(emitted: &Emitted, test: &str, target: &Path) {
    let ClaimOutcome::Proved(_) = texts_audited::by_digest(emitted) else {
        panic!("{:?}", texts_audited::by_digest(emitted));
    };
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    write_crates(root, emitted, "1.31").unwrap();
    fs::create_dir(root.join("verify/tests")).unwrap();
    fs::write(root.join("verify/tests/run.rs"), test).unwrap();
    run(
        root,
        Command::new("cargo")
            .args([
                "test",
                "--offline",
                "--quiet",
                "--manifest-path",
                "verify/Cargo.toml",
            ])
            .env("CARGO_TARGET_DIR", target),
    );

    // Kani sets its flag for its own crates too; others, of which some know it, are left as Cargo has compiled them.
    let checked = target.join("debug/deps");
    let entries = fs::read_dir(&checked).unwrap();
    let fixed = entries
        .map(|entry| entry.unwrap().path())
        .find(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            name.starts_with("libfixed-") && name.ends_with(".rmeta")
        })
        .unwrap();
    let rustc = |name: &str, source: &str, arguments: &[&str]| {
        let mut command = Command::new("rustc");
        command
            .args([
                "--edition",
                "2024",
                "--crate-name",
                name,
                source,
                "--out-dir",
                ".",
            ])
            .args(["--check-cfg", "cfg(kani)", "-L", "."])
            .arg("-L")
            .arg(format!("dependency={}", checked.display()))
            .args(arguments);
        run(root, &mut command);
    };
    fs::write(root.join("kani_macros.rs"), MACROS).unwrap();
    fs::write(root.join("kani.rs"), LIBRARY).unwrap();
    rustc(
        "kani_macros",
        "kani_macros.rs",
        &["--crate-type", "proc-macro", "--extern", "proc_macro"],
    );
    let library = ["--crate-type", "lib", "--emit", "metadata"];
    rustc(
        "kani",
        "kani.rs",
        &[&library[..], &["--extern", "kani_macros"]].concat(),
    );
    let with_kani = [&library[..], &["--extern", "kani", "--cfg", "kani"]].concat();
    let extern_fixed = format!("fixed={}", fixed.display());
    let own = [&with_kani[..], &["--extern", &extern_fixed]].concat();
    rustc("generated", "src/lib.rs", &own);
    let harness = [&with_kani[..], &["--extern", "generated"]].concat();
    rustc("verify", "verify/src/lib.rs", &harness);
}

#[test]
fn the_harnesses_of_every_kind_of_bench_compile_and_hold() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("target");
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated");
    holds(&Emitted::read(&committed).unwrap(), "", &target);
    for bench in BENCHES {
        println!("{}", bench.name);
        let emitted = bench.generate(folder.path());
        assert_eq!(emitted.strays, [""; 0]);
        assert!(emitted.harness_cargo.is_some() && emitted.harnesses.len() > 8);
        holds(&emitted, &bench.test(), &target);
    }
}
