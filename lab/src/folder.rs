//! Checks of folders: which folder is a bench, and whether all its files lie inside it.

use std::fs;
use std::path::{Path, PathBuf};

use workbench::Bench;

/// The bench's folder and where its bench.toml is, both without symlinks.
///
/// # Errors
/// A sentence: there is no bench, or one of its files lies outside its folder.
pub fn of_bench(path: &Path) -> Result<PathBuf, String> {
    let named = if path.is_dir() {
        path.join("bench.toml")
    } else {
        path.to_path_buf()
    };
    let parent = named.parent().unwrap_or(Path::new("."));
    let parent = if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    };
    let folder = parent
        .canonicalize()
        .map_err(|error| format!("{}: {error}", path.display()))?;
    if !named.is_file() {
        return Err(format!(
            "{}: there is no bench.toml; a bench is a folder with a bench.toml and its logs",
            path.display()
        ));
    }
    within(&folder, &named)?;
    // The model is written as well, so the target of its name must be in the folder, too.
    within(&folder, &folder.join("model.toml"))?;
    Ok(folder)
}

/// Checks that the logs of a bench and the effects of its user lie in its folder.
///
/// # Errors
/// A sentence that names the file.
pub fn holds_its_files(folder: &Path, bench: &Bench) -> Result<(), String> {
    let logs = bench.experiments.iter();
    let logs = logs.map(|experiment| bench.folder.join(&experiment.file));
    let effects = fs::read_dir(folder.join("effects"));
    let effects = effects.into_iter().flatten().flatten();
    logs.chain(effects.map(|entry| entry.path()))
        .try_for_each(|file| within(folder, &file))
}

/// Checks that a file, which may not exist yet, lies in a folder; symlinks are followed.
///
/// # Errors
/// A sentence that names the file.
pub fn within(folder: &Path, file: &Path) -> Result<(), String> {
    let outside = || {
        format!(
            "{}: lies outside {}; the lab reads and writes only inside the bench folder: copy the file into it",
            file.display(),
            folder.display()
        )
    };
    let folder = folder.canonicalize().map_err(|_| outside())?;
    // The nearest existing part of the path decides: the lab creates what is below it.
    let mut there = file.to_path_buf();
    while fs::symlink_metadata(&there).is_err() {
        if !there.pop() {
            return Err(outside());
        }
    }
    let rest = file.strip_prefix(&there).unwrap_or(Path::new(""));
    let climbs = rest
        .components()
        .any(|part| !matches!(part, std::path::Component::Normal(_)));
    // A symlink to a missing target cannot be followed, and is refused.
    let there = there.canonicalize().map_err(|_| outside())?;
    if there.starts_with(&folder) && !climbs {
        Ok(())
    } else {
        Err(outside())
    }
}

/// Writes `effects/NAME.toml` into a bench folder, if the text could stand there.
///
/// # Errors
/// A sentence, with line and column where it is the text.
pub fn write_effect(folder: &Path, name: &str, text: &str) -> Result<(), String> {
    workbench::check_own_effect(name, text).map_err(|error| {
        let place = error.line.map_or(String::new(), |line| {
            let position = error.position.map_or(String::new(), |at| format!(":{at}"));
            format!(":{line}{position}")
        });
        format!("effects/{name}.toml{place}: {}", error.message)
    })?;
    let file = folder.join("effects").join(format!("{name}.toml"));
    within(folder, &file)?;
    let failed = |error: std::io::Error| format!("{}: {error}", file.display());
    fs::create_dir_all(folder.join("effects")).map_err(failed)?;
    bench_files::write_atomically(&file, text.as_bytes()).map_err(|error| error.to_string())
}

/// Largest number of benches that are offered.
const MOST_OFFERED: usize = 50;

/// The benches in the working directory, in its folders, and in theirs.
pub fn nearby() -> Vec<PathBuf> {
    let Ok(here) = std::env::current_dir() else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut level = vec![here];
    for _ in 0..3 {
        let mut next = Vec::new();
        for folder in level {
            if folder.join("bench.toml").is_file() {
                found.push(folder.clone());
            }
            let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
            next.extend(
                entries
                    .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
                    .filter(|entry| !entry.file_name().to_string_lossy().starts_with('.'))
                    .filter(|entry| entry.file_name() != "target")
                    .map(|entry| entry.path()),
            );
        }
        next.sort();
        next.truncate(1000);
        level = next;
    }
    found.truncate(MOST_OFFERED);
    found
}

/// Folder of the demonstration bench, below the working directory.
const DEMONSTRATION: &str = "out/lab-demo";

/// The folder of the demonstration bench; missing files are written.
///
/// # Errors
/// A sentence that names the file.
pub fn demonstration() -> Result<PathBuf, String> {
    let folder = PathBuf::from(DEMONSTRATION);
    let missing = || {
        demo::FILES
            .iter()
            .any(|(name, _)| !folder.join(name).exists())
    };
    if missing() {
        bench_files::can_write_into(&folder)
            .map_err(|error| format!("{error}; start the lab in a folder that you may write"))?;
    }
    let failed = |path: &Path, error: &std::io::Error| format!("{}: {error}", path.display());
    fs::create_dir_all(&folder).map_err(|error| failed(&folder, &error))?;
    for (name, text) in demo::FILES {
        let file = folder.join(name);
        if !file.exists() {
            bench_files::write_atomically(&file, text.as_bytes())
                .map_err(|error| error.to_string())?;
        }
    }
    Ok(folder)
}
