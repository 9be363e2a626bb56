//! What commands print: text for people, JSON for programs.

pub mod json;
pub mod numbers;
pub mod table;

use serde::Serialize;

use crate::failure::Failure;

/// The result of a command.
pub struct Report {
    /// The text for standard output, ending in a line break.
    pub text: String,
    /// The same for programs.
    json: serde_json::Value,
    /// False where a proof or a check failed (exit code 1).
    pub passed: bool,
}

impl Report {
    /// A report of a command that did what it should.
    pub fn new(text: String, json: &impl Serialize) -> Result<Report, Failure> {
        Ok(Report {
            text,
            json: serde_json::to_value(json).map_err(|error| {
                Failure::new(format!("cannot write the result as JSON: {error}"))
            })?,
            passed: true,
        })
    }

    /// The result for programs.
    pub fn value(&self) -> &serde_json::Value {
        &self.json
    }

    /// The same report with exit code 1.
    pub fn failed(self) -> Report {
        Report {
            passed: false,
            ..self
        }
    }

    /// The JSON as text, ending in a line break.
    pub fn json_text(&self) -> Result<String, Failure> {
        serde_json::to_string_pretty(&self.json)
            .map(|text| text + "\n")
            .map_err(|error| Failure::new(format!("cannot write the result as JSON: {error}")))
    }
}
