//! What every answer of the server needs.

use std::sync::Arc;

use crate::desk::Desk;
use crate::guard::Guard;

/// The data that every answer needs.
#[derive(Clone)]
pub(crate) struct Shared {
    pub guard: Arc<Guard>,
    pub desk: Arc<Desk>,
}
