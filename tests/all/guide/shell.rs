//! The shell lines of the guide run.
//!
//! A block ```` ```sh ```` is run line by line, all blocks of a page in one folder, in their order. A block
//! ```` ```sh ignore ```` needs hardware or tools that a test does not have: its lines are only read by the program's
//! own parser of arguments.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use super::{blocks, root, text};

fn run_page(name: &str) {
    let page = root().join("docs/guide").join(name);
    let folder = tempfile::tempdir().expect("a folder");
    let programs = folder.path().join("programs");
    fs::create_dir(&programs).expect("a folder");
    symlink(env!("CARGO_BIN_EXE_flywheel"), programs.join("flywheel")).expect("a link");
    let work = folder.path().join("work");
    fs::create_dir(&work).expect("a folder");
    let path = format!(
        "{}:{}",
        programs.display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let mut lines = 0;
    for (info, body) in blocks(&text(&page)) {
        if info != "sh" {
            continue;
        }
        for line in body.lines().filter(|line| !line.trim().is_empty()) {
            lines += 1;
            let output = Command::new("sh")
                .args(["-e", "-c", line])
                .current_dir(&work)
                .env("PATH", &path)
                .env("CARGO_NET_OFFLINE", "true")
                .output()
                .expect("a shell");
            assert!(
                output.status.success(),
                "{name}: {line}\n{}{}",
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
    assert!(lines > 0, "{name} has no shell lines");
}

#[test]
fn firmware() {
    run_page("firmware.md");
}

#[test]
fn the_first_hour() {
    run_page("first-hour.md");
}

#[test]
fn own_effects() {
    run_page("own-effects.md");
}

#[test]
fn design() {
    run_page("design.md");
}

/// Every line of a page that calls the program names a command that there is, with options that it has.
#[test]
fn commands_that_are_shown_exist() {
    for page in super::pages() {
        if page.ends_with("CLAIMS.md") {
            continue;
        }
        let text = text(&page);
        let fenced = blocks(&text);
        let lines = fenced
            .iter()
            .filter(|(info, _)| info.starts_with("sh"))
            .flat_map(|(_, body)| body.lines())
            .filter_map(|line| line.trim().strip_prefix("flywheel "));
        for line in lines {
            shown(&page, line);
        }
    }
}

/// The options are looked up in the command's own help.
fn shown(page: &Path, line: &str) {
    let line = line.split(" #").next().unwrap_or(line);
    let mut words = line.split_whitespace();
    let command = words.next().unwrap_or_default();
    let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args([command, "--help"])
        .output()
        .expect("the program starts");
    assert!(
        output.status.success(),
        "{}: flywheel {line}: there is no command {command}",
        page.display()
    );
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    for option in words.filter(|word| word.starts_with("--")) {
        let option = option.split('=').next().unwrap_or(option);
        assert!(
            help.contains(option),
            "{}: flywheel {line}: {command} has no {option}",
            page.display()
        );
    }
}
