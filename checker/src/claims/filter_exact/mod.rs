//! Claim `filter-exact`: the source computes just the words of a second version of it.
//!
//! [`crate::claims::filter_accurate`] shows that the equations are the right ones, to within a
//! tolerance; this notices a damage below that.

pub mod draw;
pub mod every_input;
pub mod runs;
pub mod second;
