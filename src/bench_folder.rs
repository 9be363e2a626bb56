//! A bench on disk as the commands use it: its measurements, its model.toml, its folder for output.

use std::path::{Path, PathBuf};

use bench_files::{Bench, DesignSection, ModelFile, Problem};
use identify::Setup;

use crate::cli::BenchFiles;
use crate::failure::Failure;

/// A loaded bench with the places of its other files.
pub struct BenchFolder {
    /// The measurements.
    pub bench: Bench,
    /// The same, prepared for fits.
    pub setup: Setup,
    /// The model of the bench, whether or not there is one yet.
    pub model_path: PathBuf,
    /// Where figures and reports go; made when the first is written.
    pub out: PathBuf,
}

impl BenchFolder {
    /// Loads the bench; `path` is its folder or its bench.toml.
    pub fn load(path: &Path, files: &BenchFiles) -> Result<BenchFolder, Failure> {
        let bench = Bench::load(path)?;
        let setup = Setup::new(&bench).map_err(|error| Failure::in_file(&bench.folder, error))?;
        Ok(BenchFolder {
            model_path: files
                .model
                .clone()
                .unwrap_or_else(|| bench.folder.join("model.toml")),
            out: files
                .out
                .clone()
                .unwrap_or_else(|| bench.folder.join("out")),
            bench,
            setup,
        })
    }

    /// The bench's model.toml, if there is one.
    pub fn existing_model(&self) -> Result<Option<ModelFile>, Failure> {
        match ModelFile::read(&self.model_path) {
            Ok(model) => Ok(Some(model)),
            Err(error) if matches!(error.problem(), Problem::NotFound) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// The bench's model.toml, or one with the base model and nothing else.
    pub fn model_or_base(&self) -> Result<ModelFile, Failure> {
        Ok(self.existing_model()?.unwrap_or_default())
    }

    /// The bench's model.toml, which must be there.
    pub fn required_model(&self) -> Result<ModelFile, Failure> {
        self.existing_model()?.ok_or_else(|| {
            Failure::in_file(
                &self.model_path,
                format!(
                    "there is no model yet; make one with: flywheel identify {}",
                    self.bench.folder.display()
                ),
            )
        })
    }

    /// Writes model.toml.
    pub fn write_model(&self, model: &ModelFile) -> Result<(), Failure> {
        if let Some(folder) = self.model_path.parent() {
            // What goes wrong here is said by the write, which then fails too.
            let _ = std::fs::create_dir_all(folder);
        }
        model.write(&self.model_path).map_err(|error| {
            Failure::new(format!(
                "{error}; --model FILE names another place, for example where the bench is \
                 read-only"
            ))
        })
    }

    /// What a design is asked for unless model.toml says otherwise: the weights and the sample time
    /// of the thesis (1 ms, whatever rate the measured logs had), with the current limit of the
    /// bench's own controller where it has one.
    pub fn usual_design(&self) -> DesignSection {
        let controller = self.bench.controller;
        DesignSection {
            sample_time_s: 0.001,
            state_weights: [25.0, 0.5, 5e-4],
            current_weight: 1.0,
            current_limit_a: controller.map_or(2.0, |own| own.current_limit_a),
            friction_linearisation_speed_rad_s: None,
            bias_time_constant_s: None,
        }
    }
}

/// A file name made from a name that a user gave: letters and digits, the rest as hyphens; the sign
/// of a number as a word, so that 0.6 and −0.6 stay apart.
pub fn file_name(name: &str) -> String {
    let lower = name.to_lowercase();
    let mut text = String::new();
    let mut before = ' ';
    let mut characters = lower.chars().peekable();
    while let Some(c) = characters.next() {
        let is_sign = matches!(c, '-' | '−')
            && !before.is_alphanumeric()
            && characters.peek().is_some_and(char::is_ascii_digit);
        if is_sign {
            text.push_str("minus-");
        } else if c.is_alphanumeric() || c == '.' {
            text.push(c);
        } else if !text.ends_with('-') {
            text.push('-');
        }
        before = c;
    }
    let short: String = text.chars().take(80).collect();
    match short.trim_matches(['-', '.']) {
        "" => "unnamed".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_harmless() {
        for (name, expected) in [
            ("free swing 20 deg", "free-swing-20-deg"),
            ("spin-up 0.6 A", "spin-up-0.6-a"),
            ("spin-up -0.6 A", "spin-up-minus-0.6-a"),
            ("../../etc/passwd", "etc-passwd"),
            ("  ", "unnamed"),
            ("Schwung α/β", "schwung-α-β"),
        ] {
            assert_eq!(file_name(name), expected);
        }
    }
}
