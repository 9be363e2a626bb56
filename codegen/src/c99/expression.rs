//! Scalars: numbers, booleans, enumerators.

use syn::{BinOp, Expr, UnOp};

use super::Result;
use super::items::{literal, suffix};
use super::scope::Scope;
use super::types::{Int, Type};

/// A scalar in C.
#[derive(Debug, Clone)]
pub struct CScalar {
    /// Its text.
    pub text: String,
    /// Its type.
    pub ty: Type,
    /// Binding strength of the outermost operator: 0 for a text that never needs parentheses.
    pub strength: u8,
}

/// A cast or a sign.
const UNARY: u8 = 1;
const PRODUCT: u8 = 2;
const SUM: u8 = 3;
const SHIFT: u8 = 4;
const COMPARISON: u8 = 5;
const BITS: u8 = 6;
const AND: u8 = 7;
const OR: u8 = 8;

impl CScalar {
    pub(super) fn new(text: impl Into<String>, ty: Type, strength: u8) -> CScalar {
        CScalar {
            text: text.into(),
            ty,
            strength,
        }
    }

    /// The text, in parentheses unless it binds at least this tightly.
    pub fn within(&self, strength: u8) -> String {
        if self.strength <= strength {
            self.text.clone()
        } else {
            format!("({})", self.text)
        }
    }
}

/// The expression without its outer parentheses and references.
pub fn bare(expression: &Expr) -> &Expr {
    match expression {
        Expr::Paren(inner) => bare(&inner.expr),
        Expr::Group(inner) => bare(&inner.expr),
        Expr::Reference(inner) => bare(&inner.expr),
        other => other,
    }
}

/// Whether the expression is a number whose type follows from the context.
fn is_untyped(expression: &Expr) -> bool {
    match bare(expression) {
        Expr::Lit(value) => literal(&value.lit).is_some() && suffix(&value.lit).is_none(),
        Expr::Unary(unary) => matches!(unary.op, UnOp::Neg(_)) && is_untyped(&unary.expr),
        _ => false,
    }
}

impl Scope<'_> {
    /// Translates a scalar. `wanted` is the type that the context requires, if it requires one.
    pub fn scalar(&mut self, expression: &Expr, wanted: Option<&Type>) -> Result<CScalar> {
        self.scalar_beside(expression, wanted, true)
    }

    /// Translates a scalar. If `is_beside_wide`, another operand or the target determines the width of a number.
    fn scalar_beside(
        &mut self,
        expression: &Expr,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<CScalar> {
        match bare(expression) {
            Expr::Lit(value) => self.number(&value.lit, wanted, is_beside_wide),
            Expr::Unary(unary) => self.unary(unary, wanted, is_beside_wide),
            Expr::Binary(binary) => self.binary(binary, wanted),
            Expr::Cast(cast) => {
                let ty = self.items.type_of(self.module, &cast.ty)?;
                self.cast(&cast.expr, ty)
            }
            Expr::MethodCall(call) => self.method(call),
            Expr::Call(call) => self.call(call),
            Expr::If(_) => self.conditional(expression, wanted),
            Expr::Path(_) | Expr::Field(_) | Expr::Index(_) => {
                let place = self.place(expression)?;
                if place.ty.is_aggregate() {
                    return self.refuse("a structure where a number is wanted");
                }
                let text = if place.is_pointer {
                    format!("*{}", place.text)
                } else {
                    place.text
                };
                Ok(CScalar::new(text, place.ty, u8::from(place.is_pointer)))
            }
            Expr::Block(block) if block.block.stmts.len() == 1 => match &block.block.stmts[0] {
                syn::Stmt::Expr(inner, None) => self.scalar(inner, wanted),
                _ => self.refuse("a block in an expression"),
            },
            other => self.refuse(kind(other)),
        }
    }

    fn number(
        &mut self,
        value: &syn::Lit,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<CScalar> {
        if let syn::Lit::Bool(value) = value {
            return Ok(CScalar::new(
                u8::from(value.value).to_string(),
                Type::Bool,
                0,
            ));
        }
        let Some((magnitude, text)) = literal(value) else {
            return self.refuse("this literal");
        };
        let int = match (suffix(value), wanted) {
            (Some(int), _) => int,
            (None, Some(Type::Int(int))) => *int,
            _ => Int::I32,
        };
        let text = int.literal(magnitude, &text, is_beside_wide);
        Ok(CScalar::new(text, Type::Int(int), 0))
    }

    fn unary(
        &mut self,
        unary: &syn::ExprUnary,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<CScalar> {
        match unary.op {
            UnOp::Neg(_) => {
                if let Expr::Lit(value) = bare(&unary.expr)
                    && let Some((0x8000_0000, _)) = literal(&value.lit)
                    && !matches!(wanted, Some(Type::Int(Int::I64)))
                {
                    // C has no negative literals, and 2^31 does not fit into an `int32_t`.
                    let text = "-INT32_C(2147483647) - 1";
                    return Ok(CScalar::new(text, Type::Int(Int::I32), SUM));
                }
                let inner = self.scalar_beside(&unary.expr, wanted, is_beside_wide)?;
                Ok(CScalar::new(
                    format!("-{}", inner.within(0)),
                    inner.ty,
                    UNARY,
                ))
            }
            UnOp::Not(_) => {
                let inner = self.scalar(&unary.expr, wanted)?;
                if inner.ty != Type::Bool {
                    return self.refuse("`!` of a number");
                }
                Ok(CScalar::new(
                    format!("!{}", inner.within(0)),
                    Type::Bool,
                    UNARY,
                ))
            }
            UnOp::Deref(_) => self.scalar(&unary.expr, wanted),
            _ => self.refuse("this sign"),
        }
    }

    fn binary(&mut self, binary: &syn::ExprBinary, wanted: Option<&Type>) -> Result<CScalar> {
        let (sign, strength) = match binary.op {
            BinOp::Add(_) => ("+", SUM),
            BinOp::Sub(_) => ("-", SUM),
            BinOp::Mul(_) => ("*", PRODUCT),
            BinOp::Shl(_) => return self.shift_left(binary, wanted),
            BinOp::Shr(_) => {
                let left = self.scalar(&binary.left, wanted)?;
                let right = self.shift_amount(&binary.right)?;
                let text = format!("{} >> {right}", left.within(UNARY));
                return Ok(CScalar::new(text, left.ty, SHIFT));
            }
            BinOp::BitAnd(_) => ("&", BITS),
            BinOp::Lt(_) => ("<", COMPARISON),
            BinOp::Le(_) => ("<=", COMPARISON),
            BinOp::Gt(_) => (">", COMPARISON),
            BinOp::Ge(_) => (">=", COMPARISON),
            BinOp::Eq(_) => ("==", COMPARISON),
            BinOp::Ne(_) => ("!=", COMPARISON),
            BinOp::And(_) => return self.logical(binary, "&&", AND),
            BinOp::Or(_) => return self.logical(binary, "||", OR),
            _ => return self.refuse("this operator"),
        };
        let is_comparison = strength == COMPARISON;
        let wanted = if is_comparison { None } else { wanted };
        let (left, right) = match (is_untyped(&binary.left), is_untyped(&binary.right)) {
            (true, false) => {
                let right = self.scalar(&binary.right, wanted)?;
                let ty = right.ty.clone();
                (self.scalar_beside(&binary.left, Some(&ty), true)?, right)
            }
            (false, true) => {
                let left = self.scalar(&binary.left, wanted)?;
                let ty = left.ty.clone();
                let right = self.scalar_beside(&binary.right, Some(&ty), true)?;
                (left, right)
            }
            (both, _) => (
                self.scalar_beside(&binary.left, wanted, !both)?,
                self.scalar_beside(&binary.right, wanted, !both)?,
            ),
        };
        if left.ty != right.ty {
            return self.refuse(format!("{:?} {sign} {:?}", left.ty, right.ty));
        }
        let is_narrow = matches!(left.ty, Type::Int(Int::I16 | Int::U16 | Int::U8));
        if !is_comparison && (is_narrow || !matches!(left.ty, Type::Int(_))) {
            return self.refuse("arithmetic of words narrower than `int`");
        }
        // The left operand of a chain of sums needs no parentheses, and a product within a sum needs none.
        let own = if strength == BITS { UNARY } else { strength };
        let left_text = left.within(if is_comparison { SUM } else { own });
        let right_text = right.within(if is_comparison { SUM } else { own - 1 });
        let ty = if is_comparison { Type::Bool } else { left.ty };
        Ok(CScalar::new(
            format!("{left_text} {sign} {right_text}"),
            ty,
            strength,
        ))
    }

    fn logical(&mut self, binary: &syn::ExprBinary, sign: &str, strength: u8) -> Result<CScalar> {
        let left = self.scalar(&binary.left, Some(&Type::Bool))?;
        let lines = self.lines.len();
        let right = self.scalar(&binary.right, Some(&Type::Bool))?;
        if self.lines.len() != lines {
            // C would execute these steps even if the left side already decides the result.
            return self.refuse(format!("steps on the right of `{sign}`"));
        }
        // Where two signs meet, parentheses keep them apart, as compilers advise.
        let text = |side: &CScalar| {
            if side.strength == strength {
                side.text.clone()
            } else {
                side.within(BITS)
            }
        };
        let text = format!("{} {sign} {}", text(&left), text(&right));
        Ok(CScalar::new(text, Type::Bool, strength))
    }

    /// A left shift. Only a number that is not negative may be shifted: for others, C leaves the result undefined.
    fn shift_left(&mut self, binary: &syn::ExprBinary, wanted: Option<&Type>) -> Result<CScalar> {
        let Expr::Lit(_) = bare(&binary.left) else {
            return self.refuse("a shift to the left of something that may be negative");
        };
        let left = self.scalar_beside(&binary.left, wanted, false)?;
        let right = self.shift_amount(&binary.right)?;
        let text = format!("{} << {right}", left.within(UNARY));
        Ok(CScalar::new(text, left.ty, SHIFT))
    }

    fn shift_amount(&mut self, expression: &Expr) -> Result<String> {
        if is_untyped(expression) {
            let amount = self.scalar_beside(expression, None, true)?;
            return Ok(amount.text);
        }
        Ok(self
            .scalar(expression, Some(&Type::Int(Int::U32)))?
            .within(UNARY))
    }

    /// `inner as ty`.
    pub(super) fn cast(&mut self, inner: &Expr, ty: Type) -> Result<CScalar> {
        let inner = self.scalar(inner, None)?;
        let Type::Int(int) = ty else {
            return self.refuse("this cast");
        };
        if inner.ty == ty {
            return Ok(inner);
        }
        let text = format!("({}){}", int.c_name(), inner.within(UNARY));
        Ok(CScalar::new(text, ty, UNARY))
    }

    fn conditional(&mut self, expression: &Expr, wanted: Option<&Type>) -> Result<CScalar> {
        let ty = match (wanted, self.infer(expression)?) {
            (_, Some(ty)) => ty,
            (Some(ty), None) => ty.clone(),
            (None, None) => Type::Int(Int::I32),
        };
        let place = self.temporary(&ty);
        self.assign(expression, &place)?;
        Ok(CScalar::new(place.text, ty, 0))
    }
}

/// The kind of an expression, in the words of a message.
pub(super) fn kind(expression: &Expr) -> String {
    let text = quote::quote!(#expression).to_string();
    format!("`{}`", text.chars().take(60).collect::<String>())
}
