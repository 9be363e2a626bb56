//! Parameters and matrices for other programs: a module for Python (NumPy) and a script for MATLAB.

use serde::{Deserialize, Serialize};

use crate::control_design::ControlDesign;
use crate::output_file::{OutputFile, file_name};

/// The language of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExportLanguage {
    /// A module that needs NumPy.
    Python,
    /// A script, which GNU Octave reads too.
    Matlab,
}

impl ControlDesign {
    /// Parameters with standard errors and correlations, the linear model (continuous and sampled), weights and gains,
    /// as source text that gives the same numbers back, digit by digit.
    pub fn export(&self, language: ExportLanguage) -> OutputFile {
        let syntax = Syntax { language };
        let mut text = String::new();
        let mut comment = |line: &str| text.push_str(&format!("{} {line}\n", syntax.comment()));
        comment(&format!(
            "{}: parameters and matrices, SI units.",
            one_line(self.name())
        ));
        comment(
            "States: angle from upright in rad, rate in rad/s, wheel speed in rad/s. Input: motor current in A.",
        );
        comment(
            "Continuous dx/dt = A x + B u; sampled x+ = Ad x + Bd u; law u = -K x, within +-current_limit.",
        );
        if language == ExportLanguage::Python {
            text.push_str("import numpy as np\n");
        }
        let parameters = &self.file().parameters;
        text.push_str(&syntax.open_parameters());
        for parameter in parameters {
            let std = parameter.std.map_or_else(|| "nan".to_owned(), number);
            let name = parameter.name.as_str();
            text.push_str(&syntax.parameter(name, &number(parameter.value), &std, &parameter.unit));
        }
        text.push_str(&syntax.close_parameters());
        if let Some(correlation) = &self.file().correlation {
            // A derived parameter follows from the others: the file states no correlation of its error, and zero would be
            // wrong.
            let is_fitted = |name: &&str| correlation.parameters.iter().any(|own| own == name);
            let with_std: Vec<&str> = parameters
                .iter()
                .filter(|one| one.std.is_some())
                .map(|one| one.name.as_str())
                .filter(is_fitted)
                .collect();
            text.push_str(&syntax.names("correlation_of", &with_std));
            let rows: Vec<Vec<f64>> = with_std
                .iter()
                .map(|a| {
                    let of = |b: &&str| {
                        if a == b {
                            1.0
                        } else {
                            correlation.between(a, b)
                        }
                    };
                    with_std.iter().map(of).collect()
                })
                .collect();
            text.push_str(&syntax.matrix("correlation", &rows));
        }
        let wishes = self.wishes();
        text.push_str(&syntax.scalar("sample_time", wishes.sample_time_s));
        text.push_str(&syntax.scalar("current_limit", wishes.current_limit_a));
        let design = self.design();
        let square = |entry: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            let row = |row: usize| (0..3).map(|column| entry(row, column)).collect();
            (0..3).map(row).collect()
        };
        let column = |entry: &dyn Fn(usize) -> f64| -> Vec<Vec<f64>> {
            (0..3).map(|row| vec![entry(row)]).collect()
        };
        let weights = wishes.state_weights;
        let matrices: [(&str, Vec<Vec<f64>>); 7] = [
            (
                "A",
                square(&|row, column| design.model.state[(row, column)]),
            ),
            ("B", column(&|row| design.model.input[row])),
            (
                "Ad",
                square(&|row, column| design.discrete.state[(row, column)]),
            ),
            ("Bd", column(&|row| design.discrete.input[row])),
            (
                "Q",
                square(&|row, column| if row == column { weights[row] } else { 0.0 }),
            ),
            ("R", vec![vec![wishes.current_weight]]),
            ("K", vec![self.gains().to_vec()]),
        ];
        for (name, rows) in matrices {
            if name == "K" {
                for line in OF_THE_GAINS {
                    text.push_str(&format!("{} {line}\n", syntax.comment()));
                }
            }
            text.push_str(&syntax.matrix(name, &rows));
        }
        // Module names of both languages are letters, digits and underscores.
        let stem: String = file_name(self.name())
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
            .collect();
        OutputFile {
            name: format!("model_{stem}.{}", syntax.ending()),
            text,
        }
    }
}

/// What the gains minimise, for a reader who computes them again.
const OF_THE_GAINS: [&str; 2] = [
    "K minimises the integral of x'Qx + u'Ru over time, with u held for sample_time (MATLAB: lqrd).",
    "dlqr(Ad, Bd, Q, R) minimises a sum over the samples, which is not the same.",
];

struct Syntax {
    language: ExportLanguage,
}

impl Syntax {
    fn is_python(&self) -> bool {
        self.language == ExportLanguage::Python
    }

    fn comment(&self) -> &'static str {
        if self.is_python() { "#" } else { "%" }
    }

    fn ending(&self) -> &'static str {
        if self.is_python() { "py" } else { "m" }
    }

    fn open_parameters(&self) -> String {
        if self.is_python() {
            "# name: (value, standard error, unit)\nparameters = {\n".to_owned()
        } else {
            "% columns: name, value, standard error, unit\nparameters = {\n".to_owned()
        }
    }

    fn parameter(&self, name: &str, value: &str, std: &str, unit: &str) -> String {
        let (name, unit) = (self.quoted(name), self.quoted(unit));
        if self.is_python() {
            let std = if std == "nan" { "float(\"nan\")" } else { std };
            format!("    {name}: ({value}, {std}, {unit}),\n")
        } else {
            let std = if std == "nan" { "NaN" } else { std };
            format!("  {name}, {value}, {std}, {unit};\n")
        }
    }

    fn close_parameters(&self) -> String {
        if self.is_python() {
            "}\n".to_owned()
        } else {
            "};\n".to_owned()
        }
    }

    fn names(&self, name: &str, all: &[&str]) -> String {
        let all: Vec<String> = all.iter().map(|one| self.quoted(one)).collect();
        if self.is_python() {
            format!("{name} = [{}]\n", all.join(", "))
        } else {
            format!("{name} = {{{}}};\n", all.join(", "))
        }
    }

    fn scalar(&self, name: &str, value: f64) -> String {
        let end = if self.is_python() { "" } else { ";" };
        format!("{name} = {}{end}\n", number(value))
    }

    fn matrix(&self, name: &str, rows: &[Vec<f64>]) -> String {
        let cells = |row: &Vec<f64>| -> String {
            let cells: Vec<String> = row.iter().copied().map(number).collect();
            cells.join(", ")
        };
        if self.is_python() {
            let rows: Vec<String> = rows
                .iter()
                .map(|row| format!("    [{}],\n", cells(row)))
                .collect();
            format!("{name} = np.array([\n{}])\n", rows.concat())
        } else {
            let rows: Vec<String> = rows
                .iter()
                .map(|row| format!("  {};\n", cells(row)))
                .collect();
            format!("{name} = [\n{}];\n", rows.concat())
        }
    }

    /// A text in quotes. Characters that could end it are doubled or escaped.
    fn quoted(&self, text: &str) -> String {
        let text = one_line(text);
        if self.is_python() {
            format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
        } else {
            format!("'{}'", text.replace('\'', "''"))
        }
    }
}

/// The shortest decimal that reads back as the same double.
fn number(value: f64) -> String {
    format!("{value:e}")
}

fn one_line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}
