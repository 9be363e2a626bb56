//! The one computation that is under way.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A running task.
pub struct Running {
    /// Its number, counted from the start of the server.
    pub number: u64,
    /// Its name, for people.
    pub name: &'static str,
    /// Its present progress message.
    pub says: String,
    /// Set to end it.
    pub called_off: Arc<AtomicBool>,
}
