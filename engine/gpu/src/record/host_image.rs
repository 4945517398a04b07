//! Images of a host, and their states when the engine gets them and returns them.

use ash::vk;

use crate::core::error::Error;
use crate::record::access::{Access, MemoryBarrier};

/// The state of an image between two users: its layout, and the accesses before or after.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImageState {
    /// The layout. On entry, [`vk::ImageLayout::UNDEFINED`] discards the contents.
    pub layout: vk::ImageLayout,
    /// The stages of the other user that access the image.
    pub stages: vk::PipelineStageFlags2,
    /// The accesses of these stages.
    pub access: vk::AccessFlags2,
}

impl ImageState {
    /// Returns the state of an image whose contents are not needed, with no accesses that the
    /// commands must wait for.
    pub fn fresh() -> Self {
        Self::default()
    }

    pub(crate) fn during(access: Access) -> Self {
        let MemoryBarrier { to_stages, to_access, .. } = MemoryBarrier::between(&[], &[access]);
        Self { layout: access.layout(), stages: to_stages, access: to_access }
    }

    /// Returns the state during renderings that write depth.
    pub fn depth_attachment() -> Self {
        Self::during(Access::Depth)
    }

    /// Returns the state during renderings that write colour.
    pub fn colour_attachment() -> Self {
        Self::during(Access::Colour)
    }
}

/// An image of a host to draw to: its first level with one or several layers, and a view of them.
#[derive(Debug, Clone, Copy)]
pub struct HostImage {
    /// The image.
    pub image: vk::Image,
    /// A view of the image with all aspects of the format: a 2D view, or a 2D array view with one
    /// layer per view if several views are drawn at once.
    pub view: vk::ImageView,
    /// The format of the view.
    pub format: vk::Format,
    /// The usage that the image was created with: at least
    /// [`vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT`] for a depth, and
    /// [`vk::ImageUsageFlags::COLOR_ATTACHMENT`] for a colour. Box tests by compute shaders need
    /// [`vk::ImageUsageFlags::TRANSFER_SRC`] on the depth image.
    pub usage: vk::ImageUsageFlags,
    /// The state before the engine's first command.
    pub entry: ImageState,
    /// The state after the engine's last command; `None` leaves the image as an attachment.
    pub exit: Option<ImageState>,
}

/// The images of a host to draw a view to.
#[derive(Debug, Clone, Copy)]
pub struct HostImages<'a> {
    /// The depth image.
    pub depth: HostImage,
    /// The colour images, if the engine begins the renderings and there are any.
    pub colours: &'a [HostImage],
    /// The number of samples per pixel of all images.
    pub samples: vk::SampleCountFlags,
    /// The depth value at the near plane.
    pub near_depth: crate::record::attachments::NearDepth,
    /// The number of views that are drawn at once, each to the layer of its index; 1 without
    /// multiview.
    pub views: u32,
    /// The size of the images in pixels.
    pub size: [u32; 2],
}

/// Refuses images that were not created as attachments.
pub(super) fn check_usages(images: &HostImages<'_>) -> Result<(), Error> {
    use vk::ImageUsageFlags as U;
    let refuse = |what: String, usage, needed| Err(Error::TargetUsage { what, usage, needed });
    let usage = images.depth.usage;
    if !usage.contains(U::DEPTH_STENCIL_ATTACHMENT) {
        let needed = "VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT";
        return refuse("depth image".to_owned(), usage, needed);
    }
    let mut usages = images.colours.iter().map(|colour| colour.usage).enumerate();
    match usages.find(|(_, usage)| !usage.contains(U::COLOR_ATTACHMENT)) {
        None => Ok(()),
        Some((number, usage)) => {
            let needed = "VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT";
            refuse(format!("colour image {number}"), usage, needed)
        }
    }
}

impl<'a> HostImages<'a> {
    /// Describes images of one sample per pixel for one view whose depth is reversed.
    pub fn new(depth: HostImage, colours: &'a [HostImage], size: [u32; 2]) -> Self {
        let near_depth = crate::record::attachments::NearDepth::One;
        Self { depth, colours, samples: vk::SampleCountFlags::TYPE_1, near_depth, views: 1, size }
    }
}
