//! Users' formulas: parsed, evaluated, and differentiated exactly by one backward pass over their operations
//! (reverse mode; Griewank & Walther, *Evaluating Derivatives*, 2nd ed., ch. 3).
//!
//! Operator precedence is that of Python: `-z^2` is −(z²), `a^b^c` is a^(b^c), `2^-1` is ½.

use std::collections::BTreeMap;

/// An error in a formula, with its position in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FormulaError {
    /// Position in the text, in bytes.
    pub at: usize,
    /// What is wrong, and what would be right.
    pub what: String,
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Sin,
    Cos,
    Tan,
    Exp,
    Ln,
    Sqrt,
    Tanh,
    Abs,
    /// tanh(v/v₀), with v₀ the small smoothing speed of the fit.
    Sign,
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

/// One operation; its operands are earlier operations.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Number(f64),
    Variable(usize),
    Negative(usize),
    Sum(usize, usize),
    Difference(usize, usize),
    Product(usize, usize),
    Quotient(usize, usize),
    Power(usize, usize),
    Call(Function, usize),
}

/// A formula over numbered variables.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Formula {
    operations: Vec<Operation>,
}

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

/// Number of operations up to which an evaluation needs no heap allocation.
const FEW: usize = 64;
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

    /// Whether the formula contains the variable with this number.
    pub fn uses(&self, variable: usize) -> bool {
        self.operations.contains(&Operation::Variable(variable))
    }

    /// Whether it has a kink or a smoothed step: `abs` or `sign`.
    pub fn has_kink(&self) -> bool {
        let is_kink = |operation: &Operation| {
            matches!(
                operation,
                Operation::Call(Function::Abs | Function::Sign, _)
            )
        };
        self.operations.iter().any(is_kink)
    }

    /// Its value. The derivatives with respect to the variables are added to `slopes`. `v0` smooths `sign`.
    pub fn value(&self, variables: &[f64], v0: f64, slopes: &mut [f64]) -> f64 {
        let count = self.operations.len();
        let mut stack = [0.0; 2 * FEW];
        let mut heap = vec![];
        let room: &mut [f64] = if count <= FEW {
            &mut stack[..2 * count]
        } else {
            heap.resize(2 * count, 0.0);
            &mut heap
        };
        let (values, weights) = room.split_at_mut(count);
        for (index, operation) in self.operations.iter().enumerate() {
            values[index] = match *operation {
                Operation::Number(number) => number,
                Operation::Variable(variable) => variables[variable],
                Operation::Negative(a) => -values[a],
                Operation::Sum(a, b) => values[a] + values[b],
                Operation::Difference(a, b) => values[a] - values[b],
                Operation::Product(a, b) => values[a] * values[b],
                Operation::Quotient(a, b) => values[a] / values[b],
                Operation::Power(a, b) => values[a].powf(values[b]),
                Operation::Call(function, a) => function.value(values[a], v0),
            };
        }
        let Some(last) = count.checked_sub(1) else {
            return 0.0;
        };
        weights[last] = 1.0;
        for (index, operation) in self.operations.iter().enumerate().rev() {
            let weight = weights[index];
            if weight == 0.0 {
                continue;
            }
            match *operation {
                Operation::Number(_) => {}
                Operation::Variable(variable) => slopes[variable] += weight,
                Operation::Negative(a) => weights[a] -= weight,
                Operation::Sum(a, b) => {
                    weights[a] += weight;
                    weights[b] += weight;
                }
                Operation::Difference(a, b) => {
                    weights[a] += weight;
                    weights[b] -= weight;
                }
                Operation::Product(a, b) => {
                    weights[a] += weight * values[b];
                    weights[b] += weight * values[a];
                }
                Operation::Quotient(a, b) => {
                    weights[a] += weight / values[b];
                    weights[b] -= weight * values[index] / values[b];
                }
                Operation::Power(a, b) => {
                    let (base, exponent) = (values[a], values[b]);
                    if exponent != 0.0 {
                        weights[a] += weight * exponent * base.powf(exponent - 1.0);
                    }
                    // A power with a negative base exists only for whole exponents, which are constant.
                    if base > 0.0 {
                        weights[b] += weight * values[index] * base.ln();
                    }
                }
                Operation::Call(function, a) => {
                    weights[a] += weight * function.slope(values[a], values[index], v0);
                }
            }
        }
        values[last]
    }
}

impl Function {
    fn value(self, x: f64, v0: f64) -> f64 {
        match self {
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Exp => x.exp(),
            Function::Ln => x.ln(),
            Function::Sqrt => x.sqrt(),
            Function::Tanh => x.tanh(),
            Function::Abs => x.abs(),
            Function::Sign => (x / v0).tanh(),
        }
    }

    /// Derivative at x, where the function has the value y.
    fn slope(self, x: f64, y: f64, v0: f64) -> f64 {
        match self {
            Function::Sin => x.cos(),
            Function::Cos => -x.sin(),
            Function::Tan => 1.0 + y * y,
            Function::Exp => y,
            Function::Ln => 1.0 / x,
            Function::Sqrt => 0.5 / y,
            Function::Tanh => 1.0 - y * y,
            Function::Abs if x == 0.0 => 0.0,
            Function::Abs => x.signum(),
            Function::Sign => (1.0 - y * y) / v0,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> BTreeMap<&'static str, Meaning<'static>> {
        [
            ("x", Meaning::Variable(0)),
            ("y", Meaning::Variable(1)),
            ("pi", Meaning::Number(std::f64::consts::PI)),
        ]
        .into()
    }

    fn value(text: &str, x: f64, y: f64) -> f64 {
        let formula =
            Formula::read(text, &names()).unwrap_or_else(|error| panic!("{text}: {error:?}"));
        formula.value(&[x, y], 0.01, &mut [0.0; 2])
    }

    /// Each against what Python gives.
    #[test]
    fn precedence_is_that_of_python() {
        for (text, expected) in [
            ("-x^2", -4.0),
            ("(-x)^2", 4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("-2^-2", -0.25),
            ("1 - 2 - 3", -4.0),
            ("12 / 2 / 3", 2.0),
            ("1 + 2*3^2", 19.0),
            ("2*-3", -6.0),
            ("- - 3", 3.0),
            ("1.5e1 + .5", 15.5),
            ("x*exp(-x^2)", 2.0 * (-4.0_f64).exp()),
            ("sin(pi/2)", 1.0),
            ("abs(-3) + sqrt(16)", 7.0),
            ("2e0x", f64::NAN),
        ] {
            if expected.is_nan() {
                assert!(Formula::read(text, &names()).is_err(), "{text}");
            } else {
                assert!((value(text, 2.0, 3.0) - expected).abs() < 1e-12, "{text}");
            }
        }
        // z exp(−z²) at z = 2 is 0.037, and not 109.
        assert!((value("x*exp(-x^2)", 2.0, 0.0) - 0.0366).abs() < 1e-4);
    }

    #[test]
    fn derivatives_are_those_of_small_steps() {
        for text in [
            "x*exp(-x^2) + y",
            "sin(x)*cos(y)/tan(0.3 + x)",
            "x^y",
            "(x - y)^3",
            "ln(x + y)*sqrt(x)",
            "tanh(x*y) - abs(y - x)",
            "sign(0.003*x)",
            "x/y/(1 + x^2)",
        ] {
            let formula = Formula::read(text, &names()).expect(text);
            let at = [0.7, 1.3];
            let mut slopes = [0.0; 2];
            formula.value(&at, 0.01, &mut slopes);
            for k in 0..2 {
                let moved = |step: f64| {
                    let mut variables = at;
                    variables[k] += step;
                    formula.value(&variables, 0.01, &mut [0.0; 2])
                };
                let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                let error = (slopes[k] - difference).abs();
                assert!(
                    error < 1e-7 * (1.0 + difference.abs()),
                    "{text}: {slopes:?} {difference}"
                );
            }
        }
    }

    #[test]
    fn formulas_stand_in_each_other() {
        let names_of_z = names();
        let z = Formula::read("(x - 0.5)/y", &names_of_z).expect("z");
        let mut names = names();
        names.insert("z", Meaning::Formula(&z));
        let torque = Formula::read("3*z*exp(-z^2)", &names).expect("torque");
        let z = (2.0 - 0.5) / 3.0_f64;
        let found = torque.value(&[2.0, 3.0], 0.01, &mut [0.0; 2]);
        assert!((found - 3.0 * z * (-z * z).exp()).abs() < 1e-15);
        assert!(torque.uses(1) && !torque.has_kink());
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, at, what) in [
            ("", 0, "a number, a name"),
            ("1 +", 3, "a number, a name"),
            ("2*(x", 4, "closing parenthesis"),
            ("x y", 2, "an operator"),
            ("2*omega", 2, "the name \"omega\" is not defined"),
            ("sin x", 4, "in parentheses"),
            ("x**2", 1, "written with ^"),
            ("1.2.3", 0, "not a number"),
            ("x)", 1, "an operator"),
        ] {
            let error = Formula::read(text, &names()).expect_err(text);
            assert_eq!(error.at, at, "{text}: {error:?}");
            assert!(error.what.contains(what), "{text}: {error:?}");
        }
        assert!(Formula::read(&"(".repeat(100_000), &names()).is_err());
        assert!(Formula::read(&"-".repeat(100_000), &names()).is_err());
        assert!(Formula::read(&"1+".repeat(100_000), &names()).is_err());
    }
}
