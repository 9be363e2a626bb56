//! From the body of a function to a [`Program`]: types are checked, names resolved, calls put in
//! place, and every construct that is not understood is refused with its place.

use std::collections::HashMap;
use std::sync::Arc;

use syn::spanned::Spanned;

use crate::domains::machine::Machine;
use crate::language::declarations::{Declarations, Named, Read, refuse, shown};
use crate::program::contract::Contract;
use crate::program::place::{Place, SourceError};
use crate::program::steps::{Action, Arithmetic, Comparison, Join, Program, Slot, Step};
use crate::program::types::{Integer, Type};

/// The words of a value.
#[derive(Clone, Debug)]
struct Value {
    type_: Type,
    slots: Vec<Slot>,
}

/// What is known while the body of one function is read.
#[derive(Clone, Debug)]
struct Scope {
    module: usize,
    path: Arc<str>,
    owner: Option<usize>,
    variables: Vec<(String, Value)>,
    /// `assert!`, `abs` and `i128` are for constants that assert something.
    is_assertion: bool,
    /// Whether the value of what is read is the value of the function: only there is `return`
    /// what this reader takes it for.
    is_tail: bool,
}

/// Values of the constants, computed when first needed.
pub type Constants = HashMap<usize, Vec<i128>>;

/// Builds one program.
struct Builder<'a> {
    declarations: &'a Declarations,
    constants: &'a mut Constants,
    contracts: &'a HashMap<usize, Contract>,
    initial: Vec<i128>,
    is_constant: Vec<bool>,
    pool: HashMap<i128, Slot>,
    places: Vec<Place>,
    /// Functions that are being put in place, against recursion.
    stack: Vec<usize>,
}

/// More steps than this come from calls that multiply, not from a controller.
const LARGEST_PROGRAM: usize = 200_000;

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

impl<'a> Builder<'a> {
    fn new(
        declarations: &'a Declarations,
        constants: &'a mut Constants,
        contracts: &'a HashMap<usize, Contract>,
    ) -> Self {
        Builder {
            declarations,
            constants,
            contracts,
            initial: Vec::new(),
            is_constant: Vec::new(),
            pool: HashMap::new(),
            places: Vec::new(),
            stack: Vec::new(),
        }
    }

    fn slot(&mut self) -> Slot {
        self.initial.push(0);
        self.is_constant.push(false);
        self.initial.len() - 1
    }

    fn fresh(&mut self, type_: &Type) -> Value {
        let width = self.declarations.width(type_);
        Value {
            type_: type_.clone(),
            slots: (0..width).map(|_| self.slot()).collect(),
        }
    }

    fn known(&mut self, value: i128) -> Slot {
        if let Some(slot) = self.pool.get(&value) {
            return *slot;
        }
        let slot = self.slot();
        self.initial[slot] = value;
        self.is_constant[slot] = true;
        self.pool.insert(value, slot);
        slot
    }

    fn at(&mut self, scope: &Scope, span: proc_macro2::Span) -> u32 {
        self.places.push(Place::of(&scope.path, span));
        u32::try_from(self.places.len() - 1).unwrap_or(u32::MAX)
    }

    /// Puts the body of a function in place; returns its result and its `&mut` arguments.
    fn body(
        &mut self,
        number: usize,
        arguments: Vec<Value>,
        steps: &mut Vec<Step>,
    ) -> Read<(Value, Vec<Value>)> {
        let declarations = self.declarations;
        let function = &declarations.functions[number];
        if self.stack.contains(&number) {
            return Err(SourceError {
                place: function.place.clone(),
                message: format!("`{}` calls itself", function.name),
            });
        }
        if self.places.len() > LARGEST_PROGRAM {
            return Err(SourceError {
                place: function.place.clone(),
                message: format!("more than {LARGEST_PROGRAM} steps"),
            });
        }
        self.stack.push(number);
        let mut scope = Scope {
            module: function.module,
            path: declarations.files[function.module].path.clone(),
            owner: function.owner,
            variables: function
                .arguments
                .iter()
                .map(|argument| argument.name.clone())
                .zip(arguments)
                .collect(),
            is_assertion: false,
            is_tail: true,
        };
        let result = self.statements(
            &mut scope,
            &function.body.stmts,
            Some(&function.result),
            steps,
        )?;
        if result.type_ != function.result {
            return refuse(
                &scope.path,
                function.body.brace_token.span.close(),
                format!(
                    "`{}` returns a {}, its body is a {}",
                    function.name,
                    declarations.type_name(&function.result),
                    declarations.type_name(&result.type_)
                ),
            );
        }
        self.stack.pop();
        let mutated = function
            .arguments
            .iter()
            .zip(&scope.variables)
            .filter(|(argument, _)| argument.is_mutable)
            .map(|(_, (_, value))| value.clone())
            .collect();
        Ok((result, mutated))
    }

    fn block(
        &mut self,
        scope: &mut Scope,
        block: &syn::Block,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let outside = scope.variables.len();
        let value = self.statements(scope, &block.stmts, expected, steps)?;
        scope.variables.truncate(outside);
        Ok(value)
    }

    fn statements(
        &mut self,
        scope: &mut Scope,
        statements: &[syn::Stmt],
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let unit = Value {
            type_: Type::Tuple(Vec::new()),
            slots: Vec::new(),
        };
        for (index, statement) in statements.iter().enumerate() {
            let is_last = index + 1 == statements.len();
            match statement {
                syn::Stmt::Local(local) => {
                    let is_tail = std::mem::replace(&mut scope.is_tail, false);
                    self.binding(scope, local, steps)?;
                    scope.is_tail = is_tail;
                }
                syn::Stmt::Expr(syn::Expr::Return(value), _) if is_last && scope.is_tail => {
                    return self.returned(scope, value, expected, steps);
                }
                syn::Stmt::Expr(syn::Expr::If(choice), _)
                    if scope.is_tail
                        && choice.else_branch.is_none()
                        && returns(&choice.then_branch) =>
                {
                    // if c { return x; } rest   is   if c { x } else { rest }
                    let rest = &statements[index + 1..];
                    return self.choice(
                        scope,
                        &choice.cond,
                        choice.if_token.span,
                        steps,
                        |builder, scope, steps| {
                            builder.block(scope, &choice.then_branch, expected, steps)
                        },
                        |builder, scope, steps| builder.statements(scope, rest, expected, steps),
                    );
                }
                syn::Stmt::Expr(expression, None) if is_last => {
                    return self.expression(scope, expression, expected, steps);
                }
                syn::Stmt::Expr(expression, _) => {
                    let is_tail = std::mem::replace(&mut scope.is_tail, false);
                    let value = self.expression(scope, expression, None, steps)?;
                    scope.is_tail = is_tail;
                    let is_effect = matches!(
                        expression,
                        syn::Expr::Assign(_)
                            | syn::Expr::MethodCall(_)
                            | syn::Expr::If(_)
                            | syn::Expr::Match(_)
                    );
                    if !is_effect || value.type_ != unit.type_ {
                        return refuse(
                            &scope.path,
                            expression.span(),
                            format!("found {}; its value is not used", shown(expression)),
                        );
                    }
                }
                syn::Stmt::Macro(call) if scope.is_assertion => {
                    self.assertion(scope, call, steps)?;
                }
                other => {
                    return refuse(
                        &scope.path,
                        other.span(),
                        format!(
                            "found {}; a body holds `let`, assignments and a final expression",
                            shown(other)
                        ),
                    );
                }
            }
        }
        Ok(unit)
    }

    fn returned(
        &mut self,
        scope: &mut Scope,
        value: &syn::ExprReturn,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        match &value.expr {
            Some(expression) => self.expression(scope, expression, expected, steps),
            None => refuse(
                &scope.path,
                value.span(),
                "`return` needs a value".to_owned(),
            ),
        }
    }

    fn binding(
        &mut self,
        scope: &mut Scope,
        local: &syn::Local,
        steps: &mut Vec<Step>,
    ) -> Read<()> {
        let Some(init) = local.init.as_ref().filter(|init| init.diverge.is_none()) else {
            return refuse(
                &scope.path,
                local.span(),
                format!("found {}; `let` gives a value", shown(local)),
            );
        };
        let (pattern, type_) = match &local.pat {
            syn::Pat::Type(typed) => (
                &*typed.pat,
                Some(
                    self.declarations
                        .type_(scope.module, &scope.path, &typed.ty)?,
                ),
            ),
            other => (other, None),
        };
        let value = self.expression(scope, &init.expr, type_.as_ref(), steps)?;
        if let Some(type_) = type_
            && type_ != value.type_
        {
            return self.mismatch(scope, init.expr.span(), &type_, &value.type_);
        }
        self.pattern(scope, pattern, value)
    }

    fn pattern(&mut self, scope: &mut Scope, pattern: &syn::Pat, value: Value) -> Read<()> {
        match pattern {
            syn::Pat::Ident(name) if name.subpat.is_none() && name.by_ref.is_none() => {
                scope.variables.push((name.ident.to_string(), value));
                Ok(())
            }
            syn::Pat::Tuple(tuple) => {
                let Type::Tuple(types) = &value.type_ else {
                    return refuse(
                        &scope.path,
                        tuple.span(),
                        format!(
                            "a {} is no tuple",
                            self.declarations.type_name(&value.type_)
                        ),
                    );
                };
                if types.len() != tuple.elems.len() {
                    return refuse(
                        &scope.path,
                        tuple.span(),
                        format!("{} names for {} values", tuple.elems.len(), types.len()),
                    );
                }
                let mut offset = 0;
                for (pattern, type_) in tuple.elems.iter().zip(types) {
                    let width = self.declarations.width(type_);
                    let part = Value {
                        type_: type_.clone(),
                        slots: value.slots[offset..offset + width].to_vec(),
                    };
                    offset += width;
                    self.pattern(scope, pattern, part)?;
                }
                Ok(())
            }
            other => refuse(
                &scope.path,
                other.span(),
                format!(
                    "found {}; `let` takes names and tuples of names",
                    shown(other)
                ),
            ),
        }
    }

    fn assertion(
        &mut self,
        scope: &mut Scope,
        call: &syn::StmtMacro,
        steps: &mut Vec<Step>,
    ) -> Read<()> {
        let arguments = call
            .mac
            .parse_body_with(
                syn::punctuated::Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated,
            )
            .ok()
            .filter(|arguments| call.mac.path.is_ident("assert") && arguments.len() <= 2);
        let Some((condition, message)) =
            arguments.and_then(|list| Some((list.first()?.clone(), list.get(1).map(shown))))
        else {
            return refuse(
                &scope.path,
                call.span(),
                format!(
                    "found {}; only assert!(condition, \"message\") may stand here",
                    shown(call)
                ),
            );
        };
        let value = self.expression(scope, &condition, Some(&Type::Bool), steps)?;
        self.require(scope, condition.span(), &Type::Bool, &value.type_)?;
        let place = self.at(scope, call.span());
        steps.push(Step {
            action: Action::Assert {
                a: value.slots[0],
                message: message.unwrap_or_else(|| shown(&condition)),
            },
            place,
        });
        Ok(())
    }

    fn mismatch<T>(
        &self,
        scope: &Scope,
        span: proc_macro2::Span,
        expected: &Type,
        found: &Type,
    ) -> Read<T> {
        refuse(
            &scope.path,
            span,
            format!(
                "a {} is expected, found a {}",
                self.declarations.type_name(expected),
                self.declarations.type_name(found)
            ),
        )
    }

    fn require(
        &self,
        scope: &Scope,
        span: proc_macro2::Span,
        expected: &Type,
        found: &Type,
    ) -> Read<()> {
        if expected == found {
            Ok(())
        } else {
            self.mismatch(scope, span, expected, found)
        }
    }

    /// A condition and two sides, which meet in new slots.
    fn choice(
        &mut self,
        scope: &mut Scope,
        condition: &syn::Expr,
        span: proc_macro2::Span,
        steps: &mut Vec<Step>,
        then: impl FnOnce(&mut Self, &mut Scope, &mut Vec<Step>) -> Read<Value>,
        otherwise: impl FnOnce(&mut Self, &mut Scope, &mut Vec<Step>) -> Read<Value>,
    ) -> Read<Value> {
        let is_tail = std::mem::replace(&mut scope.is_tail, false);
        let test = self.expression(scope, condition, Some(&Type::Bool), steps)?;
        scope.is_tail = is_tail;
        self.require(scope, condition.span(), &Type::Bool, &test.type_)?;
        self.choice_on(scope, test.slots[0], span, steps, then, otherwise)
    }

    fn choice_on(
        &mut self,
        scope: &mut Scope,
        condition: Slot,
        span: proc_macro2::Span,
        steps: &mut Vec<Step>,
        then: impl FnOnce(&mut Self, &mut Scope, &mut Vec<Step>) -> Read<Value>,
        otherwise: impl FnOnce(&mut Self, &mut Scope, &mut Vec<Step>) -> Read<Value>,
    ) -> Read<Value> {
        let outside = scope.variables.len();
        let mut then_scope = scope.clone();
        let mut then_steps = Vec::new();
        let mut one = then(self, &mut then_scope, &mut then_steps)?;
        let mut else_scope = scope.clone();
        let mut else_steps = Vec::new();
        let other = otherwise(self, &mut else_scope, &mut else_steps)?;
        if one.type_ != other.type_ {
            return self.mismatch(scope, span, &one.type_, &other.type_);
        }
        let mut joins = Vec::new();
        let mut join = |builder: &mut Self, a: &mut Slot, b: Slot| {
            if *a != b {
                let to = builder.slot();
                joins.push(Join {
                    to,
                    then: *a,
                    otherwise: b,
                });
                *a = to;
            }
        };
        for (a, b) in one.slots.iter_mut().zip(&other.slots) {
            join(self, a, *b);
        }
        then_scope.variables.truncate(outside);
        for (index, (_, value)) in then_scope.variables.iter_mut().enumerate() {
            let other = &else_scope.variables[index].1;
            for (a, b) in value.slots.iter_mut().zip(&other.slots) {
                join(self, a, *b);
            }
        }
        scope.variables = then_scope.variables;
        let place = self.at(scope, span);
        steps.push(Step {
            action: Action::If {
                condition,
                then: then_steps,
                otherwise: else_steps,
                joins,
            },
            place,
        });
        Ok(one)
    }

    fn expression(
        &mut self,
        scope: &mut Scope,
        expression: &syn::Expr,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
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
            syn::Expr::Binary(binary) => self.binary(scope, binary, expected, steps),
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

    fn literal(
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

    fn unary(
        &mut self,
        scope: &mut Scope,
        unary: &syn::ExprUnary,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        match unary.op {
            syn::UnOp::Deref(_) => self.expression(scope, &unary.expr, expected, steps),
            syn::UnOp::Neg(_) => {
                if let syn::Expr::Lit(literal) = &*unary.expr {
                    return self.literal(scope, literal, true, expected);
                }
                let value = self.expression(scope, &unary.expr, expected, steps)?;
                let zero = Value {
                    type_: value.type_.clone(),
                    slots: vec![self.known(0)],
                };
                self.arithmetic(
                    scope,
                    unary.span(),
                    Arithmetic::Subtract,
                    zero,
                    value,
                    steps,
                )
            }
            syn::UnOp::Not(_) => {
                let value = self.expression(scope, &unary.expr, Some(&Type::Bool), steps)?;
                self.require(scope, unary.expr.span(), &Type::Bool, &value.type_)?;
                let to = self.slot();
                let place = self.at(scope, unary.span());
                steps.push(Step {
                    action: Action::Not {
                        to,
                        a: value.slots[0],
                    },
                    place,
                });
                Ok(Value {
                    type_: Type::Bool,
                    slots: vec![to],
                })
            }
            _ => refuse(
                &scope.path,
                unary.span(),
                format!("found {}; emitted code has no such operator", shown(unary)),
            ),
        }
    }

    fn arithmetic(
        &mut self,
        scope: &Scope,
        span: proc_macro2::Span,
        operation: Arithmetic,
        a: Value,
        b: Value,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let is_shift = matches!(operation, Arithmetic::ShiftLeft | Arithmetic::ShiftRight);
        let (Type::Integer(type_), Type::Integer(_)) = (&a.type_, &b.type_) else {
            return refuse(
                &scope.path,
                span,
                format!(
                    "arithmetic on a {} and a {}; it is done on integers",
                    self.declarations.type_name(&a.type_),
                    self.declarations.type_name(&b.type_)
                ),
            );
        };
        if !is_shift && a.type_ != b.type_ {
            return self.mismatch(scope, span, &a.type_, &b.type_);
        }
        let type_ = *type_;
        let to = self.slot();
        let place = self.at(scope, span);
        steps.push(Step {
            action: Action::Arithmetic {
                to,
                operation,
                a: a.slots[0],
                b: b.slots[0],
                type_,
            },
            place,
        });
        Ok(Value {
            type_: a.type_,
            slots: vec![to],
        })
    }

    fn binary(
        &mut self,
        scope: &mut Scope,
        binary: &syn::ExprBinary,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let span = binary.op.span();
        if let syn::BinOp::And(_) | syn::BinOp::Or(_) = binary.op {
            let is_and = matches!(binary.op, syn::BinOp::And(_));
            let decided = Value {
                type_: Type::Bool,
                slots: vec![self.known(i128::from(!is_and))],
            };
            let right = |builder: &mut Self, scope: &mut Scope, steps: &mut Vec<Step>| {
                let value = builder.expression(scope, &binary.right, Some(&Type::Bool), steps)?;
                builder.require(scope, binary.right.span(), &Type::Bool, &value.type_)?;
                Ok(value)
            };
            let early = |_: &mut Self, _: &mut Scope, _: &mut Vec<Step>| Ok(decided);
            return if is_and {
                self.choice(scope, &binary.left, span, steps, right, early)
            } else {
                self.choice(scope, &binary.left, span, steps, early, right)
            };
        }
        let operation = match binary.op {
            syn::BinOp::Add(_) => Some(Arithmetic::Add),
            syn::BinOp::Sub(_) => Some(Arithmetic::Subtract),
            syn::BinOp::Mul(_) => Some(Arithmetic::Multiply),
            syn::BinOp::Shl(_) => Some(Arithmetic::ShiftLeft),
            syn::BinOp::Shr(_) => Some(Arithmetic::ShiftRight),
            syn::BinOp::BitAnd(_) => Some(Arithmetic::And),
            _ => None,
        };
        if let Some(operation) = operation {
            if matches!(operation, Arithmetic::ShiftLeft | Arithmetic::ShiftRight) {
                let type_ = self.type_of(scope, &binary.left).or(expected.cloned());
                let a = self.expression(scope, &binary.left, type_.as_ref(), steps)?;
                let amount = self
                    .type_of(scope, &binary.right)
                    .unwrap_or(Type::Integer(Integer::U32));
                let b = self.expression(scope, &binary.right, Some(&amount), steps)?;
                return self.arithmetic(scope, span, operation, a, b, steps);
            }
            let type_ = self
                .type_of(scope, &binary.left)
                .or_else(|| self.type_of(scope, &binary.right))
                .or(expected.cloned());
            let a = self.expression(scope, &binary.left, type_.as_ref(), steps)?;
            let b = self.expression(scope, &binary.right, type_.as_ref(), steps)?;
            return self.arithmetic(scope, span, operation, a, b, steps);
        }
        let (comparison, is_swapped) = match binary.op {
            syn::BinOp::Lt(_) => (Comparison::Less, false),
            syn::BinOp::Le(_) => (Comparison::LessEqual, false),
            syn::BinOp::Gt(_) => (Comparison::Less, true),
            syn::BinOp::Ge(_) => (Comparison::LessEqual, true),
            syn::BinOp::Eq(_) => (Comparison::Equal, false),
            syn::BinOp::Ne(_) => (Comparison::NotEqual, false),
            _ => {
                return refuse(
                    &scope.path,
                    span,
                    format!(
                        "found {}; operators are + - * << >> & && || ! and comparisons",
                        shown(&binary.op)
                    ),
                );
            }
        };
        let type_ = self
            .type_of(scope, &binary.left)
            .or_else(|| self.type_of(scope, &binary.right));
        let a = self.expression(scope, &binary.left, type_.as_ref(), steps)?;
        let b = self.expression(scope, &binary.right, type_.as_ref(), steps)?;
        let is_integer = matches!(a.type_, Type::Integer(_));
        if a.type_ != b.type_ || !is_integer {
            return self.mismatch(scope, span, &a.type_, &b.type_);
        }
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let to = self.slot();
        let place = self.at(scope, span);
        steps.push(Step {
            action: Action::Compare {
                to,
                comparison,
                a: a.slots[0],
                b: b.slots[0],
            },
            place,
        });
        Ok(Value {
            type_: Type::Bool,
            slots: vec![to],
        })
    }

    fn cast(
        &mut self,
        scope: &mut Scope,
        cast: &syn::ExprCast,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let type_ = self
            .declarations
            .type_(scope.module, &scope.path, &cast.ty)?;
        // A literal takes the type that it is cast to; everything else has its own.
        let inner = self.type_of(scope, &cast.expr).unwrap_or(type_.clone());
        let value = self.expression(scope, &cast.expr, Some(&inner), steps)?;
        self.converted(scope, cast.span(), value, &type_, steps)
    }

    fn converted(
        &mut self,
        scope: &Scope,
        span: proc_macro2::Span,
        value: Value,
        type_: &Type,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let (Type::Integer(from), Type::Integer(to_type)) = (&value.type_, type_) else {
            return refuse(
                &scope.path,
                span,
                format!(
                    "a cast from {} to {}; casts are between integers",
                    self.declarations.type_name(&value.type_),
                    self.declarations.type_name(type_)
                ),
            );
        };
        if to_type.bits == 128 && !scope.is_assertion {
            return refuse(
                &scope.path,
                span,
                "128 bits stand in assertions only".to_owned(),
            );
        }
        if to_type.holds(from.min()) && to_type.holds(from.max()) {
            return Ok(Value {
                type_: type_.clone(),
                slots: value.slots,
            });
        }
        let to = self.slot();
        let place = self.at(scope, span);
        steps.push(Step {
            action: Action::Cast {
                to,
                a: value.slots[0],
                type_: *to_type,
            },
            place,
        });
        Ok(Value {
            type_: type_.clone(),
            slots: vec![to],
        })
    }

    fn name(
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
            _ => {}
        }
        refuse(
            &scope.path,
            path.span(),
            format!("{} is not known here", shown(path)),
        )
    }

    fn constant(&mut self, scope: &Scope, number: usize, span: proc_macro2::Span) -> Read<Value> {
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

    fn constant_words(&mut self, number: usize) -> Read<Vec<i128>> {
        constant(self.declarations, self.constants, number)
    }

    fn field(&self, scope: &Scope, type_: &Type, member: &syn::Member) -> Read<(usize, Type)> {
        let name = match member {
            syn::Member::Named(name) => name.to_string(),
            syn::Member::Unnamed(index) => index.index.to_string(),
        };
        let fields: Vec<(String, Type)> = match type_ {
            Type::Struct(index) => self.declarations.structs[*index].fields.clone(),
            Type::Tuple(elements) => elements
                .iter()
                .enumerate()
                .map(|(index, type_)| (index.to_string(), type_.clone()))
                .collect(),
            _ => Vec::new(),
        };
        let mut offset = 0;
        for (field, type_) in fields {
            if field == name {
                return Ok((offset, type_));
            }
            offset += self.declarations.width(&type_);
        }
        refuse(
            &scope.path,
            member.span(),
            format!(
                "a {} has no field `{name}`",
                self.declarations.type_name(type_)
            ),
        )
    }

    /// What an assignment or a `&mut` receiver stands for: variable, offset and type.
    fn target(&self, scope: &Scope, expression: &syn::Expr) -> Read<(usize, usize, Type)> {
        match expression {
            syn::Expr::Path(path) => {
                if let Some(name) = path.path.get_ident()
                    && let Some(index) = scope.variables.iter().rposition(|(n, _)| name == n)
                {
                    return Ok((index, 0, scope.variables[index].1.type_.clone()));
                }
                refuse(
                    &scope.path,
                    path.span(),
                    format!("{} cannot be assigned to", shown(path)),
                )
            }
            syn::Expr::Field(field) => {
                let (variable, base, type_) = self.target(scope, &field.base)?;
                let (offset, type_) = self.field(scope, &type_, &field.member)?;
                Ok((variable, base + offset, type_))
            }
            other => refuse(
                &scope.path,
                other.span(),
                format!("{} cannot be assigned to", shown(other)),
            ),
        }
    }

    fn array(
        &mut self,
        scope: &mut Scope,
        array: &syn::ExprArray,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
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

    fn struct_number(&self, scope: &Scope, path: &syn::Path) -> Option<usize> {
        let name = path.get_ident()?.to_string();
        if name == "Self" {
            return scope.owner;
        }
        match self.declarations.files[scope.module].names.get(&name) {
            Some(Named::Type(Type::Struct(number))) => Some(*number),
            _ => None,
        }
    }

    fn struct_literal(
        &mut self,
        scope: &mut Scope,
        literal: &syn::ExprStruct,
        steps: &mut Vec<Step>,
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

    fn if_expression(
        &mut self,
        scope: &mut Scope,
        choice: &syn::ExprIf,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        self.choice(
            scope,
            &choice.cond,
            choice.if_token.span,
            steps,
            |builder, scope, steps| builder.block(scope, &choice.then_branch, expected, steps),
            |builder, scope, steps| match &choice.else_branch {
                Some((_, other)) => builder.expression(scope, other, expected, steps),
                None => Ok(Value {
                    type_: Type::Tuple(Vec::new()),
                    slots: Vec::new(),
                }),
            },
        )
    }

    /// `match x { Some(name) => …, None => … }`.
    fn match_option(
        &mut self,
        scope: &mut Scope,
        choice: &syn::ExprMatch,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let is_tail = std::mem::replace(&mut scope.is_tail, false);
        let value = self.expression(scope, &choice.expr, None, steps)?;
        scope.is_tail = is_tail;
        let mut some = None;
        let mut none = None;
        for arm in &choice.arms {
            match &arm.pat {
                syn::Pat::TupleStruct(pattern)
                    if pattern.path.is_ident("Some") && pattern.elems.len() == 1 =>
                {
                    if let Some(syn::Pat::Ident(name)) = pattern.elems.first() {
                        some = Some((name.ident.to_string(), &arm.body));
                    }
                }
                syn::Pat::Ident(name) if name.ident == "None" => none = Some(&arm.body),
                _ => {}
            }
        }
        let (Some((name, some)), Some(none), 2, Type::Option(content)) =
            (some, none, choice.arms.len(), &value.type_)
        else {
            return refuse(
                &scope.path,
                choice.span(),
                "a `match` has the two arms Some(name) and None".to_owned(),
            );
        };
        let inner = Value {
            type_: (**content).clone(),
            slots: value.slots[1..].to_vec(),
        };
        self.choice_on(
            scope,
            value.slots[0],
            choice.match_token.span,
            steps,
            |builder, scope, steps| {
                scope.variables.push((name, inner));
                let value = builder.expression(scope, some, expected, steps)?;
                scope.variables.pop();
                Ok(value)
            },
            |builder, scope, steps| builder.expression(scope, none, expected, steps),
        )
    }

    fn call(
        &mut self,
        scope: &mut Scope,
        call: &syn::ExprCall,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
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

    fn tuple_struct(
        &mut self,
        scope: &mut Scope,
        number: usize,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
        steps: &mut Vec<Step>,
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

    /// Calls a function of the crate, with the receiver's value and place if it is a method.
    fn invoke(
        &mut self,
        scope: &mut Scope,
        number: usize,
        receiver: Option<(Value, Option<(usize, usize)>)>,
        arguments: &[&syn::Expr],
        span: proc_macro2::Span,
        steps: &mut Vec<Step>,
    ) -> Read<Value> {
        let declarations = self.declarations;
        let function = &declarations.functions[number];
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
            steps.push(Step {
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

    fn method_call(
        &mut self,
        scope: &mut Scope,
        call: &syn::ExprMethodCall,
        expected: Option<&Type>,
        steps: &mut Vec<Step>,
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
                steps.push(Step {
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
                steps.push(Step {
                    action: Action::Compare {
                        to: test,
                        comparison: Comparison::Less,
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

    /// The type of an expression as far as it is plain without its surroundings: literals without
    /// a suffix take theirs from there.
    fn type_of(&self, scope: &Scope, expression: &syn::Expr) -> Option<Type> {
        match expression {
            syn::Expr::Paren(inner) => self.type_of(scope, &inner.expr),
            syn::Expr::Group(inner) => self.type_of(scope, &inner.expr),
            syn::Expr::Reference(inner) => self.type_of(scope, &inner.expr),
            syn::Expr::Unary(inner) => self.type_of(scope, &inner.expr),
            syn::Expr::Lit(literal) => match &literal.lit {
                syn::Lit::Int(integer) => Integer::named(integer.suffix()).map(Type::Integer),
                syn::Lit::Bool(_) => Some(Type::Bool),
                _ => None,
            },
            syn::Expr::Binary(binary) => match binary.op {
                syn::BinOp::Shl(_) | syn::BinOp::Shr(_) => self.type_of(scope, &binary.left),
                syn::BinOp::Add(_)
                | syn::BinOp::Sub(_)
                | syn::BinOp::Mul(_)
                | syn::BinOp::BitAnd(_) => self
                    .type_of(scope, &binary.left)
                    .or_else(|| self.type_of(scope, &binary.right)),
                _ => Some(Type::Bool),
            },
            syn::Expr::Cast(cast) => self
                .declarations
                .type_(scope.module, &scope.path, &cast.ty)
                .ok(),
            syn::Expr::Path(path) => {
                let segments: Vec<_> = path
                    .path
                    .segments
                    .iter()
                    .map(|segment| segment.ident.to_string())
                    .collect();
                match segments.as_slice() {
                    [name] => {
                        let variable = scope.variables.iter().rev().find(|(n, _)| n == name);
                        if let Some((_, value)) = variable {
                            return Some(value.type_.clone());
                        }
                        match self.declarations.files[scope.module].names.get(name)? {
                            Named::Constant(number) => {
                                Some(self.declarations.constants[*number].type_.clone())
                            }
                            _ => None,
                        }
                    }
                    [type_, _] => Integer::named(type_).map(Type::Integer),
                    _ => None,
                }
            }
            syn::Expr::Field(field) => {
                let base = self.type_of(scope, &field.base)?;
                let (_, type_) = self.field(scope, &base, &field.member).ok()?;
                Some(type_)
            }
            syn::Expr::Index(index) => match self.type_of(scope, &index.expr)? {
                Type::Array(element, _) => Some(*element),
                _ => None,
            },
            syn::Expr::Call(call) => {
                let syn::Expr::Path(path) = &*call.func else {
                    return None;
                };
                let segments: Vec<_> = path
                    .path
                    .segments
                    .iter()
                    .map(|segment| segment.ident.to_string())
                    .collect();
                let names = &self.declarations.files[scope.module].names;
                match segments.as_slice() {
                    [name] => match names.get(name)? {
                        Named::Function(number) => {
                            Some(self.declarations.functions[*number].result.clone())
                        }
                        Named::Type(type_) => Some(type_.clone()),
                        Named::Constant(_) => None,
                    },
                    [type_, name] => {
                        if let Some(integer) = Integer::named(type_) {
                            return Some(Type::Integer(integer));
                        }
                        match names.get(type_)? {
                            Named::Type(Type::Struct(owner)) => {
                                let number =
                                    self.declarations.methods.get(&(*owner, name.clone()))?;
                                Some(self.declarations.functions[*number].result.clone())
                            }
                            Named::Type(type_) => Some(type_.clone()),
                            _ => None,
                        }
                    }
                    _ => None,
                }
            }
            syn::Expr::MethodCall(call) => {
                let receiver = self.type_of(scope, &call.receiver)?;
                let name = call.method.to_string();
                match (&receiver, name.as_str()) {
                    (Type::Fixed(_), "to_bits") => Some(Type::Integer(Integer::I32)),
                    (Type::Integer(_), "clamp" | "abs") => Some(receiver),
                    (Type::Struct(owner), _) => {
                        let number = self.declarations.methods.get(&(*owner, name))?;
                        Some(self.declarations.functions[*number].result.clone())
                    }
                    _ => None,
                }
            }
            syn::Expr::If(choice) => match choice.then_branch.stmts.last()? {
                syn::Stmt::Expr(value, None) => self.type_of(scope, value),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Whether a block ends by returning.
fn returns(block: &syn::Block) -> bool {
    matches!(
        block.stmts.last(),
        Some(syn::Stmt::Expr(syn::Expr::Return(_), _))
    )
}
