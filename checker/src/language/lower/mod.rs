//! From the body of a function to a [`crate::program::Program`]: types are checked, names resolved,
//! calls inlined, and every construct that is not understood is refused with its place.

mod branches;
mod builder;
mod calls;
mod expressions;
mod operators;
pub mod programs;
mod statements;
mod types;
