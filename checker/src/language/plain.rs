//! Constructs that are always refused, because a shorter form has the same meaning: paths
//! through types (`<i32>::MAX`), leading `::`, arguments of paths, receivers with a type, `&mut`
//! except of a receiver, lifetimes and labels, patterns that bind by reference.

use std::sync::Arc;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::language::declarations::{Read, refuse};

/// The first of them that was found.
struct Finder(Option<(proc_macro2::Span, &'static str)>);

impl Finder {
    fn found(&mut self, span: proc_macro2::Span, what: &'static str) {
        self.0.get_or_insert((span, what));
    }

    fn verdict(self, path: &Arc<str>) -> Read<()> {
        match self.0 {
            Some((span, what)) => refuse(path, span, format!("found {what}")),
            None => Ok(()),
        }
    }
}

impl<'ast> Visit<'ast> for Finder {
    fn visit_qself(&mut self, node: &'ast syn::QSelf) {
        self.found(node.span(), "a path goes through a type; names are plain");
        visit::visit_qself(self, node);
    }

    fn visit_path(&mut self, node: &'ast syn::Path) {
        if node.leading_colon.is_some() {
            self.found(node.span(), "a path begins with `::`; names are plain");
        }
        for segment in &node.segments {
            let is_plain = match &segment.arguments {
                syn::PathArguments::None => true,
                syn::PathArguments::AngleBracketed(arguments) => {
                    segment.ident == "Option"
                        && arguments.colon2_token.is_none()
                        && node.segments.len() == 1
                }
                syn::PathArguments::Parenthesized(_) => false,
            };
            if !is_plain {
                self.found(segment.span(), "a path has arguments; only Option has one");
            }
        }
        visit::visit_path(self, node);
    }

    fn visit_receiver(&mut self, node: &'ast syn::Receiver) {
        let is_plain = matches!(&node.kind, syn::ReceiverKind::Reference(_, None, _))
            && node.mutability.is_none();
        if !is_plain {
            self.found(node.span(), "a receiver is `&self` or `&mut self`");
        }
        visit::visit_receiver(self, node);
    }

    fn visit_type_reference(&mut self, node: &'ast syn::TypeReference) {
        if node.mutability.is_some() {
            self.found(node.span(), "only a receiver is `&mut`");
        }
        visit::visit_type_reference(self, node);
    }

    fn visit_lifetime(&mut self, node: &'ast syn::Lifetime) {
        self.found(node.span(), "a lifetime or a label; there are none here");
    }

    fn visit_expr_method_call(&mut self, node: &'ast syn::ExprMethodCall) {
        if let Some(turbofish) = &node.turbofish {
            self.found(turbofish.span(), "a call has arguments of types");
        }
        visit::visit_expr_method_call(self, node);
    }

    fn visit_pat_ident(&mut self, node: &'ast syn::PatIdent) {
        if node.by_ref.is_some() || node.subpat.is_some() {
            self.found(node.span(), "a pattern binds more than a name");
        }
        visit::visit_pat_ident(self, node);
    }
}

/// Refuses the constructs above in a file.
pub(super) fn check_file(path: &Arc<str>, file: &syn::File) -> Read<()> {
    let mut finder = Finder(None);
    finder.visit_file(file);
    finder.verdict(path)
}

/// Refuses the constructs above in an expression that stood in a macro.
pub(super) fn check_expression(path: &Arc<str>, expression: &syn::Expr) -> Read<()> {
    let mut finder = Finder(None);
    finder.visit_expr(expression);
    finder.verdict(path)
}
