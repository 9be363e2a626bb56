//! Words as linear forms of the arguments: affine arithmetic in exact integers.
//!
//! A word w is held as Σ cᵢ Xᵢ + c + e with e within an interval, all over one power of two:
//! w 2ᵈ = Σ cᵢ Xᵢ + c + e. Sums and products with constants are exact; a right shift by s divides
//! and rounds down, so e grows by at most the part that is cut off. A clamp to constants is kept
//! beside the form: saturation brings two numbers no further apart, so an error bound before it
//! holds after it.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::program::{Action, Arithmetic, Program, Slot, Step};

/// Σ cᵢ Xᵢ + c + e, e within [low, high]; all in units of the word.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// cᵢ by the position of the word among the arguments; zeros left out.
    pub coefficients: BTreeMap<usize, BigRational>,
    /// Lower end of c + e.
    pub low: BigRational,
    /// Upper end of c + e.
    pub high: BigRational,
    /// The value is this form clamped to these ends.
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

/// The results of `program` as linear forms; `None` for a result that is none.
pub fn forms(program: &Program) -> Vec<Option<Form>> {
    let mut state: Vec<Option<Form>> = program
        .initial
        .iter()
        .zip(&program.is_constant)
        .map(|(value, is_constant)| is_constant.then(|| Form::constant(*value)))
        .collect();
    for (index, slot) in program.arguments.iter().enumerate() {
        state[*slot] = Some(Form::argument(index));
    }
    for step in &program.steps {
        if let Some((to, form)) = step_form(step, &state) {
            state[to] = form;
        }
    }
    program
        .results
        .iter()
        .map(|slot| state[*slot].clone())
        .collect()
}

fn step_form(step: &Step, state: &[Option<Form>]) -> Option<(Slot, Option<Form>)> {
    let form = |slot: &Slot| state[*slot].as_ref();
    match &step.action {
        Action::Arithmetic {
            to,
            operation,
            a,
            b,
            ..
        } => {
            let result = form(a).zip(form(b)).and_then(|(a, b)| match operation {
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
            });
            Some((*to, result))
        }
        // The interval analysis shows that a cast loses nothing.
        Action::Cast { to, a, .. } => Some((*to, form(a).cloned())),
        Action::Clamp { to, a, low, high } => {
            let result = form(a).and_then(|a| {
                let low = form(low)?.exactly()?;
                let high = form(high)?.exactly()?;
                (a.clamped.is_none() && low <= high).then(|| Form {
                    clamped: Some((low, high)),
                    ..a.clone()
                })
            });
            Some((*to, result))
        }
        // The law has no branches; what they give is not linear.
        Action::Compare { to, .. } | Action::Not { to, .. } => Some((*to, None)),
        Action::If { .. } | Action::Assert { .. } | Action::Contract { .. } => None,
    }
}

fn shift_amount(form: &Form) -> Option<u32> {
    let value = form.exactly()?;
    u32::try_from(value.to_integer())
        .ok()
        .filter(|amount| *amount < 128)
}
