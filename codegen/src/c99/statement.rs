//! Blocks, and values that are structures or arrays.

use syn::{Expr, Pat, Stmt};

use super::Result;
use super::expression::bare;
use super::items::last;
use super::scope::{CPlace, Scope};
use super::types::{Int, Type};

/// The target of a block's value.
#[derive(Clone)]
pub enum Target {
    /// The value is returned by the function.
    Return,
    /// The value is written to a place.
    Place(CPlace),
    /// There is no value.
    Nothing,
}

impl Scope<'_> {
    /// Translates the statements of a block. The value of the last one goes to `target`.
    pub fn block(&mut self, block: &syn::Block, target: &Target) -> Result<()> {
        for (index, statement) in block.stmts.iter().enumerate() {
            let is_last = index + 1 == block.stmts.len();
            match statement {
                Stmt::Local(local) => self.local(local)?,
                Stmt::Expr(expression, None) if is_last => self.value(expression, target)?,
                Stmt::Expr(expression, _) => self.step(expression)?,
                _ => return self.refuse("this statement"),
            }
        }
        Ok(())
    }

    /// A value on its way to `target`.
    fn value(&mut self, expression: &Expr, target: &Target) -> Result<()> {
        match (target, bare(expression)) {
            (_, Expr::If(branch)) => self.branch(branch, target),
            (_, Expr::Block(inner)) => self.block(&inner.block, target),
            (Target::Nothing, other) => self.step(other),
            (Target::Place(place), other) => self.assign(other, &place.clone()),
            (Target::Return, other) => self.returned(other),
        }
    }

    fn returned(&mut self, expression: &Expr) -> Result<()> {
        let ty = self.returns.clone();
        match &ty {
            Type::Unit => self.step(expression),
            Type::Tuple(_) => {
                let Expr::Tuple(values) = bare(expression) else {
                    return self.refuse("a tuple that is not written out");
                };
                for (value, out) in values.elems.iter().zip(CPlace::outs(&ty)) {
                    self.assign(value, &out)?;
                }
                Ok(())
            }
            _ if ty.is_aggregate() => {
                for out in CPlace::outs(&ty) {
                    self.assign(expression, &out)?;
                }
                Ok(())
            }
            _ => {
                let value = self.scalar(expression, Some(&ty))?;
                self.line(format!("return {};", value.text));
                Ok(())
            }
        }
    }

    fn branch(&mut self, branch: &syn::ExprIf, target: &Target) -> Result<()> {
        let condition = self.scalar(&branch.cond, Some(&Type::Bool))?;
        self.line(format!("if ({}) {{", condition.text));
        self.enter();
        self.block(&branch.then_branch, target)?;
        self.leave();
        let mut otherwise = branch.else_branch.as_ref().map(|(_, other)| &**other);
        while let Some(expression) = otherwise {
            match expression {
                Expr::If(next) => {
                    let lines = self.lines.len();
                    let condition = self.scalar(&next.cond, Some(&Type::Bool))?;
                    if self.lines.len() != lines {
                        // These steps must not be executed if an earlier condition holds.
                        let steps = self.lines.split_off(lines);
                        self.line("} else {");
                        self.enter();
                        self.lines
                            .extend(steps.into_iter().map(|step| format!("    {step}")));
                        self.line(format!("if ({}) {{", condition.text));
                        self.enter();
                        self.block(&next.then_branch, target)?;
                        self.leave();
                        if let Some((_, last)) = &next.else_branch {
                            self.line("} else {");
                            self.enter();
                            self.value(last, target)?;
                            self.leave();
                        }
                        self.line("}");
                        self.leave();
                        break;
                    }
                    self.line(format!("}} else if ({}) {{", condition.text));
                    self.enter();
                    self.block(&next.then_branch, target)?;
                    self.leave();
                    otherwise = next.else_branch.as_ref().map(|(_, other)| &**other);
                }
                last => {
                    self.line("} else {");
                    self.enter();
                    self.value(last, target)?;
                    self.leave();
                    otherwise = None;
                }
            }
        }
        self.line("}");
        Ok(())
    }

    fn local(&mut self, local: &syn::Local) -> Result<()> {
        let Some(init) = &local.init else {
            return self.refuse("a variable without a value");
        };
        match &local.pat {
            Pat::Ident(name) => self.declared(&name.ident.to_string(), &init.expr, None),
            Pat::Type(typed) => {
                let ty = self.items.type_of(self.module, &typed.ty)?;
                match &*typed.pat {
                    Pat::Ident(name) => {
                        self.declared(&name.ident.to_string(), &init.expr, Some(ty))
                    }
                    _ => self.refuse("this pattern"),
                }
            }
            Pat::Tuple(names) => {
                let Expr::Tuple(values) = bare(&init.expr) else {
                    return self.unpacked(names, &init.expr);
                };
                for (name, value) in names.elems.iter().zip(&values.elems) {
                    match name {
                        Pat::Ident(name) => self.declared(&name.ident.to_string(), value, None)?,
                        _ => return self.refuse("this pattern"),
                    }
                }
                Ok(())
            }
            _ => self.refuse("this pattern"),
        }
    }

    /// A function that returns several values.
    fn unpacked(&mut self, names: &syn::PatTuple, value: &Expr) -> Result<()> {
        let Some(Type::Tuple(parts)) = self.infer(value)? else {
            return self.refuse("this pattern");
        };
        let mut targets = vec![];
        for (name, ty) in names.elems.iter().zip(parts) {
            let Pat::Ident(name) = name else {
                return self.refuse("this pattern");
            };
            let name = name.ident.to_string();
            let own = self.fresh(&name);
            let declaration = ty.declare(&own);
            self.line(format!("{declaration};"));
            targets.push((name, CPlace::variable(&own, ty)));
        }
        let call = self.resolved(value)?;
        let places: Vec<CPlace> = targets.iter().map(|(_, place)| place.clone()).collect();
        let text = self.call_text(&call, &places)?;
        self.line(format!("{text};"));
        for (name, place) in targets {
            self.bind(&name, place);
        }
        Ok(())
    }

    fn declared(&mut self, name: &str, value: &Expr, ty: Option<Type>) -> Result<()> {
        let ty = match (ty, self.infer(value)?) {
            (Some(ty), _) | (None, Some(ty)) => ty,
            (None, None) => Type::Int(Int::I32),
        };
        let is_branch = matches!(bare(value), Expr::If(_) | Expr::Block(_));
        if ty.is_aggregate() || is_branch {
            let own = self.fresh(name);
            let declaration = ty.declare(&own);
            self.line(format!("{declaration};"));
            let place = CPlace::variable(&own, ty);
            self.assign(value, &place)?;
            self.bind(name, place);
        } else {
            let value = self.scalar(value, Some(&ty))?;
            let own = self.fresh(name);
            let declaration = ty.declare(&own);
            self.line(format!("const {declaration} = {};", value.text));
            self.bind(name, CPlace::variable(&own, ty));
        }
        Ok(())
    }

    /// A statement.
    fn step(&mut self, expression: &Expr) -> Result<()> {
        match bare(expression) {
            Expr::If(branch) => self.branch(branch, &Target::Nothing),
            Expr::Return(value) => {
                match &value.expr {
                    Some(value) => self.value(value, &Target::Return)?,
                    None => self.line("return;"),
                }
                if self.returns.is_aggregate() {
                    self.line("return;");
                }
                Ok(())
            }
            Expr::Assign(assign) => {
                let place = self.place(&assign.left)?;
                if place.ty.is_aggregate() && !matches!(bare(&assign.right), Expr::Path(_)) {
                    // The right side may read the value that it replaces.
                    let new = self.temporary(&place.ty);
                    self.assign(&assign.right, &new)?;
                    return self.copy(&new, &place);
                }
                self.assign(&assign.right, &place)
            }
            Expr::MethodCall(_) | Expr::Call(_) => {
                let call = self.resolved(expression)?;
                let text = self.call_text(&call, &[])?;
                self.line(format!("{text};"));
                Ok(())
            }
            _ => self.refuse("this statement"),
        }
    }

    /// Writes the value of an expression to a place that the expression does not use.
    pub fn assign(&mut self, expression: &Expr, place: &CPlace) -> Result<()> {
        let ty = place.ty.clone();
        match bare(expression) {
            Expr::If(branch) => self.branch(branch, &Target::Place(place.clone())),
            Expr::Block(block) => self.block(&block.block, &Target::Place(place.clone())),
            other if !ty.is_aggregate() => {
                let value = self.scalar(other, Some(&ty))?;
                let star = if place.is_pointer { "*" } else { "" };
                self.line(format!("{star}{} = {};", place.text, value.text));
                Ok(())
            }
            Expr::Array(array) => {
                for (index, element) in array.elems.iter().enumerate() {
                    match place.element(index) {
                        Some(part) => self.assign(element, &part)?,
                        None => return self.refuse("this array"),
                    }
                }
                Ok(())
            }
            Expr::Struct(value) => {
                let Type::Struct(key) = &ty else {
                    return self.refuse("this structure");
                };
                for field in &value.fields {
                    let syn::Member::Named(name) = &field.member else {
                        return self.refuse("this field");
                    };
                    let name = name.to_string();
                    let Some(own) = self.items.field(key, &name).cloned() else {
                        return self.refuse(format!("the field {name}"));
                    };
                    self.assign(&field.expr, &place.field(&name, own))?;
                }
                Ok(())
            }
            Expr::Call(_) | Expr::MethodCall(_) => {
                let call = self.resolved(expression)?;
                if self.function(&call.key)?.returns_reference {
                    let found = self.place(expression)?;
                    return self.copy(&found, place);
                }
                let text = self.call_text(&call, std::slice::from_ref(place))?;
                self.line(format!("{text};"));
                Ok(())
            }
            Expr::Path(_) | Expr::Field(_) | Expr::Index(_) | Expr::Unary(_) => {
                let found = self.place(expression)?;
                self.copy(&found, place)
            }
            other => {
                let text = quote::quote!(#other).to_string();
                self.refuse(format!("`{text}`"))
            }
        }
    }

    /// Copies a structure or an array, number by number.
    fn copy(&mut self, from: &CPlace, to: &CPlace) -> Result<()> {
        match &to.ty {
            Type::Array(_, length) => {
                for index in 0..*length {
                    if let (Some(from), Some(to)) = (from.element(index), to.element(index)) {
                        self.copy(&from, &to)?;
                    }
                }
                Ok(())
            }
            Type::Struct(key) => {
                let Some(own) = self.items.structs.get(key) else {
                    return self.refuse(format!("the structure {}", key.1));
                };
                for (name, ty, _) in &own.fields {
                    self.copy(&from.field(name, ty.clone()), &to.field(name, ty.clone()))?;
                }
                Ok(())
            }
            _ => {
                self.line(format!("{} = {};", to.text, from.text));
                Ok(())
            }
        }
    }

    /// The initialiser of a constant.
    pub fn initialiser(&mut self, expression: &Expr, ty: &Type) -> Result<String> {
        match (bare(expression), ty) {
            (Expr::Array(array), Type::Array(element, _)) => {
                let mut parts = vec![];
                for one in &array.elems {
                    parts.push(self.initialiser(one, element)?);
                }
                Ok(format!("{{{}}}", parts.join(", ")))
            }
            (Expr::Struct(value), Type::Struct(key)) => {
                let items = self.items;
                let mut text = "{\n".to_string();
                self.depth += 1;
                for field in &value.fields {
                    let syn::Member::Named(name) = &field.member else {
                        return self.refuse("this field");
                    };
                    let name = name.to_string();
                    let Some(own) = items.field(key, &name) else {
                        return self.refuse(format!("the field {name} of {}", last(&value.path)));
                    };
                    let value = self.initialiser(&field.expr, own)?;
                    let indent = "    ".repeat(self.depth);
                    text.push_str(&format!("{indent}.{name} = {value},\n"));
                }
                self.depth -= 1;
                Ok(text + &"    ".repeat(self.depth) + "}")
            }
            (_, ty) if !ty.is_aggregate() => Ok(self.scalar(expression, Some(ty))?.text),
            // The constant is a copy of another one, whose initialiser is used.
            (Expr::Path(path), ty) => {
                let key = self.items.resolve(self.module, &last(&path.path));
                match self.items.constants.get(&key) {
                    Some(constant) => self.initialiser(&constant.value.clone(), &ty.clone()),
                    None => self.refuse("this constant"),
                }
            }
            _ => self.refuse("this constant"),
        }
    }
}
