//! Little-endian fields, one after another.

use crate::MESSAGE_BYTES_MAX;

/// A message that is being written; fields that do not fit are left out.
pub(crate) struct Writer {
    bytes: [u8; MESSAGE_BYTES_MAX],
    length: usize,
}

impl Writer {
    pub(crate) fn new() -> Writer {
        Writer {
            bytes: [0; MESSAGE_BYTES_MAX],
            length: 0,
        }
    }

    pub(crate) fn put(&mut self, field: &[u8]) {
        let end = self.length + field.len();
        if let Some(place) = self.bytes.get_mut(self.length..end) {
            place.copy_from_slice(field);
            self.length = end;
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// A message that is read; fields beyond its end are zero. The caller has compared the length.
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Reader<'a> {
        Reader { rest: bytes }
    }

    pub(crate) fn take<const N: usize>(&mut self) -> [u8; N] {
        match self.rest.split_first_chunk::<N>() {
            Some((field, rest)) => {
                self.rest = rest;
                *field
            }
            None => [0; N],
        }
    }

    pub(crate) fn byte(&mut self) -> u8 {
        let [byte] = self.take();
        byte
    }

    pub(crate) fn axes(&mut self) -> [i16; 3] {
        core::array::from_fn(|_| i16::from_le_bytes(self.take()))
    }
}
