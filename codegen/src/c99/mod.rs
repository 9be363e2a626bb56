//! The emitted crate translated to C99: for Arduino, PlatformIO and any other firmware in C.
//!
//! The C text is a translation of the Rust text, expression by expression, so that both have the same source.
//! Only the constructs of the emitted language are translated; anything else is refused. The differences:
//!
//! - a word of `fixed` is its bits, an `int32_t`; a boolean is a `uint8_t`;
//! - structures and arrays are passed and returned by pointer, and copied member by member, so that no compiler calls
//!   `memcpy`;
//! - every operand is cast to its width before it is multiplied or shifted, for any width of `int`.
//!
//! | file | job |
//! |---|---|
//! | `types` | the types of the emitted language, and how C writes them |
//! | `items` | what the emitted files declare, by module and name |
//! | `scope` | the names of one function |
//! | `expression` | scalars |
//! | `call` | calls |
//! | `place` | the places that expressions name: variables, fields, elements, constants |
//! | `infer` | the types of expressions |
//! | `statement` | blocks, structures and arrays |
//! | `constants` | constants and their initialisers |
//! | `comments` | documentation |
//! | `names` | names in C, and what a firmware calls |
//! | `definitions` | structures and enumerations of the header |
//! | `header` | what a firmware sees, with the units of the words |
//! | `files` | the source, and the order of all files |
//! | `library` | README, and the descriptions that Arduino and PlatformIO read |
//! | `board_loop` | the loop around the controller: commands in, frames out; written by hand, not translated |
//! | `sketch` | the example for Arduino, with the reading of the bench's sensors |

mod board_loop;
mod call;
mod comments;
mod constants;
mod definitions;
mod expression;
mod files;
mod header;
mod infer;
mod items;
mod library;
mod names;
mod place;
mod scope;
mod sketch;
mod statement;
mod types;

pub use files::emit;

/// A construct of the emitted Rust without a translation. This is a fault of this program.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: no translation to C for {what}")]
pub struct Untranslatable {
    /// The module, and the function if there is one.
    pub place: String,
    /// The construct.
    pub what: String,
}

type Result<T> = std::result::Result<T, Untranslatable>;
