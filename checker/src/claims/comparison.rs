//! Two statements of one number, compared.

/// Nothing, or what is wrong.
pub(crate) type Check = Result<(), String>;

/// Whether certificate and source agree on `what`.
///
/// # Errors
/// Both statements.
pub(crate) fn equal<T: PartialEq + std::fmt::Display>(what: &str, stated: T, found: T) -> Check {
    if stated == found {
        Ok(())
    } else {
        Err(format!(
            "{what}: the certificate says {stated}, the source {found}"
        ))
    }
}

/// Whether a condition holds.
///
/// # Errors
/// The message.
pub(crate) fn holds(condition: bool, message: impl FnOnce() -> String) -> Check {
    if condition { Ok(()) } else { Err(message()) }
}
