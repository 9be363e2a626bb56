//! `certificate.json`: what it holds, and what may be claimed.

pub mod claims;
pub mod hardware;
pub mod reader;

pub use reader::{Certificate, CertificateError};
