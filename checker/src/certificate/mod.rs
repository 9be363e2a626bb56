//! `certificate.json`: its content, and the claims that it may contain.

pub mod claims;
pub mod hardware;
pub mod reader;

pub use reader::{Certificate, CertificateError};
