//! An offscreen target: colour and depth to draw to.

use ash::vk;

use crate::core::deletion::Recording;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::of_device;
use crate::memory::buffer::BufferSlice;
use crate::memory::image::Image;
use crate::memory::readback::Readback;
use crate::record::access::{Access, LayoutChange};
use crate::record::commands::{Commands, Failure};
use crate::record::render_target::{Load, RenderTarget};

/// Colour: eight bits per channel, sRGB-encoded by the hardware.
pub(crate) const COLOUR_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
/// The format of the colour's memory: the same bytes without encoding, so that a window gets them
/// unchanged in whichever order of channels it wants them.
pub(crate) const COLOUR_BYTES: vk::Format = vk::Format::R8G8B8A8_UNORM;
/// Depth: 32-bit float, reversed, so that precision is even over all distances.
pub(crate) const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// A colour and a depth image of one size.
pub struct Target {
    device: Device,
    colour: Image,
    depth: Image,
    size: [u32; 2],
    // The recording that uses the images, and what it last used them for. What it recorded may
    // never be submitted, so the next one must not build on it.
    recording: Option<Recording>,
    colour_access: Access,
    depth_access: Access,
    is_submitted: bool,
}

of_device!(Target: "a target (`Target`)");

impl Target {
    /// Creates a target of `size` pixels.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for sizes of 0 or beyond the device's limits; no memory.
    pub fn new(device: &Device, size: [u32; 2], name: &str) -> Result<Self, Error> {
        let limits = &device.adapter().limits;
        let largest = limits
            .max_image_dimension2_d
            .min(limits.max_framebuffer_width)
            .min(limits.max_framebuffer_height)
            .min(limits.max_viewport_dimensions[0])
            .min(limits.max_viewport_dimensions[1]);
        for (side, what) in
            size.into_iter().zip(["the width of the image", "the height of the image"])
        {
            if side == 0 || side > largest {
                return Err(Error::TooLarge {
                    what: what.to_owned(),
                    wanted: side.into(),
                    limit: largest.into(),
                });
            }
        }
        let colour_usage =
            vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let depth_usage =
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let (colour, depth) = (vk::ImageAspectFlags::COLOR, vk::ImageAspectFlags::DEPTH);
        let image = |what, formats, usage, aspect| {
            Image::new(device, &format!("{name} {what}"), size, formats, usage, aspect)
        };
        Ok(Self {
            device: device.clone(),
            colour: image("colour", [COLOUR_BYTES, COLOUR_FORMAT], colour_usage, colour)?,
            depth: image("depth", [DEPTH_FORMAT; 2], depth_usage, depth)?,
            size,
            recording: None,
            colour_access: Access::Nothing,
            depth_access: Access::Nothing,
            is_submitted: false,
        })
    }

    /// Returns its size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the colour image and its last access.
    pub(crate) fn colour(&self) -> (&Image, Access) {
        (&self.colour, self.colour_access)
    }

    /// Prepares both images to be drawn to, after any earlier access. This is needed between two
    /// renderings too: dynamic rendering orders nothing by itself. Their contents last for one
    /// frame: the first rendering of each must clear. Commands of another device fail.
    pub fn prepare(&mut self, commands: &Commands) {
        if commands.admit(self).is_err() {
            return;
        }
        let (colour, depth) = (vk::ImageAspectFlags::COLOR, vk::ImageAspectFlags::DEPTH);
        self.is_submitted = false;
        let is_first = self.recording.replace(commands.recording()) != Some(commands.recording());
        let changes = if is_first {
            let colour_uses = [Access::Colour, Access::CopyRead];
            let depth_uses = [Access::Depth, Access::CopyRead];
            [
                LayoutChange::forgetting(self.colour.raw, colour, &colour_uses, Access::Colour),
                LayoutChange::forgetting(self.depth.raw, depth, &depth_uses, Access::Depth),
            ]
        } else {
            [
                self.colour.change(colour, self.colour_access, Access::Colour),
                self.depth.change(depth, self.depth_access, Access::Depth),
            ]
        };
        commands.change_layouts(changes);
        self.colour_access = Access::Colour;
        self.depth_access = Access::Depth;
    }

    /// Returns the images to draw to, starting from a colour and the far depth, or from their
    /// contents.
    pub fn render_target(&self, clear: Option<[f32; 4]>) -> RenderTarget {
        const FAR: f32 = 0.0; // reversed depth
        RenderTarget {
            device: self.device.id(),
            colour: self.colour.view,
            depth: self.depth.view,
            origin: [0, 0],
            size: self.size,
            colour_load: clear.map_or(Load::Keep, Load::Clear),
            depth_load: clear.map_or(Load::Keep, |_| Load::Clear(FAR)),
        }
    }

    /// Copies the depth of `size` pixels from `origin` on (from the upper left) to `to`: 32-bit
    /// floats, rows from the top without gaps, an [`Access::CopyWrite`]. Copies nothing to a slice
    /// that is too small, and nothing of an area beyond the image. To continue drawing, prepare the
    /// target again.
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
        if bytes == 0 || to.size_bytes < bytes || !fits(0) || !fits(1) {
            return;
        }
        if commands.admit(self).is_err() || commands.admit(&to).is_err() {
            return;
        }
        let aspect = vk::ImageAspectFlags::DEPTH;
        let change = self.depth.change(aspect, self.depth_access, Access::CopyRead);
        commands.change_layouts([change]);
        self.depth_access = Access::CopyRead;
        let region = vk::BufferImageCopy::default()
            .buffer_offset(to.offset_bytes)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: aspect,
                layer_count: 1,
                ..Default::default()
            })
            .image_offset(vk::Offset3D { x: x as i32, y: y as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: the slice holds the area, which lies within the image, in the layout named.
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

    /// Copies the colour image to `readback`; the recording fails unless both have the same size.
    /// The last use of the target in a frame.
    pub fn copy_to(&mut self, commands: &Commands, readback: &Readback) {
        if commands.admit(self).is_err() {
            return;
        }
        if readback.size() != self.size {
            commands.fail(Failure::Wrong("an image is copied to a `Readback` of another size"));
            return;
        }
        let Some(to) = readback.begin_copy(commands) else { return };
        let change =
            self.colour.change(vk::ImageAspectFlags::COLOR, self.colour_access, Access::CopyRead);
        commands.change_layouts([change]);
        self.colour_access = Access::CopyRead;
        let [width, height] = self.size;
        let region = vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                layer_count: 1,
                ..Default::default()
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // SAFETY: the buffer holds exactly this image; it is in the layout named.
        unsafe {
            commands.device().raw().cmd_copy_image_to_buffer(
                commands.raw(),
                self.colour.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                to.raw,
                &[region],
            );
        }
        let to_host = crate::record::access::MemoryBarrier::between(
            &[Access::CopyWrite],
            &[Access::HostRead],
        );
        commands.barrier(to_host);
    }
}

impl Target {
    /// Notes that the frame that drew last was submitted: only then is there an image to show.
    pub fn submitted(&mut self) {
        self.is_submitted = self.recording.is_some();
    }

    /// Returns true if the GPU has, or will have, an image here.
    pub(crate) fn has_frame(&self) -> bool {
        self.is_submitted
    }
}
