//! Branches: `if`, `match` on an `Option`, and the short-circuit operators `&&` and `||`.

use syn::spanned::Spanned;

use crate::language::declarations::{Read, refuse};
use crate::language::lower::builder::{Builder, Scope, Value};
use crate::program::steps::{Action, Join, ProgramStep, Slot};
use crate::program::types::Type;

impl Builder<'_> {
    /// A condition and two sides, which meet in new slots.
    pub(super) fn choice(
        &mut self,
        scope: &mut Scope,
        condition: &syn::Expr,
        span: proc_macro2::Span,
        steps: &mut Vec<ProgramStep>,
        then: impl FnOnce(&mut Self, &mut Scope, &mut Vec<ProgramStep>) -> Read<Value>,
        otherwise: impl FnOnce(&mut Self, &mut Scope, &mut Vec<ProgramStep>) -> Read<Value>,
    ) -> Read<Value> {
        let is_tail = std::mem::replace(&mut scope.is_tail, false);
        let test = self.expression(scope, condition, Some(&Type::Bool), steps)?;
        scope.is_tail = is_tail;
        self.require(scope, condition.span(), &Type::Bool, &test.type_)?;
        self.choice_on(scope, test.slots[0], span, steps, then, otherwise)
    }

    pub(super) fn choice_on(
        &mut self,
        scope: &mut Scope,
        condition: Slot,
        span: proc_macro2::Span,
        steps: &mut Vec<ProgramStep>,
        then: impl FnOnce(&mut Self, &mut Scope, &mut Vec<ProgramStep>) -> Read<Value>,
        otherwise: impl FnOnce(&mut Self, &mut Scope, &mut Vec<ProgramStep>) -> Read<Value>,
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
        steps.push(ProgramStep {
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

    pub(super) fn if_expression(
        &mut self,
        scope: &mut Scope,
        choice: &syn::ExprIf,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
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
    pub(super) fn match_option(
        &mut self,
        scope: &mut Scope,
        choice: &syn::ExprMatch,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
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
}
