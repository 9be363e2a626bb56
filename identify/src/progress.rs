//! Long work says what it is doing, and can be called off.

/// What long work tells its caller, and what it asks him.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Is told in words what comes next; from the thread that called, never from another one.
    pub say: &'a dyn Fn(&str),
    /// Asked before every fit and within it, from any thread: `true` ends the work with [`Cancelled`]. It must answer
    /// at once, and after the first `true` it must not go back.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Progress<'a> {
    /// Progress that is reported and never called off.
    pub fn saying(say: &'a dyn Fn(&str)) -> Progress<'a> {
        Progress {
            say,
            cancelled: &|| false,
        }
    }

    /// Neither reported nor called off.
    pub fn silent() -> Progress<'static> {
        Progress {
            say: &|_| {},
            cancelled: &|| false,
        }
    }

    /// Goes on unless the work has been called off.
    ///
    /// # Errors
    /// [`Cancelled`] if it has.
    pub fn check(&self) -> Result<(), Cancelled> {
        if (self.cancelled)() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }
}

/// The work was called off; there is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("called off")]
pub struct Cancelled;
