//! The last step of a picture: from the target to an image of a window.

use ash::vk;

use super::Target;
use crate::access::{Access, LayoutChange};
use crate::commands::Commands;

impl Target {
    /// Copies the picture to an image of a window, byte for byte where their sizes are equal. Leaves
    /// the target as it was, since these commands may never be submitted.
    pub(crate) fn copy_to_window(
        &self,
        commands: &Commands,
        window: vk::Image,
        window_size: [u32; 2],
    ) {
        let colour = vk::ImageAspectFlags::COLOR;
        let is_drawn = self.colour_access != Access::CopyRead;
        let fresh =
            LayoutChange::forgetting(window, colour, &[Access::CopyWrite], Access::CopyWrite);
        let (drawn, read) = (self.colour_access, Access::CopyRead);
        match is_drawn {
            true => commands.change_layouts([self.colour.change(colour, drawn, read), fresh]),
            false => commands.change_layouts([fresh]),
        }
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: colour,
            layer_count: 1,
            ..Default::default()
        };
        let corners = |size: [u32; 2]| {
            let [x, y] = size.map(|side| side as i32);
            [vk::Offset3D::default(), vk::Offset3D { x, y, z: 1 }]
        };
        let regions = [vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets(corners(self.size))
            .dst_subresource(layers)
            .dst_offsets(corners(window_size))];
        let filter = match self.size == window_size {
            true => vk::Filter::NEAREST,
            false => vk::Filter::LINEAR,
        };
        // SAFETY: both images are in the layouts named, and as large as the regions; the formats
        // were checked to be blitted when the swapchain was made.
        unsafe {
            commands.device().raw().cmd_blit_image(
                commands.raw(),
                self.colour.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                window,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &regions,
                filter,
            );
        }
        let shown = LayoutChange::new(window, colour, Access::CopyWrite, Access::Present);
        match is_drawn {
            true => commands.change_layouts([self.colour.change(colour, read, drawn), shown]),
            false => commands.change_layouts([shown]),
        }
    }
}
