//! A controller as `flywheel generate` writes it, for the tests of what is emitted.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use checker::prove::{ClaimResult, ProofSettings};
use tempfile::TempDir;

/// The model of the thesis with `more` put at its end (its last section is `[design]`), as text.
pub fn model_with(more: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/thesis-4.4.toml");
    format!("{}\n{more}", fs::read_to_string(path).expect("the model"))
}

/// What `flywheel generate` writes for `model`, and the folder that holds it.
pub fn generated(model: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bench.toml");
    fs::write(&file, model).expect("written");
    let out = folder.path().join("emitted");
    let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .arg("generate")
        .arg(&file)
        .arg("--out")
        .arg(&out)
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    (folder, out)
}

/// The rows of a proof by the engines that take a second: nothing is compiled, and the bounds of the closed loop are not
/// computed. Whole proofs take a minute; `cli::prove` makes them.
pub fn quick_proof(folder: &Path, model: Option<&Path>) -> Vec<ClaimResult> {
    let settings = ProofSettings {
        cases: 100,
        compiled: false,
        kani: false,
        closed_loop: false,
        python: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    checker::prove::prove(folder, model, &settings, &|_| ()).expect("an emitted crate")
}
