//! Words as linear forms of the arguments: affine arithmetic in exact integers.
//!
//! A word w is represented as Σ cᵢ Xᵢ + c + e, with e within an interval, all divided by one power of two:
//! w 2ᵈ = Σ cᵢ Xᵢ + c + e. Sums and products with constants are exact. A right shift by s divides
//! and rounds down, so e grows by at most the part that is cut off. A clamp to constants is stored
//! beside the form: saturation does not increase the distance of two numbers, so an error bound before it
//! also holds after it.

use std::collections::BTreeMap;
use std::convert::Infallible;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::domains::walk::{BranchEnd, ContractedCall, Domain, Site, start, walk};
use crate::program::steps::{Arithmetic, Join, Program, Slot, WordComparison};
use crate::program::types::Integer;

/// Σ cᵢ Xᵢ + c + e, with e within [low, high]; all in units of the word.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// cᵢ by the position of the word among the arguments; zeros left out.
    pub coefficients: BTreeMap<usize, BigRational>,
    /// Lower end of c + e.
    pub low: BigRational,
    /// Upper end of c + e.
    pub high: BigRational,
    /// The ends to which this form is clamped, if it is.
    pub clamped: Option<(BigRational, BigRational)>,
}

impl Form {
    fn constant(value: i128) -> Form {
        let value = BigRational::from(BigInt::from(value));
        Form {
            coefficients: BTreeMap::new(),
            low: value.clone(),
            high: value,
            clamped: None,
        }
    }

    fn argument(index: usize) -> Form {
        Form {
            coefficients: [(index, BigRational::one())].into(),
            low: BigRational::zero(),
            high: BigRational::zero(),
            clamped: None,
        }
    }

    fn exactly(&self) -> Option<BigRational> {
        (self.coefficients.is_empty() && self.low == self.high && self.clamped.is_none())
            .then(|| self.low.clone())
    }

    fn scaled(&self, factor: &BigRational) -> Option<Form> {
        if self.clamped.is_some() {
            return None;
        }
        let (a, b) = (&self.low * factor, &self.high * factor);
        let (low, high) = if factor.is_negative() { (b, a) } else { (a, b) };
        Some(Form {
            coefficients: self
                .coefficients
                .iter()
                .filter(|_| !factor.is_zero())
                .map(|(index, value)| (*index, value * factor))
                .collect(),
            low,
            high,
            clamped: None,
        })
    }

    fn plus(&self, other: &Form) -> Option<Form> {
        if self.clamped.is_some() || other.clamped.is_some() {
            return None;
        }
        let mut coefficients = self.coefficients.clone();
        for (index, value) in &other.coefficients {
            let sum = coefficients.remove(index).unwrap_or_default() + value;
            if !sum.is_zero() {
                coefficients.insert(*index, sum);
            }
        }
        Some(Form {
            coefficients,
            low: &self.low + &other.low,
            high: &self.high + &other.high,
            clamped: None,
        })
    }

    /// ⌊self / 2ˢ⌋: the exact quotient less at most (2ˢ − 1)/2ˢ.
    fn shifted_right(&self, shift: u32) -> Option<Form> {
        let unit = BigRational::new(BigInt::one(), BigInt::one() << shift);
        let mut form = self.scaled(&unit)?;
        form.low -= BigRational::one() - unit;
        Some(form)
    }
}

/// The results of `program` as linear forms; `None` for a result that is not one.
pub fn forms(program: &Program) -> Vec<Option<Form>> {
    let arguments = (0..program.arguments.len()).map(|index| Some(Form::argument(index)));
    let mut words = start(&mut LinearForms, program, arguments);
    match walk(&mut LinearForms, program, &mut words) {
        Ok(()) => {}
    }
    let results = program.results.iter();
    results.map(|slot| words[*slot].clone()).collect()
}

/// Linear forms, for words that have one. [`crate::domains::intervals`] proves that nothing overflows and no cast
/// loses bits.
struct LinearForms;

impl Domain for LinearForms {
    type Word = Option<Form>;
    type Stop = Infallible;

    fn initial(&mut self, _slot: Slot, constant: Option<i128>) -> Option<Form> {
        constant.map(Form::constant)
    }

    fn arithmetic(
        &mut self,
        site: &Site<Option<Form>>,
        _to: Slot,
        operation: Arithmetic,
        (a, b): (Slot, Slot),
        _type: Integer,
    ) -> Result<Option<Form>, Infallible> {
        let operands = site.word(a).as_ref().zip(site.word(b).as_ref());
        Ok(operands.and_then(|(a, b)| arithmetic(operation, a, b)))
    }

    // The law has no branches, and their results would not be linear.
    fn comparison(
        &mut self,
        _site: &Site<Option<Form>>,
        _to: Slot,
        _comparison: WordComparison,
        _operands: (Slot, Slot),
    ) -> Result<Option<Form>, Infallible> {
        Ok(None)
    }

    fn negation(
        &mut self,
        _site: &Site<Option<Form>>,
        _to: Slot,
        _operand: Slot,
    ) -> Result<Option<Form>, Infallible> {
        Ok(None)
    }

    fn cast(
        &mut self,
        site: &Site<Option<Form>>,
        operand: Slot,
        _type: Integer,
    ) -> Result<Option<Form>, Infallible> {
        Ok(site.word(operand).clone())
    }

    fn clamp(
        &mut self,
        site: &Site<Option<Form>>,
        _to: Slot,
        operand: Slot,
        (low, high): (Slot, Slot),
    ) -> Result<Option<Form>, Infallible> {
        let end = |slot| site.word(slot).as_ref().and_then(Form::exactly);
        let ends = end(low).zip(end(high)).filter(|(low, high)| low <= high);
        let free = site.word(operand).as_ref();
        let free = free.filter(|form| form.clamped.is_none()).cloned();
        Ok(free.zip(ends).map(|(form, ends)| Form {
            clamped: Some(ends),
            ..form
        }))
    }

    fn assertion(
        &mut self,
        _site: &Site<Option<Form>>,
        _condition: Slot,
        _message: &str,
    ) -> Result<(), Infallible> {
        Ok(())
    }

    fn call(
        &mut self,
        _site: &Site<Option<Form>>,
        call: ContractedCall,
    ) -> Result<Vec<Option<Form>>, Infallible> {
        Ok(vec![None; call.ensures.len()])
    }

    fn join(
        &mut self,
        _site: &Site<Option<Form>>,
        _condition: Slot,
        joins: &[Join],
        _sides: [BranchEnd<Option<Form>>; 2],
    ) -> Result<Vec<Option<Form>>, Infallible> {
        Ok(vec![None; joins.len()])
    }
}

fn arithmetic(operation: Arithmetic, a: &Form, b: &Form) -> Option<Form> {
    match operation {
        Arithmetic::Add => a.plus(b),
        Arithmetic::Subtract => a.plus(&b.scaled(&-BigRational::one())?),
        Arithmetic::Multiply => match (a.exactly(), b.exactly()) {
            (Some(factor), _) => b.scaled(&factor),
            (_, Some(factor)) => a.scaled(&factor),
            _ => None,
        },
        Arithmetic::ShiftRight => a.shifted_right(shift_amount(b)?),
        Arithmetic::ShiftLeft => {
            let factor = BigRational::from(BigInt::one() << shift_amount(b)?);
            a.scaled(&factor)
        }
        Arithmetic::And => None,
    }
}

fn shift_amount(form: &Form) -> Option<u32> {
    let value = form.exactly()?;
    u32::try_from(value.to_integer())
        .ok()
        .filter(|amount| *amount < 128)
}
