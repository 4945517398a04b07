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
    /// The image that the samples of the first colour are averaged into when the rendering ends;
    /// null for none.
    pub(crate) average: vk::ImageView,
    pub(crate) has_stencil: bool,
    pub(crate) view_mask: u32,
    pub(crate) origin: [u32; 2],
    pub(crate) size: [u32; 2],
    /// The colour to start from, the same for all colour images.
    pub colour_load: Load<[f32; 4]>,
    /// The depth to start from.
    pub depth_load: Load<f32>,
}

/// The contents of an image when a rendering to it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load<T> {
    /// The contents that are there.
    Keep,
    /// One value everywhere.
    Clear(T),
    /// Undefined contents: nothing is drawn to the image, and nobody reads what the rendering
    /// leaves.
    Forget,
}

impl OfDevice for RenderTarget {
    const KIND: &'static str = "a target (`RenderTarget`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl RenderTarget {
    /// Restricts the rendering to `size` pixels from `origin` on (from the upper left), cut to what
    /// is there: nothing outside is drawn to or cleared.
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
        Self { colour_load: Load::Forget, ..self }
    }

    /// Returns the target with a colour to start from, whatever the depth starts from.
    #[must_use]
    pub fn cleared_to(self, colour: [f32; 4]) -> Self {
        Self { colour_load: Load::Clear(colour), ..self }
    }
}
