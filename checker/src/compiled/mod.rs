//! The emitted crate, compiled and run beside the reader's interpretation of it.
//!
//! Every other engine reads one lowered form of the source; this one asks rustc what the source
//! means. [`harness`] writes a program that calls the public functions with words, [`points`] chooses
//! the words and computes what the reader gives for them, [`run`] builds and runs the program in a
//! folder of its own.

pub mod harness;
pub mod points;
pub mod run;
