//! The form in which everything is computed: words with their types, the steps of a resolved function, and the
//! contracts between functions.

pub mod contract;
pub mod place;
pub mod steps;
pub mod types;

pub use contract::{Contract, Range};
pub use place::{SourceError, SourcePlace};
pub use steps::{Action, Arithmetic, Program, ProgramStep, Slot, WordComparison};
pub use types::{Integer, Type};
