//! How the files of an emitted crate belong together: what its root declares, and which names a file takes from
//! others.

use std::sync::Arc;

use syn::spanned::Spanned;

use crate::language::attributes::outer_attributes;
use crate::language::declarations::{Declarations, Named, Read, refuse, shown};
use crate::language::signatures::fixed_named;
use crate::language::visibility;

impl Declarations {
    /// `src/lib.rs` forbids unsafe code, needs no standard library, and declares every file.
    pub(super) fn root(&self, path: &Arc<str>, file: &syn::File) -> Read<()> {
        let start = proc_macro2::Span::call_site();
        for (name, argument) in [("no_std", None), ("forbid", Some("unsafe_code"))] {
            let is_there = file.attrs.iter().any(|attribute| {
                attribute.path().is_ident(name)
                    && attribute
                        .meta
                        .require_list()
                        .ok()
                        .map(|list| list.tokens.to_string())
                        .as_deref()
                        == argument
            });
            if !is_there {
                let shown = argument.map_or(name.to_owned(), |text| format!("{name}({text})"));
                return refuse(path, start, format!("`#![{shown}]` is missing"));
            }
        }
        let is_declared = |name: &str| {
            file.items
                .iter()
                .any(|item| matches!(item, syn::Item::Mod(item) if item.ident == name))
        };
        for other in &self.files {
            if !other.module.is_empty() && !is_declared(&other.module) {
                let message = format!("`{}` is a file of no module", other.path);
                return refuse(path, start, message);
            }
        }
        for item in &file.items {
            let (vis, span) = match item {
                syn::Item::Mod(item) => (&item.vis, item.span()),
                syn::Item::Use(item) => (&item.vis, item.span()),
                _ => continue,
            };
            if !matches!(vis, syn::Visibility::Public(_)) {
                return refuse(path, span, format!("{} is not public", shown(item)));
            }
        }
        Ok(())
    }

    /// Second pass: `use`, repeated because a name may be passed on.
    pub(super) fn imports(&mut self, parsed: &[(Arc<str>, syn::File)]) -> Read<()> {
        let mut pending = Vec::new();
        for (module, (path, file)) in parsed.iter().enumerate() {
            for item in &file.items {
                if let syn::Item::Use(item) = item {
                    outer_attributes(path, &item.attrs)?;
                    let mut prefix = Vec::new();
                    use_paths(path, &item.tree, &mut prefix, &mut |segments, span| {
                        pending.push((module, path.clone(), segments, span));
                    })?;
                }
            }
        }
        for (_, path, segments, span) in &pending {
            if let [.., file, name] = segments.as_slice()
                && let Some(other) = self.module(file)
                && !visibility::is_shown(&parsed[other].1, name)
            {
                let message = format!("`{name}` of src/{file}.rs is private");
                return refuse(path, *span, message);
            }
        }
        while !pending.is_empty() {
            let before = pending.len();
            let mut left = Vec::new();
            for (module, path, segments, span) in pending {
                match self.import(module, &segments) {
                    Some(named) => {
                        let name = segments.last().cloned().unwrap_or_default();
                        let names = &mut self.files[module].names;
                        if names.insert(name.clone(), named).is_some() {
                            return refuse(&path, span, format!("`{name}` is defined twice"));
                        }
                    }
                    None => left.push((module, path, segments, span)),
                }
            }
            if left.len() == before {
                let (_, path, segments, span) = &left[0];
                return refuse(
                    path,
                    *span,
                    format!("`{}` is not known in this crate", segments.join("::")),
                );
            }
            pending = left;
        }
        Ok(())
    }

    fn import(&self, module: usize, segments: &[String]) -> Option<Named> {
        let parts: Vec<_> = segments.iter().map(String::as_str).collect();
        let is_root = self.files[module].module.is_empty();
        match parts.as_slice() {
            ["fixed", "types", name] => fixed_named(name).map(Named::Type),
            ["super" | "crate", file, name] => self.lookup(file, name),
            [file, name] if is_root => self.lookup(file, name),
            _ => None,
        }
    }
}

/// Paths of a `use`, with their last name.
fn use_paths(
    path: &Arc<str>,
    tree: &syn::UseTree,
    prefix: &mut Vec<String>,
    found: &mut impl FnMut(Vec<String>, proc_macro2::Span),
) -> Read<()> {
    match tree {
        syn::UseTree::Path(tree) => {
            prefix.push(tree.ident.to_string());
            use_paths(path, &tree.tree, prefix, found)?;
            prefix.pop();
            Ok(())
        }
        syn::UseTree::Name(name) => {
            let mut segments = prefix.clone();
            segments.push(name.ident.to_string());
            found(segments, name.ident.span());
            Ok(())
        }
        syn::UseTree::Group(group) => group
            .items
            .iter()
            .try_for_each(|tree| use_paths(path, tree, prefix, found)),
        other => refuse(
            path,
            other.span(),
            format!("found {}; a `use` lists names", shown(other)),
        ),
    }
}
