//! Mode `ATTRIBUTES`: bytes of elements, each as its difference from the element before
//! (`EXT_meshopt_compression`, appendix A, mode 0).

use super::stream::Stream;
use crate::error::Reason;

const HEADER: u8 = 0xA0;
const GROUP: usize = 16;
const MAX_BLOCK_BYTES: usize = 8192;
const MAX_BLOCK_ELEMENTS: usize = 256;
const MIN_TAIL_BYTES: usize = 32;

/// Decompresses `count` elements of `stride` bytes, at most 256.
pub(super) fn decode(encoded: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Reason> {
    let (mut stream, tail) = Stream::open(encoded, HEADER, stride.max(MIN_TAIL_BYTES))?;
    // The element that the first one differs from.
    let mut last = tail.get(tail.len() - stride..).unwrap_or_default().to_vec();
    let mut elements = vec![0; count * stride];
    let block = (MAX_BLOCK_BYTES / stride / GROUP * GROUP).clamp(GROUP, MAX_BLOCK_ELEMENTS);
    for block in elements.chunks_mut(block * stride) {
        for (place, last) in last.iter_mut().enumerate() {
            decode_bytes(&mut stream, block, stride, place, last)?;
        }
    }
    stream.close()?;
    Ok(elements)
}

/// Decompresses one byte of each element of a block.
fn decode_bytes(
    stream: &mut Stream,
    block: &mut [u8],
    stride: usize,
    place: usize,
    last: &mut u8,
) -> Result<(), Reason> {
    let groups = (block.len() / stride).div_ceil(GROUP);
    let widths = stream.take(groups.div_ceil(4))?;
    for (index, group) in block.chunks_mut(GROUP * stride).enumerate() {
        let width = widths.get(index / 4).map_or(0, |byte| byte >> (index % 4 * 2) & 3);
        let steps = decode_group(stream, width)?;
        for (element, step) in group.chunks_mut(stride).zip(steps) {
            *last = last.wrapping_add((step >> 1) ^ (step & 1).wrapping_neg());
            if let Some(byte) = element.get_mut(place) {
                *byte = *last;
            }
        }
    }
    Ok(())
}

/// Sixteen steps: zeros, of two bits, of four bits, or bytes. Those that do not fit their bits follow them.
fn decode_group(stream: &mut Stream, width: u8) -> Result<[u8; GROUP], Reason> {
    let mut steps = [0; GROUP];
    let bits: usize = match width {
        0 => return Ok(steps),
        1 => 2,
        2 => 4,
        _ => {
            steps.copy_from_slice(stream.take(GROUP)?);
            return Ok(steps);
        }
    };
    let packed = stream.take(GROUP * bits / 8)?;
    let sentinel = (1 << bits) - 1;
    for (index, step) in steps.iter_mut().enumerate() {
        let bit = index * bits;
        let byte = packed.get(bit / 8).copied().unwrap_or(0);
        // The first is in the highest bits.
        *step = (byte >> (8 - bits - bit % 8)) & sentinel;
        if *step == sentinel {
            *step = stream.byte()?;
        }
    }
    Ok(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_do_not_fit_follow() {
        // The example of the specification.
        let packed = [0xA0, 0x17, 0x5F, 0xF0, 0xBC, 0x77, 0xA9, 0x21, 0x00, 0x34, 0xB5];
        let (mut stream, _) = Stream::open(&packed, HEADER, 0).expect("it begins right");
        let steps = decode_group(&mut stream, 2).expect("it is whole");
        let signed = steps.map(|step| ((step >> 1) ^ (step & 1).wrapping_neg()) as i8);
        assert_eq!(signed, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert_eq!(stream.close(), Ok(()));
    }
}
