//! The types of the emitted Rust, and their declarations in C.

/// An item of a module: module and name.
pub type ItemKey = (String, String);

/// A type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Type {
    /// `bool`.
    Bool,
    /// An integer. A number of `fixed` is an `I32`; a structure with one unnamed number is that number.
    Int(Int),
    /// An array of this length.
    Array(Box<Type>, usize),
    /// A structure with named fields.
    Struct(ItemKey),
    /// An enumeration without data.
    Enum(ItemKey),
    /// Several returned values.
    Tuple(Vec<Type>),
    /// `()`.
    Unit,
}

/// An integer type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Int {
    /// `i16`
    I16,
    /// `u8`
    U8,
    /// `u16`
    U16,
    /// `u32`
    U32,
    /// `i32`
    I32,
    /// `i64`
    I64,
}

impl Int {
    /// The integer type with this name in Rust.
    pub fn from_name(name: &str) -> Option<Int> {
        Some(match name {
            "i16" => Int::I16,
            "u8" => Int::U8,
            "u16" => Int::U16,
            "u32" => Int::U32,
            "i32" => Int::I32,
            "i64" => Int::I64,
            _ => return None,
        })
    }

    /// Its name in C.
    pub fn c_name(self) -> &'static str {
        match self {
            Int::I16 => "int16_t",
            Int::U8 => "uint8_t",
            Int::U16 => "uint16_t",
            Int::U32 => "uint32_t",
            Int::I32 => "int32_t",
            Int::I64 => "int64_t",
        }
    }

    /// A literal of this type. A C literal without a suffix has the type `int`, which may have only 16 bits. A literal
    /// that fits into 16 bits needs no suffix if the other operand is at least as wide as this type (`is_beside_wide`).
    pub fn literal(self, magnitude: u64, text: &str, is_beside_wide: bool) -> String {
        let is_short = magnitude <= 0x7fff;
        match self {
            Int::I64 => format!("INT64_C({text})"),
            Int::U32 if is_short => format!("{text}u"),
            Int::U32 => format!("UINT32_C({text})"),
            Int::U16 => format!("{text}u"),
            _ if is_short && (is_beside_wide || self != Int::I32) => text.to_string(),
            _ => format!("INT32_C({text})"),
        }
    }
}

impl Type {
    /// Whether values of the type are passed and returned by pointer.
    pub fn is_aggregate(&self) -> bool {
        matches!(self, Type::Array(..) | Type::Struct(_) | Type::Tuple(_))
    }

    /// A declaration of `name` with this type.
    pub fn declare(&self, name: &str) -> String {
        match self {
            Type::Array(element, length) => element.declare(&format!("{name}[{length}]")),
            Type::Unit | Type::Tuple(_) => format!("void {name}"),
            Type::Bool => format!("uint8_t {name}"),
            Type::Int(int) => format!("{} {name}", int.c_name()),
            Type::Struct((_, own)) | Type::Enum((_, own)) => format!("{} {name}", type_name(own)),
        }
    }
}

/// The name of a structure or enumeration in C: `FilterState` is `flywheel_filter_state_t`.
pub fn type_name(name: &str) -> String {
    format!("flywheel_{}_t", snake(name))
}

/// `NotAligned` as `not_aligned`.
pub fn snake(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.push(letter.to_ascii_lowercase());
    }
    text
}
