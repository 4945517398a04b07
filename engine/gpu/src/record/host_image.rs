//! Images that a host owns, and the states in which we get them and give them back.

use ash::vk;

use crate::record::access::{Access, MemoryBarrier};

/// The state of an image between two users: the layout that it is in, and the accesses that come
/// before or after.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImageState {
    /// The layout. [`vk::ImageLayout::UNDEFINED`] on entry drops the contents.
    pub layout: vk::ImageLayout,
    /// The stages of the other user that access the image.
    pub stages: vk::PipelineStageFlags2,
    /// The accesses of these stages.
    pub access: vk::AccessFlags2,
}

impl ImageState {
    /// Returns the state of an image with contents that nobody wants, after accesses that are over
    /// before the commands begin.
    pub fn fresh() -> Self {
        Self::default()
    }

    /// Returns the state during an access.
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

/// An image of a host that is drawn to: its first level, its first layer or several, and a view of
/// that.
#[derive(Debug, Clone, Copy)]
pub struct HostImage {
    /// The image.
    pub image: vk::Image,
    /// A view of it with all aspects of the format: 2D, or where several views are drawn at once a
    /// 2D array of as many layers.
    pub view: vk::ImageView,
    /// The format of the view.
    pub format: vk::Format,
    /// The usage that it was created with. The tests of boxes by compute shaders need
    /// [`vk::ImageUsageFlags::TRANSFER_SRC`] of a depth image.
    pub usage: vk::ImageUsageFlags,
    /// The state before our first command.
    pub entry: ImageState,
    /// The state after our last one; `None` leaves it as an attachment.
    pub exit: Option<ImageState>,
}

/// The images of a host that a view is drawn to.
#[derive(Debug, Clone, Copy)]
pub struct HostImages<'a> {
    /// The depth.
    pub depth: HostImage,
    /// The colours, if renderings are opened by us and have any.
    pub colours: &'a [HostImage],
    /// Samples per pixel, of all of them.
    pub samples: vk::SampleCountFlags,
    /// The depth of the near plane.
    pub near_depth: crate::record::attachments::NearDepth,
    /// The views that are drawn at once, each to the layer of its number; 1 without multiview.
    pub views: u32,
    /// Their size in pixels.
    pub size: [u32; 2],
}
