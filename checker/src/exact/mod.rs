//! Exact arithmetic: rational numbers, matrices of them, and real numbers rounded outward.

pub mod enclosure;
pub mod grid;
pub mod matrices;
pub mod rational;
pub mod short;
pub mod slopes;
