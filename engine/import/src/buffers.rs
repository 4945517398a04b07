//! The bytes of buffers, from the binary chunk, data URIs and files.

use std::ops::Range;
use std::path::Path;

use gltf::json::Root;
use scene::counted;

use crate::Limits;
use crate::element::Kind;
use crate::elements::BufferBytes;
use crate::error::{At, Fault, Reason};
use crate::memory;
use crate::uri::{self, Wanted};
use crate::verdict::Verdict;

/// The number of bytes outside of the file that may still be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Budget {
    left: u64,
}

impl Budget {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self { left: limits.buffer_bytes }
    }

    /// Reads the data of a URI, if it is within the remaining budget.
    pub(crate) fn fetch(
        &mut self,
        uri: &str,
        folder: Option<&Path>,
        wanted: Wanted,
    ) -> Result<Vec<u8>, Reason> {
        let bytes = uri::fetch(uri, folder, wanted, self.left)?;
        self.left = self.left.saturating_sub(bytes.len() as u64);
        Ok(bytes)
    }

    /// Returns zeroed memory for decompressed bytes, which counts towards the budget.
    fn zeros(&mut self, length: u64) -> Result<Vec<u8>, Reason> {
        let left = self.left.checked_sub(length);
        self.left =
            left.ok_or_else(|| Reason::too_large("bytes decompressed", length, self.left))?;
        memory::ask(length)?;
        Ok(vec![0; length as usize])
    }
}

/// Returns the bytes of the used buffers; the bytes of placeholders are zeros.
pub(crate) fn resolve(
    root: &Root,
    binary: Option<&Range<usize>>,
    placeholders: &[bool],
    folder: Option<&Path>,
    budget: &mut Budget,
    verdict: &mut Verdict,
) -> Result<Vec<BufferBytes>, Fault> {
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let length = buffer.byte_length.0;
        let element = Kind::Buffer.at(index);
        let is_used = verdict.is_used(element);
        let bytes = match (&buffer.uri, binary) {
            _ if placeholders.get(index) == Some(&true) => {
                let length = if is_used { length } else { 0 };
                budget.zeros(length).map(BufferBytes::Apart)
            }
            (Some(_), _) if !is_used => Ok(BufferBytes::Apart(Vec::new())),
            (Some(uri), _) => {
                budget.fetch(uri, folder, Wanted::First(length)).map(BufferBytes::Apart)
            }
            (None, Some(binary)) if index == 0 => within(binary, length).map(BufferBytes::InFile),
            (None, _) => {
                Err(Reason::malformed("it has no URI, and there is no binary chunk for it"))
            }
        };
        let bytes = verdict.judge(element, bytes.at(|| element.to_string()))?;
        buffers.push(bytes.unwrap_or(BufferBytes::Apart(Vec::new())));
    }
    Ok(buffers)
}

fn within(binary: &Range<usize>, length: u64) -> Result<Range<usize>, Reason> {
    let there = binary.len() as u64;
    if length > there {
        let there = counted(there, "byte", "bytes");
        let text = format!("its byteLength is {length}, but the binary chunk has {there}");
        return Err(Reason::malformed(text));
    }
    Ok(binary.start..binary.start + length as usize)
}
