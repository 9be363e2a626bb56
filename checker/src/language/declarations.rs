//! The declarations of an emitted crate: files, types, constants and functions.
//!
//! The language is the one that the generator documents for its output, read from that document
//! and written anew here: 32-bit fixed-point aliases, structs, arrays, plain functions, no loops,
//! no generics, no traits but `Default`, no macro but `assert!` in a constant. Anything else is
//! refused with its place. Bodies are read in [`crate::language::lower`].

use std::collections::HashMap;
use std::sync::Arc;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use crate::program::place::{Place, SourceError};
use crate::program::types::{Integer, Type};

/// Result of reading source.
pub type Read<T> = Result<T, SourceError>;

/// A struct.
#[derive(Clone, Debug)]
pub struct Struct {
    /// Name.
    pub name: String,
    /// Names (`0`, `1`, … in a tuple struct) and types of the fields.
    pub fields: Vec<(String, Type)>,
    /// Whether code outside its module can write a field.
    pub is_open: bool,
}

/// Something that a name of a module stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Named {
    /// A type.
    Type(Type),
    /// A constant, by its number in [`Declarations::constants`].
    Constant(usize),
    /// A function, by its number in [`Declarations::functions`].
    Function(usize),
}

/// A constant, its value not yet computed.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Name; `_` for an assertion.
    pub name: String,
    /// Module in which it stands.
    pub module: usize,
    /// Type.
    pub type_: Type,
    /// Value as written.
    pub expression: syn::Expr,
    /// Where its item starts (after documentation).
    pub place: Place,
    /// Whether others see it.
    pub is_public: bool,
}

/// A function or method.
#[derive(Clone, Debug)]
pub struct Function {
    /// Name; `Type::name` for a method.
    pub name: String,
    /// Module in which it stands.
    pub module: usize,
    /// Struct whose method it is.
    pub owner: Option<usize>,
    /// Arguments; a receiver is called `self`.
    pub arguments: Vec<Argument>,
    /// Type of the result.
    pub result: Type,
    /// Body.
    pub body: syn::Block,
    /// Where its name stands.
    pub place: Place,
    /// Attributes, in which contracts may stand.
    pub attributes: Vec<syn::Attribute>,
    /// Whether others see it.
    pub is_public: bool,
}

/// An argument.
#[derive(Clone, Debug)]
pub struct Argument {
    /// Name.
    pub name: String,
    /// Type behind any reference.
    pub type_: Type,
    /// Whether it is `&mut`, so that its value comes back to the caller.
    pub is_mutable: bool,
}

/// One file.
#[derive(Clone, Debug)]
pub struct File {
    /// Path inside the crate.
    pub path: Arc<str>,
    /// `control` of `src/control.rs`; empty for `src/lib.rs`.
    pub module: String,
    /// What names mean here.
    pub names: HashMap<String, Named>,
}

/// Everything declared in an emitted crate.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// Files, `src/lib.rs` among them if it was given.
    pub files: Vec<File>,
    /// Structs of all files.
    pub structs: Vec<Struct>,
    /// Constants of all files.
    pub constants: Vec<Constant>,
    /// Functions and methods of all files.
    pub functions: Vec<Function>,
    /// Methods and associated functions by struct and name.
    pub methods: HashMap<(usize, String), usize>,
}

/// `found`, at `span`, is not understood.
pub(crate) fn refuse<T>(file: &Arc<str>, span: proc_macro2::Span, message: String) -> Read<T> {
    Err(SourceError {
        place: Place::of(file, span),
        message,
    })
}

/// The piece of source between two spans, for messages.
pub(crate) fn shown(item: &impl Spanned) -> String {
    let text = item
        .span()
        .source_text()
        .unwrap_or_else(|| "this".to_owned());
    let line = text.lines().next().unwrap_or_default();
    let short: String = line.chars().take(60).collect();
    if short.len() < text.len() {
        format!("`{short} …`")
    } else {
        format!("`{short}`")
    }
}

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
            let file = syn::parse_file(text).map_err(|error| SourceError {
                place: Place::of(&path, error.span()),
                message: format!("this is no Rust: {error}"),
            })?;
            declarations.files.push(File {
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

    /// The file's number by its module's name.
    pub fn module(&self, name: &str) -> Option<usize> {
        self.files.iter().position(|file| file.module == name)
    }

    /// Number of words that a value of `type_` takes.
    pub fn width(&self, type_: &Type) -> usize {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Fixed(_) => 1,
            Type::Struct(index) => self.structs[*index]
                .fields
                .iter()
                .map(|(_, type_)| self.width(type_))
                .sum(),
            Type::Array(element, length) => self.width(element) * length,
            Type::Tuple(elements) => elements.iter().map(|type_| self.width(type_)).sum(),
            Type::Option(content) => 1 + self.width(content),
        }
    }

    /// The types of the words of a value, in order; for `Option` first whether there is a value.
    pub fn words(&self, type_: &Type) -> Vec<Type> {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Fixed(_) => vec![type_.clone()],
            Type::Struct(index) => self.structs[*index]
                .fields
                .iter()
                .flat_map(|(_, type_)| self.words(type_))
                .collect(),
            Type::Array(element, length) => {
                let one = self.words(element);
                (0..*length).flat_map(|_| one.clone()).collect()
            }
            Type::Tuple(elements) => elements
                .iter()
                .flat_map(|type_| self.words(type_))
                .collect(),
            Type::Option(content) => {
                let mut words = vec![Type::Bool];
                words.extend(self.words(content));
                words
            }
        }
    }

    /// Names of the words of a value called `name`.
    pub fn word_names(&self, name: &str, type_: &Type) -> Vec<String> {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Fixed(_) => vec![name.to_owned()],
            Type::Struct(index) => self.structs[*index]
                .fields
                .iter()
                .flat_map(|(field, type_)| self.word_names(&format!("{name}.{field}"), type_))
                .collect(),
            Type::Array(element, length) => (0..*length)
                .flat_map(|index| self.word_names(&format!("{name}[{index}]"), element))
                .collect(),
            Type::Tuple(elements) => elements
                .iter()
                .enumerate()
                .flat_map(|(index, type_)| self.word_names(&format!("{name}.{index}"), type_))
                .collect(),
            Type::Option(content) => {
                let mut names = vec![format!("{name}.is_some")];
                names.extend(self.word_names(name, content));
                names
            }
        }
    }

    /// The type as written in Rust.
    pub fn type_name(&self, type_: &Type) -> String {
        match type_ {
            Type::Integer(integer) => {
                format!("{}{}", if integer.signed { "i" } else { "u" }, integer.bits)
            }
            Type::Bool => "bool".to_owned(),
            Type::Fixed(bits) => format!("I{}F{bits}", 32 - bits),
            Type::Struct(index) => self.structs[*index].name.clone(),
            Type::Array(element, length) => format!("[{}; {length}]", self.type_name(element)),
            Type::Tuple(elements) => {
                let names: Vec<_> = elements.iter().map(|t| self.type_name(t)).collect();
                format!("({})", names.join(", "))
            }
            Type::Option(content) => format!("Option<{}>", self.type_name(content)),
        }
    }

    /// First pass: which structs there are, so that types can name each other.
    fn item_name(&mut self, module: usize, path: &Arc<str>, item: &syn::Item) -> Read<()> {
        if let syn::Item::Struct(item) = item {
            outer_attributes(path, &item.attrs)?;
            let number = self.structs.len();
            self.structs.push(Struct {
                name: item.ident.to_string(),
                fields: Vec::new(),
                is_open: item
                    .fields
                    .iter()
                    .any(|field| !matches!(field.vis, syn::Visibility::Inherited)),
            });
            self.define(module, path, &item.ident, Named::Type(Type::Struct(number)))?;
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
                place: Place::of(
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
                place: Place::of(path, item.sig.ident.span()),
                attributes: item.attrs.clone(),
                is_public: matches!(item.vis, syn::Visibility::Public(_)),
            });
            self.define(module, path, &item.sig.ident, Named::Function(number))?;
        }
        Ok(())
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

    /// `src/lib.rs` forbids unsafe code, needs no standard library, and declares every file.
    fn root(&self, path: &Arc<str>, file: &syn::File) -> Read<()> {
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
    fn imports(&mut self, parsed: &[(Arc<str>, syn::File)]) -> Read<()> {
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

    fn lookup(&self, file: &str, name: &str) -> Option<Named> {
        let module = self.module(file)?;
        self.files[module].names.get(name).cloned()
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
                        place: Place::of(path, item.const_token.span()),
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
                if ["fixed", "core", "std", "alloc"]
                    .iter()
                    .any(|name| item.ident == name)
                {
                    return refuse(
                        path,
                        item.span(),
                        format!("`{}` is the name of another crate", item.ident),
                    );
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
            // What a step keeps about a state holds only if nothing else can write it.
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
                place: Place::of(path, function.sig.ident.span()),
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

    fn signature(
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
                    let (type_, is_mutable) = match &*typed.ty {
                        syn::Type::Reference(reference) => (
                            self.owned_type(module, path, &reference.elem, owner)?,
                            reference.mutability.is_some(),
                        ),
                        other => (self.owned_type(module, path, other, owner)?, false),
                    };
                    arguments.push(Argument {
                        name: name.ident.to_string(),
                        type_,
                        is_mutable,
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
    fn owned_type(
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

fn module_name(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    let stem = name.strip_suffix(".rs").unwrap_or(name);
    if stem == "lib" {
        String::new()
    } else {
        stem.to_owned()
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

/// The type that an alias stands for: `fixed::types::IxFy` with x + y = 32.
fn fixed_type(path: &Arc<str>, type_: &syn::Type) -> Read<Type> {
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

fn fixed_named(name: &str) -> Option<Type> {
    let (integer, fraction) = name.strip_prefix('I')?.split_once('F')?;
    let (integer, fraction): (u32, u32) = (integer.parse().ok()?, fraction.parse().ok()?);
    (integer.checked_add(fraction)? == 32).then_some(Type::Fixed(fraction))
}

/// Names that Rust gives a meaning where nothing else has them; integers are known beside these.
const TAKEN_NAMES: [&str; 18] = [
    "bool", "char", "str", "isize", "usize", "u128", "f16", "f32", "f64", "f128", "Option", "Some",
    "None", "Result", "Ok", "Err", "Default", "Self",
];

fn is_plain(signature: &syn::Signature) -> bool {
    signature.asyncness.is_none()
        && signature.abi.is_none()
        && signature.variadic.is_none()
        && matches!(signature.safety, syn::Safety::Default)
}

/// Finds attributes inside of functions, where `cfg` would take away code that is read here.
struct AttributeFinder(Option<proc_macro2::Span>);

impl<'ast> Visit<'ast> for AttributeFinder {
    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        self.0.get_or_insert(attribute.span());
        visit::visit_attribute(self, attribute);
    }
}

fn no_attributes(path: &Arc<str>, look: impl FnOnce(&mut AttributeFinder)) -> Read<()> {
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

fn no_generics(path: &Arc<str>, generics: &syn::Generics) -> Read<()> {
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

fn inner_attributes(path: &Arc<str>, attributes: &[syn::Attribute]) -> Read<()> {
    attributes.iter().try_for_each(|attribute| {
        let name = attribute.path();
        if ["doc", "no_std", "forbid", "warn"]
            .iter()
            .any(|known| name.is_ident(known))
        {
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

/// Attributes that do not change what the code does. Kani's contracts stand under
/// `cfg_attr(kani, …)`, which nothing but Kani compiles.
pub(crate) fn outer_attributes(path: &Arc<str>, attributes: &[syn::Attribute]) -> Read<()> {
    attributes.iter().try_for_each(|attribute| {
        let name = attribute.path();
        let list = || {
            attribute
                .parse_args_with(
                    syn::punctuated::Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated,
                )
                .ok()
        };
        let is_harmless = ["doc", "inline", "must_use"]
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
                matches!(
                    paths.as_slice(),
                    [["kani"], ["kani", "requires" | "ensures"]]
                )
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
