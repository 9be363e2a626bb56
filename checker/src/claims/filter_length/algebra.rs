//! Functions whose calls are kept as calls, and the forms with which their words are compared.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::Signed;

use crate::domains::polynomials::{Polynomial, PolynomialCall, Words};
use crate::language::module::Module;
use crate::program::contract::{Contract, Range};
use crate::program::steps::{Program, Slot};

/// Fraction bits of the quaternion's words.
pub(crate) const FRACTION_BITS: i32 = 30;

/// The function `name`, with the calls of `through` kept as calls.
pub(crate) fn with_calls(module: &Module, name: &str, through: &[&str]) -> Result<Program, String> {
    let mut contracts = HashMap::new();
    for callee in through {
        let (number, contract) = every_word(module, callee)?;
        contracts.insert(number, contract);
    }
    let number = number(module, name)?;
    let program = module.function_with_contracts(number, &contracts);
    program.map_err(|error| error.to_string())
}

/// A contract that names every word of the arguments and promises nothing.
pub(crate) fn every_word(module: &Module, name: &str) -> Result<(usize, Contract), String> {
    let number = number(module, name)?;
    let program = module
        .program(number)
        .ok_or_else(|| format!("there is no {name}"))?;
    let requires = program
        .argument_types
        .iter()
        .enumerate()
        .map(|(word, type_)| {
            let (low, high) = type_.range();
            Range { word, low, high }
        })
        .collect();
    let contract = Contract {
        requires,
        ..Contract::default()
    };
    Ok((number, contract))
}

pub(crate) fn number(module: &Module, name: &str) -> Result<usize, String> {
    let number = module.function_number(name);
    number.ok_or_else(|| format!("there is no function {name}, or several"))
}

pub(crate) fn unless(condition: bool, message: &str) -> Result<(), String> {
    if condition {
        Ok(())
    } else {
        Err(message.to_owned())
    }
}

/// The monomials of a form as (symbols, coefficient).
pub(crate) fn is_terms(form: &Polynomial, terms: &[(&[Slot], BigRational)]) -> bool {
    let wanted = terms
        .iter()
        .fold(Polynomial::zero(), |sum, (symbols, coefficient)| {
            sum.with(symbols.to_vec(), coefficient.clone())
        });
    form.terms == wanted.terms
}

/// The coefficient c of a form c Σ xᵢ² + k + e, and k.
pub(crate) fn sum_of_squares(
    form: &Polynomial,
    symbols: &[Slot],
) -> Option<(BigRational, BigRational)> {
    let constant = form.terms.get(&Vec::new()).cloned().unwrap_or_default();
    let coefficient = form.terms.get(&vec![symbols[0]; 2])?.clone();
    let wanted = symbols
        .iter()
        .fold(Polynomial::constant(constant.clone()), |sum, symbol| {
            sum.with(vec![*symbol; 2], coefficient.clone())
        });
    let is_sum = form.terms == wanted.terms && coefficient.is_positive();
    is_sum.then_some((coefficient, constant))
}

/// Value and constant ends of a call of `clamp`.
pub(crate) fn clamp_of(
    words: &Words,
    slot: Slot,
) -> Option<(&PolynomialCall, Polynomial, BigRational, BigRational)> {
    let call = words.call(slot).filter(|call| call.function == "clamp")?;
    let [value, low, high] = call.arguments.as_slice() else {
        return None;
    };
    let (low, high) = (words.form(*low).number()?, words.form(*high).number()?);
    Some((call, words.form(*value).clone(), low, high))
}
