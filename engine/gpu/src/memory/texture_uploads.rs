//! Uploads of textures: arrays are filled layer by layer during loading, on any thread.

use ash::vk;

use crate::core::cancellation::CancellationToken;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::memory::texture_array::{MipGeneration, TextureArray};
use crate::record::access::{Access, MemoryBarrier};

/// The size of the pieces in which images are copied to the GPU.
const STAGING_BYTES: u64 = 8 << 20;

/// The uploader of images to texture arrays, through memory of bounded size. Each call waits for
/// its copy on the calling thread: a loading thread may fill arrays while another thread draws
/// frames.
pub struct TextureUploads {
    device: Device,
    staging: Buffer,
    cancellation: CancellationToken,
}

impl TextureUploads {
    /// Creates an uploader with its staging memory.
    ///
    /// # Errors
    /// No memory.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let staging =
            Buffer::new(device, "texture staging", STAGING_BYTES, usage, MemoryKind::Upload)?;
        let cancellation = CancellationToken::default();
        Ok(Self { device: device.clone(), staging, cancellation })
    }

    /// Returns the same uploader with a cancellation. Once it is requested, uploads end before the
    /// next piece of an image with [`Error::Cancelled`]; pieces written before stay.
    #[must_use]
    pub fn cancelled_by(self, cancellation: CancellationToken) -> Self {
        Self { cancellation, ..self }
    }

    /// Writes the next rows of a layer, from its top on: complete rows of four bytes per pixel, or
    /// of compressed blocks. The last row completes the layer and creates its mip maps. So a loader
    /// can upload images piece by piece.
    ///
    /// # Errors
    /// [`Error::WrongCommands`] for a missing layer, for bytes that are not complete rows or more
    /// than are left, and for an array with several [given](MipGeneration::Given) mip maps;
    /// [`Error::Foreign`] for an array of another device; a failed call. Rows written before stay.
    pub fn write_rows(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        rgba8: &[u8],
    ) -> Result<(), Error> {
        if array.has_given_levels() && array.levels > 1 {
            return Err(Error::WrongCommands("the mip maps of a layer are written with it"));
        }
        self.write_first_level(array, layer, rgba8)
    }

    /// Writes the next rows of the whole image of a layer.
    fn write_first_level(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        rgba8: &[u8],
    ) -> Result<(), Error> {
        let row_bytes = array.row_bytes(0) as usize;
        let done = array.layers.get(layer as usize).map(|layer| layer.rows);
        let left = done.map_or(0, |rows| (array.level_rows(0) - rows) as usize);
        if rgba8.is_empty()
            || !rgba8.len().is_multiple_of(row_bytes)
            || rgba8.len() / row_bytes > left
        {
            return Err(Error::WrongCommands("what is written to a layer is not rows of it"));
        }
        self.device.check(array, "texture uploads (`TextureUploads`)")?;
        let piece_rows = (STAGING_BYTES as usize / row_bytes).max(1);
        for piece in rgba8.chunks(piece_rows * row_bytes) {
            self.write_piece(array, layer, piece)?;
        }
        Ok(())
    }

    /// Writes a whole layer and creates its mip maps.
    ///
    /// # Errors
    /// The errors of [`TextureUploads::write_rows`]; a layer that was written to before.
    pub fn write(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        rgba8: &[u8],
    ) -> Result<(), Error> {
        array.check_level(0, rgba8)?;
        self.write_rows(array, layer, rgba8)
    }

    /// Writes a whole layer of an array with [given](MipGeneration::Given) mip maps, the whole
    /// image first.
    ///
    /// # Errors
    /// The errors of [`TextureUploads::write`]; another number of mip maps than the array has.
    pub fn write_levels(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        levels: &[Vec<u8>],
    ) -> Result<(), Error> {
        const OTHERS: &str = "a layer is written with other mip maps than it has";
        let is_given = array.has_given_levels() && levels.len() == array.levels as usize;
        let Some((first, smaller)) = levels.split_first().filter(|_| is_given) else {
            return Err(Error::WrongCommands(OTHERS));
        };
        for (level, bytes) in (0..).zip(levels) {
            array.check_level(level, bytes)?;
        }
        self.write_first_level(array, layer, first)?;
        if smaller.is_empty() { Ok(()) } else { self.write_smaller_levels(array, layer, smaller) }
    }

    /// Prepares unwritten layers to be bound, with undefined texels, for
    /// [`Commands::write_texture`](crate::Commands::write_texture).
    ///
    /// # Errors
    /// [`Error::WrongCommands`] for layers that are missing or were written; [`Error::Foreign`] for
    /// an array of another device; a failed call.
    pub fn reserve(
        &mut self,
        array: &mut TextureArray,
        layers: std::ops::Range<u32>,
    ) -> Result<(), Error> {
        self.device.check(array, "texture uploads (`TextureUploads`)")?;
        let reserved = array.layers.get(layers.start as usize..layers.end as usize);
        if !reserved.is_some_and(|reserved| reserved.iter().all(|layer| layer.rows == 0)) {
            return Err(Error::WrongCommands("layers are reserved that are not there or written"));
        }
        if layers.is_empty() {
            return Ok(());
        }
        let changed: &TextureArray = array;
        self.device.run_once("texture room", |commands| {
            for layer in layers.clone() {
                commands.change_layouts([changed.change(
                    layer,
                    0..changed.levels,
                    Access::Nothing,
                    Access::FragmentSample,
                )]);
            }
        })?;
        let rows = array.level_rows(0);
        let reserved = array.layers.get_mut(layers.start as usize..layers.end as usize);
        reserved.into_iter().flatten().for_each(|layer| layer.rows = rows);
        Ok(())
    }

    /// Writes rows that fit into the staging buffer.
    fn write_piece(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        piece: &[u8],
    ) -> Result<(), Error> {
        self.cancellation.check()?;
        let place = layer as usize;
        let first = array.layers.get(place).map_or(0, |layer| layer.rows);
        let rows = first..first + (piece.len() / array.row_bytes(0) as usize) as u32;
        let is_last = rows.end == array.level_rows(0);
        let has_more = is_last && !array.blits_levels() && array.levels > 1;
        let end = rows.end;
        self.stage(piece);
        let staging = &self.staging;
        let written: &TextureArray = array;
        self.device.run_once("texture", |commands| {
            if first == 0 {
                let all = 0..written.levels;
                commands.change_layouts([written.change(
                    layer,
                    all,
                    Access::Nothing,
                    Access::CopyWrite,
                )]);
            }
            written.copy_rows(commands, staging.whole(), layer, 0, rows);
            if is_last && !has_more {
                written.blit_levels(commands, layer);
            }
            // The wait makes nothing visible to the GPU, and later submits use the image without a
            // barrier of their own.
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
        })?;
        if let Some(layer) = array.layers.get_mut(place) {
            if array.mip_making == MipGeneration::Cpu && array.levels > 1 {
                layer.kept.extend_from_slice(piece);
            }
            if !has_more {
                layer.rows = end;
            }
        }
        if has_more && array.mip_making == MipGeneration::Cpu {
            let kept = array.layers.get_mut(place).map(|layer| std::mem::take(&mut layer.kept));
            let levels = array.levels_by_cpu(&kept.unwrap_or_default());
            self.write_smaller_levels(array, layer, &levels)?;
        }
        Ok(())
    }

    /// Writes the levels of a layer from the second on, and prepares all levels to be sampled.
    fn write_smaller_levels(
        &mut self,
        array: &mut TextureArray,
        layer: u32,
        levels: &[Vec<u8>],
    ) -> Result<(), Error> {
        for (level, pixels) in (1..).zip(levels) {
            let row_bytes = array.row_bytes(level) as usize;
            let piece_rows = (STAGING_BYTES as usize / row_bytes).max(1);
            for (piece, bytes) in pixels.chunks(piece_rows * row_bytes).enumerate() {
                self.cancellation.check()?;
                let first = (piece * piece_rows) as u32;
                let rows = first..first + (bytes.len() / row_bytes) as u32;
                self.stage(bytes);
                let staging = &self.staging;
                let array = &*array;
                self.device.run_once("texture level", |commands| {
                    array.copy_rows(commands, staging.whole(), layer, level, rows);
                    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::Any]));
                })?;
            }
        }
        let changed: &TextureArray = array;
        self.device.run_once("texture levels", |commands| {
            let all = 0..changed.levels;
            commands.change_layouts([changed.change(
                layer,
                all,
                Access::CopyWrite,
                Access::FragmentSample,
            )]);
        })?;
        let rows = array.level_rows(0);
        if let Some(layer) = array.layers.get_mut(layer as usize) {
            layer.rows = rows;
        }
        Ok(())
    }

    fn stage(&mut self, bytes: &[u8]) {
        if let Some(place) = self.staging.bytes_mut().get_mut(..bytes.len()) {
            place.copy_from_slice(bytes);
        }
    }
}
