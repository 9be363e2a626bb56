//! An emitted crate that has been read and understood, ready to be run and analysed.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::language::declarations::{Constants, Declarations, Named, Read};
use crate::language::lower::programs;
use crate::program::contract::Contract;
use crate::program::place::{SourceError, SourcePlace};
use crate::program::steps::Program;

/// An emitted crate.
#[derive(Clone, Debug)]
pub struct Module {
    declarations: Declarations,
    constants: Constants,
    programs: HashMap<usize, Program>,
    texts: Vec<(String, String)>,
}

/// The reason why a folder could not be read as an emitted crate.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A file is not in the language of emitted code.
    #[error("{0}")]
    Source(#[from] SourceError),
}

impl Module {
    /// Reads the sources of an emitted crate, given as (path, text), and resolves every function,
    /// constant and assertion in it.
    ///
    /// # Errors
    /// [`SourceError`] for Rust that does not parse, every construct outside the language, wrong
    /// types, and assertions about constants that do not hold.
    pub fn parse(sources: &[(&str, &str)]) -> Result<Module, SourceError> {
        let declarations = Declarations::read(sources)?;
        let mut constants = Constants::new();
        for number in 0..declarations.constants.len() {
            programs::constant(&declarations, &mut constants, number)?;
        }
        let none = HashMap::new();
        let mut programs = HashMap::new();
        for number in 0..declarations.functions.len() {
            let program = programs::function(&declarations, &mut constants, &none, number)?;
            programs.insert(number, program);
        }
        Ok(Module {
            declarations,
            constants,
            programs,
            texts: sources
                .iter()
                .map(|(path, text)| ((*path).to_owned(), (*text).to_owned()))
                .collect(),
        })
    }

    /// Reads `src/*.rs` of the crate in `directory`.
    ///
    /// # Errors
    /// [`ReadError`]: a file cannot be read or is not understood.
    pub fn read(directory: &Path) -> Result<Module, ReadError> {
        let sources = sources(directory)?;
        let borrowed: Vec<_> = sources
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str()))
            .collect();
        Ok(Module::parse(&borrowed)?)
    }

    /// Everything declared.
    pub fn declarations(&self) -> &Declarations {
        &self.declarations
    }

    /// Path and text of each file.
    pub fn texts(&self) -> &[(String, String)] {
        &self.texts
    }

    /// The text of one file.
    pub fn text(&self, path: &str) -> Option<&str> {
        let (_, text) = self.texts.iter().find(|(name, _)| name == path)?;
        Some(text)
    }

    /// The number of a function: `control`, `Controller::step`, or `root::refined` where a name
    /// occurs in several files.
    pub fn function_number(&self, name: &str) -> Option<usize> {
        let functions = &self.declarations.functions;
        let mut matching = functions.iter().enumerate().filter(|(_, function)| {
            let module = &self.declarations.files[function.module].module;
            function.name == name || format!("{module}::{}", function.name) == name
        });
        let (number, _) = matching.next()?;
        matching.next().is_none().then_some(number)
    }

    /// A resolved function; `None` if there is none of that name, or several.
    pub fn function(&self, name: &str) -> Option<&Program> {
        self.programs.get(&self.function_number(name)?)
    }

    /// A resolved function by its number.
    pub fn program(&self, number: usize) -> Option<&Program> {
        self.programs.get(&number)
    }

    /// The same function with the calls of others represented by contracts.
    ///
    /// # Errors
    /// [`SourceError`]; not expected, since [`Module::parse`] has found every error.
    pub fn function_with_contracts(
        &self,
        number: usize,
        contracts: &HashMap<usize, Contract>,
    ) -> Read<Program> {
        let mut constants = self.constants.clone();
        programs::function(&self.declarations, &mut constants, contracts, number)
    }

    /// Number of a constant by file (without `src/` and `.rs`) and name.
    fn constant_number(&self, file: &str, name: &str) -> Option<usize> {
        let module = self.declarations.module(file)?;
        match self.declarations.files[module].names.get(name)? {
            Named::Constant(number) => Some(*number),
            _ => None,
        }
    }

    /// The words of a constant, fields in the order of the struct.
    pub fn constant(&self, file: &str, name: &str) -> Option<&[i128]> {
        let number = self.constant_number(file, name)?;
        self.constants.get(&number).map(Vec::as_slice)
    }

    /// Words of a constant with their names, `FILTER.beta` for instance.
    pub fn constant_words(&self, file: &str, name: &str) -> Option<Vec<(String, i128)>> {
        let number = self.constant_number(file, name)?;
        let type_ = &self.declarations.constants[number].type_;
        let names = self.declarations.word_names(name, type_);
        let words = self.constants.get(&number)?;
        Some(names.into_iter().zip(words.iter().copied()).collect())
    }

    /// Where a constant stands.
    pub fn constant_place(&self, file: &str, name: &str) -> Option<&SourcePlace> {
        let number = self.constant_number(file, name)?;
        Some(&self.declarations.constants[number].place)
    }
}

/// `src/*.rs` in `directory`, sorted by path.
///
/// # Errors
/// [`ReadError::Io`].
pub fn sources(directory: &Path) -> Result<Vec<(String, String)>, ReadError> {
    let folder = directory.join("src");
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| ReadError::Io { path, source }
    };
    let mut sources = Vec::new();
    for entry in fs::read_dir(&folder).map_err(io(&folder))? {
        let path = entry.map_err(io(&folder))?.path();
        if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).map_err(io(&path))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            sources.push((format!("src/{name}"), text));
        }
    }
    sources.sort();
    Ok(sources)
}
