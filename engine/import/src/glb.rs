//! GLB, the container that holds the JSON and one buffer (glTF 2.0, chapter 4).

use std::ops::Range;

use scene::counted;

use crate::error::{Fault, Reason};

const MAGIC: &[u8; 4] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BINARY: u32 = 0x004E_4942;
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The ranges of the parts of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parts {
    pub(crate) json: Range<usize>,
    pub(crate) binary: Option<Range<usize>>,
}

/// Returns true if the bytes are a GLB and not plain JSON, even if there are very few bytes.
pub(crate) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || (!bytes.is_empty() && MAGIC.starts_with(bytes))
}

/// Finds the chunks of a GLB. Chunks of unknown types and bytes after the end are skipped.
pub(crate) fn split(bytes: &[u8]) -> Result<Parts, Fault> {
    let of_header = |reason: Reason| reason.of("GLB header");
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        let there = counted(bytes.len(), "byte", "bytes");
        return Err(of_header(Reason::malformed(format!("cut off after {there}"))));
    };
    if version != 2 {
        return Err(of_header(Reason::unsupported(format!("version {version}, only 2 is known"))));
    }
    let length = length as usize;
    let whole = bytes.get(..length).ok_or_else(|| {
        let there = bytes.len();
        of_header(Reason::malformed(format!(
            "says {}, but the file has {there}: it is cut off",
            counted(length, "byte", "bytes")
        )))
    })?;
    chunks(whole)
}

/// Frees what is in front of the binary chunk, unless moving the chunk takes longer than reading
/// that text did. Returns the new range of the chunk.
pub(crate) fn free_text(file: &mut Vec<u8>, binary: Range<usize>) -> Range<usize> {
    if binary.len() > binary.start {
        return binary;
    }
    file.truncate(binary.end);
    file.drain(..binary.start);
    file.shrink_to_fit();
    0..file.len()
}

fn chunks(whole: &[u8]) -> Result<Parts, Fault> {
    let mut start = HEADER_BYTES;
    let mut json = None;
    let mut binary = None;
    for number in 0.. {
        if start >= whole.len() {
            break;
        }
        let of_chunk = |reason: String| Reason::malformed(reason).of(format!("GLB chunk {number}"));
        let (Some(length), Some(kind)) = (u32_at(whole, start), u32_at(whole, start + 4)) else {
            return Err(of_chunk("its header is cut off".to_owned()));
        };
        let first = start + CHUNK_HEADER_BYTES;
        let end = first.checked_add(length as usize).filter(|&end| end <= whole.len());
        let Some(end) = end else {
            let left = whole.len() - first;
            let length = counted(length, "byte", "bytes");
            return Err(of_chunk(format!("says {length}, but has only {left}")));
        };
        match (number, kind) {
            (0, JSON) => json = Some(first..end),
            (0, _) => return Err(of_chunk("must be the JSON, and is not".to_owned())),
            (_, BINARY) if binary.is_none() => binary = Some(first..end),
            _ => {}
        }
        start = end;
    }
    let json = json.ok_or_else(|| Reason::malformed("there is no JSON chunk").of("GLB header"))?;
    Ok(Parts { json, binary })
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|&bytes| u32::from_le_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_text_is_freed_and_a_long_chunk_is_not_moved() {
        let mut file = b"a long text, data, rest".to_vec();
        assert_eq!(free_text(&mut file, 13..17), 0..4);
        assert_eq!(file, b"data");
        let mut file = b"text, and more data".to_vec();
        assert_eq!(free_text(&mut file, 6..19), 6..19);
        assert_eq!(file.len(), 19);
    }
}
