//! `[hardware]` on the command line: what is refused, what is assumed, what is warned of.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use checker::prove::{ProofVerdict, verdict};

use crate::emitted::quick_proof;

/// The model of the thesis with `more` put at its end.
fn model_with(more: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/thesis-4.4.toml");
    format!("{}\n{more}", fs::read_to_string(path).expect("the model"))
}

/// The model of the thesis without what it states of its hardware, and with other sections.
fn model_without_hardware(more: &str) -> String {
    let whole = model_with("");
    let (before, rest) = whole
        .split_once("# The sensors and the drive")
        .expect("the hardware of the model");
    let (_, after) = rest
        .split_once("# The thesis prints its gains")
        .expect("the design of the model");
    format!("{before}# The thesis prints its gains{after}\n{more}")
}

fn flywheel(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs `generate` on a model; standard output, standard error, exit code.
fn generate(folder: &Path, model: &str, more: &[&str]) -> (String, String, Option<i32>) {
    let file = folder.join("bench.toml");
    fs::write(&file, model).expect("written");
    let out = folder.join("emitted");
    let (file, out) = (file.display().to_string(), out.display().to_string());
    let arguments = [&["generate", &file, "--out", &out], more].concat();
    let output = flywheel(&arguments);
    (
        text(&output.stdout),
        text(&output.stderr),
        output.status.code(),
    )
}

const PRESET: [&str; 2] = ["--preset", "thesis-bench"];

#[test]
fn nothing_is_assumed_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = model_without_hardware("");
    let (_, error, code) = generate(folder.path(), &model, &[]);
    assert_eq!(code, Some(2), "{error}");
    for part in [
        "[hardware.gyroscope]",
        "[hardware.accelerometer]",
        "[hardware.wheel_speed]",
        "[hardware.drive]",
        "--preset thesis-bench",
    ] {
        assert!(error.contains(part), "{error}");
    }
    assert!(!folder.path().join("emitted").exists());
    let (said, error, code) = generate(folder.path(), &model, &PRESET);
    assert_eq!(code, Some(0), "{error}");
    assert!(
        said.contains("Assumed") && said.contains("ESCON 24/2"),
        "{said}"
    );
    let emitted = folder.path().join("emitted");
    for file in ["src/lib.rs", "certificate.json"] {
        let text = fs::read_to_string(emitted.join(file)).expect("emitted");
        assert!(text.contains("FXOS8700, ±8 g"), "{file}");
    }
    let verdict = verdict(&quick_proof(&emitted, None));
    assert!(!matches!(verdict, ProofVerdict::Fails(_)), "{verdict:?}");
    // Whoever simulates gets the assumption, too.
    let file = folder.path().join("bench.toml").display().to_string();
    let out = folder.path().join("figures").display().to_string();
    let simulated = flywheel(&["simulate", &file, "--out", &out]);
    let said = text(&simulated.stdout);
    assert!(
        said.contains("Assumed") && said.contains("ESCON 24/2"),
        "{said}"
    );
}

/// A line of the drive that belongs to a timer of 12 bits is not squeezed into one of 16.
#[test]
fn another_timer_than_that_of_the_preset_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = "[calibration.current]\nslope = 820.0\nslope_std = 0.3\noffset = 2050.0\noffset_std = 0.4\n";
    let model = model_without_hardware(line);
    let (_, error, code) = generate(folder.path(), &model, &PRESET);
    assert_eq!(code, Some(2), "{error}");
    assert!(
        error.contains("the timer is another one") && error.contains("duty_low"),
        "{error}"
    );
}

#[test]
fn a_one_way_converter_is_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = "[calibration.wheel_speed]\nslope = 0.2\nslope_std = 1e-4\noffset = 0.5\noffset_std = 0.1\n";
    let (said, error, code) = generate(folder.path(), &model_without_hardware(line), &PRESET);
    assert_eq!(code, Some(0), "{error}");
    assert!(said.contains("cannot show a negative speed"), "{said}");
}

/// A slip in a section's name is not taken for another tool's section.
#[test]
fn unknown_sections_are_refused_with_the_nearest_name() {
    let folder = tempfile::tempdir().expect("a folder");
    for (section, wanted) in [("[hardwre]", "hardware"), ("[desing]", "design")] {
        let model = model_with(&format!("{section}\nx = 1\n"));
        let (_, error, code) = generate(folder.path(), &model, &[]);
        assert_eq!(code, Some(2), "{error}");
        assert!(
            error.contains(&format!("did you mean \"{wanted}\"")),
            "{error}"
        );
    }
    let model = model_with("[tool.flasher]\nport = \"/dev/ttyUSB0\"\n");
    assert_eq!(generate(folder.path(), &model, &[]).2, Some(0));
}

/// Calibrated before anything was measured, and twice: the file that is left is a model.
#[test]
fn calibration_comes_first_or_last() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = "[known]\ngravity = 9.81\n[hardware.gyroscope]\npart = \"MPU-6050\"\n[calibration]\n\
         gyroscope = \"still.csv\"\ngyroscope_scale = 1.0642e-3\nsample_time = 0.001\n";
    fs::write(folder.path().join("bench.toml"), bench).expect("written");
    let rows: String = (0..4000)
        .map(|k| format!("{},{},{}\n", 5 + k % 3, -3 + k % 2, k % 4))
        .collect();
    fs::write(folder.path().join("still.csv"), format!("gx,gy,gz\n{rows}")).expect("written");
    let path = folder.path().display().to_string();
    for _ in 0..2 {
        let output = flywheel(&["calibrate", &path]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    let model = fs::read_to_string(folder.path().join("model.toml")).expect("a model");
    assert!(
        model.contains("[hardware.gyroscope]\npart = \"MPU-6050\""),
        "{model}"
    );
    let output = flywheel(&["identify", &path]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("experiment"), "{error}");
    let with_logs = format!(
        "{bench}[[experiment]]\nname = \"spin\"\nkind = \"spin-up\"\nfile = \"spin.csv\"\n\
         [[experiment]]\nname = \"swing\"\nkind = \"free-swing\"\nfile = \"swing.csv\"\n"
    );
    fs::write(folder.path().join("bench.toml"), with_logs).expect("written");
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("demo/bench");
    for (from, to) in [
        ("spin-up-0.4A.csv", "spin.csv"),
        ("free-swing-20deg.csv", "swing.csv"),
    ] {
        fs::copy(demo.join(from), folder.path().join(to)).expect("copied");
    }
    let output = flywheel(&["identify", &path]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}
