//! The finished image of a frame that is still being recorded, for a host that draws over it.

use ash::vk;

use crate::core::device::Device;
use crate::core::ownership::OwnerId;
use crate::record::access::Access;
use crate::record::attachments::COLOURS_MAX;
use crate::record::host_image::ImageState;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};

/// The finished colour image of a frame, one sample per pixel, for commands of a host's own behind
/// all others that draw.
///
/// The commands find it in [`OverlayImage::state`], behind a barrier: they may begin a rendering
/// that loads it at once. They leave it in the same layout, and what they wrote last they wrote in
/// such a rendering, or a barrier of theirs orders it before [`OverlayImage::state`].
#[derive(Debug, Clone, Copy)]
pub struct OverlayImage {
    /// The image: eight bits per channel, a colour attachment, which commands may also sample and
    /// copy from.
    pub image: vk::Image,
    /// A view of it that encodes the colours.
    pub view: vk::ImageView,
    /// The format of the view. The memory of the image has its twin without encoding,
    /// [`vk::Format::R8G8B8A8_UNORM`], of which a host can make a view too.
    pub format: vk::Format,
    /// Its size in pixels.
    pub size: [u32; 2],
    /// The layout, stages and accesses before the host's commands, and after them.
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

    /// Returns the target of a rendering over what is there, without depth, for
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
