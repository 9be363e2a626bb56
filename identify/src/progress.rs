//! Progress messages of long work, and its cancellation.

/// The link between long work and its caller.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Receives a message about the next piece of work; always called from the caller's own thread.
    pub say: &'a dyn Fn(&str),
    /// Called before every fit and during it, from any thread. If it returns `true`, the work ends with [`Cancelled`].
    /// It must return immediately, and once it has returned `true` it must not return `false` again.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Progress<'a> {
    /// Messages without cancellation.
    pub fn saying(say: &'a dyn Fn(&str)) -> Progress<'a> {
        Progress {
            say,
            cancelled: &|| false,
        }
    }

    /// Neither messages nor cancellation.
    pub fn silent() -> Progress<'static> {
        Progress {
            say: &|_| {},
            cancelled: &|| false,
        }
    }

    /// Returns [`Cancelled`] if the work has been cancelled.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if (self.cancelled)() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }
}

/// The work was cancelled; there is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("called off")]
pub struct Cancelled;
