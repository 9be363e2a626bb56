//! Calls: methods of numbers, constructors of words, functions of the module.

use syn::Expr;

use super::Result;
use super::expression::{CScalar, bare, kind};
use super::items::{Function, FunctionKey, last};
use super::scope::{CPlace, Scope};
use super::types::{Int, Type};

/// A call: the function and its arguments.
pub struct Call<'e> {
    /// The function.
    pub key: FunctionKey,
    /// The receiver, if there is one.
    pub receiver: Option<&'e Expr>,
    /// The others.
    pub arguments: Vec<&'e Expr>,
}

impl Scope<'_> {
    pub(super) fn method(&mut self, call: &syn::ExprMethodCall) -> Result<CScalar> {
        match call.method.to_string().as_str() {
            "to_bits" => self.scalar(&call.receiver, None),
            "clamp" => {
                let value = self.scalar(&call.receiver, None)?;
                let mut texts = vec![value.text.clone()];
                for argument in &call.args {
                    texts.push(self.scalar(argument, Some(&value.ty))?.text);
                }
                if value.ty != Type::Int(Int::I64) {
                    return self.refuse("`clamp` of this type");
                }
                self.needs.clamp_64 = true;
                let text = format!("clamp_64({})", texts.join(", "));
                Ok(CScalar::new(text, value.ty, 0))
            }
            _ => self.called(&Expr::MethodCall(call.clone())),
        }
    }

    pub(super) fn call(&mut self, call: &syn::ExprCall) -> Result<CScalar> {
        let Expr::Path(path) = &*call.func else {
            return self.refuse("this call");
        };
        let names: Vec<String> = path
            .path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        let argument = call.args.first();
        match (&names[..], argument) {
            ([name], Some(inner)) if self.word(name).is_some() => {
                let word = self.word(name);
                self.scalar(inner, word.as_ref())
            }
            ([word, make], Some(inner)) if make == "from_bits" && self.word(word).is_some() => {
                self.scalar(inner, Some(&Type::Int(Int::I32)))
            }
            ([int, make], Some(inner)) if make == "from" => match Int::from_name(int) {
                Some(int) => self.cast(inner, Type::Int(int)),
                None => self.refuse(format!("{int}::from")),
            },
            _ => self.called(&Expr::Call(call.clone())),
        }
    }

    /// The number that a type of the module stands for.
    pub(super) fn word(&self, name: &str) -> Option<Type> {
        let key = self.items.resolve(self.module, name);
        let own = (self.module.to_string(), name.to_string());
        let words = &self.items.words;
        words
            .get(&key)
            .or_else(|| words.get(&own))
            .map(|(word, _)| word.clone())
    }

    /// A call that returns a scalar.
    fn called(&mut self, expression: &Expr) -> Result<CScalar> {
        let call = self.resolved(expression)?;
        let text = self.call_text(&call, &[])?;
        let returns = self.function(&call.key)?.returns.clone();
        Ok(CScalar::new(text, returns, 0))
    }

    /// The function that is called.
    pub fn resolved<'e>(&mut self, expression: &'e Expr) -> Result<Call<'e>> {
        match bare(expression) {
            Expr::Call(call) => {
                let Expr::Path(path) = &*call.func else {
                    return self.refuse("this call");
                };
                let name = last(&path.path);
                let key = match path.path.segments.len() {
                    1 => {
                        let (module, name) = self.items.resolve(self.module, &name);
                        (module, None, name)
                    }
                    _ => {
                        let owner = path.path.segments[0].ident.to_string();
                        let owner = match (owner.as_str(), self.owner) {
                            ("Self", Some(own)) => own.to_string(),
                            _ => owner,
                        };
                        let (module, owner) = self.items.resolve(self.module, &owner);
                        (module, Some(owner), name)
                    }
                };
                Ok(Call {
                    key,
                    receiver: None,
                    arguments: call.args.iter().collect(),
                })
            }
            Expr::MethodCall(call) => {
                let receiver = self.infer(&call.receiver)?;
                let Some(Type::Struct((module, owner))) = receiver else {
                    return self.refuse(format!("the method {}", call.method));
                };
                Ok(Call {
                    key: (module, Some(owner), call.method.to_string()),
                    receiver: Some(&call.receiver),
                    arguments: call.args.iter().collect(),
                })
            }
            other => self.refuse(kind(other)),
        }
    }

    /// The function with this key.
    pub fn function(&self, key: &FunctionKey) -> Result<&Function> {
        match self.items.functions.get(key) {
            Some(function) => Ok(function),
            None => self.refuse(format!("a call of {}::{}", key.0, key.2)),
        }
    }

    /// The text of a call; structures and arrays that it returns go to `targets`.
    pub fn call_text(&mut self, call: &Call, targets: &[CPlace]) -> Result<String> {
        self.needs.functions.insert(call.key.clone());
        let parameters: Vec<Type> = {
            let function = self.function(&call.key)?;
            function
                .parameters
                .iter()
                .map(|(_, ty)| ty.clone())
                .collect()
        };
        let mut texts = vec![];
        if let Some(receiver) = call.receiver {
            texts.push(self.place(receiver)?.argument());
        }
        for (argument, ty) in call.arguments.iter().zip(&parameters) {
            texts.push(if ty.is_aggregate() {
                self.place(argument)?.argument()
            } else {
                self.scalar(argument, Some(ty))?.text
            });
        }
        texts.extend(targets.iter().map(CPlace::argument));
        Ok(format!(
            "{}({})",
            super::names::function_name(&call.key),
            texts.join(", ")
        ))
    }
}
