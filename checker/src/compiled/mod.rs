//! The emitted crate, compiled and run, compared with the reader's interpretation of it.
//!
//! Every other engine uses one lowered form of the source; this one uses rustc's
//! meaning of the source. [`harness`] writes a program that calls the public functions with words, [`points`] chooses
//! the words and computes the reader's results for them, [`run`] builds and runs the program in its
//! own folder.

pub mod harness;
pub mod points;
pub mod run;
pub(crate) mod surroundings;
