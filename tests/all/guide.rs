//! The guide against the program: what it lists is what there is, its links lead somewhere, its shell lines run.
//!
//! `FLYWHEEL_WRITE_GUIDE=1 cargo test --test all guide` writes the generated parts anew.

#[path = "guide/generated.rs"]
mod generated;
#[path = "guide/links.rs"]
mod links;
#[path = "guide/replay.rs"]
mod replay;
#[path = "guide/shell.rs"]
mod shell;

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the project.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Markdown file that a reader may open: those of the root and all under docs/.
fn pages() -> Vec<PathBuf> {
    let mut found = vec![];
    let mut folders = vec![root().join("docs")];
    for name in ["README.md", "ARCHITECTURE.md", "CLAIMS.md"] {
        found.push(root().join(name));
    }
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The text of a page.
fn text(page: &Path) -> String {
    fs::read_to_string(page).unwrap_or_else(|error| panic!("{}: {error}", page.display()))
}

/// The fenced blocks of a page: what stands after the fence, and the lines.
fn blocks(text: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = vec![];
    let mut open = false;
    for line in text.lines() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(info) => {
                found.push((info.trim().to_owned(), String::new()));
                open = true;
            }
            None if open => {
                if let Some((_, body)) = found.last_mut() {
                    body.push_str(line);
                    body.push('\n');
                }
            }
            None => {}
        }
    }
    found
}
