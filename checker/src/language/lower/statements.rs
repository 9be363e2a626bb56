//! Bodies, blocks and their statements.

use syn::spanned::Spanned;
use syn::visit::Visit;

use crate::language::attributes::no_attributes;
use crate::language::declarations::{Read, refuse, shown};
use crate::language::lower::builder::{Builder, Scope, Value};
use crate::language::plain;
use crate::program::place::SourceError;
use crate::program::steps::{Action, ProgramStep};
use crate::program::types::Type;

/// Largest number of steps. More come from multiplying calls, not from a controller.
const LARGEST_PROGRAM: usize = 200_000;

impl Builder<'_> {
    /// Inlines the body of a function; returns its result and its `&mut` arguments.
    pub(super) fn body(
        &mut self,
        number: usize,
        arguments: Vec<Value>,
        steps: &mut Vec<ProgramStep>,
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

    pub(super) fn block(
        &mut self,
        scope: &mut Scope,
        block: &syn::Block,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let outside = scope.variables.len();
        let value = self.statements(scope, &block.stmts, expected, steps)?;
        scope.variables.truncate(outside);
        Ok(value)
    }

    pub(super) fn statements(
        &mut self,
        scope: &mut Scope,
        statements: &[syn::Stmt],
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
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

    pub(super) fn returned(
        &mut self,
        scope: &mut Scope,
        value: &syn::ExprReturn,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
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

    pub(super) fn binding(
        &mut self,
        scope: &mut Scope,
        local: &syn::Local,
        steps: &mut Vec<ProgramStep>,
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

    pub(super) fn pattern(
        &mut self,
        scope: &mut Scope,
        pattern: &syn::Pat,
        value: Value,
    ) -> Read<()> {
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

    pub(super) fn assertion(
        &mut self,
        scope: &mut Scope,
        call: &syn::StmtMacro,
        steps: &mut Vec<ProgramStep>,
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
        plain::check_expression(&scope.path, &condition)?;
        no_attributes(&scope.path, |finder| finder.visit_expr(&condition))?;
        let value = self.expression(scope, &condition, Some(&Type::Bool), steps)?;
        self.require(scope, condition.span(), &Type::Bool, &value.type_)?;
        let place = self.at(scope, call.span());
        steps.push(ProgramStep {
            action: Action::Assert {
                a: value.slots[0],
                message: message.unwrap_or_else(|| shown(&condition)),
            },
            place,
        });
        Ok(())
    }
}

/// Whether a block ends by returning.
fn returns(block: &syn::Block) -> bool {
    matches!(
        block.stmts.last(),
        Some(syn::Stmt::Expr(syn::Expr::Return(_), _))
    )
}
