//! The types of expressions, where C must name what Rust infers.

use syn::{BinOp, Expr};

use super::Result;
use super::expression::{bare, kind};
use super::items::{last, suffix};
use super::scope::Scope;
use super::types::{Int, Type};

impl Scope<'_> {
    /// The type of an expression; `None` where the type follows from the context.
    pub fn infer(&mut self, expression: &Expr) -> Result<Option<Type>> {
        Ok(match bare(expression) {
            Expr::Lit(value) => match &value.lit {
                syn::Lit::Bool(_) => Some(Type::Bool),
                other => suffix(other).map(Type::Int),
            },
            Expr::Unary(unary) => self.infer(&unary.expr)?,
            Expr::Cast(cast) => Some(self.items.type_of(self.module, &cast.ty)?),
            Expr::Binary(binary) => match binary.op {
                BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::BitAnd(_) => {
                    match self.infer(&binary.left)? {
                        Some(ty) => Some(ty),
                        None => self.infer(&binary.right)?,
                    }
                }
                BinOp::Shl(_) | BinOp::Shr(_) => self.infer(&binary.left)?,
                _ => Some(Type::Bool),
            },
            Expr::Array(array) => {
                let mut element = None;
                for one in &array.elems {
                    if element.is_none() {
                        element = self.infer(one)?;
                    }
                }
                let element = element.unwrap_or(Type::Int(Int::I32));
                Some(Type::Array(Box::new(element), array.elems.len()))
            }
            Expr::Struct(value) => {
                let name = last(&value.path);
                let name = match (name.as_str(), self.owner) {
                    ("Self", Some(owner)) => owner.to_string(),
                    _ => name,
                };
                Some(self.items.named(self.module, &name)?)
            }
            Expr::If(value) => match self.infer_block(&value.then_branch)? {
                Some(ty) => Some(ty),
                None => match &value.else_branch {
                    Some((_, otherwise)) => self.infer(otherwise)?,
                    None => Some(Type::Unit),
                },
            },
            Expr::Block(block) => self.infer_block(&block.block)?,
            Expr::MethodCall(call) => match call.method.to_string().as_str() {
                "to_bits" | "clamp" => self.infer(&call.receiver)?,
                _ => {
                    let call = self.resolved(expression)?;
                    Some(self.function(&call.key)?.returns.clone())
                }
            },
            Expr::Call(call) => {
                let Expr::Path(path) = &*call.func else {
                    return self.refuse("this call");
                };
                let first = path.path.segments[0].ident.to_string();
                let name = last(&path.path);
                if let Some(word) = self.word(&first) {
                    Some(word)
                } else if name == "from" {
                    Int::from_name(&first).map(Type::Int)
                } else {
                    let call = self.resolved(expression)?;
                    Some(self.function(&call.key)?.returns.clone())
                }
            }
            Expr::Path(_) | Expr::Field(_) | Expr::Index(_) => Some(self.place(expression)?.ty),
            other => return self.refuse(kind(other)),
        })
    }

    /// The type of a block's last expression; `None` where the names of the block would be needed.
    fn infer_block(&mut self, block: &syn::Block) -> Result<Option<Type>> {
        match block.stmts.last() {
            Some(syn::Stmt::Expr(last, None)) if block.stmts.len() == 1 => self.infer(last),
            Some(syn::Stmt::Expr(_, None)) => Ok(None),
            _ => Ok(Some(Type::Unit)),
        }
    }
}
