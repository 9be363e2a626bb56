//! Writing and comparing.

use crate::thesis;

use std::fs;
use std::path::Path;

use codegen::{EmittedCrate, FileError, generate};

fn emitted() -> EmittedCrate {
    generate(&thesis::spec()).unwrap()
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn writes_what_changed_and_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("new/folder");
    let emitted = emitted();
    assert!(
        matches!(emitted.check(&out), Err(FileError::Differs { paths }) if paths.len() == emitted.files.len())
    );
    assert_eq!(emitted.write(&out).unwrap().len(), emitted.files.len());
    emitted.check(&out).unwrap();
    assert_eq!(
        emitted.write(&out).unwrap(),
        Vec::<std::path::PathBuf>::new()
    );
    assert_eq!(
        names(&out),
        [
            "Cargo.toml",
            "README.md",
            "certificate.json",
            "src",
            "verify"
        ]
    );
    let mut sources: Vec<_> = emitted
        .files
        .iter()
        .filter_map(|file| file.path.strip_prefix("src/"))
        .collect();
    sources.sort_unstable();
    assert_eq!(names(&out.join("src")), sources);

    // A change by hand is found, and undone by writing.
    let path = out.join("src/control.rs");
    let damaged = fs::read_to_string(&path)
        .unwrap()
        .replace("SHIFT - 1", "SHIFT - 2");
    fs::write(&path, &damaged).unwrap();
    let error = emitted.check(&out).unwrap_err();
    assert!(error.to_string().contains("control.rs"), "{error}");
    assert_eq!(
        fs::read_to_string(&path).unwrap(),
        damaged,
        "check wrote something"
    );
    assert_eq!(emitted.write(&out).unwrap(), [path]);
    emitted.check(&out).unwrap();
}

#[test]
fn a_file_of_somebody_else_is_left_alone_with_everything_beside_it() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(
        directory.path().join("Cargo.toml"),
        "[package]\nname = \"mine\"\n",
    )
    .unwrap();
    let error = emitted().write(directory.path()).unwrap_err();
    assert!(matches!(error, FileError::Foreign { .. }));
    assert!(error.to_string().contains("Cargo.toml"), "{error}");
    assert_eq!(names(directory.path()), ["Cargo.toml"]);
}

/// The crate of a bench with other sensors has other files. What it leaves behind would be a file of no module.
#[test]
fn files_of_another_emission_are_found_and_removed() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path();
    let emitted = emitted();
    emitted.write(out).unwrap();
    let lib = fs::read_to_string(out.join("src/lib.rs")).unwrap();
    let stale = out.join("src/encoder_of_another_bench.rs");
    fs::write(&stale, lib).unwrap();
    let notes = out.join("src/notes.txt");
    fs::write(&notes, "of the user").unwrap();
    let error = emitted.check(out).unwrap_err();
    assert!(
        error.to_string().contains("encoder_of_another_bench.rs"),
        "{error}"
    );
    assert_eq!(emitted.write(out).unwrap(), std::slice::from_ref(&stale));
    assert!(!stale.exists() && notes.exists());
    emitted.check(out).unwrap();
}

#[test]
fn an_error_leaves_no_file_behind() {
    let directory = tempfile::tempdir().unwrap();
    // A file where the folder `src` has to be.
    fs::write(directory.path().join("src"), "").unwrap();
    let error = emitted().write(directory.path()).unwrap_err();
    assert!(matches!(error, FileError::Io { .. }));
    assert_eq!(names(directory.path()), ["src"]);
}
