//! `flywheel prove`: rows, verdicts and exit codes.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{done, flywheel, models, refused, stderr, stdout};
use crate::emitted::quick_proof;

/// A copy of the committed crate, with its harness crate.
fn copy(folder: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated");
    let to = folder.join("controller");
    copy_folder(&from, &to);
    to
}

/// Copies a folder but for what Cargo writes into it.
fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, name) = (entry.path(), entry.file_name());
        if name == "target" || name == "Cargo.lock" {
            continue;
        }
        if path.is_dir() {
            copy_folder(&path, &to.join(name));
        } else {
            fs::copy(&path, to.join(name)).unwrap();
        }
    }
}

/// Exit code and rows.
fn proof(folder: &Path, more: &[&str]) -> (Option<i32>, Vec<Value>) {
    let mut arguments = vec!["prove", folder.to_str().unwrap()];
    arguments.extend(["--cases", "300", "--without-kani", "--json", "-"]);
    arguments.extend(more);
    let output = flywheel(arguments);
    let json: Value = serde_json::from_str(&stdout(&output))
        .unwrap_or_else(|error| panic!("{error}: {}", stderr(&output)));
    (
        output.status.code(),
        json["claims"].as_array().unwrap().clone(),
    )
}

fn results<'a>(rows: &'a [Value], id: &str) -> Vec<&'a str> {
    let own = rows.iter().filter(|row| row["id"] == id);
    own.map(|row| row["result"].as_str().unwrap()).collect()
}

/// A crate with a name of the user's, as `generate --check` and `prove` take it: the whole proof, by every engine that
/// is here.
#[test]
fn every_claim_has_a_row_with_its_five_results() {
    let folder = tempfile::tempdir().unwrap();
    let crate_ = folder.path().join("controller");
    let model = models().join("thesis-4.4.toml");
    let [place, model_path] = [&crate_, &model].map(|path| path.to_str().unwrap());
    let generate = ["generate", model_path, "--out", place];
    done([&generate[..], &["--name", "my-pendulum"]].concat());
    let manifest = fs::read_to_string(crate_.join("Cargo.toml")).unwrap();
    assert!(manifest.contains("name = \"my-pendulum\""), "{manifest}");
    let (code, rows) = proof(&crate_, &["--model", model_path]);
    assert_eq!(code, Some(0), "{rows:#?}");
    let known = ["proved", "tested", "not run", "not applicable", "failed"];
    for row in &rows {
        assert!(known.contains(&row["result"].as_str().unwrap()), "{row}");
        assert!(
            row["why"].is_string() && row["seconds"].is_number(),
            "{row}"
        );
        assert_eq!(row["cases"].is_number(), row["result"] == "tested", "{row}");
        assert!(!row["statement"].as_str().unwrap().is_empty(), "{row}");
    }
    for claim in checker::certificate::claims::CLAIMS {
        assert!(
            !results(&rows, claim.id).is_empty(),
            "{} has no row",
            claim.id
        );
    }
    assert_eq!(results(&rows, "model-matches"), ["proved", "proved"]);
    assert_eq!(results(&rows, "texts-audited"), ["proved"]);
    assert_eq!(results(&rows, "bias-observer-stable"), ["not applicable"]);

    // Of another bench.
    let other = models().join("thesis-3.5.3.toml");
    let rows = quick_proof(&crate_, Some(&other));
    let matching = rows.iter().find(|row| row.id == "model-matches").unwrap();
    assert_eq!(matching.outcome.word(), "failed");

    // A source that is not understood has every row all the same.
    let path = crate_.join("src/control.rs");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("let limit", "let r#limit")).unwrap();
    let (code, rows) = proof(&crate_, &[]);
    assert_eq!(code, Some(1));
    assert_eq!(results(&rows, "source-understood"), ["failed"]);
    for claim in checker::certificate::claims::CLAIMS {
        assert!(
            !results(&rows, claim.id).is_empty(),
            "{} has no row",
            claim.id
        );
    }
}

#[test]
fn what_no_engine_settles_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let crate_ = copy(folder.path());
    let path = crate_.join("certificate.json");
    let mut certificate: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    certificate["closed_loop"] = Value::Null;
    fs::write(&path, certificate.to_string()).unwrap();
    let (code, rows) = proof(&crate_, &[]);
    assert_eq!(code, Some(3));
    let of_loop = results(&rows, "closed-loop-for-all-time");
    assert!(
        of_loop.iter().all(|result| *result == "not run"),
        "{of_loop:?}"
    );
}

/// Files that Cargo or rustup would obey.
#[test]
fn what_cargo_obeys_is_refused() {
    for name in [
        "rust-toolchain.toml",
        "rust-toolchain",
        "build.rs",
        ".cargo",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let crate_ = copy(folder.path());
        fs::write(crate_.join(name), "").unwrap();
        let (code, rows) = proof(&crate_, &[]);
        assert_eq!(code, Some(1), "{name}");
        assert_eq!(results(&rows, "source-understood"), ["failed"], "{name}");
        // What is not understood is not run.
        assert_eq!(results(&rows, "compiled-agrees"), ["not run"], "{name}");
    }
    refused(["prove", "no-such-folder"], &["no-such-folder"]);
}

/// The name belongs to what `generate --check` compares.
#[test]
fn a_crate_with_another_name_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let crate_ = folder.path().join("controller");
    let model = models().join("thesis-4.4.toml");
    let [place, model] = [&crate_, &model].map(|path| path.to_str().unwrap());
    let generate = ["generate", model, "--out", place];
    let named = [&generate[..], &["--name", "my-pendulum"]].concat();
    done(&named);
    done([&named[..], &["--check"]].concat());
    let other_name = flywheel([&generate[..], &["--check"]].concat());
    assert_eq!(other_name.status.code(), Some(1));
    // The README is one of the files that are compared.
    let readme = crate_.join("README.md");
    let text = fs::read_to_string(&readme).unwrap();
    fs::write(&readme, text.replace("my_pendulum", "mine")).unwrap();
    let changed = flywheel([&named[..], &["--check"]].concat());
    assert_eq!(changed.status.code(), Some(1));
    assert!(
        stdout(&changed).contains("README.md"),
        "{}",
        stdout(&changed)
    );

    let bad = [&generate[..], &["--name", "My Pendulum"]].concat();
    refused(
        bad,
        &[
            "`My Pendulum` is no name for the emitted crate",
            "my-pendulum",
        ],
    );
}
