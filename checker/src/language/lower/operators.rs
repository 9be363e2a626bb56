//! Operators and casts.

use syn::spanned::Spanned;

use crate::language::declarations::{Read, refuse, shown};
use crate::language::lower::builder::{Builder, Scope, Value};
use crate::program::steps::{Action, Arithmetic, ProgramStep, WordComparison};
use crate::program::types::{Integer, Type};

impl Builder<'_> {
    pub(super) fn unary(
        &mut self,
        scope: &mut Scope,
        unary: &syn::ExprUnary,
        expected: Option<&Type>,
        steps: &mut Vec<ProgramStep>,
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
                steps.push(ProgramStep {
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

    pub(super) fn arithmetic(
        &mut self,
        scope: &Scope,
        span: proc_macro2::Span,
        operation: Arithmetic,
        a: Value,
        b: Value,
        steps: &mut Vec<ProgramStep>,
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
        steps.push(ProgramStep {
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

    pub(super) fn binary(
        &mut self,
        scope: &mut Scope,
        binary: &syn::ExprBinary,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let span = binary.op.span();
        if let syn::BinOp::And(_) | syn::BinOp::Or(_) = binary.op {
            let is_and = matches!(binary.op, syn::BinOp::And(_));
            let decided = Value {
                type_: Type::Bool,
                slots: vec![self.known(i128::from(!is_and))],
            };
            let right = |builder: &mut Self, scope: &mut Scope, steps: &mut Vec<ProgramStep>| {
                let value = builder.expression(scope, &binary.right, Some(&Type::Bool), steps)?;
                builder.require(scope, binary.right.span(), &Type::Bool, &value.type_)?;
                Ok(value)
            };
            let early = |_: &mut Self, _: &mut Scope, _: &mut Vec<ProgramStep>| Ok(decided);
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
                // The type of a shift is the type of the shifted operand. The amount of the shift may have another
                // type.
                let Some(type_) = self.type_of(scope, &binary.left) else {
                    return self.unclear(scope, &binary.left);
                };
                let a = self.expression(scope, &binary.left, Some(&type_), steps)?;
                let amount = match self.type_of(scope, &binary.right) {
                    Some(type_) => type_,
                    None if is_literal(&binary.right) => Type::Integer(Integer::U32),
                    None => return self.unclear(scope, &binary.right),
                };
                let b = self.expression(scope, &binary.right, Some(&amount), steps)?;
                return self.arithmetic(scope, span, operation, a, b, steps);
            }
            let (a, b) = self.operands(scope, binary, steps)?;
            return self.arithmetic(scope, span, operation, a, b, steps);
        }
        let (comparison, is_swapped) = match binary.op {
            syn::BinOp::Lt(_) => (WordComparison::Less, false),
            syn::BinOp::Le(_) => (WordComparison::LessEqual, false),
            syn::BinOp::Gt(_) => (WordComparison::Less, true),
            syn::BinOp::Ge(_) => (WordComparison::LessEqual, true),
            syn::BinOp::Eq(_) => (WordComparison::Equal, false),
            syn::BinOp::Ne(_) => (WordComparison::NotEqual, false),
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
        let (a, b) = self.operands(scope, binary, steps)?;
        let is_equality = matches!(comparison, WordComparison::Equal | WordComparison::NotEqual);
        let is_comparable = match a.type_ {
            Type::Integer(_) => true,
            Type::Enum(..) => is_equality,
            _ => false,
        };
        if a.type_ != b.type_ || !is_comparable {
            return self.mismatch(scope, span, &a.type_, &b.type_);
        }
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let to = self.slot();
        let place = self.at(scope, span);
        steps.push(ProgramStep {
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

    /// The two operands of an operator, which have the same type. One of them states the type; the other one states the
    /// same type or is a literal.
    fn operands(
        &mut self,
        scope: &mut Scope,
        binary: &syn::ExprBinary,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<(Value, Value)> {
        let sides = [&*binary.left, &*binary.right];
        let types = sides.map(|side| self.type_of(scope, side));
        let Some(type_) = types.iter().flatten().next() else {
            return self.unclear(scope, &binary.left);
        };
        for (side, own) in sides.into_iter().zip(&types) {
            if own.is_none() && !is_literal(side) {
                return self.unclear(scope, side);
            }
        }
        let a = self.expression(scope, sides[0], Some(type_), steps)?;
        let b = self.expression(scope, sides[1], Some(type_), steps)?;
        Ok((a, b))
    }

    /// Refuses an expression whose type Rust would determine by rules that this reader does not implement.
    fn unclear<T>(&mut self, scope: &mut Scope, expression: &syn::Expr) -> Read<T> {
        // An error inside the expression is more informative.
        if !is_literal(expression) {
            self.expression(scope, expression, None, &mut Vec::new())?;
        }
        refuse(
            &scope.path,
            expression.span(),
            format!(
                "the type of {} is not stated here; write it at the number (`1_i64`) or give the value a name with a type",
                shown(expression)
            ),
        )
    }

    pub(super) fn cast(
        &mut self,
        scope: &mut Scope,
        cast: &syn::ExprCast,
        steps: &mut Vec<ProgramStep>,
    ) -> Read<Value> {
        let type_ = self
            .declarations
            .type_(scope.module, &scope.path, &cast.ty)?;
        // A literal takes the type of the cast. Any other expression must have a stated type: Rust
        // would assume i32 where none is stated.
        let inner = match self.type_of(scope, &cast.expr) {
            Some(inner) => inner,
            None if is_literal(&cast.expr) => type_.clone(),
            None => return self.unclear(scope, &cast.expr),
        };
        let value = self.expression(scope, &cast.expr, Some(&inner), steps)?;
        self.converted(scope, cast.span(), value, &type_, steps)
    }

    pub(super) fn converted(
        &mut self,
        scope: &Scope,
        span: proc_macro2::Span,
        value: Value,
        type_: &Type,
        steps: &mut Vec<ProgramStep>,
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
        steps.push(ProgramStep {
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
}

/// An integer without a suffix, with or without a minus.
fn is_literal(expression: &syn::Expr) -> bool {
    match expression {
        syn::Expr::Paren(inner) => is_literal(&inner.expr),
        syn::Expr::Lit(literal) => matches!(literal.lit, syn::Lit::Int(_)),
        syn::Expr::Unary(unary) => {
            matches!(unary.op, syn::UnOp::Neg(_)) && matches!(&*unary.expr, syn::Expr::Lit(_))
        }
        _ => false,
    }
}
