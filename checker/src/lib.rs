//! Checks an emitted controller without trusting, or sharing code with, its generator.
//!
//! | file | job |
//! |---|---|
//! | [`module`] | an emitted crate: read, resolved, with its constants |
//! | [`language`] | its declarations; what is not in the language is refused |
//! | [`lower`] | function bodies to the one form that everything below reads |
//! | [`program`] | that form |
//! | [`interpret`] | runs a function, finding every overflow |
//! | [`contract`] | ranges that functions promise each other |

#![warn(missing_docs)]

pub mod contract;
pub mod interpret;
pub mod language;
pub mod lower;
pub mod module;
pub mod program;
pub mod source;

pub use interpret::{Machine, Trap};
pub use module::{Module, ReadError};
pub use source::{Place, SourceError};
