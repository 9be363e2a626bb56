//! Calls: those of functions and methods of the crate, which are inlined, and the few others that the
//! language has.

use syn::spanned::Spanned;

use crate::language::declarations::{Named, Read, refuse, shown};
use crate::language::lower::builder::{Builder, Scope, Value};
use crate::program::steps::{Action, Arithmetic, ProgramStep, Slot, WordComparison};
use crate::program::types::{Integer, Type};

impl Builder<'_> {
    pub(super) fn call(
        &mut self,
        scope: &mut Scope,
        call: &syn::ExprCall,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let unknown = format!("{} is no function of this crate", shown(&call.func));
        let syn::Expr::Path(path) = &*call.func else {
            return refuse(&scope.path, call.func.span(), unknown);
        };
        let segments: Vec<_> = path
            .path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        let arguments: Vec<&syn::Expr> = call.args.iter().collect();
        match segments.as_slice() {
            [name] if name == "Some" && arguments.len() == 1 => {
                let wanted = match expected {
                    Some(Type::Option(content)) => Some((**content).clone()),
                    _ => None,
                };
                let value = self.expression(scope, arguments[0], wanted.as_ref(), steps)?;
                let mut slots = vec![self.known(1)];
                slots.extend(value.slots);
                Ok(Value {
                    type_: Type::Option(Box::new(value.type_)),
                    slots,
                })
            }
            [name] => match self.declarations.files[scope.module]
                .names
                .get(name)
                .cloned()
            {
                Some(Named::Function(number)) => {
                    self.invoke(scope, number, None, &arguments, call.span(), steps)
                }
                Some(Named::Type(Type::Struct(number))) => {
                    self.tuple_struct(scope, number, &arguments, call.span(), steps)
                }
                _ => refuse(&scope.path, call.func.span(), unknown),
            },
            [type_, name] => {
                if let (Some(to), "from", [argument]) =
                    (Integer::named(type_), name.as_str(), arguments.as_slice())
                {
                    let value = self.expression(scope, argument, None, steps)?;
                    if let Type::Integer(from) = &value.type_
                        && to.holds(from.min())
                        && to.holds(from.max())
                    {
                        return self.converted(
                            scope,
                            call.span(),
                            value,
                            &Type::Integer(to),
                            steps,
                        );
                    }
                    return self.mismatch(scope, argument.span(), &Type::Integer(to), &value.type_);
                }
                let named = if type_ == "Self" {
                    scope.owner.map(|owner| Named::Type(Type::Struct(owner)))
                } else {
                    self.declarations.files[scope.module]
                        .names
                        .get(type_)
                        .cloned()
                };
                match (named, arguments.as_slice()) {
                    (Some(Named::Type(type_ @ Type::Fixed(_))), [argument])
                        if name == "from_bits" =>
                    {
                        let word = Type::Integer(Integer::I32);
                        let value = self.expression(scope, argument, Some(&word), steps)?;
                        self.require(scope, argument.span(), &word, &value.type_)?;
                        Ok(Value {
                            type_,
                            slots: value.slots,
                        })
                    }
                    (Some(Named::Type(Type::Struct(owner))), _) => {
                        let found = self.declarations.methods.get(&(owner, name.clone()));
                        match found {
                            Some(number) => {
                                self.invoke(scope, *number, None, &arguments, call.span(), steps)
                            }
                            None => refuse(&scope.path, call.func.span(), unknown),
                        }
                    }
                    _ => refuse(&scope.path, call.func.span(), unknown),
                }
            }
            _ => refuse(&scope.path, call.func.span(), unknown),
        }
    }

    /// Calls a function of the crate, with the receiver's value and place if it is a method.
    pub(super) fn invoke(
        &mut self,
        scope: &mut Scope,
        number: usize,
        receiver: Option<(Value, Option<(usize, usize)>)>,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let declarations = self.declarations;
        let function = &declarations.functions[number];
        if !function.is_public && function.module != scope.module {
            let message = format!("`{}` is private to another file", function.name);
            return refuse(&scope.path, span, message);
        }
        let mut values = Vec::new();
        let mut targets = Vec::new();
        if let Some((value, target)) = receiver {
            values.push(value);
            targets.push(target);
        }
        if values.len() + arguments.len() != function.arguments.len() {
            return refuse(
                &scope.path,
                span,
                format!(
                    "`{}` takes {} arguments",
                    function.name,
                    function.arguments.len()
                ),
            );
        }
        for argument in arguments {
            let declared = &function.arguments[values.len()];
            if declared.is_mutable {
                return refuse(
                    &scope.path,
                    argument.span(),
                    "only a receiver is passed as `&mut`".to_owned(),
                );
            }
            let value = self.expression(scope, argument, Some(&declared.type_), steps)?;
            values.push(value);
            targets.push(None);
        }
        for (index, (value, declared)) in values.iter().zip(&function.arguments).enumerate() {
            if value.type_ != declared.type_ {
                let span = arguments
                    .get(index + arguments.len() - values.len())
                    .map_or(span, |argument| argument.span());
                return self.mismatch(scope, span, &declared.type_, &value.type_);
            }
        }
        if let Some(contract) = self.contracts.get(&number) {
            let slots: Vec<Slot> = values
                .iter()
                .flat_map(|value| value.slots.clone())
                .collect();
            let result = self.fresh(&function.result);
            let place = self.at(scope, span);
            steps.push(ProgramStep {
                action: Action::Contract {
                    function: function.name.clone(),
                    requires: contract.applied(&contract.requires, &slots),
                    ensures: contract
                        .promised(&declarations.words(&function.result), &result.slots),
                },
                place,
            });
            return Ok(result);
        }
        let (result, mutated) = self.body(number, values, steps)?;
        let places = function
            .arguments
            .iter()
            .zip(targets)
            .filter(|(argument, _)| argument.is_mutable)
            .map(|(_, target)| target);
        for (value, target) in mutated.into_iter().zip(places) {
            let Some((variable, offset)) = target else {
                return refuse(
                    &scope.path,
                    span,
                    "a changed value that has no place".to_owned(),
                );
            };
            let slots = &mut scope.variables[variable].1.slots;
            slots.splice(offset..offset + value.slots.len(), value.slots);
        }
        Ok(result)
    }

    pub(super) fn method_call(
        &mut self,
        scope: &mut Scope,
        call: &syn::ExprMethodCall,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let name = call.method.to_string();
        let arguments: Vec<&syn::Expr> = call.args.iter().collect();
        let receiver = self.expression(scope, &call.receiver, expected, steps)?;
        match (&receiver.type_, name.as_str(), arguments.as_slice()) {
            (Type::Fixed(_), "to_bits", []) => {
                return Ok(Value {
                    type_: Type::Integer(Integer::I32),
                    slots: receiver.slots,
                });
            }
            (Type::Integer(_), "clamp", [low, high]) => {
                let type_ = receiver.type_.clone();
                let low_value = self.expression(scope, low, Some(&type_), steps)?;
                self.require(scope, low.span(), &type_, &low_value.type_)?;
                let high_value = self.expression(scope, high, Some(&type_), steps)?;
                self.require(scope, high.span(), &type_, &high_value.type_)?;
                let to = self.slot();
                let place = self.at(scope, call.method.span());
                steps.push(ProgramStep {
                    action: Action::Clamp {
                        to,
                        a: receiver.slots[0],
                        low: low_value.slots[0],
                        high: high_value.slots[0],
                    },
                    place,
                });
                return Ok(Value {
                    type_,
                    slots: vec![to],
                });
            }
            (Type::Integer(_), "abs", []) if scope.is_assertion => {
                let zero = Value {
                    type_: receiver.type_.clone(),
                    slots: vec![self.known(0)],
                };
                let test = self.slot();
                let place = self.at(scope, call.method.span());
                steps.push(ProgramStep {
                    action: Action::Compare {
                        to: test,
                        comparison: WordComparison::Less,
                        a: receiver.slots[0],
                        b: zero.slots[0],
                    },
                    place,
                });
                let same = receiver.clone();
                return self.choice_on(
                    scope,
                    test,
                    call.method.span(),
                    steps,
                    |builder, scope, steps| {
                        let span = call.method.span();
                        builder.arithmetic(scope, span, Arithmetic::Subtract, zero, receiver, steps)
                    },
                    |_, _, _| Ok(same),
                );
            }
            (Type::Struct(owner), _, _) => {
                if let Some(number) = self.declarations.methods.get(&(*owner, name.clone())) {
                    let is_mutable = self.declarations.functions[*number]
                        .arguments
                        .first()
                        .is_some_and(|argument| argument.is_mutable);
                    let target = if is_mutable {
                        let (variable, offset, _) = self.target(scope, &call.receiver)?;
                        Some((variable, offset))
                    } else {
                        None
                    };
                    let number = *number;
                    return self.invoke(
                        scope,
                        number,
                        Some((receiver, target)),
                        &arguments,
                        call.span(),
                        steps,
                    );
                }
            }
            _ => {}
        }
        refuse(
            &scope.path,
            call.method.span(),
            format!(
                "found `.{name}()` of a {}; methods are to_bits, clamp and those of the crate",
                self.declarations.type_name(&receiver.type_)
            ),
        )
    }
}
