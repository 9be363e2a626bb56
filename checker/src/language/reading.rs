//! The declarations of an emitted crate: files, types, constants and functions.
//!
//! The language is the one that the generator documents for its output, implemented here from that
//! documentation: 32-bit fixed-point aliases, structs, arrays, plain functions, no loops,
//! no generics, no traits except `Default`, no macro except `assert!` in a constant. Anything else is
//! refused with its place. [`crate::language::lower`] reads the bodies.

use std::collections::HashMap;
use std::sync::Arc;

use syn::spanned::Spanned;
use syn::visit::Visit;

use crate::language::attributes::{inner_attributes, no_attributes, no_generics, outer_attributes};
use crate::language::declarations::{
    Constant, Declarations, Enum, Function, Named, Read, SourceFile, Struct, refuse, shown,
};
use crate::language::signatures::fixed_type;
use crate::language::{plain, text, visibility};
use crate::program::place::{SourceError, SourcePlace};
use crate::program::types::{Integer, Type};

impl Declarations {
    /// Reads all files of a crate, given as (path, text).
    ///
    /// # Errors
    /// [`SourceError`] for Rust that does not parse and for every construct outside the language.
    pub fn read(sources: &[(&str, &str)]) -> Read<Declarations> {
        let mut declarations = Declarations::default();
        let mut parsed = Vec::new();
        for (path, text) in sources {
            let path: Arc<str> = (*path).into();
            text::check(&path, text)?;
            let file = syn::parse_file(text).map_err(|error| SourceError {
                place: SourcePlace::of(&path, error.span()),
                message: format!("this is no Rust: {error}"),
            })?;
            plain::check_file(&path, &file)?;
            visibility::check_file(&path, &file)?;
            declarations.files.push(SourceFile {
                module: module_name(&path),
                path: path.clone(),
                names: HashMap::new(),
            });
            parsed.push((path, file));
        }
        for (module, (path, file)) in parsed.iter().enumerate() {
            inner_attributes(path, &file.attrs)?;
            if declarations.files[module].module.is_empty() {
                declarations.root(path, file)?;
            }
            for item in &file.items {
                declarations.item_name(module, path, item)?;
            }
        }
        declarations.imports(&parsed)?;
        for (module, (path, file)) in parsed.iter().enumerate() {
            for item in &file.items {
                declarations.item_types(module, path, item)?;
            }
        }
        for (module, (path, file)) in parsed.iter().enumerate() {
            for item in &file.items {
                declarations.item_bodies(module, path, item)?;
            }
        }
        Ok(declarations)
    }

    /// First pass: which structs there are, so that types can name each other.
    fn item_name(&mut self, module: usize, path: &Arc<str>, item: &syn::Item) -> Read<()> {
        if let syn::Item::Struct(item) = item {
            outer_attributes(path, &item.attrs)?;
            let number = self.structs.len();
            self.structs.push(Struct {
                name: item.ident.to_string(),
                fields: Vec::new(),
                module,
                is_whole: item
                    .fields
                    .iter()
                    .all(|field| matches!(field.vis, syn::Visibility::Public(_))),
                is_open: item
                    .fields
                    .iter()
                    .any(|field| !matches!(field.vis, syn::Visibility::Inherited)),
            });
            self.define(module, path, &item.ident, Named::Type(Type::Struct(number)))?;
        }
        if let syn::Item::Enum(item) = item {
            self.enumeration(module, path, item)?;
        }
        if let syn::Item::Type(item) = item {
            outer_attributes(path, &item.attrs)?;
            no_generics(path, &item.generics)?;
            let type_ = fixed_type(path, &item.ty)?;
            self.define(module, path, &item.ident, Named::Type(type_))?;
        }
        if let syn::Item::Const(item) = item
            && item.ident != "_"
        {
            let number = self.constants.len();
            self.constants.push(Constant {
                name: item.ident.to_string(),
                module,
                type_: Type::Bool,
                expression: (*item.expr).clone(),
                place: SourcePlace::of(
                    path,
                    item.vis
                        .span()
                        .join(item.ident.span())
                        .unwrap_or(item.ident.span()),
                ),
                is_public: matches!(item.vis, syn::Visibility::Public(_)),
            });
            self.define(module, path, &item.ident, Named::Constant(number))?;
        }
        if let syn::Item::Fn(item) = item {
            let number = self.functions.len();
            self.functions.push(Function {
                name: item.sig.ident.to_string(),
                module,
                owner: None,
                arguments: Vec::new(),
                result: Type::Tuple(Vec::new()),
                body: (*item.block).clone(),
                place: SourcePlace::of(path, item.sig.ident.span()),
                attributes: item.attrs.clone(),
                is_public: matches!(item.vis, syn::Visibility::Public(_)),
            });
            self.define(module, path, &item.sig.ident, Named::Function(number))?;
        }
        Ok(())
    }

    /// An enum without fields, its values written and counted from zero.
    fn enumeration(&mut self, module: usize, path: &Arc<str>, item: &syn::ItemEnum) -> Read<()> {
        outer_attributes(path, &item.attrs)?;
        no_generics(path, &item.generics)?;
        let mut variants: Vec<String> = Vec::new();
        for (index, variant) in item.variants.iter().enumerate() {
            outer_attributes(path, &variant.attrs)?;
            let value = match &variant.discriminant {
                Some((_, syn::Expr::Lit(literal))) => match &literal.lit {
                    syn::Lit::Int(value) => value.base10_parse::<usize>().ok(),
                    _ => None,
                },
                _ => None,
            };
            if value != Some(index) || index > 254 || !matches!(variant.fields, syn::Fields::Unit) {
                return refuse(
                    path,
                    variant.span(),
                    format!(
                        "found {}; a variant has no fields and the value {index}",
                        shown(variant)
                    ),
                );
            }
            variants.push(variant.ident.to_string());
        }
        let (number, count) = (self.enums.len(), variants.len() as u8);
        self.enums.push(Enum {
            name: item.ident.to_string(),
            module,
            variants,
        });
        let type_ = Type::Enum(number, count);
        self.define(module, path, &item.ident, Named::Type(type_))
    }

    fn define(
        &mut self,
        module: usize,
        path: &Arc<str>,
        name: &syn::Ident,
        named: Named,
    ) -> Read<()> {
        let text = name.to_string();
        // Rust would take the new meaning where this reader takes the usual one.
        let is_taken = Integer::named(&text).is_some() || TAKEN_NAMES.contains(&text.as_str());
        if is_taken {
            return refuse(path, name.span(), format!("`{name}` has a meaning in Rust"));
        }
        if self.files[module].names.insert(text, named).is_some() {
            return refuse(path, name.span(), format!("`{name}` is defined twice"));
        }
        Ok(())
    }

    /// Third pass: types of fields, constants and signatures.
    fn item_types(&mut self, module: usize, path: &Arc<str>, item: &syn::Item) -> Read<()> {
        match item {
            syn::Item::Struct(item) => {
                no_generics(path, &item.generics)?;
                let mut fields = Vec::new();
                for (index, field) in item.fields.iter().enumerate() {
                    outer_attributes(path, &field.attrs)?;
                    let name = field
                        .ident
                        .as_ref()
                        .map_or(index.to_string(), ToString::to_string);
                    fields.push((name, self.type_(module, path, &field.ty)?));
                }
                let Some(Named::Type(Type::Struct(number))) =
                    self.files[module].names.get(&item.ident.to_string())
                else {
                    return refuse(path, item.ident.span(), "a struct is expected".to_owned());
                };
                let number = *number;
                self.structs[number].fields = fields;
            }
            syn::Item::Const(item) => {
                outer_attributes(path, &item.attrs)?;
                no_generics(path, &item.generics)?;
                no_attributes(path, |finder| finder.visit_expr(&item.expr))?;
                let type_ = self.type_(module, path, &item.ty)?;
                if item.ident == "_" {
                    self.constants.push(Constant {
                        name: "_".to_owned(),
                        module,
                        type_,
                        expression: (*item.expr).clone(),
                        place: SourcePlace::of(path, item.const_token.span()),
                        is_public: false,
                    });
                } else if let Some(Named::Constant(number)) =
                    self.files[module].names.get(&item.ident.to_string())
                {
                    let number = *number;
                    self.constants[number].type_ = type_;
                }
            }
            syn::Item::Fn(item) => {
                outer_attributes(path, &item.attrs)?;
                no_attributes(path, |finder| {
                    finder.visit_signature(&item.sig);
                    finder.visit_block(&item.block);
                })?;
                let (arguments, result) = self.signature(module, path, &item.sig, None)?;
                if let Some(Named::Function(number)) =
                    self.files[module].names.get(&item.sig.ident.to_string())
                {
                    let number = *number;
                    self.functions[number].arguments = arguments;
                    self.functions[number].result = result;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Fourth pass: methods, and the refusal of every other item.
    fn item_bodies(&mut self, module: usize, path: &Arc<str>, item: &syn::Item) -> Read<()> {
        match item {
            syn::Item::Struct(_)
            | syn::Item::Enum(_)
            | syn::Item::Const(_)
            | syn::Item::Fn(_)
            | syn::Item::Type(_)
            | syn::Item::Use(_) => Ok(()),
            syn::Item::Mod(item) => {
                outer_attributes(path, &item.attrs)?;
                if item.content.is_some() || !self.files[module].module.is_empty() {
                    return refuse(
                        path,
                        item.span(),
                        "modules are declared in src/lib.rs, each with a file of its own"
                            .to_owned(),
                    );
                }
                let name = item.ident.to_string();
                if let Some(why) = unusable_module(&name) {
                    return refuse(path, item.span(), format!("`{name}` {why}"));
                }
                if self.module(&item.ident.to_string()).is_none() {
                    return refuse(
                        path,
                        item.span(),
                        format!("there is no file src/{}.rs", item.ident),
                    );
                }
                Ok(())
            }
            syn::Item::Impl(item) => self.methods(module, path, item),
            other => refuse(
                path,
                other.span(),
                format!(
                    "found {}; emitted files hold types, structs, constants, functions and methods",
                    shown(other)
                ),
            ),
        }
    }

    fn methods(&mut self, module: usize, path: &Arc<str>, item: &syn::ItemImpl) -> Read<()> {
        outer_attributes(path, &item.attrs)?;
        no_generics(path, &item.generics)?;
        if let Some((name, _)) = &item.trait_
            && !name.is_ident("Default")
        {
            return refuse(
                path,
                name.span(),
                format!(
                    "found the trait {}; only `Default` is implemented",
                    shown(name)
                ),
            );
        }
        let Type::Struct(owner) = self.type_(module, path, &item.self_ty)? else {
            return refuse(
                path,
                item.self_ty.span(),
                "methods belong to structs".to_owned(),
            );
        };
        for item in &item.items {
            let syn::ImplItem::Fn(function) = item else {
                return refuse(
                    path,
                    item.span(),
                    format!("found {}; an `impl` holds functions", shown(item)),
                );
            };
            outer_attributes(path, &function.attrs)?;
            no_attributes(path, |finder| {
                finder.visit_signature(&function.sig);
                finder.visit_block(&function.block);
            })?;
            let (arguments, result) = self.signature(module, path, &function.sig, Some(owner))?;
            // An invariant of a state that every step keeps holds only if nothing else can write the state.
            let is_mutating = arguments.first().is_some_and(|first| first.is_mutable);
            if is_mutating && self.structs[owner].is_open {
                return refuse(
                    path,
                    function.sig.ident.span(),
                    format!(
                        "`{}` has a field that others can write, and a method that changes it",
                        self.structs[owner].name
                    ),
                );
            }
            let number = self.functions.len();
            let name = function.sig.ident.to_string();
            self.functions.push(Function {
                name: format!("{}::{name}", self.structs[owner].name),
                module,
                owner: Some(owner),
                arguments,
                result,
                body: function.block.clone(),
                place: SourcePlace::of(path, function.sig.ident.span()),
                attributes: function.attrs.clone(),
                is_public: matches!(function.vis, syn::Visibility::Public(_)),
            });
            if self.methods.insert((owner, name), number).is_some() {
                return refuse(
                    path,
                    function.sig.ident.span(),
                    format!("{} is defined twice", shown(&function.sig.ident)),
                );
            }
        }
        Ok(())
    }
}

fn module_name(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    let stem = name.strip_suffix(".rs").unwrap_or(name);
    if stem == "lib" {
        String::new()
    } else {
        stem.to_owned()
    }
}

/// Why no module may be called so: Rust would take its paths, or its file, for something else.
fn unusable_module(name: &str) -> Option<&'static str> {
    let is_lower = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if ["fixed", "core", "std", "alloc", "kani"].contains(&name) {
        Some("is the name of another crate")
    } else if ["main", "build", "lib"].contains(&name) {
        Some("is a file that Cargo takes for a program or a root")
    } else if Integer::named(name).is_some() || TAKEN_NAMES.contains(&name) {
        Some("has a meaning in Rust")
    } else if !name.chars().all(is_lower) {
        Some("is no name of a module: lower case, digits and `_`")
    } else {
        None
    }
}

/// Names that Rust gives a meaning where nothing else has them; integers are known beside these.
const TAKEN_NAMES: [&str; 18] = [
    "bool", "char", "str", "isize", "usize", "u128", "f16", "f32", "f64", "f128", "Option", "Some",
    "None", "Result", "Ok", "Err", "Default", "Self",
];
