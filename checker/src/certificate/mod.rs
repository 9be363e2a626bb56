//! `certificate.json`: its content, and the claims that it may contain.

pub mod claims;
pub mod hardware;
pub mod reader;
pub mod stated_decimal;

pub use reader::{Certificate, CertificateError};
