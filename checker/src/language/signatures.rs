//! Types as they are written, and signatures of functions.

use std::sync::Arc;

use syn::spanned::Spanned;

use crate::language::attributes::no_generics;
use crate::language::declarations::{Argument, Declarations, Named, Read, refuse, shown};
use crate::program::types::{Integer, Type};

impl Declarations {
    pub(super) fn signature(
        &self,
        module: usize,
        path: &Arc<str>,
        signature: &syn::Signature,
        owner: Option<usize>,
    ) -> Read<(Vec<Argument>, Type)> {
        no_generics(path, &signature.generics)?;
        if !is_plain(signature) {
            return refuse(
                path,
                signature.span(),
                format!("found {}; functions are plain", shown(signature)),
            );
        }
        let mut arguments = Vec::new();
        for input in &signature.inputs {
            match input {
                syn::FnArg::Receiver(receiver) => {
                    let Some(owner) = owner else {
                        return refuse(path, receiver.span(), "`self` outside an impl".to_owned());
                    };
                    arguments.push(Argument {
                        name: "self".to_owned(),
                        type_: Type::Struct(owner),
                        is_reference: true,
                        is_mutable: matches!(
                            receiver.kind,
                            syn::ReceiverKind::Reference(_, _, Some(_))
                        ),
                    });
                }
                syn::FnArg::Typed(typed) => {
                    let name = match &*typed.pat {
                        syn::Pat::Ident(name) if name.by_ref.is_none() && name.subpat.is_none() => {
                            name
                        }
                        other => {
                            return refuse(
                                path,
                                other.span(),
                                format!("found {}; an argument has a name", shown(other)),
                            );
                        }
                    };
                    let (written, is_reference) = match &*typed.ty {
                        syn::Type::Reference(reference) => (&*reference.elem, true),
                        other => (other, false),
                    };
                    arguments.push(Argument {
                        name: name.ident.to_string(),
                        type_: self.owned_type(module, path, written, owner)?,
                        is_reference,
                        is_mutable: false,
                    });
                }
            }
        }
        let result = match &signature.output {
            syn::ReturnType::Default => Type::Tuple(Vec::new()),
            syn::ReturnType::Type(_, type_) => {
                let type_ = match &**type_ {
                    syn::Type::Reference(reference) if reference.mutability.is_none() => {
                        &reference.elem
                    }
                    other => other,
                };
                self.owned_type(module, path, type_, owner)?
            }
        };
        Ok((arguments, result))
    }

    /// A type in which `Self` may stand.
    pub(super) fn owned_type(
        &self,
        module: usize,
        path: &Arc<str>,
        type_: &syn::Type,
        owner: Option<usize>,
    ) -> Read<Type> {
        if let (syn::Type::Path(named), Some(owner)) = (type_, owner)
            && named.path.is_ident("Self")
        {
            return Ok(Type::Struct(owner));
        }
        self.type_(module, path, type_)
    }

    /// The type written as `type_` in `module`.
    pub(crate) fn type_(&self, module: usize, path: &Arc<str>, type_: &syn::Type) -> Read<Type> {
        match type_ {
            syn::Type::Path(named) if named.qself.is_none() => {
                if let Some(name) = named.path.get_ident() {
                    let name = name.to_string();
                    if name == "bool" {
                        return Ok(Type::Bool);
                    }
                    if let Some(integer) = Integer::named(&name) {
                        return Ok(Type::Integer(integer));
                    }
                    if let Some(Named::Type(type_)) = self.files[module].names.get(&name) {
                        return Ok(type_.clone());
                    }
                }
                if let [segment] = named.path.segments.iter().collect::<Vec<_>>().as_slice()
                    && segment.ident == "Option"
                    && let syn::PathArguments::AngleBracketed(arguments) = &segment.arguments
                    && let [syn::GenericArgument::Type(content)] =
                        arguments.args.iter().collect::<Vec<_>>().as_slice()
                {
                    let content = self.type_(module, path, content)?;
                    return Ok(Type::Option(Box::new(content)));
                }
            }
            syn::Type::Tuple(tuple) => {
                let elements = tuple
                    .elems
                    .iter()
                    .map(|element| self.type_(module, path, element))
                    .collect::<Read<_>>()?;
                return Ok(Type::Tuple(elements));
            }
            syn::Type::Array(array) => {
                if let syn::Expr::Lit(literal) = &array.len
                    && let syn::Lit::Int(length) = &literal.lit
                    && let Ok(length) = length.base10_parse::<usize>()
                    && length <= 64
                {
                    let element = self.type_(module, path, &array.elem)?;
                    return Ok(Type::Array(Box::new(element), length));
                }
            }
            _ => {}
        }
        refuse(
            path,
            type_.span(),
            format!(
                "found the type {}; understood are integers, bool, aliases of 32-bit fixed-point \
                 types, structs of the crate, arrays, tuples and Option",
                shown(type_)
            ),
        )
    }
}

/// The type that an alias stands for: `fixed::types::IxFy` with x + y = 32.
pub(super) fn fixed_type(path: &Arc<str>, type_: &syn::Type) -> Read<Type> {
    if let syn::Type::Path(named) = type_ {
        let segments: Vec<_> = named
            .path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        if let [first, second, name] = segments.as_slice()
            && first == "fixed"
            && second == "types"
            && let Some(type_) = fixed_named(name)
        {
            return Ok(type_);
        }
    }
    refuse(
        path,
        type_.span(),
        format!(
            "found {}; an alias stands for fixed::types::IxFy with x + y = 32",
            shown(type_)
        ),
    )
}

pub(super) fn fixed_named(name: &str) -> Option<Type> {
    let (integer, fraction) = name.strip_prefix('I')?.split_once('F')?;
    let (integer, fraction): (u32, u32) = (integer.parse().ok()?, fraction.parse().ok()?);
    (integer.checked_add(fraction)? == 32).then_some(Type::Fixed(fraction))
}

fn is_plain(signature: &syn::Signature) -> bool {
    signature.asyncness.is_none()
        && signature.abi.is_none()
        && signature.variadic.is_none()
        && matches!(signature.safety, syn::Safety::Default)
}
