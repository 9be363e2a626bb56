//! `[correlation]` of model.toml: the correlations between the errors of the parameters.
//!
//! A fit often determines the ratio of two parameters far better than each of them: the period of a
//! swing determines G/Θ. Standard errors alone do not express this. The correlation ρ does, through
//! cov(a, b) = ρ std(a) std(b).
//!
//! ```toml
//! [correlation]
//! parameters = ["total_inertia", "gravity_torque"]
//! matrix = [
//!     [1.0, 0.98],
//!     [0.98, 1.0],
//! ]
//! ```
//!
//! A parameter that is not listed is not correlated with any other.

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};
use toml_edit::{Array, TableLike, Value};

use crate::error::{Error, Names, Problem};
use crate::toml_section::Section;
use crate::toml_source::Located;
use crate::toml_writing::{number, set, table_in};

/// Tolerance for the symmetry, the unit diagonal and the signs of the eigenvalues of a matrix. It covers
/// rounding errors of its computation, not a matrix written with few digits.
const ROUNDING: f64 = 1e-9;
const EXAMPLE: &str = "matrix = [[1.0, 0.98], [0.98, 1.0]]";

/// Correlations of the errors of parameters; dimensionless.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correlation {
    /// The parameters, each once and each with a standard error.
    pub parameters: Vec<String>,
    /// Row by row in that order: symmetric, ones on the diagonal, no negative eigenvalue.
    pub matrix: Vec<Vec<f64>>,
}

impl Correlation {
    /// The correlation of two parameters: 1 for a parameter with itself, 0 for a pair that is not listed.
    pub fn between(&self, a: &str, b: &str) -> f64 {
        if a == b {
            return 1.0;
        }
        let at = |name: &str| self.parameters.iter().position(|known| known == name);
        match (at(a), at(b)) {
            (Some(row), Some(column)) => self.matrix[row][column],
            _ => 0.0,
        }
    }

    /// The correlations of the parameters for which `keep` is true; `None` if none remains.
    pub(crate) fn among(&self, keep: impl Fn(&str) -> bool) -> Option<Correlation> {
        let kept: Vec<usize> = (0..self.parameters.len())
            .filter(|&index| keep(&self.parameters[index]))
            .collect();
        (!kept.is_empty()).then(|| Correlation {
            parameters: kept.iter().map(|&i| self.parameters[i].clone()).collect(),
            matrix: kept
                .iter()
                .map(|&row| {
                    kept.iter()
                        .map(|&column| self.matrix[row][column])
                        .collect()
                })
                .collect(),
        })
    }

    /// Reads the section. `with_std` lists the parameters that have a standard error.
    pub(crate) fn read(section: &Section, with_std: &[&str]) -> Result<Correlation, Error> {
        section.allow_only(&crate::keys::names(crate::keys::MODEL, "correlation"))?;
        let names = section.texts("parameters")?.unwrap_or_default();
        if names.is_empty() {
            let example = "parameters = [\"total_inertia\", \"gravity_torque\"]";
            return Err(section.error_at("parameters", section.missing("parameters", example)));
        }
        for (index, name) in names.iter().enumerate() {
            let problem = if !with_std.contains(&name.value.as_str()) {
                Problem::UnknownName {
                    what: "parameter with a std".to_string(),
                    name: name.value.clone(),
                    names: Names::new(with_std),
                }
            } else if names[..index].iter().any(|other| other.value == name.value) {
                Problem::CorrelatedTwice {
                    name: name.value.clone(),
                }
            } else {
                continue;
            };
            return Err(section.error_in_value(name.span.clone(), problem));
        }
        let matrix = section
            .square_matrix("matrix", names.len())?
            .ok_or_else(|| section.error(section.missing("matrix", EXAMPLE)))?;
        check(section, &names, &matrix)?;
        Ok(Correlation {
            parameters: names.into_iter().map(|name| name.value).collect(),
            matrix: matrix
                .into_iter()
                .map(|row| row.into_iter().map(|entry| entry.value).collect())
                .collect(),
        })
    }

    /// Writes the section.
    pub(crate) fn write(&self, root: &mut dyn TableLike) {
        let section = table_in(root, "correlation", false);
        let names: Array = self.parameters.iter().map(String::as_str).collect();
        set(section, "parameters", Value::Array(names));
        let mut matrix = Array::new();
        for row in &self.matrix {
            let row: Array = row.iter().map(|entry| number(*entry)).collect();
            let mut row = Value::Array(row);
            row.decor_mut().set_prefix("\n    ");
            matrix.push_formatted(row);
        }
        matrix.set_trailing_comma(true);
        matrix.set_trailing("\n");
        set(section, "matrix", Value::Array(matrix));
    }
}

/// Refuses a matrix that is not a correlation matrix. The error points to an entry if one entry is wrong.
fn check(
    section: &Section,
    names: &[Located<String>],
    matrix: &[Vec<Located<f64>>],
) -> Result<(), Error> {
    for (row, entries) in matrix.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            let mirrored = matrix[column][row].value;
            let must_be = if row == column && (entry.value - 1.0).abs() > ROUNDING {
                "1, as every correlation of a parameter with itself".to_string()
            } else if entry.value.abs() > 1.0 + ROUNDING {
                "between -1 and 1".to_string()
            } else if column < row && (entry.value - mirrored).abs() > ROUNDING {
                format!("{mirrored}, as the other way round: the matrix is symmetric")
            } else {
                continue;
            };
            let problem = Problem::OutOfRange {
                key: format!("{} with {}", names[row].value, names[column].value),
                value: entry.value,
                must_be,
            };
            return Err(section.error_in_value(entry.span.clone(), problem));
        }
    }
    let count = matrix.len();
    let symmetric = DMatrix::from_fn(count, count, |row, column| {
        matrix[row.max(column)][row.min(column)].value
    });
    let eigen = SymmetricEigen::new(symmetric);
    let least = eigen.eigenvalues.iter().copied().fold(0.0, f64::min);
    if least < -ROUNDING {
        let problem = Problem::OutOfRange {
            key: "smallest eigenvalue of matrix".to_string(),
            value: least,
            must_be: "zero or positive, no errors can hang together so; strong correlations need \
                      all their digits"
                .to_string(),
        };
        return Err(section.error_at("matrix", problem));
    }
    Ok(())
}
