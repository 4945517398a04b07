//! Room for things that are added while a renderer runs.

use std::ops::Range;

use range_alloc::RangeAllocator;
use scene::{Encoding, PreparedTexture, Sampler};

use crate::error::Error;

/// Room that a renderer keeps for things that are added while it runs, in addition to the room of
/// removed ones. This room never grows. By default there is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SpareCapacity {
    /// The number of point and spot lights, in a scene with surfaces: 48 bytes each. If it is above
    /// 0, the pipelines are compiled for both kinds.
    pub lights: u32,
    /// The number of directional lights, in a scene with surfaces. Each costs every pixel a little,
    /// even while it is unused. Together with the shining ones of the scene there may be at most
    /// [`MAX_DIRECTIONAL_LIGHTS`](scene::limits::MAX_DIRECTIONAL_LIGHTS).
    pub directional_lights: u32,
    /// The number of meshes.
    pub meshes: u32,
    /// The number of vertices of meshes: 20 bytes each, and 28 more in a scene with surfaces.
    pub vertices: u32,
    /// The number of indices of meshes and of their coarser levels: 4 bytes each.
    pub indices: u32,
    /// The number of coarser levels of meshes.
    pub levels: u32,
    /// The number of materials, in a scene with surfaces: 224 bytes each, including the transforms
    /// of their textures. If it is above 0, the pipelines are compiled for holes, emission, unlit
    /// materials and textures of all kinds, which costs every pixel a little.
    pub materials: u32,
    /// Textures of a scene with surfaces, for later materials, if textures lie on
    /// [pages](crate::surfaces::TextureStorage::ArrayPacked): a page for each kind. Together with
    /// the pages of the scene there may be at most [`MAX_PAGES`](scene::limits::MAX_PAGES), so
    /// images of the scene may be resampled to share a page.
    /// share a page.
    pub textures: Vec<TextureCapacity>,
}

/// Room for textures of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureCapacity {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The meaning of the bytes.
    pub encoding: Encoding,
    /// The sampler.
    pub sampler: Sampler,
    /// The number of textures: four bytes per pixel each, and a third more for mip maps.
    pub layers: u32,
}

impl TextureCapacity {
    /// Returns true for a texture of this kind.
    pub(crate) fn takes(&self, texture: &PreparedTexture) -> bool {
        let kind = (texture.image().size, texture.encoding(), texture.sampler());
        kind == (self.size, self.encoding, self.sampler)
    }
}

/// The allocated ranges of one array.
#[derive(Debug)]
pub(crate) struct SpareRanges {
    what: &'static str,
    ranges: RangeAllocator<u32>,
}

impl SpareRanges {
    /// Allocates the first `used` elements, with room for `spare` more.
    pub(crate) fn behind(what: &'static str, used: u32, spare: u32) -> Self {
        let mut ranges = RangeAllocator::new(0..used.saturating_add(spare));
        if used > 0 {
            // The first allocation begins at 0, since all is free.
            let _beginning = ranges.allocate_range(used);
        }
        Self { what, ranges }
    }

    /// Allocates a range. An empty range needs no room.
    pub(crate) fn take(&mut self, count: usize) -> Result<Range<u32>, Error> {
        if count == 0 {
            return Ok(0..0);
        }
        // The allocator supports at most half of the numbers of 32 bits.
        let count_32 = u32::try_from(count).ok().filter(|count| *count <= u32::MAX / 2);
        let taken = count_32.and_then(|count| self.ranges.allocate_range(count).ok());
        taken.ok_or_else(|| Error::CapacityExceeded {
            what: self.what,
            wanted: count as u64,
            left: self.largest_free(),
        })
    }

    /// Frees a range.
    pub(crate) fn free(&mut self, range: Range<u32>) {
        if !range.is_empty() {
            self.ranges.free_range(range);
        }
    }

    /// Returns the free ranges between and behind the allocated ones; some may be empty.
    fn free_ranges(&self) -> impl Iterator<Item = Range<u32>> {
        let mut begin = 0;
        let end = self.ranges.initial_range().end;
        let taken = self.ranges.allocated_ranges().chain(std::iter::once(end..end));
        taken.map(move |taken| std::mem::replace(&mut begin, taken.end)..taken.start)
    }

    /// Returns the length of the longest free range.
    fn largest_free(&self) -> u64 {
        self.free_ranges().map(|free| u64::from(free.end - free.start)).max().unwrap_or_default()
    }
}

impl Clone for SpareRanges {
    /// Returns ranges of which the same are allocated.
    fn clone(&self) -> Self {
        let mut same = Self::behind(self.what, self.ranges.initial_range().end, 0);
        self.free_ranges().for_each(|free| same.free(free));
        same
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_lie_behind_what_is_there_and_are_taken_again() {
        let mut ranges = SpareRanges::behind("indices", 10, 20);
        let [a, b] = [12, 8].map(|count| ranges.take(count).unwrap());
        assert_eq!((a.clone(), b.clone(), ranges.take(0).unwrap()), (10..22, 22..30, 0..0));
        let error = ranges.take(1).unwrap_err().to_string();
        assert!(error.contains("1 indices") && error.contains("at most 0"), "{error}");
        ranges.free(a);
        ranges.free(0..4);
        let error = ranges.take(13).unwrap_err().to_string();
        assert!(error.contains("at most 12"), "{error}");
        assert_eq!(ranges.take(3).unwrap(), 0..3);
        ranges.free(b);
        let mut same = ranges.clone();
        assert_eq!((same.take(17).unwrap(), same.largest_free()), (10..27, 3));
        assert_eq!(ranges.take(17).unwrap(), 10..27);
        assert_eq!(ranges.take(1).unwrap(), 3..4);
    }

    #[test]
    fn without_room_nothing_is_taken() {
        let mut ranges = SpareRanges::behind("meshes", 0, 0);
        assert!(ranges.take(1).is_err());
    }
}
