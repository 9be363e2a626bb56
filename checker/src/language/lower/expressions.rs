//! Expressions: names, literals, arrays, structs; the others by their files.

use std::collections::HashMap;

use syn::spanned::Spanned;

use crate::language::declarations::{Named, Read, refuse, shown};
use crate::language::lower::builder::{Builder, Scope, Value};
use crate::language::lower::programs;
use crate::program::steps::ProgramStep;
use crate::program::types::{Integer, Type};

impl Builder<'_> {
    pub(super) fn expression(
        &mut self,
        scope: &mut Scope,
        expression: &syn::Expr,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let unit = Value {
            type_: Type::Tuple(Vec::new()),
            slots: Vec::new(),
        };
        let keeps_tail = matches!(
            expression,
            syn::Expr::If(_) | syn::Expr::Match(_) | syn::Expr::Block(_)
        );
        if scope.is_tail && !keeps_tail {
            scope.is_tail = false;
            let value = self.expression(scope, expression, expected, steps);
            scope.is_tail = true;
            return value;
        }
        match expression {
            syn::Expr::Paren(inner) => self.expression(scope, &inner.expr, expected, steps),
            syn::Expr::Group(inner) => self.expression(scope, &inner.expr, expected, steps),
            syn::Expr::Reference(inner) if inner.mutability.is_none() => {
                self.expression(scope, &inner.expr, expected, steps)
            }
            syn::Expr::Block(inner) if inner.label.is_none() => {
                self.block(scope, &inner.block, expected, steps)
            }
            syn::Expr::Lit(literal) => self.literal(scope, literal, false, expected),
            syn::Expr::Unary(unary) => self.unary(scope, unary, expected, steps),
            syn::Expr::Binary(binary) => self.binary(scope, binary, steps),
            syn::Expr::Cast(cast) => self.cast(scope, cast, steps),
            syn::Expr::Path(path) => self.name(scope, path, expected),
            syn::Expr::Field(_) => {
                let syn::Expr::Field(field) = expression else {
                    return Ok(unit);
                };
                let base = self.expression(scope, &field.base, None, steps)?;
                let (offset, type_) = self.field(scope, &base.type_, &field.member)?;
                let width = self.declarations.width(&type_);
                Ok(Value {
                    type_,
                    slots: base.slots[offset..offset + width].to_vec(),
                })
            }
            syn::Expr::Index(index) => {
                let base = self.expression(scope, &index.expr, None, steps)?;
                let Type::Array(element, length) = &base.type_ else {
                    return refuse(
                        &scope.path,
                        index.span(),
                        format!(
                            "a {} has no elements",
                            self.declarations.type_name(&base.type_)
                        ),
                    );
                };
                let position = match &*index.index {
                    syn::Expr::Lit(literal) => match &literal.lit {
                        syn::Lit::Int(integer) => integer.base10_parse::<usize>().ok(),
                        _ => None,
                    },
                    _ => None,
                };
                let Some(position) = position.filter(|position| position < length) else {
                    return refuse(
                        &scope.path,
                        index.index.span(),
                        format!(
                            "found the index {}; it is a literal below {length}",
                            shown(&index.index)
                        ),
                    );
                };
                let width = self.declarations.width(element);
                Ok(Value {
                    type_: (**element).clone(),
                    slots: base.slots[position * width..(position + 1) * width].to_vec(),
                })
            }
            syn::Expr::Array(array) => self.array(scope, array, expected, steps),
            syn::Expr::Tuple(tuple) => {
                let mut value = unit;
                let mut types = Vec::new();
                for (index, element) in tuple.elems.iter().enumerate() {
                    let wanted = match expected {
                        Some(Type::Tuple(types)) => types.get(index),
                        _ => None,
                    };
                    let part = self.expression(scope, element, wanted, steps)?;
                    types.push(part.type_);
                    value.slots.extend(part.slots);
                }
                value.type_ = Type::Tuple(types);
                Ok(value)
            }
            syn::Expr::Struct(literal) => self.struct_literal(scope, literal, steps),
            syn::Expr::If(choice) => self.if_expression(scope, choice, expected, steps),
            syn::Expr::Match(choice) => self.match_option(scope, choice, expected, steps),
            syn::Expr::Call(call) => self.call(scope, call, expected, steps),
            syn::Expr::MethodCall(call) => self.method_call(scope, call, expected, steps),
            syn::Expr::Assign(assign) => {
                let (variable, offset, type_) = self.target(scope, &assign.left)?;
                let value = self.expression(scope, &assign.right, Some(&type_), steps)?;
                self.require(scope, assign.right.span(), &type_, &value.type_)?;
                let slots = &mut scope.variables[variable].1.slots;
                slots.splice(offset..offset + value.slots.len(), value.slots);
                Ok(unit)
            }
            other => refuse(
                &scope.path,
                other.span(),
                format!(
                    "found {}; emitted code has no such expression",
                    shown(other)
                ),
            ),
        }
    }

    pub(super) fn literal(
        &mut self,
        scope: &Scope,
        literal: &syn::ExprLit,
        is_negative: bool,
        expected: Option<&Type>,
    ) -> Read<Value> {
        match &literal.lit {
            syn::Lit::Int(integer) => {
                let type_ = match (integer.suffix(), expected) {
                    ("", Some(Type::Integer(type_))) => Some(*type_),
                    ("", _) => None,
                    (suffix, _) => Integer::named(suffix),
                };
                let Some(type_) = type_ else {
                    return refuse(
                        &scope.path,
                        literal.span(),
                        format!("the type of {} is not clear here", shown(literal)),
                    );
                };
                let value = integer.base10_parse::<i128>().ok();
                let value = value.map(|value| if is_negative { -value } else { value });
                match value.filter(|value| type_.holds(*value)) {
                    Some(value) => Ok(Value {
                        type_: Type::Integer(type_),
                        slots: vec![self.known(value)],
                    }),
                    None => refuse(
                        &scope.path,
                        literal.span(),
                        format!(
                            "{} is no {}",
                            shown(literal),
                            self.declarations.type_name(&Type::Integer(type_))
                        ),
                    ),
                }
            }
            syn::Lit::Bool(value) if !is_negative => Ok(Value {
                type_: Type::Bool,
                slots: vec![self.known(i128::from(value.value))],
            }),
            _ => refuse(
                &scope.path,
                literal.span(),
                format!("found {}; literals are integers", shown(literal)),
            ),
        }
    }

    pub(super) fn name(
        &mut self,
        scope: &Scope,
        path: &syn::ExprPath,
        expected: Option<&Type>,
    ) -> Read<Value> {
        let segments: Vec<_> = path
            .path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        match segments.as_slice() {
            [name] => {
                if let Some((_, value)) = scope.variables.iter().rev().find(|(n, _)| n == name) {
                    return Ok(value.clone());
                }
                if name == "None"
                    && let Some(Type::Option(content)) = expected
                {
                    let width = self.declarations.width(content);
                    let zero = self.known(0);
                    return Ok(Value {
                        type_: Type::Option(content.clone()),
                        slots: vec![zero; width + 1],
                    });
                }
                if let Some(Named::Constant(number)) =
                    self.declarations.files[scope.module].names.get(name)
                {
                    return self.constant(scope, *number, path.span());
                }
            }
            [type_, end] if end == "MAX" || end == "MIN" => {
                if let Some(integer) = Integer::named(type_) {
                    let value = if end == "MAX" {
                        integer.max()
                    } else {
                        integer.min()
                    };
                    return Ok(Value {
                        type_: Type::Integer(integer),
                        slots: vec![self.known(value)],
                    });
                }
            }
            [type_, variant] => {
                let found = self.declarations.variant(scope.module, type_, variant);
                if let Some((type_, value)) = found {
                    return Ok(Value {
                        type_,
                        slots: vec![self.known(value)],
                    });
                }
            }
            _ => {}
        }
        refuse(
            &scope.path,
            path.span(),
            format!("{} is not known here", shown(path)),
        )
    }

    pub(super) fn constant(
        &mut self,
        scope: &Scope,
        number: usize,
        span: proc_macro2::Span,
    ) -> Read<Value> {
        let id = usize::MAX - number;
        if self.stack.contains(&id) || self.stack.len() > 64 {
            return refuse(&scope.path, span, "a constant that needs itself".to_owned());
        }
        let declarations = self.declarations;
        let words = if let Some(words) = self.constants.get(&number) {
            words.clone()
        } else {
            // Its own constants are computed first; the depth of `stack` bounds the recursion.
            let mut inner = Builder::new(declarations, self.constants, self.contracts);
            inner.stack = self.stack.clone();
            inner.stack.push(id);
            inner.constant_words(number)?
        };
        Ok(Value {
            type_: declarations.constants[number].type_.clone(),
            slots: words.into_iter().map(|word| self.known(word)).collect(),
        })
    }

    pub(super) fn constant_words(&mut self, number: usize) -> Read<Vec<i128>> {
        programs::constant(self.declarations, self.constants, number)
    }

    pub(super) fn array(
        &mut self,
        scope: &mut Scope,
        array: &syn::ExprArray,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let wanted = match expected {
            Some(Type::Array(element, _)) => Some((**element).clone()),
            _ => array
                .elems
                .iter()
                .find_map(|element| self.type_of(scope, element)),
        };
        let mut slots = Vec::new();
        let mut element_type = None;
        for element in &array.elems {
            let value = self.expression(scope, element, wanted.as_ref(), steps)?;
            if let Some(type_) = &element_type {
                self.require(scope, element.span(), type_, &value.type_)?;
            }
            element_type = Some(value.type_);
            slots.extend(value.slots);
        }
        let Some(element_type) = element_type else {
            return refuse(&scope.path, array.span(), "an empty array".to_owned());
        };
        Ok(Value {
            type_: Type::Array(Box::new(element_type), array.elems.len()),
            slots,
        })
    }

    pub(super) fn struct_literal(
        &mut self,
        scope: &mut Scope,
        literal: &syn::ExprStruct,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let Some(number) = self.struct_number(scope, &literal.path) else {
            return refuse(
                &scope.path,
                literal.path.span(),
                format!("{} is no struct of this crate", shown(&literal.path)),
            );
        };
        if let Some(rest) = &literal.rest {
            return refuse(
                &scope.path,
                rest.span(),
                "a struct is written with all its fields".to_owned(),
            );
        }
        let declarations = self.declarations;
        let fields = &declarations.structs[number].fields;
        let mut values: HashMap<String, Value> = HashMap::new();
        for given in &literal.fields {
            let name = match &given.member {
                syn::Member::Named(name) => name.to_string(),
                syn::Member::Unnamed(index) => index.index.to_string(),
            };
            let Some((_, type_)) = fields.iter().find(|(field, _)| *field == name) else {
                return refuse(
                    &scope.path,
                    given.span(),
                    format!(
                        "`{}` has no field `{name}`",
                        declarations.structs[number].name
                    ),
                );
            };
            let value = self.expression(scope, &given.expr, Some(type_), steps)?;
            self.require(scope, given.expr.span(), type_, &value.type_)?;
            values.insert(name, value);
        }
        let mut slots = Vec::new();
        for (name, _) in fields {
            let Some(value) = values.remove(name) else {
                return refuse(
                    &scope.path,
                    literal.span(),
                    format!("the field `{name}` is missing"),
                );
            };
            slots.extend(value.slots);
        }
        Ok(Value {
            type_: Type::Struct(number),
            slots,
        })
    }

    pub(super) fn tuple_struct(
        &mut self,
        scope: &mut Scope,
        number: usize,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let declarations = self.declarations;
        let fields = &declarations.structs[number].fields;
        if fields.len() != arguments.len()
            || fields
                .iter()
                .any(|(name, _)| name.parse::<usize>().is_err())
        {
            return refuse(
                &scope.path,
                span,
                format!(
                    "`{}` is not built like this",
                    declarations.structs[number].name
                ),
            );
        }
        let mut slots = Vec::new();
        for ((_, type_), argument) in fields.iter().zip(arguments) {
            let value = self.expression(scope, argument, Some(type_), steps)?;
            self.require(scope, argument.span(), type_, &value.type_)?;
            slots.extend(value.slots);
        }
        Ok(Value {
            type_: Type::Struct(number),
            slots,
        })
    }
}
