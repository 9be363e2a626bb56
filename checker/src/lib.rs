//! Checks an emitted controller without trusting its generator, and without sharing code with it.
//!
//! The folders are listed in the order of the argument; each uses only those above it.
//!
//! | folder | job |
//! |---|---|
//! | [`exact`] | rational numbers, matrices of them, outward-rounded intervals |
//! | [`program`] | a resolved function: words, types, steps, contracts |
//! | [`domains`] | what a word is: one integer, a range, a linear form, a polynomial, a term for z3; and the walk over a program for all of them |
//! | [`language`] | the emitted source, parsed and converted to that form; anything outside the language is refused |
//! | [`certificate`] | `certificate.json`, read strictly, and the claims that it may contain |
//! | [`compiled`] | the crate compiled by rustc, compared with the reader |
//! | [`audit`] | the texts of an emitted crate, fixed by digests |
//! | [`claims`] | one file per claim: what each engine does for it |
//! | [`prove`] | every claim by every engine |
//! | [`document`] | CLAIMS.md |
//! | [`mutate`] | damages the source and shows which engine detects it |

#![warn(missing_docs)]

pub mod audit;
pub mod certificate;
pub mod claims;
pub mod compiled;
pub mod document;
pub mod domains;
pub mod exact;
pub mod language;
pub mod mutate;
pub mod program;
pub mod prove;

pub use domains::machine::{Machine, Trap};
pub use language::module::{Module, ReadError};
pub use program::place::{SourceError, SourcePlace};
pub use prove::{ClaimOutcome, ClaimResult, ProofSettings, ProveError};
