//! Decodes views with the crate `meshopt`, whose decoders accept untrusted bytes.

use super::{Compressed, Filter, Mode};
use crate::error::Reason;
use crate::extensions::MESHOPT;

/// The first byte of attributes: version 0, and version 1, which only the newer extension allows.
const ATTRIBUTES: [u8; 2] = [0xA0, 0xA1];
/// The first byte of triangles and of other indices.
const TRIANGLES: u8 = 0xE1;
const INDICES: u8 = 0xD1;

/// An element of `COUNT` values.
#[derive(Clone, Copy)]
struct Values<const COUNT: usize>([u32; COUNT]);

impl<const COUNT: usize> Default for Values<COUNT> {
    fn default() -> Self {
        Self([0; COUNT])
    }
}

/// Decompresses a view, which must have been checked to fit its mode.
pub(super) fn decode(view: &Compressed, encoded: &[u8]) -> Result<Vec<u8>, Reason> {
    check_header(view, encoded)?;
    let count = view.count;
    let is_short = view.stride == 2;
    let decoded = match view.mode {
        Mode::Attributes(filter) => {
            attributes(view, encoded).map(|values| filtered(values, filter, view.stride))
        }
        Mode::Triangles if is_short => {
            ::meshopt::decode_index_buffer::<u16>(encoded, count).map(bytes_of)
        }
        Mode::Triangles => ::meshopt::decode_index_buffer::<u32>(encoded, count).map(bytes_of),
        Mode::Indices if is_short => {
            ::meshopt::decode_index_sequence::<u16>(encoded, count).map(bytes_of)
        }
        Mode::Indices => ::meshopt::decode_index_sequence::<u32>(encoded, count).map(bytes_of),
    };
    decoded.map_err(|_| Reason::damaged("its compressed bytes are cut off or damaged"))
}

fn check_header(view: &Compressed, encoded: &[u8]) -> Result<(), Reason> {
    let Some(&first) = encoded.first() else {
        return Err(Reason::damaged("it has no bytes"));
    };
    let is_newer = view.extension == MESHOPT[1];
    let known: &[u8] = match view.mode {
        Mode::Attributes(_) if is_newer => &ATTRIBUTES,
        Mode::Attributes(_) => &ATTRIBUTES[..1],
        Mode::Triangles => &[TRIANGLES],
        Mode::Indices => &[INDICES],
    };
    if known.contains(&first) {
        return Ok(());
    }
    let expected: Vec<String> = known.iter().map(|byte| format!("{byte:#04x}")).collect();
    let expected = expected.join(" or ");
    Err(Reason::damaged(format!("it begins with {first:#04x} and not with {expected}")))
}

fn attributes(view: &Compressed, encoded: &[u8]) -> ::meshopt::Result<Vec<u32>> {
    macro_rules! by_values {
        ($($values:literal)*) => {
            match view.stride / 4 {
                $($values => decode_values::<$values>(encoded, view.count),)*
                _ => Ok(Vec::new()),
            }
        };
    }
    by_values!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

fn decode_values<const COUNT: usize>(encoded: &[u8], count: usize) -> ::meshopt::Result<Vec<u32>> {
    let elements = ::meshopt::decode_vertex_buffer::<Values<COUNT>>(encoded, count)?;
    let mut values = Vec::with_capacity(count * COUNT);
    elements.iter().for_each(|Values(element)| values.extend_from_slice(element));
    Ok(values)
}

/// Returns the filtered elements, each of `stride` bytes.
fn filtered(mut values: Vec<u32>, filter: Filter, stride: usize) -> Vec<u8> {
    let list = values.as_mut_slice();
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            ::meshopt::decode_filter_oct::<i8>(bytemuck::cast_slice_mut(list));
        }
        (Filter::Octahedral, _) => {
            ::meshopt::decode_filter_oct::<i16>(bytemuck::cast_slice_mut(list));
        }
        (Filter::Quaternion, _) => ::meshopt::decode_filter_quat(bytemuck::cast_slice_mut(list)),
        (Filter::Exponential, _) => {
            ::meshopt::decode_filter_exp::<1>(bytemuck::cast_slice_mut(list));
        }
        (Filter::Colour, 4) => {
            ::meshopt::decode_filter_color::<u8>(bytemuck::cast_slice_mut(list));
        }
        (Filter::Colour, _) => {
            ::meshopt::decode_filter_color::<u16>(bytemuck::cast_slice_mut(list));
        }
    }
    bytes_of(values)
}

fn bytes_of<T: bytemuck::Pod>(numbers: Vec<T>) -> Vec<u8> {
    bytemuck::cast_slice(&numbers).to_vec()
}
