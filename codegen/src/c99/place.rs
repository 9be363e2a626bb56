//! The places that expressions name: variables, fields, elements, constants.

use syn::{Expr, UnOp};

use super::Result;
use super::expression::{bare, kind};
use super::items::{last, literal};
use super::scope::{CPlace, Scope};
use super::types::{ItemKey, Type, snake};

impl Scope<'_> {
    /// The place that an expression names, or a new one with its value.
    pub fn place(&mut self, expression: &Expr) -> Result<CPlace> {
        match bare(expression) {
            Expr::Path(path) => self.named_place(&path.path),
            Expr::Field(field) => {
                let base = self.place(&field.base)?;
                match (&field.member, &base.ty) {
                    (syn::Member::Named(name), Type::Struct(key)) => {
                        let name = name.to_string();
                        match self.items.field(key, &name) {
                            Some(ty) => Ok(base.field(&name, ty.clone())),
                            None => self.refuse(format!("the field {name}")),
                        }
                    }
                    // A structure around one number is that number.
                    (syn::Member::Unnamed(_), Type::Int(_)) => Ok(base),
                    _ => self.refuse("this field"),
                }
            }
            Expr::Index(index) => {
                let base = self.place(&index.expr)?;
                let number = match bare(&index.index) {
                    Expr::Lit(value) => literal(&value.lit),
                    _ => None,
                };
                match number.and_then(|(number, _)| base.element(number as usize)) {
                    Some(place) => Ok(place),
                    None => self.refuse("this index"),
                }
            }
            Expr::Unary(unary) if matches!(unary.op, UnOp::Deref(_)) => self.place(&unary.expr),
            other => {
                let Some(ty) = self.infer(other)? else {
                    return self.refuse(kind(other));
                };
                if let Expr::MethodCall(_) | Expr::Call(_) = other
                    && ty.is_aggregate()
                {
                    let call = self.resolved(other)?;
                    if self.function(&call.key)?.returns_reference {
                        let text = self.call_text(&call, &[])?;
                        return Ok(CPlace::behind(&text, ty));
                    }
                }
                let place = self.temporary(&ty);
                self.assign(other, &place)?;
                Ok(place)
            }
        }
    }

    fn named_place(&mut self, path: &syn::Path) -> Result<CPlace> {
        let name = last(path);
        if path.segments.len() == 1 {
            if let Some(place) = self.lookup(&name) {
                return Ok(place.clone());
            }
            let key = self.items.resolve(self.module, &name);
            if let Some(constant) = self.items.constants.get(&key) {
                let ty = constant.ty.clone();
                self.needs.constants.insert(key.clone());
                return Ok(CPlace::variable(&super::constants::name(&key), ty));
            }
        } else {
            let owner = path.segments[path.segments.len() - 2].ident.to_string();
            let key = self.items.resolve(self.module, &owner);
            if let Some(own) = self.items.enums.get(&key)
                && own.variants.iter().any(|(variant, _, _)| *variant == name)
            {
                let text = enumerator(&name);
                return Ok(CPlace::variable(&text, Type::Enum(key)));
            }
            let constant: ItemKey = (owner, name.clone());
            if let Some(found) = self.items.constants.get(&constant) {
                let ty = found.ty.clone();
                self.needs.constants.insert(constant.clone());
                return Ok(CPlace::variable(&super::constants::name(&constant), ty));
            }
        }
        self.refuse(format!("the name {name}"))
    }
}

/// `NotAligned` is `FLYWHEEL_NOT_ALIGNED`.
pub fn enumerator(name: &str) -> String {
    format!("FLYWHEEL_{}", snake(name).to_uppercase())
}
