//! The finished image of a frame that is still being recorded, for a host that draws over it.

use ash::vk;

use crate::core::device::Device;
use crate::core::ownership::OwnerId;
use crate::record::access::Access;
use crate::record::attachments::COLOURS_MAX;
use crate::record::host_image::ImageState;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};

/// The finished colour image of a frame, with one sample per pixel, for a host's own commands after
/// all other draws.
///
/// Before these commands, the image is in [`OverlayImage::state`] after a barrier, so they may
/// begin a rendering that loads it at once. They must leave it in the same layout. Their last
/// writes must be in such a rendering, or a barrier must order them before [`OverlayImage::state`].
#[derive(Debug, Clone, Copy)]
pub struct OverlayImage {
    /// The image with eight bits per channel: a colour attachment that commands may also sample and
    /// copy from.
    pub image: vk::Image,
    /// A view of the image that encodes the colours.
    pub view: vk::ImageView,
    /// The format of the view. The memory of the image has the format without encoding,
    /// [`vk::Format::R8G8B8A8_UNORM`]; a host can also create a view with it.
    pub format: vk::Format,
    /// The size of the image in pixels.
    pub size: [u32; 2],
    /// The layout, stages and accesses before and after the host's commands.
    pub state: ImageState,
    device: OwnerId,
}

impl OverlayImage {
    pub(super) fn new(
        device: &Device,
        image: vk::Image,
        view: vk::ImageView,
        format: vk::Format,
        size: [u32; 2],
    ) -> Self {
        let device = device.id();
        let state = ImageState::during(Access::Colour);
        Self { image, view, format, size, state, device }
    }

    /// Returns the target of a rendering over the contents of the image, without depth, for
    /// [`Commands::rendering`](crate::Commands::rendering).
    pub fn render_target(&self) -> RenderTarget {
        let mut colours = [vk::ImageView::null(); COLOURS_MAX];
        if let Some(first) = colours.first_mut() {
            *first = self.view;
        }
        RenderTarget {
            device: self.device,
            colours,
            colour_count: 1,
            depth: vk::ImageView::null(),
            average: vk::ImageView::null(),
            has_stencil: false,
            view_mask: 0,
            origin: [0, 0],
            size: self.size,
            colour_load: Load::Keep,
            depth_load: Load::Forget,
            colour_store: AttachmentStore::Keep,
            depth_store: AttachmentStore::Forget,
        }
    }
}
