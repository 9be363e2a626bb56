//! The claims of the emitted crate `generated`, stated once and decided by several engines.
//!
//! Each property in [`properties`] is a plain function that asserts it for one input. The same
//! function is called
//!
//! - by the tests in `verify/tests/`, on tables of extreme words and on random ones (proptest), and
//! - by the harnesses in `proofs` (compiled only by `cargo kani -p verify`), on every input at
//!   once.
//!
//! Every claim is thus executable, and none is stated twice. The identifiers of the claims are
//! those of `generated/certificate.json`.

pub mod properties;

#[cfg(kani)]
mod proofs;
#[cfg(kani)]
mod proofs_attitude;
#[cfg(kani)]
mod proofs_step;
#[cfg(kani)]
mod proofs_supervisor;
