//! Attributes and generics that emitted code may have.

use std::sync::Arc;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::language::declarations::{Read, refuse, shown};

/// Finds attributes inside of functions, where `cfg` would take away code that is read here.
pub(super) struct AttributeFinder(Option<proc_macro2::Span>);

impl<'ast> Visit<'ast> for AttributeFinder {
    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        self.0.get_or_insert(attribute.span());
        visit::visit_attribute(self, attribute);
    }
}

pub(super) fn no_attributes(path: &Arc<str>, look: impl FnOnce(&mut AttributeFinder)) -> Read<()> {
    let mut finder = AttributeFinder(None);
    look(&mut finder);
    match finder.0 {
        Some(span) => refuse(
            path,
            span,
            "an attribute stands here; bodies and arguments have none".to_owned(),
        ),
        None => Ok(()),
    }
}

pub(super) fn no_generics(path: &Arc<str>, generics: &syn::Generics) -> Read<()> {
    if generics.params.is_empty() && generics.where_clause.is_none() {
        Ok(())
    } else {
        refuse(
            path,
            generics.span(),
            format!("found {}; nothing is generic here", shown(generics)),
        )
    }
}

pub(super) fn inner_attributes(path: &Arc<str>, attributes: &[syn::Attribute]) -> Read<()> {
    attributes.iter().try_for_each(|attribute| {
        let name = attribute.path();
        let is_known = ["no_std", "forbid", "warn"]
            .iter()
            .any(|known| name.is_ident(known));
        if is_known || is_documentation(attribute) {
            Ok(())
        } else {
            refuse(
                path,
                attribute.span(),
                format!(
                    "found {}; not an attribute of emitted files",
                    shown(attribute)
                ),
            )
        }
    })
}

/// A comment of documentation, not one that is read from somewhere.
fn is_documentation(attribute: &syn::Attribute) -> bool {
    attribute.path().is_ident("doc")
        && matches!(
            &attribute.meta,
            syn::Meta::NameValue(syn::MetaNameValue {
                value: syn::Expr::Lit(_),
                ..
            })
        )
}

/// Attributes that do not change what the code does. Contracts that Kani proves stand under
/// `cfg_attr(kani, …)`, which nothing but Kani compiles, and those that the checker alone proves under
/// `cfg_attr(any(), …)`, which nothing compiles.
pub(super) fn outer_attributes(path: &Arc<str>, attributes: &[syn::Attribute]) -> Read<()> {
    attributes.iter().try_for_each(|attribute| {
        let name = attribute.path();
        let list = || {
            attribute
                .parse_args_with(
                    syn::punctuated::Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated,
                )
                .ok()
        };
        let is_harmless = is_documentation(attribute)
            || ["inline", "must_use"]
                .iter()
                .any(|known| name.is_ident(known));
        let is_derive = name.is_ident("derive")
            && list().is_some_and(|list| {
                list.iter().all(|item| {
                    ["Clone", "Copy", "Debug", "PartialEq", "Eq"]
                        .iter()
                        .any(|known| item.path().is_ident(known))
                })
            });
        // One contract each: a second attribute in the list could be anything.
        let is_contract = name.is_ident("cfg_attr")
            && list().is_some_and(|list| {
                let paths: Vec<Vec<String>> = list
                    .iter()
                    .map(|item| {
                        let segments = item.path().segments.iter();
                        segments.map(|segment| segment.ident.to_string()).collect()
                    })
                    .collect();
                let paths: Vec<Vec<&str>> = paths
                    .iter()
                    .map(|path| path.iter().map(String::as_str).collect())
                    .collect();
                let paths: Vec<&[&str]> = paths.iter().map(Vec::as_slice).collect();
                let is_never = list.first().is_some_and(|condition| match condition {
                    syn::Meta::Path(path) => path.is_ident("kani"),
                    syn::Meta::List(list) => list.path.is_ident("any") && list.tokens.is_empty(),
                    syn::Meta::NameValue(_) => false,
                });
                let is_one_contract = matches!(
                    paths.as_slice(),
                    [["kani" | "any"], ["kani", "requires" | "ensures"]]
                );
                is_never && is_one_contract
            });
        if is_harmless || is_derive || is_contract {
            Ok(())
        } else {
            refuse(
                path,
                attribute.span(),
                format!(
                    "found {}; not an attribute of emitted items",
                    shown(attribute)
                ),
            )
        }
    })
}
