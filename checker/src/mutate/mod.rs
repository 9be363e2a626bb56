//! Damages the emitted source in many small ways and shows which engine detects it.
//!
//! A mutant is one edit of one token in a function, constant or alias: a constant changed by one or
//! by a bit, a sign reversed, an operator or comparison exchanged, a shift or index changed, a format
//! changed, two arguments or names swapped, a rounding, saturation or assignment removed, a `let`
//! made conditional. Documentation is not changed. The manifest and the head of `src/lib.rs` are
//! damaged line by line.
//!
//! A mutant that `rustc` would refuse counts as detected only if an engine detects it. Only changed types are compiled, and of
//! them those that no other engine detects.

pub mod comparison;
pub mod judgement;
pub mod mutants;
pub mod tokens;

pub use judgement::{Fate, MutantVerdict, Notice, Summary, judged, notices, summary};
pub use mutants::{Mutant, applied, chosen, mutants};
