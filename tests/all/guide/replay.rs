//! The worked examples of the guide are followed to the letter, in a copy of the sources.
//!
//! A block after `<!-- replayed: FILE -->` is a new file. A block after `<!-- replayed: FILE, after: LINE -->` is
//! inserted into a file after the one line that reads LINE.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{root, text};

/// The page with the worked examples.
const PAGE: &str = "docs/guide/carrying-on.md";

/// Folders of the root that no example needs.
const LEFT_OUT: [&str; 3] = [".git", "target", "embedded"];

/// One block of an example.
struct Step {
    file: String,
    /// The line after which the block stands; `None` for a new file.
    after: Option<String>,
    block: String,
}

/// The blocks of the page under the heading with this text.
fn steps(heading: &str) -> Vec<Step> {
    let page = text(&root().join(PAGE));
    let (_, section) = page
        .split_once(&format!("\n## {heading}\n"))
        .unwrap_or_else(|| panic!("{PAGE} has no heading {heading}"));
    let section = section.split("\n## ").next().unwrap_or(section);
    let found: Vec<Step> = section
        .split("<!-- replayed: ")
        .skip(1)
        .map(|part| {
            let (place, rest) = part.split_once(" -->\n```rust\n").expect("a block of Rust");
            let (file, after) = match place.split_once(", after: ") {
                Some((file, line)) => (file, Some(line.to_owned())),
                None => (place, None),
            };
            Step {
                file: file.to_owned(),
                after,
                block: rest.split("```").next().expect("a block").to_owned(),
            }
        })
        .collect();
    assert!(!found.is_empty(), "{heading}: no block is replayed");
    found
}

/// The file after the step.
fn applied(step: &Step, old: Option<String>) -> String {
    let Step { file, after, block } = step;
    let Some(line) = after else {
        assert!(old.is_none(), "{file} is there already");
        return block.clone();
    };
    let old = old.unwrap_or_else(|| panic!("there is no {file}"));
    let places: Vec<usize> = old
        .lines()
        .enumerate()
        .filter(|(_, found)| found.trim() == line)
        .map(|(at, _)| at)
        .collect();
    let [place] = places[..] else {
        panic!("{file} has {} lines \"{line}\"", places.len());
    };
    let mut new = String::new();
    for (at, found) in old.lines().enumerate() {
        new.push_str(found);
        new.push('\n');
        if at == place {
            new.push_str(block);
        }
    }
    new
}

/// Brings `to` to the state of `from`. Files that are the same keep their time, so that cargo builds only what has
/// changed since the last run.
fn mirror(from: &Path, to: &Path, keep: &dyn Fn(&Path) -> bool) {
    fs::create_dir_all(to).expect("a folder");
    let names = |folder: &Path| -> Vec<std::ffi::OsString> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        entries.map(|entry| entry.file_name()).collect()
    };
    for name in names(from) {
        let (source, target) = (from.join(&name), to.join(&name));
        if !keep(&source) {
            continue;
        }
        if source.is_dir() {
            mirror(&source, &target, keep);
        } else {
            write(&target, &fs::read(&source).expect("a file"));
        }
    }
    for name in names(to) {
        let target = to.join(&name);
        let is_gone = !from.join(&name).exists() || !keep(&from.join(&name));
        match (is_gone, target.is_dir()) {
            (true, true) => fs::remove_dir_all(target).expect("an old folder"),
            (true, false) => fs::remove_file(target).expect("an old file"),
            _ => {}
        }
    }
}

/// Writes a file where its content changes.
fn write(file: &Path, content: &[u8]) {
    if fs::read(file).ok().as_deref() != Some(content) {
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        fs::write(file, content).expect("a file");
    }
}

/// A copy of the folders and files of the root that `keep` lets through, with the steps applied. It lies in the
/// target folder, always at the same place.
fn copy_with(name: &str, steps: &[Step], keep: &dyn Fn(&Path) -> bool) -> PathBuf {
    let copy = root().join("target/guide-replay").join(name);
    let is_changed = |file: &Path| steps.iter().any(|step| root().join(&step.file) == *file);
    mirror(root(), &copy, &|file| keep(file) || is_changed(file));
    let mut files: Vec<(&str, String)> = vec![];
    for step in steps {
        let at = files.iter().position(|(file, _)| *file == step.file);
        let old = match at {
            Some(at) => Some(files.swap_remove(at).1),
            None => fs::read_to_string(root().join(&step.file)).ok(),
        };
        files.push((&step.file, applied(step, old)));
    }
    for (file, content) in files {
        write(&copy.join(file), content.as_bytes());
    }
    copy
}

/// Settings that leave the crates of this workspace unoptimised, and others as they have been built already. The examples
/// run in no time; what takes time is their compilation.
fn unoptimised() -> Vec<String> {
    let workspace = text(&root().join("Cargo.toml"));
    let (_, members) = workspace.split_once("members = [").expect("members");
    let (members, _) = members.split_once(']').expect("the end of the members");
    let names = members.split('"').skip(1).step_by(2);
    names
        .map(|name| if name == "." { "flywheel" } else { name })
        .map(|name| format!("--config=profile.dev.package.{name}.opt-level=0"))
        .collect()
}

/// What cargo says in this folder; `names` are filters of its tests.
fn cargo(folder: &Path, target: &Path, arguments: &[&str], names: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .args(unoptimised())
        .arg("--")
        .args(names)
        .current_dir(folder)
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_PROFILE_DEV_DEBUG", "false")
        .env_remove("CARGO_MANIFEST_DIR")
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "cargo {arguments:?}\n{said}\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    said
}

/// The number of tests that passed, by what cargo says.
fn passed(said: &str) -> usize {
    said.split("test result: ok. ")
        .skip(1)
        .filter_map(|rest| rest.split(' ').next()?.parse::<usize>().ok())
        .sum()
}

#[test]
fn every_worked_example_works_as_shown() {
    let mut all = vec![];
    for heading in [
        "An effect, from beginning to end",
        "A sensor",
        "An experiment",
        "A claim",
        "A command",
    ] {
        all.extend(steps(heading));
    }
    let copy = copy_with("sources", &all, &|file| {
        let inside = file.strip_prefix(root()).expect("in the root");
        let first = inside.components().next().expect("a name");
        !LEFT_OUT.iter().any(|name| first.as_os_str() == *name) && !inside.ends_with("target")
    });
    // The whole workspace has the features with which the crates that others publish are compiled already; tests of
    // libraries and programs leave no program there.
    let target = root().join("target");
    let run = |names: &[&str]| {
        let tests = ["test", "--locked", "--workspace", "--lib", "--bins"];
        passed(&cargo(&copy, &target, &tests, names))
    };
    assert_eq!(run(&["worked_example"]), 4);
    // The new effect is in the list with a description that says all there is to say.
    assert!(run(&["effects::tests::", "every_effect_describes"]) >= 3);
    let drivers = [
        "test",
        "--locked",
        "-p",
        "sensor-drivers",
        "--test",
        "mt6701",
    ];
    let said = cargo(
        &copy.join("firmware"),
        &root().join("target/guide-replay/target"),
        &drivers,
        &[],
    );
    assert_eq!(passed(&said), 1, "{said}");
}
