//! The language of emitted code: parsed from text, checked, and converted to the form in which it is
//! computed ([`crate::program`]). A construct that is not understood is refused with its place.

pub mod attributes;
pub mod contracts;
pub mod declarations;
pub mod emitted;
pub mod emitted_error;
pub(crate) mod harness;
mod imports;
pub mod lower;
pub mod manifest;
pub mod module;
mod plain;
pub mod reading;
pub mod signatures;
pub mod text;
mod visibility;
