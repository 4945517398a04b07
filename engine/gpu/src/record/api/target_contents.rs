//! Recording of operations on the images of a target after its draws: averages and copies.

use ash::vk;

use crate::core::error::Error;
use crate::memory::buffer::BufferSlice;
use crate::memory::readback::Readback;
use crate::record::access::{Access, MemoryBarrier};
use crate::record::attachments::{Attachments, DEPTH_AND_STENCIL_FORMAT, DEPTH_FORMAT};
use crate::record::commands::{Commands, Failure};
use crate::record::overlay_image::OverlayImage;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};
use crate::record::target::Target;

impl Target {
    /// Averages the samples of each pixel into the finished image. The average is taken of linear
    /// light, except on drivers that average the encoded values (SwiftShader). Must be called
    /// outside of rendering, after draws of the same frame. To continue drawing, prepare the target
    /// again. Does nothing with one sample per pixel.
    pub fn resolve(&mut self, commands: &Commands) {
        if self.recording != Some(commands.recording()) || commands.check_owner(self).is_err() {
            return;
        }
        let Some(multisampling) = &mut self.multisampling else { return };
        let average = &mut multisampling.average;
        let uses = [Access::Colour, Access::CopyRead];
        let fresh = average.first_change(&uses, Access::Colour);
        let average = average.view;
        let drawn = self.colours.iter_mut().map(|image| image.change(Access::Colour));
        commands.change_layouts(std::iter::once(fresh).chain(drawn));
        let kept = self.render_target(None);
        let target = RenderTarget {
            depth: vk::ImageView::null(),
            depth_load: Load::Forget,
            average,
            ..kept
        };
        let unchanged = AttachmentStore::Unchanged;
        commands.rendering(RenderTarget { colour_store: unchanged, ..target }, |_| ());
    }

    /// Makes a rendering of the visible image average the samples of each pixel into the finished
    /// image when it ends, so that the samples need not be stored. Must be called right before this
    /// rendering begins, which must be the last one of the frame that draws colours. Changes
    /// nothing with one sample per pixel.
    #[must_use]
    pub fn resolved_by(&mut self, commands: &Commands, rendering: RenderTarget) -> RenderTarget {
        if self.recording != Some(commands.recording()) || commands.check_owner(self).is_err() {
            return rendering;
        }
        let Some(multisampling) = &mut self.multisampling else { return rendering };
        multisampling.is_resolved = true;
        let average = &mut multisampling.average;
        let uses = [Access::Colour, Access::CopyRead];
        commands.change_layouts([average.first_change(&uses, Access::Colour)]);
        let colour_store = AttachmentStore::Forget;
        RenderTarget { average: average.view, colour_store, ..rendering }
    }

    /// Prepares the finished image for commands of a host that draws over it. Must be called
    /// outside of rendering, after the last draws and after [`Target::resolve`].
    ///
    /// # Errors
    /// [`Error::NoImage`] if these commands drew nothing to the target, or if it has no colours;
    /// [`Error::Foreign`] for commands of another device.
    pub fn begin_overlay(&mut self, commands: &Commands) -> Result<OverlayImage, Error> {
        commands.check_owner(self)?;
        let format = self.attachments.colours.as_slice().first().copied();
        let colour = match &mut self.multisampling {
            Some(multisampling) => Some(&mut multisampling.average),
            None => self.colours.first_mut(),
        };
        let is_drawn = self.recording == Some(commands.recording());
        let (Some(colour), Some(format), true) = (colour, format, is_drawn) else {
            return Err(Error::NoImage);
        };
        commands.change_layouts([colour.change(Access::Colour)]);
        Ok(OverlayImage::new(&self.device, colour.raw, colour.view, format, self.size))
    }

    /// Copies the depth of an area of `size` pixels at `origin` (from the upper left) to `to`, a
    /// storage buffer: 32-bit floats, rows from the top without gaps, with [`Access::CopyWrite`].
    /// If a pixel has several samples, copies the farthest. Does nothing if the slice is too small
    /// or the area extends beyond the image. To continue drawing, prepare the target again.
    pub fn copy_depth_to(
        &mut self,
        commands: &Commands,
        origin: [u32; 2],
        size: [u32; 2],
        to: BufferSlice,
    ) {
        let [x, y] = origin;
        let [width, height] = size;
        let fits = |side: usize| {
            u64::from(origin[side]) + u64::from(size[side]) <= u64::from(self.size[side])
        };
        let bytes = u64::from(width) * u64::from(height) * 4;
        let has_room = bytes > 0 && to.size_bytes >= bytes && fits(0) && fits(1);
        if !has_room || !self.can_copy_depth {
            return;
        }
        if commands.check_owner(self).is_err() || commands.check_owner(&to).is_err() {
            return;
        }
        if let Some(multisampling) = &self.multisampling {
            commands.change_layouts([self.depth.change(Access::ComputeSample)]);
            multisampling.copy_farthest(commands, self.depth.depth_view(), origin, size, to);
            return;
        }
        commands.change_layouts([self.depth.change(Access::CopyRead)]);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(to.offset_bytes)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::DEPTH,
                layer_count: 1,
                ..Default::default()
            })
            .image_offset(vk::Offset3D { x: x as i32, y: y as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: the slice can hold the area, which lies within the image in the given layout.
        unsafe {
            commands.device().raw().cmd_copy_image_to_buffer(
                commands.raw(),
                self.depth.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                to.raw,
                &[region],
            );
        }
    }

    /// Copies the colour image to `readback`, its layers one below the other. The recording fails
    /// unless the sizes agree. Must be the last use of the target in a frame.
    pub fn copy_to(&mut self, commands: &Commands, readback: &Readback) {
        if commands.check_owner(self).is_err() {
            return;
        }
        let [width, height] = self.size;
        let layers = self.attachments.views;
        if readback.size() != [width, height.saturating_mul(layers)] {
            commands.fail(Failure::Wrong("an image is copied to a `Readback` of another size"));
            return;
        }
        let ours = |depth: &vk::Format| {
            let ours = Attachments { views: layers, depth: *depth, ..Attachments::default() };
            self.attachments == ours
        };
        let is_ours = [DEPTH_FORMAT, DEPTH_AND_STENCIL_FORMAT].iter().any(ours);
        let colour = match &mut self.multisampling {
            Some(multisampling) => Some(&mut multisampling.average),
            None => self.colours.first_mut().filter(|_| is_ours),
        };
        let Some(colour) = colour else {
            commands.fail(Failure::Wrong("the image of a host is copied to a `Readback`"));
            return;
        };
        let Some(to) = readback.begin_copy(commands) else { return };
        commands.change_layouts([colour.change(Access::CopyRead)]);
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: layers,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: the buffer has exactly the size of this image, which is in the given layout.
        unsafe {
            commands.device().raw().cmd_copy_image_to_buffer(
                commands.raw(),
                colour.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                to.raw,
                &[region],
            );
        }
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    }
}
