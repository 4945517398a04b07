//! Reads compressed bytes from the front; what is missing is an error.

use crate::error::Reason;

/// What is left of some bytes.
pub(super) struct Stream<'a> {
    left: &'a [u8],
}

impl<'a> Stream<'a> {
    /// Of the body of compressed bytes, and their tail: the first byte must be `header`, the last `tail`
    /// bytes are given apart.
    pub(super) fn open(
        encoded: &'a [u8],
        header: u8,
        tail: usize,
    ) -> Result<(Self, &'a [u8]), Reason> {
        match encoded.split_first() {
            Some((&first, rest)) if first == header => {
                let body = rest.len().checked_sub(tail).ok_or_else(cut_off)?;
                let (left, tail) = rest.split_at(body);
                Ok((Self { left }, tail))
            }
            Some((first, _)) => {
                Err(Reason::malformed(format!("it begins with {first:#x}, not {header:#x}")))
            }
            None => Err(cut_off()),
        }
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Reason> {
        let (taken, left) = self.left.split_at_checked(count).ok_or_else(cut_off)?;
        self.left = left;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Reason> {
        let (&byte, left) = self.left.split_first().ok_or_else(cut_off)?;
        self.left = left;
        Ok(byte)
    }

    /// A whole number in groups of seven bits, the lowest first; all but the last have their top bit set.
    pub(super) fn varint(&mut self) -> Result<u32, Reason> {
        let mut value = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                break;
            }
        }
        Ok(value)
    }

    /// That nothing is left.
    pub(super) fn close(self) -> Result<(), Reason> {
        match self.left.len() {
            0 => Ok(()),
            left => Err(Reason::malformed(format!(
                "{left} bytes are left over when all is decompressed"
            ))),
        }
    }
}

fn cut_off() -> Reason {
    Reason::malformed("its compressed bytes are cut off")
}

/// Appends the lowest bytes of an index, as many as its type has.
pub(super) fn write_index(all: &mut Vec<u8>, index: u32, index_bytes: usize) {
    let bytes = index.to_le_bytes();
    all.extend_from_slice(bytes.get(..index_bytes).unwrap_or(&bytes));
}

/// A signed step out of an unsigned number whose lowest bit is the sign.
pub(super) fn unzigzag(value: u32) -> u32 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}
