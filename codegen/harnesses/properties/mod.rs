//! One module for each part of the emitted crate.

pub mod attitude;
pub mod control;
pub mod modes;
pub mod supervisor;
