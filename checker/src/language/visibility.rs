//! Visibility of items. `rustc` refuses a private item that another file names. The reader inlines calls and would not
//! notice. Three rules make sure that both read the same crate: an item is either `pub` or private; an item that
//! another file imports is `pub`; the fields of a struct are all public or all private.

use std::sync::Arc;

use syn::spanned::Spanned;
use syn::visit::Visit;

use crate::language::declarations::{Read, refuse};

/// Finds `pub(…)`.
struct Between(Option<proc_macro2::Span>);

impl<'ast> Visit<'ast> for Between {
    fn visit_visibility(&mut self, node: &'ast syn::Visibility) {
        if let syn::Visibility::Restricted(_) = node {
            self.0.get_or_insert(node.span());
        }
    }
}

/// Checks one file by itself.
///
/// # Errors
/// The first place that breaks one of these rules.
pub(crate) fn check_file(path: &Arc<str>, file: &syn::File) -> Read<()> {
    let mut between = Between(None);
    between.visit_file(file);
    if let Some(span) = between.0 {
        let message = "an item is `pub` or private, nothing between".to_owned();
        return refuse(path, span, message);
    }
    for item in &file.items {
        if let syn::Item::Struct(item) = item {
            let public = item.fields.iter().filter(|field| is_public(&field.vis));
            let count = public.count();
            if count != 0 && count != item.fields.len() {
                let message = "the fields of a struct are all public or all private".to_owned();
                return refuse(path, item.ident.span(), message);
            }
        }
    }
    Ok(())
}

/// Whether it is `pub`.
pub(crate) fn is_public(visibility: &syn::Visibility) -> bool {
    matches!(visibility, syn::Visibility::Public(_))
}

/// Whether another file may import `name` from this file. A name that this file only passes on may be imported.
pub(crate) fn is_shown(file: &syn::File, name: &str) -> bool {
    let own = file.items.iter().find_map(|item| {
        let (ident, visibility) = match item {
            syn::Item::Struct(item) => (&item.ident, &item.vis),
            syn::Item::Enum(item) => (&item.ident, &item.vis),
            syn::Item::Type(item) => (&item.ident, &item.vis),
            syn::Item::Const(item) => (&item.ident, &item.vis),
            syn::Item::Fn(item) => (&item.sig.ident, &item.vis),
            _ => return None,
        };
        (ident == name).then_some(visibility)
    });
    own.is_none_or(is_public)
}
