//! The language of emitted code: read from text, checked, and brought to the one form in which it is
//! computed ([`crate::program`]). What is not understood is refused with its place.

pub mod attributes;
pub mod contracts;
pub mod declarations;
pub mod emitted;
pub mod lower;
pub mod manifest;
pub mod module;
mod plain;
pub mod reading;
pub mod signatures;
pub mod text;
mod visibility;
