//! Recording of copies to texture arrays that are sampled in the meantime.

use crate::memory::buffer::BufferSlice;
use crate::memory::texture_array::TextureArray;
use crate::record::access::Access;
use crate::record::commands::{Commands, Failure};

/// Rows of one level of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureRows {
    /// The layer.
    pub layer: u32,
    /// The mip level; 0 is the whole image.
    pub level: u32,
    /// The first row, from the top; with compressed blocks, the first row of blocks.
    pub first: u32,
    /// The number of rows.
    pub count: u32,
}

impl Commands {
    /// Prepares all layers of an unwritten array to be sampled and
    /// [written](Commands::write_texture), with undefined texels. Does the same as
    /// [`TextureUploads::reserve`](crate::TextureUploads::reserve), but without waiting. The array
    /// counts as filled once it was [announced](TextureArray::announce).
    pub fn open_texture(&self, array: &TextureArray) {
        if self.check_owner(array).is_err() {
            return;
        }
        for layer in 0..array.layers() {
            self.change_layouts([array.change(
                layer,
                0..array.levels,
                Access::Nothing,
                Access::FragmentSample,
            )]);
        }
    }

    /// Copies rows from the beginning of `from` to a layer that was
    /// [written](crate::TextureUploads::write) or [reserved](crate::TextureUploads::reserve): four
    /// bytes per pixel, or compressed blocks. Waits for earlier draws that sample the array; later
    /// draws wait for the copy.
    ///
    /// The frame fails if the rows are not in the array or their bytes are not in `from`.
    pub fn write_texture(&self, array: &TextureArray, rows: TextureRows, from: BufferSlice) {
        if self.check_owner(array).is_err() || !self.check_owners([&from]) {
            return;
        }
        let TextureRows { layer, level, first, count } = rows;
        let is_there = array.is_filled()
            && layer < array.layers()
            && level < array.levels
            && first.checked_add(count).is_some_and(|end| end <= array.level_rows(level))
            && array.row_bytes(level) * u64::from(count) <= from.size_bytes;
        if !is_there {
            self.fail(Failure::Wrong("rows are copied to a texture array that has none there"));
            return;
        }
        if count == 0 {
            return;
        }
        let levels = level..level + 1;
        self.change_layouts([array.change(
            layer,
            levels.clone(),
            Access::FragmentSample,
            Access::CopyWrite,
        )]);
        array.copy_rows(self, from, layer, level, first..first + count);
        self.change_layouts([array.change(
            layer,
            levels,
            Access::CopyWrite,
            Access::FragmentSample,
        )]);
    }

    /// Creates the mip maps of a layer whose rows were all [copied](Commands::write_texture), if
    /// the device creates them. Otherwise see [`TextureArray::levels_by_cpu`].
    pub fn make_texture_levels(&self, array: &TextureArray, layer: u32) {
        if self.check_owner(array).is_err() {
            return;
        }
        if !array.is_filled() || layer >= array.layers() {
            self.fail(Failure::Wrong("mip maps are made of a layer that is not there"));
            return;
        }
        if array.blits_levels() {
            let all = 0..array.levels;
            self.change_layouts([array.change(
                layer,
                all,
                Access::FragmentSample,
                Access::CopyWrite,
            )]);
            array.blit_levels(self, layer);
        }
    }
}
