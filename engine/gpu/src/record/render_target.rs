//! The images of a rendering, and their contents at its start.

use ash::vk;

use crate::core::ownership::{OfDevice, OwnerId};
use crate::record::attachments::COLOURS_MAX;

/// The images that a render pass draws to.
#[derive(Debug, Clone, Copy)]
pub struct RenderTarget {
    pub(crate) device: OwnerId,
    pub(crate) colours: [vk::ImageView; COLOURS_MAX],
    pub(crate) colour_count: usize,
    pub(crate) depth: vk::ImageView,
    /// The image for the averaged samples of the first colour when the rendering ends; null for
    /// none.
    pub(crate) average: vk::ImageView,
    pub(crate) has_stencil: bool,
    pub(crate) view_mask: u32,
    pub(crate) origin: [u32; 2],
    pub(crate) size: [u32; 2],
    /// The initial colour, the same for all colour images.
    pub colour_load: Load<[f32; 4]>,
    /// The initial depth.
    pub depth_load: Load<f32>,
    /// The use of the colour images after the rendering.
    pub colour_store: AttachmentStore,
    /// The use of the depth image after the rendering.
    pub depth_store: AttachmentStore,
}

/// The contents of an image when a rendering to it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load<T> {
    /// The present contents.
    Keep,
    /// One value everywhere.
    Clear(T),
    /// Undefined contents, if the present contents are not read.
    Forget,
}

/// The use of an image's contents after a rendering. It determines if a tile-based GPU must write
/// them to memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AttachmentStore {
    /// The contents are written to memory, because a later command reads them.
    #[default]
    Keep,
    /// The contents become undefined, because no command reads them.
    Forget,
    /// The contents stay unchanged, and nothing is written to memory. The rendering draws nothing
    /// to the image, but may test against it.
    Unchanged,
}

impl OfDevice for RenderTarget {
    const KIND: &'static str = "a target (`RenderTarget`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl RenderTarget {
    /// Restricts the rendering to an area of `size` pixels at `origin` (from the upper left),
    /// clamped to the target: nothing outside is drawn to or cleared.
    #[must_use]
    pub fn within(mut self, origin: [u32; 2], size: [u32; 2]) -> Self {
        for side in 0..2 {
            let start = origin[side].min(self.size[side]);
            self.origin[side] += start;
            self.size[side] = size[side].min(self.size[side] - start);
        }
        self
    }

    /// Restricts the rendering to the depth: the colour is not drawn to and is undefined
    /// afterwards.
    #[must_use]
    pub fn depth_only(self) -> Self {
        Self { colour_load: Load::Forget, colour_store: AttachmentStore::Forget, ..self }
    }

    /// Returns the target for a rendering whose images are not read afterwards.
    #[must_use]
    pub fn forgotten(self) -> Self {
        let forget = AttachmentStore::Forget;
        Self { colour_store: forget, depth_store: forget, ..self }
    }

    /// Returns the target with an initial colour; the initial depth stays the same.
    #[must_use]
    pub fn cleared_to(self, colour: [f32; 4]) -> Self {
        Self { colour_load: Load::Clear(colour), ..self }
    }
}
