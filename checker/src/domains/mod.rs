//! The number domains in which a program is computed.
//!
//! | file | a word is |
//! |---|---|
//! | [`machine`] | one integer; every overflow is detected |
//! | [`intervals`] | all integers between two |
//! | [`linear_forms`] | a linear form of the arguments, with an error |
//! | [`polynomials`] | a polynomial of symbols, with a remainder |
//! | [`smt`] | a term of SMT-LIB |
//!
//! [`walk`] is the walk over a program that serves them all; [`halving`] proves contracts by intervals.

pub mod directions;
pub mod halving;
pub mod intervals;
pub mod linear_forms;
pub mod machine;
pub mod polynomials;
pub mod smt;
pub mod walk;
