//! Words as polynomials of symbols with a remainder, in exact rational numbers.
//!
//! A word is represented as Σ cₘ m + e, with monomials m in symbols and e within an interval. Arguments,
//! results of calls, and words in which branches join are symbols. Sums and products are exact. A
//! right shift by s divides by 2ˢ and lowers e by up to one unit. A factor with a remainder
//! becomes a new symbol, whose definition is kept.
//!
//! Machine words are treated as integers here. [`crate::domains::intervals`] proves that nothing overflows.

use std::collections::BTreeMap;
use std::convert::Infallible;

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::exact::rational::{integer, power_of_two};
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::Integer;

/// Symbols, sorted, each as often as its power.
pub type Monomial = Vec<Slot>;

/// Σ cₘ m + e, with e within [low, high].
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// cₘ by monomial; zeros left out. The empty monomial is the constant.
    pub terms: BTreeMap<Monomial, BigRational>,
    /// Lower end of e.
    pub low: BigRational,
    /// Upper end of e.
    pub high: BigRational,
}

impl Polynomial {
    /// A number.
    pub fn constant(value: BigRational) -> Polynomial {
        Polynomial::zero().with(Vec::new(), value)
    }

    /// A symbol.
    pub fn symbol(slot: Slot) -> Polynomial {
        Polynomial::zero().with(vec![slot], BigRational::one())
    }

    /// Nothing.
    pub fn zero() -> Polynomial {
        Polynomial {
            terms: BTreeMap::new(),
            low: BigRational::zero(),
            high: BigRational::zero(),
        }
    }

    /// The polynomial with one more term.
    pub fn with(mut self, mut monomial: Monomial, coefficient: BigRational) -> Polynomial {
        monomial.sort_unstable();
        let sum = self.terms.remove(&monomial).unwrap_or_default() + coefficient;
        if !sum.is_zero() {
            self.terms.insert(monomial, sum);
        }
        self
    }

    /// Whether there is no remainder.
    pub fn is_exact(&self) -> bool {
        self.low.is_zero() && self.high.is_zero()
    }

    /// Its value, if the polynomial is a constant without remainder.
    pub fn number(&self) -> Option<BigRational> {
        let is_number = self.is_exact() && self.terms.keys().all(Vec::is_empty);
        is_number.then(|| self.terms.get(&Vec::new()).cloned().unwrap_or_default())
    }

    /// The largest magnitude of the remainder.
    pub fn remainder(&self) -> BigRational {
        self.low.abs().max(self.high.abs())
    }

    /// Sum.
    pub fn plus(&self, other: &Polynomial) -> Polynomial {
        let mut sum = self.clone();
        for (monomial, coefficient) in &other.terms {
            sum = sum.with(monomial.clone(), coefficient.clone());
        }
        sum.low += &other.low;
        sum.high += &other.high;
        sum
    }

    /// Product with a number.
    pub fn scaled(&self, factor: &BigRational) -> Polynomial {
        let mut product = Polynomial::zero();
        for (monomial, coefficient) in &self.terms {
            product = product.with(monomial.clone(), coefficient * factor);
        }
        let (low, high) = (&self.low * factor, &self.high * factor);
        (product.low, product.high) = if factor.is_negative() {
            (high, low)
        } else {
            (low, high)
        };
        product
    }

    /// Product of two polynomials without their remainders.
    pub fn times(&self, other: &Polynomial) -> Polynomial {
        let mut product = Polynomial::zero();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                product = product.with([a.as_slice(), b.as_slice()].concat(), x * y);
            }
        }
        product
    }

    /// The terms without the remainder.
    pub fn terms_only(&self) -> Polynomial {
        Polynomial {
            terms: self.terms.clone(),
            ..Polynomial::zero()
        }
    }

    /// The polynomial with `value` in place of a symbol of power one; `None` for a higher power. The remainder of `value`
    /// may be multiplied by numbers only; `None` if it would be multiplied by a symbol.
    pub fn substituted(&self, symbol: Slot, value: &Polynomial) -> Option<Polynomial> {
        let mut result = Polynomial {
            terms: BTreeMap::new(),
            low: self.low.clone(),
            high: self.high.clone(),
        };
        for (monomial, coefficient) in &self.terms {
            let rest: Monomial = monomial.iter().copied().filter(|s| *s != symbol).collect();
            match monomial.len() - rest.len() {
                0 => result = result.with(rest, coefficient.clone()),
                1 if rest.is_empty() => result = result.plus(&value.scaled(coefficient)),
                _ => return None,
            }
        }
        Some(result)
    }

    /// The range for values `low..=high` of the only symbol, with the remainder, computed term by term;
    /// `None` if other symbols occur.
    pub fn range(
        &self,
        symbol: Slot,
        low: &BigRational,
        high: &BigRational,
    ) -> Option<(BigRational, BigRational)> {
        let (mut least, mut most) = (self.low.clone(), self.high.clone());
        for (monomial, coefficient) in &self.terms {
            if monomial.iter().any(|found| *found != symbol) {
                return None;
            }
            let power = i32::try_from(monomial.len()).ok()?;
            let (a, b) = (low.pow(power), high.pow(power));
            let (mut smaller, mut larger) = (a.clone().min(b.clone()), a.max(b));
            if power % 2 == 0 && power > 0 && low.is_negative() && high.is_positive() {
                smaller = BigRational::zero();
            }
            if coefficient.is_negative() {
                (smaller, larger) = (larger, smaller);
            }
            least += smaller * coefficient;
            most += larger * coefficient;
        }
        Some((least, most))
    }
}

/// A call that a contract represents.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialCall {
    /// Function.
    pub function: String,
    /// Slots of the arguments that the contract names.
    pub arguments: Vec<Slot>,
    /// Slots of the results.
    pub results: Vec<Slot>,
}

/// Every word of a program.
#[derive(Clone, Debug)]
pub struct Words {
    forms: Vec<Polynomial>,
    joins: Vec<Vec<Join>>,
    /// Calls, in order.
    pub calls: Vec<PolynomialCall>,
}

impl Words {
    /// Processes every step, on both sides of each branch.
    pub fn of(program: &Program) -> Words {
        let mut domain = Polynomials::default();
        let arguments = program.arguments.iter().copied().map(Polynomial::symbol);
        let mut forms = start(&mut domain, program, arguments);
        match walk(&mut domain, program, &mut forms) {
            Ok(()) => {}
        }
        Words {
            forms,
            joins: domain.joins,
            calls: domain.calls,
        }
    }

    /// The known form of a word; the word itself as a symbol if nothing is known.
    pub fn form(&self, slot: Slot) -> &Polynomial {
        &self.forms[slot]
    }

    /// The symbol that a word is, or is a copy of.
    pub fn symbol(&self, slot: Slot) -> Option<Slot> {
        let form = self.form(slot);
        let (monomial, coefficient) = form.terms.first_key_value()?;
        let is_symbol =
            form.is_exact() && form.terms.len() == 1 && monomial.len() == 1 && coefficient.is_one();
        is_symbol.then(|| monomial[0])
    }

    /// The call that a word is the result of, or a copy of a result.
    pub fn call(&self, slot: Slot) -> Option<&PolynomialCall> {
        let symbol = self.symbol(slot)?;
        self.calls
            .iter()
            .find(|call| call.results.contains(&symbol))
    }

    /// The words of a tuple for each path through the branches in which its words join.
    pub fn alternatives(&self, tuple: &[Slot]) -> Vec<Vec<Slot>> {
        // Later branches first: the words of a later one join those of an earlier.
        for joins in self.joins.iter().rev() {
            let joined = |slot: &Slot| joins.iter().find(|join| join.to == *slot);
            let side = |is_then: bool| -> Vec<Slot> {
                let picked = tuple
                    .iter()
                    .map(|slot| joined(slot).map_or(*slot, |join| join.of(is_then)));
                picked.collect()
            };
            if tuple.iter().any(|slot| joined(slot).is_some()) {
                let mut found = self.alternatives(&side(true));
                found.extend(self.alternatives(&side(false)));
                return found;
            }
        }
        vec![tuple.to_vec()]
    }
}

/// Polynomials of symbols; a word without a form becomes a symbol.
#[derive(Default)]
struct Polynomials {
    joins: Vec<Vec<Join>>,
    calls: Vec<PolynomialCall>,
}

impl Domain for Polynomials {
    type Word = Polynomial;
    type Stop = Infallible;

    fn initial(&mut self, slot: Slot, constant: Option<i128>) -> Polynomial {
        match constant {
            Some(value) => Polynomial::constant(integer(value)),
            None => Polynomial::symbol(slot),
        }
    }

    fn arithmetic(
        &mut self,
        site: &Site<Polynomial>,
        to: Slot,
        operation: Arithmetic,
        operands: (Slot, Slot),
        _type: Integer,
    ) -> Result<Polynomial, Infallible> {
        let form = arithmetic(site, operation, operands);
        Ok(form.unwrap_or_else(|| Polynomial::symbol(to)))
    }

    fn comparison(
        &mut self,
        _site: &Site<Polynomial>,
        to: Slot,
        _comparison: WordComparison,
        _operands: (Slot, Slot),
    ) -> Result<Polynomial, Infallible> {
        Ok(Polynomial::symbol(to))
    }

    fn negation(
        &mut self,
        _site: &Site<Polynomial>,
        to: Slot,
        _operand: Slot,
    ) -> Result<Polynomial, Infallible> {
        Ok(Polynomial::symbol(to))
    }

    fn cast(
        &mut self,
        site: &Site<Polynomial>,
        operand: Slot,
        _type: Integer,
    ) -> Result<Polynomial, Infallible> {
        Ok(site.word(operand).clone())
    }

    fn clamp(
        &mut self,
        _site: &Site<Polynomial>,
        to: Slot,
        _operand: Slot,
        _ends: (Slot, Slot),
    ) -> Result<Polynomial, Infallible> {
        Ok(Polynomial::symbol(to))
    }

    fn assertion(
        &mut self,
        _site: &Site<Polynomial>,
        _condition: Slot,
        _message: &str,
    ) -> Result<(), Infallible> {
        Ok(())
    }

    fn call(
        &mut self,
        _site: &Site<Polynomial>,
        call: ContractedCall,
    ) -> Result<Vec<Polynomial>, Infallible> {
        let results: Vec<Slot> = call.ensures.iter().map(|(slot, _, _)| *slot).collect();
        let symbols = results.iter().copied().map(Polynomial::symbol).collect();
        self.calls.push(PolynomialCall {
            function: call.function.to_owned(),
            arguments: call.requires.iter().map(|(slot, _, _)| *slot).collect(),
            results,
        });
        Ok(symbols)
    }

    fn join(
        &mut self,
        _site: &Site<Polynomial>,
        _condition: Slot,
        joins: &[Join],
        _sides: [BranchEnd<Polynomial>; 2],
    ) -> Result<Vec<Polynomial>, Infallible> {
        self.joins.push(joins.to_vec());
        let joined = joins.iter().map(|join| Polynomial::symbol(join.to));
        Ok(joined.collect())
    }
}

fn arithmetic(
    site: &Site<Polynomial>,
    operation: Arithmetic,
    (a, b): (Slot, Slot),
) -> Option<Polynomial> {
    let (x, y) = (site.word(a), site.word(b));
    let bits = || {
        y.number()?
            .to_integer()
            .to_i32()
            .filter(|s| (0..64).contains(s))
    };
    match operation {
        Arithmetic::Add => Some(x.plus(y)),
        Arithmetic::Subtract => Some(x.plus(&y.scaled(&integer(-1)))),
        Arithmetic::Multiply => Some(match (x.number(), y.number()) {
            (Some(factor), _) => y.scaled(&factor),
            (_, Some(factor)) => x.scaled(&factor),
            _ => {
                let factor = |form: &Polynomial, slot| {
                    if form.is_exact() {
                        form.clone()
                    } else {
                        Polynomial::symbol(slot)
                    }
                };
                factor(x, a).times(&factor(y, b))
            }
        }),
        Arithmetic::ShiftLeft => Some(x.scaled(&power_of_two(bits()?))),
        Arithmetic::ShiftRight => {
            let mut quotient = x.scaled(&power_of_two(-bits()?));
            quotient.low -= BigRational::one();
            Some(quotient)
        }
        Arithmetic::And => {
            let mask = y.number().filter(|mask| !mask.is_negative())?;
            let mut form = Polynomial::zero();
            form.high = mask;
            Some(form)
        }
    }
}
