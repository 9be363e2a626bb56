//! The worked example of a new effect is followed to the letter, in a copy of the crate that holds the effects.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::{root, text};

/// What the page puts into a file: the block after `<!-- replayed: FILE -->`.
fn block(page: &str, file: &str) -> String {
    let (_, after) = page
        .split_once(&format!("<!-- replayed: {file} -->\n```rust\n"))
        .unwrap_or_else(|| panic!("the page has no block for {file}"));
    after.split("```").next().expect("a block").to_owned()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

#[test]
fn a_new_effect_is_one_file_and_one_line() {
    let page = text(&root().join("docs/guide/carrying-on.md"));
    let folder = tempfile::tempdir().expect("a folder");
    let plant = folder.path().join("plant");
    copy(&root().join("plant"), &plant);
    fs::copy(root().join("Cargo.lock"), folder.path().join("Cargo.lock")).expect("a copy");
    // A workspace of the crate alone, with the versions of this one.
    let workspace: String = text(&root().join("Cargo.toml"))
        .split_once("[workspace.package]")
        .map(|(_, rest)| format!("[workspace.package]{rest}"))
        .expect("a workspace");
    let workspace = workspace
        .split("\n[package]\n")
        .next()
        .expect("the workspace's part");
    fs::write(
        folder.path().join("Cargo.toml"),
        format!("[workspace]\nmembers = [\"plant\"]\nresolver = \"1\"\n\n{workspace}"),
    )
    .expect("a manifest");

    let file = "plant/src/effects/body_rubber_bush.rs";
    fs::write(folder.path().join(file), block(&page, file)).expect("the effect");
    let list = folder.path().join("plant/src/effects/mod.rs");
    let line = block(&page, "plant/src/effects/mod.rs");
    let old = text(&list);
    let first = "effects! {\n";
    assert!(old.contains(first), "the list has another shape");
    fs::write(&list, old.replacen(first, &format!("{first}{line}"), 1)).expect("the list");

    let output = Command::new(env!("CARGO"))
        .args(["test", "--offline", "--lib", "-p", "plant"])
        .current_dir(folder.path())
        .env("CARGO_TARGET_DIR", root().join("target/guide-replay"))
        .env_remove("CARGO_MANIFEST_DIR")
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}
