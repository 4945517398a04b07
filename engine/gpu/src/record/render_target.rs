//! What a rendering draws to, and what it starts from.

use ash::vk;

use crate::core::ownership::{OfDevice, OwnerId};

/// What a render pass draws to.
#[derive(Debug, Clone, Copy)]
pub struct RenderTarget {
    pub(crate) device: OwnerId,
    pub(crate) colour: vk::ImageView,
    pub(crate) depth: vk::ImageView,
    pub(crate) origin: [u32; 2],
    pub(crate) size: [u32; 2],
    /// The colour to start from.
    pub colour_load: Load<[f32; 4]>,
    /// The depth to start from.
    pub depth_load: Load<f32>,
}

/// What an image holds when a rendering to it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load<T> {
    /// What is there.
    Keep,
    /// The same everywhere.
    Clear(T),
    /// Anything: nothing is drawn to it, and nobody reads what the rendering leaves.
    Forget,
}

impl OfDevice for RenderTarget {
    const KIND: &'static str = "a target (`RenderTarget`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl RenderTarget {
    /// Only `size` pixels from `origin` on (from the upper left), cut to what is there: nothing
    /// outside is drawn to or cleared.
    #[must_use]
    pub fn within(mut self, origin: [u32; 2], size: [u32; 2]) -> Self {
        for side in 0..2 {
            let start = origin[side].min(self.size[side]);
            self.origin[side] += start;
            self.size[side] = size[side].min(self.size[side] - start);
        }
        self
    }

    /// With the depth alone: the colour is not drawn to and holds anything afterwards.
    #[must_use]
    pub fn depth_only(self) -> Self {
        Self { colour_load: Load::Forget, ..self }
    }

    /// With a colour to start from, whatever the depth starts from.
    #[must_use]
    pub fn cleared_to(self, colour: [f32; 4]) -> Self {
        Self { colour_load: Load::Clear(colour), ..self }
    }
}
