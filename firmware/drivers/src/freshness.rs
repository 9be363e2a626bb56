//! Whether a part still measures.

use crate::Error;

/// A part is stuck after this many calls in a row without a new reading. The slowest part has a new reading in two of
/// five calls at 1 kHz, so that the beat of the two clocks cannot cause so many misses in a row.
pub const STALE_MAX: u8 = 10;

/// Calls since the last new reading.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Freshness(u8);

impl Freshness {
    /// Takes the part's statement whether there is a new reading.
    pub(crate) fn judge<E>(&mut self, is_fresh: bool) -> Result<(), Error<E>> {
        if is_fresh {
            self.0 = 0;
            return Ok(());
        }
        self.0 = self.0.saturating_add(1);
        if self.0 >= STALE_MAX {
            Err(Error::Stuck)
        } else {
            Ok(())
        }
    }
}
