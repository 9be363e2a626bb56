//! The claims of the controller beside this crate, each stated once and decided by several engines.
//!
//! Each property in [`properties`] is a plain function that asserts it for one input. The same
//! function is called
//!
//! - by tests, on tables of extreme words and on random ones, and
//! - by the harnesses in `proofs…` (compiled only by `cargo kani` in this folder), on every input at
//!   once.
//!
//! Every claim is thus executable, and none is stated twice. The identifiers of the claims are
//! those of `flywheel prove`.

#[cfg(not(any(body_encoder, wheel_encoder, voltage_drive)))]
pub mod modes;
pub mod properties;

#[cfg(kani)]
mod proofs;
#[cfg(not(body_encoder))]
#[cfg(kani)]
mod proofs_attitude;
#[cfg(any(body_encoder, wheel_encoder))]
#[cfg(kani)]
mod proofs_encoder;
#[cfg(kani)]
mod proofs_lines;
#[cfg(not(any(body_encoder, wheel_encoder, voltage_drive)))]
#[cfg(kani)]
mod proofs_modes;
#[cfg(kani)]
mod proofs_product;
#[cfg(kani)]
mod proofs_step;
#[cfg(kani)]
mod proofs_supervisor;
#[cfg(kani)]
mod words;
