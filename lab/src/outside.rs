//! The files of a bench as they were when the lab read or wrote them: whether another program has changed one since.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The files of an open bench.
#[derive(Clone)]
pub struct KnownFiles {
    /// model.toml; the lab writes it.
    model: KnownText,
    /// bench.toml.
    bench: KnownText,
    /// The logs.
    logs: Vec<(PathBuf, Option<Stamp>)>,
}

/// A file with its text; `None` where it cannot be read.
#[derive(Clone)]
struct KnownText {
    path: PathBuf,
    text: Option<String>,
}

/// Length in bytes and time of the last change of a log: logs are too long to be read again and again.
type Stamp = (u64, Option<SystemTime>);

impl KnownFiles {
    /// The files as they are now.
    pub fn now(folder: &Path, model: &Path, logs: impl Iterator<Item = PathBuf>) -> KnownFiles {
        KnownFiles {
            model: KnownText::now(model),
            bench: KnownText::now(&folder.join("bench.toml")),
            logs: logs
                .map(|log| {
                    let stamp = stamp(&log);
                    (log, stamp)
                })
                .collect(),
        }
    }

    /// The lab has written the model.
    pub fn model_written(&mut self) {
        self.model = KnownText::now(&self.model.path);
    }

    /// The names of the files that differ from what the lab knows; the model counts where `with_model`.
    pub fn changed(&self, with_model: bool) -> Vec<String> {
        let texts = [(&self.bench, true), (&self.model, with_model)];
        let texts = texts
            .into_iter()
            .filter(|(known, counts)| *counts && KnownText::now(&known.path).text != known.text)
            .map(|(known, _)| known.path.as_path());
        let logs = self.logs.iter();
        let logs = logs
            .filter(|(path, known)| stamp(path) != *known)
            .map(|(path, _)| path.as_path());
        texts.chain(logs).map(name_of).collect()
    }
}

impl KnownText {
    fn now(path: &Path) -> KnownText {
        KnownText {
            path: path.to_path_buf(),
            text: fs::read_to_string(path).ok(),
        }
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let about = fs::metadata(path).ok()?;
    Some((about.len(), about.modified().ok()))
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each file is noticed by its name; a file that is written again as it was is not.
    #[test]
    fn every_kind_of_file_is_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let [bench, model, log] =
            ["bench.toml", "model.toml", "log.csv"].map(|name| folder.path().join(name));
        for file in [&bench, &log] {
            fs::write(file, "one").expect("written");
        }
        let mut known = KnownFiles::now(folder.path(), &model, [log.clone()].into_iter());
        fs::write(&bench, "one").expect("written");
        assert_eq!(known.changed(true), Vec::<String>::new());
        fs::write(&bench, "two").expect("written");
        fs::write(&model, "two").expect("written");
        fs::write(&log, "two, longer").expect("written");
        assert_eq!(known.changed(true), ["bench.toml", "model.toml", "log.csv"]);
        assert_eq!(known.changed(false), ["bench.toml", "log.csv"]);
        known.model_written();
        assert_eq!(known.changed(true), ["bench.toml", "log.csv"]);
        fs::remove_file(&log).expect("removed");
        fs::write(&bench, "one").expect("written");
        assert_eq!(known.changed(true), ["log.csv"]);
    }
}
