//! A depth image with a stencil. It holds either a copy of depths that are drawn elsewhere, for
//! counting shadow volumes, or no depths, for marks next to the colours of a target.

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::{OfDevice, of_device};
use crate::memory::buffer::BufferSlice;
use crate::memory::image::{Image, ImageFormats};
use crate::record::access::{Access, LayoutChange};
use crate::record::attachments::{Attachments, COLOURS_MAX, ColourFormats};
use crate::record::commands::Commands;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};
use crate::record::target::{Target, check_size};

/// The format: depth bit-identical to a [`Target`](crate::Target), and eight bits of stencil.
const FORMAT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

/// Depths and a stencil, for pipelines with a [`StencilMode`](crate::StencilMode).
pub struct StencilTarget {
    device: Device,
    image: Image,
    size: [u32; 2],
}

of_device!(StencilTarget: "depths with a stencil (`StencilTarget`)");

impl StencilTarget {
    /// Creates a target of `size` pixels.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side that is 0 or beyond the device's limits;
    /// [`Error::Unsupported`] on a device without [`OptionalFeature::DepthClamp`], which volumes
    /// need; [`Error::TargetFormat`] if the device cannot draw to 32-bit float depth with a
    /// stencil; no memory.
    pub fn new(device: &Device, size: [u32; 2], name: &str) -> Result<Self, Error> {
        check_size(device, size)?;
        device.require(OptionalFeature::DepthClamp, "counting volumes")?;
        Self::attachments().check(device)?;
        let usage =
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::new(device, name, size, ImageFormats::same(FORMAT), usage, both())?;
        Ok(Self { device: device.clone(), image, size })
    }

    /// Creates a stencil with the size and the samples of `target`, for renderings of its
    /// [colours](StencilTarget::with_colours).
    ///
    /// # Errors
    /// [`Error::TargetFormat`] or [`Error::Samples`] if the device cannot draw to 32-bit float
    /// depth with a stencil; no memory.
    pub fn beside(device: &Device, target: &Target, name: &str) -> Result<Self, Error> {
        let attachments = Self::attachments_beside(&target.attachments());
        attachments.check(device)?;
        let size = target.size();
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;

        let image =
            Image::multisampled(device, name, size, attachments.samples, FORMAT, usage, both())?;
        Ok(Self { device: device.clone(), image, size })
    }

    /// Returns the attachments of pipelines that draw to the colours of a target with this stencil.
    pub fn attachments_beside(target: &Attachments) -> Attachments {
        Attachments { depth: FORMAT, ..*target }
    }

    /// Discards the contents, after any earlier rendering, so that the stencil can be drawn to.
    /// Clear it first.
    pub fn forget(&self, commands: &Commands) {
        if commands.check_owner(self).is_ok() {
            let uses = [Access::Depth];
            let fresh = LayoutChange::forgetting(self.image.raw, both(), &uses, Access::Depth);
            commands.change_layouts([fresh]);
        }
    }

    /// Returns the rendering to the colours of `target`, with this stencil in place of the target's
    /// depth. The stencil has undefined contents before and after it. `target` must be the target
    /// that the stencil was created for.
    #[must_use]
    pub fn with_colours(&self, target: RenderTarget) -> RenderTarget {
        RenderTarget {
            depth: self.image.view,
            has_stencil: true,
            depth_load: Load::Forget,
            depth_store: AttachmentStore::Forget,
            ..target
        }
    }

    /// Returns the attachments of pipelines that draw to a stencil target.
    pub fn attachments() -> Attachments {
        Attachments { colours: ColourFormats::new(&[]), depth: FORMAT, ..Attachments::default() }
    }

    /// Returns the size in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Copies the depth of an area of `size` pixels to the upper left corner, from 32-bit floats in
    /// rows from the top without gaps, with [`Access::CopyRead`]. After that the target can be
    /// drawn to. All other contents are undefined, so clear the stencil. Copies nothing if the
    /// slice is too small or the area is larger than the image.
    pub fn load_depth(&mut self, commands: &Commands, from: BufferSlice, size: [u32; 2]) {
        if commands.check_owner(self).is_err() || commands.check_owner(&from).is_err() {
            return;
        }
        let uses = [Access::CopyWrite, Access::Depth];
        let fresh = LayoutChange::forgetting(self.image.raw, both(), &uses, Access::CopyWrite);
        commands.change_layouts([fresh]);
        let [width, height] = size;
        let bytes = u64::from(width) * u64::from(height) * 4;
        let fits = width <= self.size[0] && height <= self.size[1];
        if bytes > 0 && from.size_bytes >= bytes && fits {
            let region = vk::BufferImageCopy::default()
                .buffer_offset(from.offset_bytes)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::DEPTH,
                    layer_count: 1,
                    ..Default::default()
                })
                .image_extent(vk::Extent3D { width, height, depth: 1 });
            // SAFETY: the slice contains the area, which lies within the image in the given layout.
            unsafe {
                commands.device().raw().cmd_copy_buffer_to_image(
                    commands.raw(),
                    from.raw,
                    self.image.raw,
                    Access::CopyWrite.layout(),
                    &[region],
                );
            }
        }
        commands.change_layouts([self.image.change(both(), Access::CopyWrite, Access::Depth)]);
    }

    /// Orders a rendering to the target after an earlier one.
    pub fn prepare(&self, commands: &Commands) {
        if commands.check_owner(self).is_ok() {
            commands.change_layouts([self.image.change(both(), Access::Depth, Access::Depth)]);
        }
    }

    /// Returns the upper left `size` pixels as a render target that keeps its contents.
    pub fn render_target(&self, size: [u32; 2]) -> RenderTarget {
        RenderTarget {
            device: self.device_id(),
            colours: [vk::ImageView::null(); COLOURS_MAX],
            colour_count: 0,
            depth: self.image.view,
            average: vk::ImageView::null(),
            has_stencil: true,
            view_mask: 0,
            origin: [0, 0],
            size: self.size,
            colour_load: Load::Forget,
            depth_load: Load::Keep,
            colour_store: AttachmentStore::Keep,
            depth_store: AttachmentStore::Keep,
        }
        .within([0, 0], size)
    }
}

fn both() -> vk::ImageAspectFlags {
    vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
}
