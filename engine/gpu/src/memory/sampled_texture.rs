//! Textures as draws sample them, for all kinds of owners.

use std::marker::PhantomData;

use ash::vk;

use crate::core::deletion::RecordingId;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::record::access::Access;
use crate::record::commands::Commands;

/// The contents of an image after its newest recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Contents {
    /// The contents are undefined, as after creation.
    Undefined,
    /// The recording defined the contents, but may never be submitted.
    OfRecording(RecordingId),
    /// The contents are defined: the recording was submitted.
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

    /// Returns the contents after the recording was submitted.
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
    // The image lives as long as this value, and after that until its frames are over.
    owner: PhantomData<&'a vk::Image>,
}

impl OfDevice for SampledTexture<'_> {
    const KIND: &'static str = "a texture (`SampledTexture`)";

    fn device_id(&self) -> OwnerId {
        self.device
    }
}

impl SampledTexture<'_> {
    /// Returns a texture for the view of an image, which must be in the layout of
    /// [`Access::FragmentSample`] when it is sampled.
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
