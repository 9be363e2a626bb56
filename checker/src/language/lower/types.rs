//! The types of expressions, determined before the expressions are read.

use crate::language::declarations::Named;
use crate::language::lower::builder::{Builder, Scope};
use crate::program::types::{Integer, Type};

impl Builder<'_> {
    /// The type of an expression as far as it is plain without its surroundings: literals without
    /// a suffix take theirs from there.
    pub(super) fn type_of(&self, scope: &Scope, expression: &syn::Expr) -> Option<Type> {
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
                    [type_, variant] => Integer::named(type_).map(Type::Integer).or_else(|| {
                        let value = self.declarations.variant(scope.module, type_, variant);
                        value.map(|(type_, _)| type_)
                    }),
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
