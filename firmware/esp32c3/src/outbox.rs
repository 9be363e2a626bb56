//! Frames that wait for the line. A frame for which there is no room is dropped whole.

/// Room for eleven frames: the line may pause for eleven steps.
const BYTES: usize = 512;

/// A ring of bytes.
pub struct Outbox {
    bytes: [u8; BYTES],
    first: usize,
    length: usize,
}

impl Outbox {
    /// An empty ring.
    pub const fn new() -> Self {
        Outbox {
            bytes: [0; BYTES],
            first: 0,
            length: 0,
        }
    }

    /// Takes a frame, all of it or nothing.
    pub fn offer(&mut self, frame: &[u8]) {
        if frame.len() > BYTES - self.length {
            return;
        }
        for byte in frame {
            let place = (self.first + self.length) % BYTES;
            if let Some(slot) = self.bytes.get_mut(place) {
                *slot = *byte;
            }
            self.length += 1;
        }
    }

    /// The byte that goes next.
    pub fn first(&self) -> Option<u8> {
        (self.length > 0)
            .then(|| self.bytes.get(self.first).copied())
            .flatten()
    }

    /// Removes the first byte, which the line has taken.
    pub fn took_first(&mut self) {
        if self.length > 0 {
            self.first = (self.first + 1) % BYTES;
            self.length -= 1;
        }
    }
}
