//! The declarations of the emitted files, by module and name.

use std::collections::BTreeMap;

use syn::{Attribute, Expr, FnArg, ImplItem, Item, Pat, ReceiverKind, ReturnType, UseTree};

use super::types::{Int, ItemKey, Type};
use super::{Result, Untranslatable};
use crate::file::EmittedCrate;

/// A translated function.
pub(super) struct Translated {
    pub prototype: String,
    pub body: Vec<String>,
}

/// A function or method.
pub struct Function {
    /// Its module.
    pub module: String,
    /// The structure whose method it is.
    pub owner: Option<String>,
    /// Its name.
    pub name: String,
    /// How the receiver is passed, if the function is a method with one.
    pub receiver: Option<Passing>,
    /// The other parameters.
    pub parameters: Vec<(String, Type)>,
    /// The type of its result.
    pub returns: Type,
    /// Whether the result is a reference to a part of the receiver.
    pub returns_reference: bool,
    /// The words of the law among its parameters, by name, and its result as `returns`.
    pub words: Vec<(String, ItemKey)>,
    /// Its body.
    pub body: syn::Block,
    /// Its documentation.
    pub attributes: Vec<Attribute>,
}

/// How a method receives its structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passing {
    /// `&self`
    Shared,
    /// `&mut self`
    Exclusive,
}

/// A structure: its fields in order.
pub struct Struct {
    /// Name, type and documentation of each field.
    pub fields: Vec<(String, Type, Vec<Attribute>)>,
    /// Optional fields; the C version does not have them.
    pub optional: Vec<String>,
    /// Its documentation.
    pub attributes: Vec<Attribute>,
}

/// An enumeration without data.
pub struct Enum {
    /// Name, value and documentation of each variant.
    pub variants: Vec<(String, u64, Vec<Attribute>)>,
    /// Its documentation.
    pub attributes: Vec<Attribute>,
}

/// A constant.
pub struct Constant {
    /// Its type.
    pub ty: Type,
    /// Its value.
    pub value: Expr,
    /// Its documentation.
    pub attributes: Vec<Attribute>,
}

/// A key of a function: module, owner, name.
pub type FunctionKey = (String, Option<String>, String);

/// Everything that a crate declares.
#[derive(Default)]
pub struct Items {
    /// The modules in the order of their files, with their documentation.
    pub modules: Vec<(String, Vec<Attribute>)>,
    /// The functions.
    pub functions: BTreeMap<FunctionKey, Function>,
    /// The keys of the functions, in the order of the source.
    pub function_order: Vec<FunctionKey>,
    /// Structures with named fields.
    pub structs: BTreeMap<ItemKey, Struct>,
    /// Structures around one number, and words of `fixed`: the number, and the documentation.
    pub words: BTreeMap<ItemKey, (Type, Vec<Attribute>)>,
    /// The number of fraction bits of the words that have a name of their own: `Angle` and the others of the law.
    pub fraction_bits: BTreeMap<ItemKey, u32>,
    /// Enumerations.
    pub enums: BTreeMap<ItemKey, Enum>,
    /// Constants.
    pub constants: BTreeMap<ItemKey, Constant>,
    /// The keys of the constants, in the order of the source.
    pub constant_order: Vec<ItemKey>,
    /// For every module: the declarations that its names refer to.
    imports: BTreeMap<ItemKey, ItemKey>,
}

fn fault<T>(place: &str, what: impl std::fmt::Display) -> Result<T> {
    Err(Untranslatable {
        place: place.to_string(),
        what: what.to_string(),
    })
}

impl Items {
    /// Reads the source files of a crate.
    pub fn read(emitted: &EmittedCrate) -> Result<Items> {
        let mut items = Items::default();
        let mut files = vec![];
        for file in &emitted.files {
            let name = file.path.strip_prefix("src/");
            let Some(module) = name.and_then(|name| name.strip_suffix(".rs")) else {
                continue;
            };
            if module == "lib" {
                continue;
            }
            let parsed = match syn::parse_file(&file.contents) {
                Ok(parsed) => parsed,
                Err(error) => return fault(module, error),
            };
            items
                .modules
                .push((module.to_string(), parsed.attrs.clone()));
            files.push((module.to_string(), parsed.items));
        }
        // The names are read first, since types refer to them.
        for (module, list) in &files {
            for item in list {
                items.declare(module, item)?;
            }
        }
        for (module, list) in files {
            for item in list {
                items.define(&module, item)?;
            }
        }
        Ok(items)
    }

    fn declare(&mut self, module: &str, item: &Item) -> Result<()> {
        let key = |name: &syn::Ident| (module.to_string(), name.to_string());
        match item {
            Item::Use(item) => self.import(module, &mut vec![], &item.tree),
            Item::Struct(item) if matches!(item.fields, syn::Fields::Named(_)) => {
                let own = Struct {
                    fields: vec![],
                    optional: vec![],
                    attributes: item.attrs.clone(),
                };
                self.structs.insert(key(&item.ident), own);
                Ok(())
            }
            Item::Struct(item) => match item.fields.iter().next() {
                Some(field) if item.fields.len() == 1 => {
                    let inner = self.type_of(module, &field.ty)?;
                    self.words
                        .insert(key(&item.ident), (inner, item.attrs.clone()));
                    Ok(())
                }
                _ => fault(module, format!("the structure {}", item.ident)),
            },
            Item::Type(item) => {
                if let Some(bits) = fraction_bits(&item.ty) {
                    self.fraction_bits.insert(key(&item.ident), bits);
                }
                let word = (Type::Int(Int::I32), item.attrs.clone());
                self.words.insert(key(&item.ident), word);
                Ok(())
            }
            Item::Enum(item) => {
                let mut variants = vec![];
                for variant in &item.variants {
                    let value = match &variant.discriminant {
                        Some((_, Expr::Lit(value))) => literal(&value.lit).map(|one| one.0),
                        _ => Some(variants.len() as u64),
                    };
                    match (value, &variant.fields) {
                        (Some(value), syn::Fields::Unit) => {
                            variants.push((variant.ident.to_string(), value, variant.attrs.clone()))
                        }
                        _ => return fault(module, format!("the variant {}", variant.ident)),
                    }
                }
                let own = Enum {
                    variants,
                    attributes: item.attrs.clone(),
                };
                self.enums.insert(key(&item.ident), own);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn import(&mut self, module: &str, path: &mut Vec<String>, tree: &UseTree) -> Result<()> {
        match tree {
            UseTree::Path(tree) => {
                path.push(tree.ident.to_string());
                self.import(module, path, &tree.tree)?;
                path.pop();
                Ok(())
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(module, path, tree)?;
                }
                Ok(())
            }
            UseTree::Name(name) => {
                let name = name.ident.to_string();
                let own = (module.to_string(), name.clone());
                match path.iter().map(String::as_str).collect::<Vec<_>>()[..] {
                    ["super" | "crate", from] => {
                        self.imports.insert(own, (from.to_string(), name));
                    }
                    ["fixed", "types"] => {
                        self.words.insert(own, (Type::Int(Int::I32), vec![]));
                    }
                    _ => return fault(module, format!("use of {}::{name}", path.join("::"))),
                }
                Ok(())
            }
            _ => fault(module, "this use"),
        }
    }

    fn define(&mut self, module: &str, item: Item) -> Result<()> {
        let key = |name: &syn::Ident| (module.to_string(), name.to_string());
        match item {
            Item::Struct(item) => {
                let syn::Fields::Named(named) = item.fields else {
                    return Ok(());
                };
                let (mut fields, mut optional) = (vec![], vec![]);
                for field in named.named {
                    let name = field.ident.map(|name| name.to_string()).unwrap_or_default();
                    // Translated code does not read optional fields, or is refused there.
                    if is_option(&field.ty) {
                        optional.push(name);
                        continue;
                    }
                    fields.push((name, self.type_of(module, &field.ty)?, field.attrs));
                }
                if let Some(own) = self.structs.get_mut(&key(&item.ident)) {
                    own.fields = fields;
                    own.optional = optional;
                }
                Ok(())
            }
            Item::Const(item) if item.ident != "_" => {
                let own = Constant {
                    ty: self.type_of(module, &item.ty)?,
                    value: *item.expr,
                    attributes: item.attrs,
                };
                self.constant_order.push(key(&item.ident));
                self.constants.insert(key(&item.ident), own);
                Ok(())
            }
            Item::Fn(item) => self.function(module, None, &item.sig, *item.block, item.attrs),
            Item::Impl(item) if item.trait_.is_none() => {
                let syn::Type::Path(path) = &*item.self_ty else {
                    return fault(module, "this impl");
                };
                let owner = last(&path.path);
                for member in item.items {
                    if let ImplItem::Fn(member) = member {
                        let owner = Some(owner.clone());
                        self.function(module, owner, &member.sig, member.block, member.attrs)?;
                    }
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn function(
        &mut self,
        module: &str,
        owner: Option<String>,
        signature: &syn::Signature,
        body: syn::Block,
        attributes: Vec<Attribute>,
    ) -> Result<()> {
        let name = signature.ident.to_string();
        let place = format!("{module}::{name}");
        let owner_type = owner.as_deref();
        let (mut receiver, mut parameters, mut words) = (None, vec![], vec![]);
        for input in &signature.inputs {
            match input {
                FnArg::Receiver(own) => {
                    receiver = Some(match &own.kind {
                        ReceiverKind::Reference(_, _, Some(_)) => Passing::Exclusive,
                        ReceiverKind::Reference(_, _, None) => Passing::Shared,
                        _ => return fault(&place, "this receiver"),
                    });
                }
                FnArg::Typed(typed) => {
                    let Pat::Ident(pattern) = &*typed.pat else {
                        return fault(&place, "this parameter");
                    };
                    let (name, ty) = (pattern.ident.to_string(), &typed.ty);
                    words.extend(self.word(module, ty).map(|word| (name.clone(), word)));
                    parameters.push((name, self.type_within(module, owner_type, ty)?));
                }
            }
        }
        let (returns, returns_reference) = match &signature.output {
            ReturnType::Default => (Type::Unit, false),
            ReturnType::Type(_, ty) => (
                self.type_within(module, owner_type, ty)?,
                matches!(**ty, syn::Type::Reference(_)),
            ),
        };
        if let ReturnType::Type(_, ty) = &signature.output {
            let word = self.word(module, ty);
            words.extend(word.map(|word| ("returns".to_string(), word)));
        }
        let key = (module.to_string(), owner.clone(), name.clone());
        self.function_order.push(key.clone());
        let own = Function {
            module: module.to_string(),
            owner,
            name,
            receiver,
            parameters,
            returns,
            returns_reference,
            words,
            body,
            attributes,
        };
        self.functions.insert(key, own);
        Ok(())
    }

    /// The word of the law that a type in a module is; `None` for another type.
    fn word(&self, module: &str, ty: &syn::Type) -> Option<ItemKey> {
        let syn::Type::Path(path) = ty else {
            return None;
        };
        let key = self.resolve(module, &last(&path.path));
        self.fraction_bits.contains_key(&key).then_some(key)
    }

    /// The declaration that a name in a module refers to.
    pub fn resolve(&self, module: &str, name: &str) -> ItemKey {
        let own = (module.to_string(), name.to_string());
        self.imports.get(&own).cloned().unwrap_or(own)
    }

    /// A type as it is written in a module.
    pub fn type_of(&self, module: &str, ty: &syn::Type) -> Result<Type> {
        self.type_within(module, None, ty)
    }

    fn type_within(&self, module: &str, owner: Option<&str>, ty: &syn::Type) -> Result<Type> {
        match ty {
            syn::Type::Reference(ty) => self.type_within(module, owner, &ty.elem),
            syn::Type::Paren(ty) => self.type_within(module, owner, &ty.elem),
            syn::Type::Tuple(ty) => {
                let parts = ty.elems.iter();
                let parts = parts.map(|part| self.type_within(module, owner, part));
                Ok(Type::Tuple(parts.collect::<Result<Vec<Type>>>()?))
            }
            syn::Type::Array(ty) => {
                let element = self.type_within(module, owner, &ty.elem)?;
                match &ty.len {
                    Expr::Lit(length) => match literal(&length.lit) {
                        Some((length, _)) => Ok(Type::Array(Box::new(element), length as usize)),
                        None => fault(module, "this length of an array"),
                    },
                    _ => fault(module, "this length of an array"),
                }
            }
            syn::Type::Path(path) => {
                let name = last(&path.path);
                match (name.as_str(), owner) {
                    ("bool", _) => return Ok(Type::Bool),
                    ("Self", Some(owner)) => return self.named(module, owner),
                    _ => {}
                }
                match Int::from_name(&name) {
                    Some(int) => Ok(Type::Int(int)),
                    None => self.named(module, &name),
                }
            }
            _ => fault(module, "this type"),
        }
    }

    /// The type with this name in a module.
    pub fn named(&self, module: &str, name: &str) -> Result<Type> {
        let own = (module.to_string(), name.to_string());
        let key = self.resolve(module, name);
        if let Some((word, _)) = self.words.get(&key).or_else(|| self.words.get(&own)) {
            Ok(word.clone())
        } else if self.structs.contains_key(&key) {
            Ok(Type::Struct(key))
        } else if self.enums.contains_key(&key) {
            Ok(Type::Enum(key))
        } else {
            fault(module, format!("the type {name}"))
        }
    }

    /// The type of a field.
    pub fn field(&self, key: &ItemKey, name: &str) -> Option<&Type> {
        let fields = &self.structs.get(key)?.fields;
        fields
            .iter()
            .find(|(field, _, _)| field == name)
            .map(|(_, ty, _)| ty)
    }
}

/// The last name of a path.
pub fn last(path: &syn::Path) -> String {
    path.segments
        .last()
        .map(|segment| segment.ident.to_string())
        .unwrap_or_default()
}

/// Value and C text of a literal number; `None` for another literal.
pub fn literal(value: &syn::Lit) -> Option<(u64, String)> {
    let syn::Lit::Int(value) = value else {
        return None;
    };
    let number: u64 = value.base10_parse().ok()?;
    let is_hexadecimal = value.to_string().starts_with("0x");
    let text = if is_hexadecimal {
        format!("0x{number:x}")
    } else {
        number.to_string()
    };
    Some((number, text))
}

/// The suffix of a literal number.
pub fn suffix(value: &syn::Lit) -> Option<Int> {
    match value {
        syn::Lit::Int(value) => Int::from_name(value.suffix()),
        _ => None,
    }
}

/// The number of fraction bits of a type such as `fixed::types::I3F29`.
fn fraction_bits(ty: &syn::Type) -> Option<u32> {
    let syn::Type::Path(path) = ty else {
        return None;
    };
    let name = last(&path.path);
    let (_, bits) = name.strip_prefix('I')?.split_once('F')?;
    bits.parse().ok()
}

fn is_option(ty: &syn::Type) -> bool {
    matches!(ty, syn::Type::Path(path) if last(&path.path) == "Option")
}
