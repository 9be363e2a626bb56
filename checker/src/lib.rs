//! Checks an emitted controller without trusting, or sharing code with, its generator.
//!
//! Folders in the order of the argument; each uses only those above it.
//!
//! | folder | job |
//! |---|---|
//! | [`exact`] | rational numbers, matrices of them, outward-rounded intervals |
//! | [`program`] | a resolved function: words, types, steps, contracts |
//! | [`domains`] | what a word is: one integer, a range, a linear form, a polynomial, a term for z3; and the one walk over a program that serves them all |
//! | [`language`] | the emitted source, read and brought to that form; what is not in the language is refused |
//! | [`certificate`] | `certificate.json`, read strictly, and the claims that may stand there |
//! | [`compiled`] | the crate as rustc compiles it, run beside the reader |
//! | [`audit`] | the texts that an emitted crate is made of, fixed by digests |
//! | [`claims`] | one file a claim: what each engine does for it |
//! | [`prove`] | every claim by every engine |
//! | [`document`] | CLAIMS.md |
//! | [`mutate`] | damages the source and shows which engine notices |

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
