//! From the text of a formula to its operations.
//!
//! Operator precedence is that of Python: `-z^2` is −(z²), `a^b^c` is a^(b^c), `2^-1` is ½.

use std::collections::BTreeMap;

use super::{Formula, Function, Operation};

/// An error in a formula, with its position in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FormulaError {
    /// Position in the text, in bytes.
    pub at: usize,
    /// What is wrong, and what would be right.
    pub what: String,
}

const FUNCTIONS: [(&str, Function); 9] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("sqrt", Function::Sqrt),
    ("tanh", Function::Tanh),
    ("abs", Function::Abs),
    ("sign", Function::Sign),
];

/// The meaning of a name in a formula.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Meaning<'a> {
    /// The variable with this number.
    Variable(usize),
    /// A number.
    Number(f64),
    /// Another formula, which is inserted.
    Formula(&'a Formula),
}

/// Largest number of operations of a formula, including the formulas inserted into it.
const MOST: usize = 4096;
/// Largest nesting depth of parentheses and signs.
const DEEPEST: usize = 100;

impl Formula {
    /// Parses a formula with these names.
    pub fn read(text: &str, names: &BTreeMap<&str, Meaning>) -> Result<Formula, FormulaError> {
        let mut reader = Reader {
            text,
            at: 0,
            depth: 0,
            names,
            operations: vec![],
        };
        reader.sum()?;
        reader.skip_blanks();
        if reader.at < text.len() {
            return Err(reader.error("an operator (+ - * / ^) or the end is expected here"));
        }
        Ok(Formula {
            operations: reader.operations,
        })
    }
}

/// Parses from left to right. Each rule leaves its result as the last operation, and returns its index.
struct Reader<'t, 'n> {
    text: &'t str,
    at: usize,
    depth: usize,
    names: &'n BTreeMap<&'n str, Meaning<'n>>,
    operations: Vec<Operation>,
}

impl Reader<'_, '_> {
    fn error(&self, what: impl Into<String>) -> FormulaError {
        FormulaError {
            at: self.at,
            what: what.into(),
        }
    }

    fn skip_blanks(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// Skips a symbol if it stands here.
    fn takes(&mut self, symbol: &str) -> bool {
        self.skip_blanks();
        let found = self.text[self.at..].starts_with(symbol);
        if found {
            self.at += symbol.len();
        }
        found
    }

    fn push(&mut self, operation: Operation) -> Result<usize, FormulaError> {
        if self.operations.len() >= MOST {
            return Err(self.error(format!("the formula has more than {MOST} operations")));
        }
        self.operations.push(operation);
        Ok(self.operations.len() - 1)
    }

    fn sum(&mut self) -> Result<usize, FormulaError> {
        let mut left = self.product()?;
        loop {
            if self.takes("+") {
                let right = self.product()?;
                left = self.push(Operation::Sum(left, right))?;
            } else if self.takes("-") {
                let right = self.product()?;
                left = self.push(Operation::Difference(left, right))?;
            } else {
                return Ok(left);
            }
        }
    }

    fn product(&mut self) -> Result<usize, FormulaError> {
        let mut left = self.signed()?;
        loop {
            self.skip_blanks();
            if self.text[self.at..].starts_with("**") {
                return Err(self.error("a power is written with ^"));
            }
            if self.takes("*") {
                let right = self.signed()?;
                left = self.push(Operation::Product(left, right))?;
            } else if self.takes("/") {
                let right = self.signed()?;
                left = self.push(Operation::Quotient(left, right))?;
            } else {
                return Ok(left);
            }
        }
    }

    /// A sign binds more weakly than a power, and more strongly than a product.
    fn signed(&mut self) -> Result<usize, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error("the formula is nested too deeply"));
        }
        let found = if self.takes("-") {
            let inner = self.signed()?;
            self.push(Operation::Negative(inner))
        } else if self.takes("+") {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        found
    }

    fn power(&mut self) -> Result<usize, FormulaError> {
        let base = self.atom()?;
        if self.takes("^") {
            // Powers associate to the right, and the exponent may have a sign.
            let exponent = self.signed()?;
            return self.push(Operation::Power(base, exponent));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<usize, FormulaError> {
        if self.takes("(") {
            let inner = self.sum()?;
            if !self.takes(")") {
                return Err(self.error("a closing parenthesis is expected here"));
            }
            return Ok(inner);
        }
        self.skip_blanks();
        let rest = &self.text[self.at..];
        let length = |part: fn(char) -> bool| rest.find(|c| !part(c)).unwrap_or(rest.len());
        let first = rest.chars().next();
        if first.is_some_and(|c| c.is_ascii_digit() || c == '.') {
            return self.number(rest);
        }
        let name = &rest[..length(|c| c.is_alphanumeric() || c == '_')];
        if name.is_empty() {
            return Err(self.error("a number, a name or an opening parenthesis is expected here"));
        }
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            self.at += name.len();
            if !self.takes("(") {
                return Err(self.error(format!("{name} needs its argument in parentheses")));
            }
            let inner = self.sum()?;
            if !self.takes(")") {
                return Err(self.error("a closing parenthesis is expected here"));
            }
            return self.push(Operation::Call(*function, inner));
        }
        let Some(meaning) = self.names.get(name) else {
            let functions = FUNCTIONS.iter().map(|(name, _)| *name);
            let known: Vec<&str> = self.names.keys().copied().chain(functions).collect();
            return Err(self.error(format!(
                "the name \"{name}\" is not defined here; known names are {}",
                known.join(", ")
            )));
        };
        self.at += name.len();
        match *meaning {
            Meaning::Variable(variable) => self.push(Operation::Variable(variable)),
            Meaning::Number(number) => self.push(Operation::Number(number)),
            Meaning::Formula(formula) => self.insert(formula),
        }
    }

    /// Digits, a point, an exponent.
    fn number(&mut self, rest: &str) -> Result<usize, FormulaError> {
        let mut end = rest
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(rest.len());
        if let Some(exponent) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(exponent.starts_with(['+', '-']));
            let digits = exponent[sign..]
                .bytes()
                .take_while(u8::is_ascii_digit)
                .count();
            if digits > 0 {
                end += 1 + sign + digits;
            }
        }
        let value: f64 = rest[..end]
            .parse()
            .map_err(|_| self.error(format!("\"{}\" is not a number", &rest[..end])))?;
        self.at += end;
        self.push(Operation::Number(value))
    }

    /// Appends the operations of another formula to those of this one.
    fn insert(&mut self, formula: &Formula) -> Result<usize, FormulaError> {
        let first = self.operations.len();
        for operation in &formula.operations {
            let moved = match *operation {
                Operation::Number(_) | Operation::Variable(_) => *operation,
                Operation::Negative(a) => Operation::Negative(a + first),
                Operation::Sum(a, b) => Operation::Sum(a + first, b + first),
                Operation::Difference(a, b) => Operation::Difference(a + first, b + first),
                Operation::Product(a, b) => Operation::Product(a + first, b + first),
                Operation::Quotient(a, b) => Operation::Quotient(a + first, b + first),
                Operation::Power(a, b) => Operation::Power(a + first, b + first),
                Operation::Call(function, a) => Operation::Call(function, a + first),
            };
            self.push(moved)?;
        }
        Ok(self.operations.len() - 1)
    }
}
