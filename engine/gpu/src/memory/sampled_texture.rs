//! Textures as draws sample them, whichever object they are part of.

use std::marker::PhantomData;

use ash::vk;

use crate::core::deletion::RecordingId;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::record::access::Access;
use crate::record::commands::Commands;

/// The contents that the newest recording left in an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Contents {
    /// Undefined contents, as after creation.
    Undefined,
    /// Contents that the recording defined, which may never be submitted.
    OfRecording(RecordingId),
    /// Defined contents: the recording was submitted.
    Defined,
}

impl Contents {
    /// Returns true if `commands` may sample the image.
    pub(crate) fn is_known_to(self, commands: &Commands) -> bool {
        match self {
            Self::Undefined => false,
            Self::OfRecording(recording) => recording == commands.recording(),
            Self::Defined => true,
        }
    }

    /// Returns the contents once the recording was submitted.
    pub(crate) fn submitted(self) -> Self {
        if self == Self::Undefined { self } else { Self::Defined }
    }
}

/// An image and a sampler, for [`Commands::bind_sampled`].
#[derive(Debug, Clone, Copy)]
pub struct SampledTexture<'a> {
    device: OwnerId,
    pub(crate) descriptor: vk::DescriptorImageInfo,
    pub(crate) contents: Contents,
    // The image lives as long as this, and then until its frames are over.
    owner: PhantomData<&'a vk::Image>,
}

impl OfDevice for SampledTexture<'_> {
    const KIND: &'static str = "a texture (`SampledTexture`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl SampledTexture<'_> {
    /// Returns a view of an image that is in the layout of [`Access::FragmentSample`] when it is
    /// sampled.
    pub(crate) fn new(
        device: OwnerId,
        view: vk::ImageView,
        sampler: vk::Sampler,
        contents: Contents,
    ) -> Self {
        let descriptor = vk::DescriptorImageInfo {
            sampler,
            image_view: view,
            image_layout: Access::FragmentSample.layout(),
        };
        Self { device, descriptor, contents, owner: PhantomData }
    }
}
