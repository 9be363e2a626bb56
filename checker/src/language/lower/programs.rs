//! Functions to programs, constants to their words.

use std::collections::HashMap;

use syn::spanned::Spanned;

use crate::domains::machine::Machine;
use crate::language::declarations::{Constants, Declarations, Read, refuse};
use crate::language::lower::builder::{Builder, Scope};
use crate::program::contract::Contract;
use crate::program::place::SourceError;
use crate::program::steps::Program;

/// Resolves the function with this number.
///
/// Calls of functions in `contracts` are represented by their contracts.
///
/// # Errors
/// [`SourceError`] for everything outside the language.
pub fn function(
    declarations: &Declarations,
    constants: &mut Constants,
    contracts: &HashMap<usize, Contract>,
    number: usize,
) -> Read<Program> {
    let function = &declarations.functions[number];
    let mut builder = Builder::new(declarations, constants, contracts);
    builder.places.push(function.place.clone());
    let mut inputs = Vec::new();
    let mut arguments = Vec::new();
    let mut argument_types = Vec::new();
    let mut values = Vec::new();
    for argument in &function.arguments {
        let value = builder.fresh(&argument.type_);
        inputs.extend(declarations.word_names(&argument.name, &argument.type_));
        arguments.extend(&value.slots);
        argument_types.extend(declarations.words(&argument.type_));
        values.push(value);
    }
    let mut steps = Vec::new();
    let (result, mutated) = builder.body(number, values, &mut steps)?;
    let mut results = result.slots;
    let mut result_types = declarations.words(&result.type_);
    for value in mutated {
        result_types.extend(declarations.words(&value.type_));
        results.extend(value.slots);
    }
    Ok(Program {
        name: function.name.clone(),
        inputs,
        arguments,
        argument_types,
        results,
        result_types,
        initial: builder.initial,
        is_constant: builder.is_constant,
        steps,
        places: builder.places,
    })
}

/// The words of the constant with this number.
///
/// # Errors
/// [`SourceError`] for everything outside the language, for a constant whose computation
/// overflows, and for an assertion that does not hold.
pub fn constant(
    declarations: &Declarations,
    constants: &mut Constants,
    number: usize,
) -> Read<Vec<i128>> {
    if let Some(words) = constants.get(&number) {
        return Ok(words.clone());
    }
    let constant = &declarations.constants[number];
    let none = HashMap::new();
    let mut builder = Builder::new(declarations, constants, &none);
    builder.places.push(constant.place.clone());
    builder.stack.push(usize::MAX - number);
    let path = declarations.files[constant.module].path.clone();
    let mut scope = Scope {
        module: constant.module,
        path: path.clone(),
        owner: None,
        variables: Vec::new(),
        is_assertion: constant.name == "_",
        is_tail: false,
    };
    let mut steps = Vec::new();
    let value = builder.expression(
        &mut scope,
        &constant.expression,
        Some(&constant.type_),
        &mut steps,
    )?;
    if value.type_ != constant.type_ {
        return refuse(
            &path,
            constant.expression.span(),
            format!(
                "a {} is expected, found a {}",
                declarations.type_name(&constant.type_),
                declarations.type_name(&value.type_)
            ),
        );
    }
    let program = Program {
        name: constant.name.clone(),
        inputs: Vec::new(),
        arguments: Vec::new(),
        argument_types: Vec::new(),
        result_types: declarations.words(&value.type_),
        results: value.slots,
        initial: builder.initial,
        is_constant: builder.is_constant,
        steps,
        places: builder.places,
    };
    let words = Machine::new(&program)
        .call(&[])
        .map(<[i128]>::to_vec)
        .map_err(|trap| SourceError {
            place: trap.place,
            message: trap.message,
        })?;
    constants.insert(number, words.clone());
    Ok(words)
}
