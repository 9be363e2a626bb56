//! The names of one function, and the items that its translation needs so far.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::items::{FunctionKey, Items};
use super::types::{ItemKey, Type};
use super::{Result, Untranslatable};

/// Reserved words of C or Arduino's C++, and names that the translation itself uses.
const RESERVED: [&str; 28] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
    "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "out", "register",
    "return", "short", "signed", "switch", "union", "unsigned", "void",
];

/// Statements longer than this are broken.
const LINE_LENGTH: usize = 100;

/// A place in memory: a variable, or a part of one.
#[derive(Debug, Clone)]
pub struct CPlace {
    /// The expression in C.
    pub text: String,
    /// Whether the expression is a pointer to the place.
    pub is_pointer: bool,
    /// The type of the value in the place.
    pub ty: Type,
}

impl CPlace {
    /// A variable.
    pub fn variable(text: &str, ty: Type) -> CPlace {
        CPlace {
            text: text.to_string(),
            is_pointer: false,
            ty,
        }
    }

    /// The place that a pointer points to.
    pub fn behind(text: &str, ty: Type) -> CPlace {
        CPlace {
            text: text.to_string(),
            is_pointer: true,
            ty,
        }
    }

    /// A field of a structure.
    pub fn field(&self, name: &str, ty: Type) -> CPlace {
        let arrow = if self.is_pointer { "->" } else { "." };
        CPlace::variable(&format!("{}{arrow}{name}", self.text), ty)
    }

    /// An element of an array.
    pub fn element(&self, index: usize) -> Option<CPlace> {
        match &self.ty {
            Type::Array(element, length) if index < *length => {
                let text = format!("{}[{index}]", self.text);
                Some(CPlace::variable(&text, (**element).clone()))
            }
            _ => None,
        }
    }

    /// The expression that passes the place to a function by pointer.
    pub fn argument(&self) -> String {
        match (&self.ty, self.is_pointer) {
            (Type::Array(..), _) | (_, true) => self.text.clone(),
            _ => format!("&{}", self.text),
        }
    }

    /// The parameters through which a C function returns a value of this type: one for an array or a structure, one
    /// for each part of a tuple, none for a number.
    pub fn outs(returns: &Type) -> Vec<CPlace> {
        let part = |name: &str, ty: &Type| match ty {
            Type::Array(..) => CPlace::variable(name, ty.clone()),
            _ => CPlace::behind(name, ty.clone()),
        };
        match returns {
            Type::Tuple(parts) => parts
                .iter()
                .enumerate()
                .map(|(index, ty)| part(&format!("out_{}", index + 1), ty))
                .collect(),
            ty if ty.is_aggregate() => vec![part("out", ty)],
            _ => vec![],
        }
    }
}

/// The items that a translation refers to.
#[derive(Default)]
pub struct Needs {
    /// Functions.
    pub functions: BTreeSet<FunctionKey>,
    /// Constants.
    pub constants: BTreeSet<ItemKey>,
    /// Whether 64-bit words are clamped.
    pub clamp_64: bool,
}

/// The translation of one function or constant.
pub struct Scope<'a> {
    /// All items that the crate declares.
    pub items: &'a Items,
    /// The module whose names are used.
    pub module: &'a str,
    /// The structure that `Self` is.
    pub owner: Option<&'a str>,
    /// The name in messages.
    pub name: String,
    /// The items that the translated text refers to.
    pub needs: Needs,
    /// The lines so far.
    pub lines: Vec<String>,
    /// Nesting depth of the next line.
    pub depth: usize,
    /// The type that the function returns.
    pub returns: Type,
    names: Vec<HashMap<String, CPlace>>,
    taken: HashSet<String>,
    temporaries: usize,
}

impl<'a> Scope<'a> {
    /// A scope without names and lines.
    pub fn new(items: &'a Items, module: &'a str, owner: Option<&'a str>, name: &str) -> Self {
        Scope {
            items,
            module,
            owner,
            name: format!("{module}::{name}"),
            needs: Needs::default(),
            lines: vec![],
            depth: 1,
            returns: Type::Unit,
            names: vec![HashMap::new()],
            taken: HashSet::new(),
            temporaries: 0,
        }
    }

    /// The error for something that has no translation.
    pub fn refuse<T>(&self, what: impl std::fmt::Display) -> Result<T> {
        Err(Untranslatable {
            place: self.name.clone(),
            what: what.to_string(),
        })
    }

    /// Adds a statement; a long one is broken after a comma or before an operator.
    pub fn line(&mut self, text: impl AsRef<str>) {
        let mut indent = "    ".repeat(self.depth);
        let mut rest = text.as_ref();
        while indent.len() + rest.len() > LINE_LENGTH {
            let within = rest.get(..LINE_LENGTH - indent.len()).unwrap_or(rest);
            let at = [", ", " && ", " || ", " + ", " - ", " * "]
                .iter()
                .filter_map(|sign| Some(within.rfind(sign)? + usize::from(*sign == ", ")))
                .max();
            let Some(at) = at else { break };
            self.lines.push(format!("{indent}{}", &rest[..at]));
            rest = rest[at..].trim_start();
            indent = "    ".repeat(self.depth + 2);
        }
        self.lines.push(format!("{indent}{rest}"));
    }

    /// A name for C that the function does not use yet: Rust may declare a name again, C may not.
    pub fn fresh(&mut self, name: &str) -> String {
        let mut own = name.to_string();
        if RESERVED.contains(&name) {
            own.push('_');
        }
        let mut count = 2;
        while self.taken.contains(&own) {
            own = format!("{name}_{count}");
            count += 1;
        }
        self.taken.insert(own.clone());
        own
    }

    /// Declares a name in the innermost block.
    pub fn bind(&mut self, name: &str, place: CPlace) {
        if let Some(block) = self.names.last_mut() {
            block.insert(name.to_string(), place);
        }
    }

    /// The place of a name.
    pub fn lookup(&self, name: &str) -> Option<&CPlace> {
        self.names.iter().rev().find_map(|block| block.get(name))
    }

    /// A new variable for an intermediate value.
    pub fn temporary(&mut self, ty: &Type) -> CPlace {
        self.temporaries += 1;
        let name = self.fresh(&format!("part_{}", self.temporaries));
        let declaration = ty.declare(&name);
        self.line(format!("{declaration};"));
        CPlace::variable(&name, ty.clone())
    }

    /// Enters a block.
    pub fn enter(&mut self) {
        self.names.push(HashMap::new());
        self.depth += 1;
    }

    /// Leaves a block.
    pub fn leave(&mut self) {
        self.names.pop();
        self.depth -= 1;
    }
}
