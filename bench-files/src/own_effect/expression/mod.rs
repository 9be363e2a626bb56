//! Users' formulas: evaluated, and differentiated exactly by one backward pass over their operations (reverse mode;
//! Griewank & Walther, *Evaluating Derivatives*, 2nd ed., ch. 3). `reader` parses them.

mod reader;

pub(crate) use reader::Meaning;

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

/// Number of operations up to which an evaluation needs no heap allocation.
const FEW: usize = 64;

impl Formula {
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

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
