//! Damages the emitted source in many small ways and shows which engine notices.
//!
//! A mutant is one edit of one token in a function, constant or alias: a constant moved by one or
//! by a bit, a sign turned, an operator or comparison exchanged, a shift or index moved, a format
//! changed, two arguments or names swapped, a rounding, saturation or assignment dropped, a `let`
//! made conditional. Documentation is left alone. The manifest and the head of `src/lib.rs` are
//! damaged line by line.
//!
//! No compiler runs: a mutant that `rustc` would refuse counts as noticed only where an engine
//! notices it.

pub mod comparison;
pub mod judgement;
pub mod mutants;
pub mod tokens;

pub use judgement::{Fate, MutantVerdict, Notice, Summary, judged, notices, summary};
pub use mutants::{Mutant, applied, chosen, mutants};
