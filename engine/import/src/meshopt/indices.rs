//! Mode `INDICES`: indices in any order, as differences from one of two before
//! (`EXT_meshopt_compression`, appendix A, mode 2).

use super::stream::{self, Stream, unzigzag};
use crate::error::Reason;

const HEADER: u8 = 0xD1;
const TAIL_BYTES: usize = 4;

/// Decompresses `count` indices of two or four bytes.
pub(super) fn decode(encoded: &[u8], count: usize, index_bytes: usize) -> Result<Vec<u8>, Reason> {
    let (mut stream, _) = Stream::open(encoded, HEADER, TAIL_BYTES)?;
    let mut last = [0u32; 2];
    let mut indices = Vec::with_capacity(count.min(encoded.len()) * index_bytes);
    for _ in 0..count {
        let code = stream.varint()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(unzigzag(code >> 1));
        stream::write_index(&mut indices, *last, index_bytes);
    }
    stream.close()?;
    Ok(indices)
}
