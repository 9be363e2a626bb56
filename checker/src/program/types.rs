//! Types of words and values.

/// An integer type of Rust.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Integer {
    /// Whether it has a sign.
    pub signed: bool,
    /// Width in bits, 8 to 128.
    pub bits: u32,
}

impl Integer {
    /// `i32`.
    pub const I32: Integer = Integer {
        signed: true,
        bits: 32,
    };
    /// `i64`.
    pub const I64: Integer = Integer {
        signed: true,
        bits: 64,
    };
    /// `i128`.
    pub const I128: Integer = Integer {
        signed: true,
        bits: 128,
    };
    /// `u32`, the type of a shift.
    pub const U32: Integer = Integer {
        signed: false,
        bits: 32,
    };

    /// The type called `name`.
    pub fn named(name: &str) -> Option<Integer> {
        let (signed, bits) = match name {
            "i8" => (true, 8),
            "i16" => (true, 16),
            "i32" => (true, 32),
            "i64" => (true, 64),
            "i128" => (true, 128),
            "u8" => (false, 8),
            "u16" => (false, 16),
            "u32" => (false, 32),
            "u64" => (false, 64),
            _ => return None,
        };
        Some(Integer { signed, bits })
    }

    /// Smallest value.
    pub fn min(self) -> i128 {
        if !self.signed {
            0
        } else if self.bits == 128 {
            i128::MIN
        } else {
            -(1 << (self.bits - 1))
        }
    }

    /// Largest value.
    pub fn max(self) -> i128 {
        if self.bits == 128 {
            i128::MAX
        } else if self.signed {
            (1 << (self.bits - 1)) - 1
        } else {
            (1 << self.bits) - 1
        }
    }

    /// Whether `value` is one of this type.
    pub fn holds(self, value: i128) -> bool {
        self.min() <= value && value <= self.max()
    }
}

/// A type of the language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// An integer.
    Integer(Integer),
    /// `bool`.
    Bool,
    /// An enum without fields: its number in [`Declarations::enums`] and how many variants it has,
    /// which count from zero.
    Enum(usize, u8),
    /// A signed 32-bit type of the crate `fixed` with this many fraction bits.
    Fixed(u32),
    /// A struct, by its number in [`Declarations::structs`].
    Struct(usize),
    /// An array.
    Array(Box<Type>, usize),
    /// A tuple; `()` is the empty one.
    Tuple(Vec<Type>),
    /// `Option<T>`.
    Option(Box<Type>),
}

impl Type {
    /// Smallest and largest value of a word of this type.
    pub fn range(&self) -> (i128, i128) {
        match self {
            Type::Integer(integer) => (integer.min(), integer.max()),
            Type::Fixed(_) => (i32::MIN.into(), i32::MAX.into()),
            Type::Enum(_, count) => (0, i128::from(*count) - 1),
            // Words are integers, fixed-point numbers or booleans.
            _ => (0, 1),
        }
    }

    /// Whether a word of this type can have this value.
    pub fn holds(&self, value: i128) -> bool {
        let (low, high) = self.range();
        low <= value && value <= high
    }
}
