//! Files that a user has dropped on the page, before they become a bench.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use bench_files::{Bench, BenchOutline, FilesInMemory};
use data_check::Corrections;
use identify::FitProblem;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::preview;

/// The name that a bench has until its folder is named.
const UNNAMED: &str = "my-bench";
/// Most files at a time.
const MOST_FILES: usize = 50;
/// Number of lines of a file that are shown.
const SHOWN_LINES: usize = 6;
/// Largest number of characters of a line that are shown.
const SHOWN_CHARACTERS: usize = 300;

/// The files, in a folder that only this user can enter; it is deleted with the lab.
#[derive(Default)]
pub struct Dropped {
    room: Option<TempDir>,
    names: Vec<String>,
}

impl Dropped {
    /// Stores a file.
    ///
    /// # Errors
    /// A sentence: the name is not a plain file name, there are too many files, or the disk is full.
    pub fn keep(&mut self, name: &str, text: &[u8]) -> Result<(), String> {
        let path = Path::new(name);
        let mut parts = path.components();
        let plain = matches!(
            (parts.next(), parts.next()),
            (Some(Component::Normal(_)), None)
        );
        let odd = |c: char| c.is_control() || "/\\:".contains(c);
        if !plain || name.starts_with('.') || name.len() > 120 || name.contains(odd) {
            return Err(format!(
                "\"{}\" is not a plain file name",
                name.escape_debug()
            ));
        }
        let is_table = ["csv", "txt", "tsv", "dat", "log"];
        let end = path
            .extension()
            .map(|end| end.to_string_lossy().to_lowercase());
        if !end.is_some_and(|end| is_table.contains(&end.as_str())) {
            return Err(format!(
                "{name}: is not a table; logs end in .{}",
                is_table.join(", .")
            ));
        }
        let is_new = !self.names.iter().any(|own| own == name);
        if is_new && self.names.len() == MOST_FILES {
            return Err(format!("more than {MOST_FILES} files at a time"));
        }
        let failed = |error: io::Error| format!("{name}: cannot be stored: {error}");
        let folder = match self.folder() {
            Some(folder) => folder,
            None => {
                let made = TempDir::with_prefix("flywheel-lab-").map_err(failed)?;
                let folder = self.room.insert(made).path().join(UNNAMED);
                fs::create_dir(&folder).map_err(failed)?;
                folder
            }
        };
        fs::write(folder.join(name), text).map_err(failed)?;
        if is_new {
            self.names.push(name.to_owned());
        }
        Ok(())
    }

    /// Forgets one of them.
    pub fn leave_out(&mut self, name: &str) {
        if let Some(index) = self.names.iter().position(|own| own == name) {
            self.names.remove(index);
            let path = self.folder().map(|folder| folder.join(name));
            // One that stays there is no longer named, and goes with the folder.
            let _ = path.map(fs::remove_file);
        }
        if self.names.is_empty() {
            self.clear();
        }
    }

    /// Deletes all of them.
    pub fn clear(&mut self) {
        *self = Dropped::default();
    }

    /// The folder of the files. A bench is called after its folder, so it has the name of one.
    fn folder(&self) -> Option<PathBuf> {
        let room = self.room.as_ref();
        room.map(|room| room.path().join(UNNAMED))
    }

    fn paths(&self) -> Vec<PathBuf> {
        let folder = self.folder().unwrap_or_default();
        self.names.iter().map(|name| folder.join(name)).collect()
    }

    /// The files with their first lines, and the bench.toml that is proposed for them with what was corrected. `open` is
    /// the name of the bench to which they can be added.
    pub fn facts(&self, corrections: &Corrections, open: Option<&str>) -> Value {
        let Some(folder) = self.folder() else {
            return json!({"files": []});
        };
        let files = self
            .paths()
            .into_iter()
            .zip(&self.names)
            .map(|(path, name)| {
                let text = fs::read(&path).unwrap_or_default();
                let shown =
                    String::from_utf8_lossy(&text[..text.len().min(64 * 1024)]).into_owned();
                let lines = shown.lines().take(SHOWN_LINES);
                let lines =
                    lines.map(|line| line.chars().take(SHOWN_CHARACTERS).collect::<String>());
                json!({"name": name, "bytes": text.len(), "lines": lines.collect::<Vec<_>>()})
            });
        let files: Vec<Value> = files.collect();
        match data_check::propose_with(&folder, &self.paths(), corrections) {
            Ok((proposal, refused)) => {
                let previews = proposal.experiments.iter();
                let previews: Vec<Value> = previews
                    .map(|one| preview::of(&folder.join(&one.file), &one.choices))
                    .collect();
                json!({
                    "files": files,
                    // A new folder is named from here on.
                    "bench": open,
                    "here": std::env::current_dir().unwrap_or_default().display().to_string(),
                    "refused": refused,
                    "previews": previews,
                    "open_ends": self.open_ends(&proposal.text),
                    "proposal": proposal,
                })
            }
            // The folder is of no interest to who reads the message.
            Err(error) => {
                let place = format!("{}/", folder.display());
                json!({"files": files, "failure": error.to_string().replace(&place, "")})
            }
        }
    }

    /// Sentences about the quantities that no fit can find with this bench.toml.
    fn open_ends(&self, text: &str) -> Vec<String> {
        let bench = Bench::from_files(&self.in_memory(text)).ok();
        let problem = bench.and_then(|bench| FitProblem::new(&bench).ok());
        problem.map_or_else(Vec::new, |problem| identify::left_open(&problem))
    }

    /// The faults of a bench.toml for these files: findings, or the reason why it cannot be read.
    pub fn check(&self, text: &str) -> Value {
        match Bench::from_files(&self.in_memory(text)) {
            Ok(bench) => json!({"findings": data_check::check(&bench)}),
            Err(error) => json!({"failure": error.to_string()}),
        }
    }

    fn in_memory(&self, text: &str) -> FilesInMemory {
        let mut files = FilesInMemory::default();
        for (path, name) in self.paths().iter().zip(&self.names) {
            files.insert(name, fs::read(path).unwrap_or_default());
        }
        files.insert("bench.toml", text);
        files
    }

    /// Creates a bench folder from the files. The folder must not be a bench, and no file is overwritten. A bench whose
    /// name the user has left as it was proposed is called after its folder.
    ///
    /// # Errors
    /// A sentence: the fault of the text or of the folder.
    pub fn write(&self, folder: &Path, text: &str) -> Result<(), String> {
        Bench::from_files(&self.in_memory(text)).map_err(|error| error.to_string())?;
        let names = self.names.iter().map(String::as_str).chain(["bench.toml"]);
        are_free(folder, names, "name another folder")?;
        bench_files::can_write_into(folder)
            .map_err(|error| format!("{error}; name a folder that you may write"))?;
        let failed =
            |path: &Path, error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
        self.copy_into(folder)?;
        let to = folder.join("bench.toml");
        let text = called_after(folder, text);
        bench_files::write_atomically(&to, text.as_bytes()).map_err(|error| failed(&to, &error))
    }

    /// Adds the files to a bench that exists: the logs beside its own, and the experiments of `text` behind those of its
    /// bench.toml. Everything else in `text` is left out, because the bench states it already.
    ///
    /// # Errors
    /// A sentence: a file of that name exists, or the bench cannot be read with these experiments. Then nothing is
    /// written.
    pub fn add_to(&self, folder: &Path, text: &str) -> Result<(), String> {
        are_free(
            folder,
            self.names.iter().map(String::as_str),
            "give the new log another name",
        )?;
        let outline = BenchOutline::read(folder).map_err(|error| error.to_string())?;
        // The explanation of all keys above the first experiment stands in the bench already, or was taken out of it.
        let from = text.find("\n[[experiment]]").unwrap_or(0);
        let whole = outline.with_experiments_of(&text[from..])?;
        let bench = Bench::load(folder).map_err(|error| error.to_string())?;
        let mut files = self.in_memory(&whole);
        for experiment in &bench.experiments {
            let path = folder.join(&experiment.file);
            // bench.toml names its logs from its folder on.
            let name = path.strip_prefix(folder).unwrap_or(&path);
            let text = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            files.insert(name, text);
        }
        Bench::from_files(&files).map_err(|error| error.to_string())?;
        self.copy_into(folder)?;
        bench_files::write_atomically(&outline.file, whole.as_bytes())
            .map_err(|error| error.to_string())
    }

    fn copy_into(&self, folder: &Path) -> Result<(), String> {
        for (from, name) in self.paths().iter().zip(&self.names) {
            let to = folder.join(name);
            fs::copy(from, &to).map_err(|error| format!("{}: {error}", to.display()))?;
        }
        Ok(())
    }
}

/// Checks that a folder has no file of these names.
fn are_free<'n>(
    folder: &Path,
    names: impl Iterator<Item = &'n str>,
    advice: &str,
) -> Result<(), String> {
    for name in names {
        let path = folder.join(name);
        if fs::symlink_metadata(&path).is_ok() {
            return Err(format!("{}: exists already; {advice}", path.display()));
        }
    }
    Ok(())
}

/// The text of bench.toml with the name of its folder, where it still has the proposed one.
fn called_after(folder: &Path, text: &str) -> String {
    let is_plain = |c: char| !c.is_control() && c != '"' && c != '\\';
    let name = folder.file_name().map(|name| name.to_string_lossy());
    match name {
        Some(name) if name.chars().all(is_plain) => text.replacen(
            &format!("name = \"{UNNAMED}\""),
            &format!("name = \"{name}\""),
            1,
        ),
        _ => text.to_owned(),
    }
}
