//! Claim `filter-exact`: the source computes exactly the words of a second implementation.
//!
//! [`crate::claims::filter_accurate`] shows that the equations are right within a
//! tolerance; this claim detects changes below that tolerance.

pub mod draw;
pub mod every_input;
pub mod runs;
pub mod second;
