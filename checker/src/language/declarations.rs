//! The declarations of an emitted crate: files, types, constants and functions.

use std::collections::HashMap;
use std::sync::Arc;

use syn::spanned::Spanned;

use crate::program::place::{SourceError, SourcePlace};
use crate::program::types::Type;

/// Result of reading source.
pub type Read<T> = Result<T, SourceError>;

/// A struct.
#[derive(Clone, Debug)]
pub struct Struct {
    /// Name.
    pub name: String,
    /// Names (`0`, `1`, … in a tuple struct) and types of the fields.
    pub fields: Vec<(String, Type)>,
    /// Module in which it stands.
    pub module: usize,
    /// Whether code outside its module can write a field.
    pub is_open: bool,
    /// Whether code outside its module can write and read every field.
    pub is_whole: bool,
}

/// An enum whose variants have no fields.
#[derive(Clone, Debug)]
pub struct Enum {
    /// Name.
    pub name: String,
    /// Module in which it stands.
    pub module: usize,
    /// Names of the variants, which count from zero.
    pub variants: Vec<String>,
}

/// Values of the constants, computed when first needed.
pub type Constants = HashMap<usize, Vec<i128>>;

/// The meaning of a name in a module.
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
    pub place: SourcePlace,
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
    pub place: SourcePlace,
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
    /// Whether it is `&` or `&mut`.
    pub is_reference: bool,
    /// Whether the argument is `&mut`: its value is then returned to the caller.
    pub is_mutable: bool,
}

/// One file.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path inside the crate.
    pub path: Arc<str>,
    /// `control` of `src/control.rs`; empty for `src/lib.rs`.
    pub module: String,
    /// The meaning of the names in this module.
    pub names: HashMap<String, Named>,
}

/// Everything declared in an emitted crate.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// Files, `src/lib.rs` among them if it was given.
    pub files: Vec<SourceFile>,
    /// Structs of all files.
    pub structs: Vec<Struct>,
    /// Constants of all files.
    pub constants: Vec<Constant>,
    /// Functions and methods of all files.
    pub functions: Vec<Function>,
    /// Enums of all files.
    pub enums: Vec<Enum>,
    /// Methods and associated functions by struct and name.
    pub methods: HashMap<(usize, String), usize>,
}

/// The error that `found`, at `span`, is not understood.
pub(crate) fn refuse<T>(file: &Arc<str>, span: proc_macro2::Span, message: String) -> Read<T> {
    Err(SourceError {
        place: SourcePlace::of(file, span),
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
    /// The file's number by its module's name.
    pub fn module(&self, name: &str) -> Option<usize> {
        self.files.iter().position(|file| file.module == name)
    }

    /// Number of words that a value of `type_` takes.
    pub fn width(&self, type_: &Type) -> usize {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Fixed(_) | Type::Enum(..) => 1,
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
            Type::Integer(_) | Type::Bool | Type::Fixed(_) | Type::Enum(..) => {
                vec![type_.clone()]
            }
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
            Type::Integer(_) | Type::Bool | Type::Fixed(_) | Type::Enum(..) => {
                vec![name.to_owned()]
            }
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
            Type::Enum(index, _) => self.enums[*index].name.clone(),
            Type::Array(element, length) => format!("[{}; {length}]", self.type_name(element)),
            Type::Tuple(elements) => {
                let names: Vec<_> = elements.iter().map(|t| self.type_name(t)).collect();
                format!("({})", names.join(", "))
            }
            Type::Option(content) => format!("Option<{}>", self.type_name(content)),
        }
    }

    /// Type and value of a variant, where `type_` is an enum that `module` knows.
    pub(crate) fn variant(
        &self,
        module: usize,
        type_: &str,
        variant: &str,
    ) -> Option<(Type, i128)> {
        let Some(Named::Type(Type::Enum(number, count))) = self.files[module].names.get(type_)
        else {
            return None;
        };
        let variants = &self.enums[*number].variants;
        let value = variants.iter().position(|name| name == variant)?;
        Some((Type::Enum(*number, *count), value as i128))
    }

    pub(super) fn lookup(&self, file: &str, name: &str) -> Option<Named> {
        let module = self.module(file)?;
        self.files[module].names.get(name).cloned()
    }
}
