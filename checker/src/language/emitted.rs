//! An emitted crate as text: all of its files.

use std::fs;
use std::path::Path;

use crate::language::emitted_error::EmittedError;
use crate::language::harness;
use crate::language::manifest;
use crate::language::module::{Module, sources};
use crate::program::place::SourceError;

/// An emitted crate as text: all of its files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Emitted {
    /// `src/*.rs`, by path.
    pub sources: Vec<(String, String)>,
    /// `Cargo.toml`.
    pub cargo: String,
    /// `certificate.json`.
    pub certificate: String,
    /// The sources of the harness crate, `verify/src/**.rs`, by path; none where the folder has no `verify`.
    pub harnesses: Vec<(String, String)>,
    /// `verify/Cargo.toml`, where there is one.
    pub harness_cargo: Option<String>,
    /// Other files in the folder that would be compiled or run with the crate, or with its harness crate.
    pub strays: Vec<String>,
}

impl Emitted {
    /// Reads an emitted crate; no other part of the project has to exist.
    ///
    /// # Errors
    /// [`EmittedError`] with the file.
    pub fn read(directory: &Path) -> Result<Emitted, EmittedError> {
        let text = |name: &'static str| {
            let path = directory.join(name);
            fs::read_to_string(&path).map_err(|source| {
                if source.kind() == std::io::ErrorKind::NotFound && directory.is_dir() {
                    let folder = directory.to_owned();
                    let missing = name;
                    return EmittedError::NoCrate { folder, missing };
                }
                EmittedError::Io { path, source }
            })
        };
        // Before the folders: a folder without these is no emitted crate, whatever else it has.
        let (certificate, cargo) = (text("certificate.json")?, text("Cargo.toml")?);
        let harness = harness::read(directory)?;
        let mut strays = strays(directory)?;
        strays.extend(harness.strays);
        Ok(Emitted {
            certificate,
            cargo,
            sources: sources(directory).map_err(EmittedError::Read)?,
            harnesses: harness.sources,
            harness_cargo: harness.cargo,
            strays,
        })
    }

    /// The sources, read and resolved.
    ///
    /// # Errors
    /// [`SourceError`].
    pub fn module(&self) -> Result<Module, SourceError> {
        let borrowed: Vec<_> = self
            .sources
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str()))
            .collect();
        Module::parse(&borrowed)
    }

    /// Name of the crate; `None` if its manifest is not one that an emitted crate may have.
    pub fn name(&self) -> Option<String> {
        manifest::read(&self.cargo)
            .ok()
            .map(|manifest| manifest.name)
    }

    /// Names of all files that something is claimed of.
    pub fn files(&self) -> Vec<String> {
        let sources = self.sources.iter().map(|(path, _)| path.clone());
        sources.chain(["Cargo.toml".to_owned()]).collect()
    }
}

/// Files beside the sources that would influence Cargo or rustup, and files in `src` that are not Rust.
fn strays(directory: &Path) -> Result<Vec<String>, EmittedError> {
    let picked_up = [
        "build.rs",
        ".cargo",
        "rust-toolchain",
        "rust-toolchain.toml",
        // Cargo finds targets in these by itself.
        "benches",
        "examples",
        "tests",
    ];
    let mut strays: Vec<String> = picked_up
        .into_iter()
        .filter(|name| directory.join(name).exists())
        .map(str::to_owned)
        .collect();
    let path = directory.join("src");
    let io = |source| EmittedError::Io {
        path: path.clone(),
        source,
    };
    for entry in fs::read_dir(&path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let is_source = entry.path().extension().is_some_and(|e| e == "rs")
            && entry.file_type().map_err(io)?.is_file();
        if !is_source {
            strays.push(format!("src/{}", entry.file_name().to_string_lossy()));
        }
    }
    strays.sort();
    Ok(strays)
}
