//! A host that draws over finished images by plain Vulkan commands.

use ash::vk;
use gpu::{Commands, Device, OverlayImage};
use render::{Error, HostOverlay};

/// A rectangle of one colour over images, drawn by `vkCmdClearAttachments` in its own rendering.
pub struct ClearedRectangle {
    /// The device of the images.
    pub device: Device,
    /// Its upper left corner, in pixels.
    pub origin: [u32; 2],
    /// Its size in pixels, within the images.
    pub size: [u32; 2],
    /// Its colour: sRGB-decoded red, green and blue, and alpha.
    pub colour: [f32; 4],
}

impl HostOverlay for ClearedRectangle {
    fn record(&self, commands: &Commands, image: &OverlayImage) -> Result<(), Error> {
        let [width, height] = image.size;
        let whole = vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
        let colours = [vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(image.state.layout)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let rendering = vk::RenderingInfo::default()
            .render_area(whole)
            .layer_count(1)
            .color_attachments(&colours);
        let clear = vk::ClearAttachment {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            color_attachment: 0,
            clear_value: vk::ClearValue { color: vk::ClearColorValue { float32: self.colour } },
        };
        let offset = vk::Offset2D { x: self.origin[0] as i32, y: self.origin[1] as i32 };
        let extent = vk::Extent2D { width: self.size[0], height: self.size[1] };
        let rect = vk::ClearRect {
            rect: vk::Rect2D { offset, extent },
            base_array_layer: 0,
            layer_count: 1,
        };
        let raw = self.device.raw();
        // SAFETY: outside of a rendering; the image is in the state named, and the rectangle lies
        // within it.
        unsafe {
            raw.cmd_begin_rendering(commands.raw(), &rendering);
            raw.cmd_clear_attachments(commands.raw(), &[clear], &[rect]);
            raw.cmd_end_rendering(commands.raw());
        }
        Ok(())
    }
}
