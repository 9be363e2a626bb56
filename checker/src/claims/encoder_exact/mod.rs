//! Claim `encoder-exact`: the counts of an encoder become the turn of its window exactly, wrap included, and a count that
//! is no motion is noticed.

pub mod runs;
pub mod second;
pub mod words;
