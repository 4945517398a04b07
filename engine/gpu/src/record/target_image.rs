//! An image of a target, created by the engine or by a host, and its last access in the recording.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::image::{DepthView, Image, ImageFormats};
use crate::record::access::{Access, LayoutChange, MemoryBarrier};
use crate::record::attachments::has_stencil;
use crate::record::host_image::{HostImage, ImageState};
use crate::record::sample_count::SampleCount;

/// An image to draw to.
pub(super) struct TargetImage {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    /// The view with which shaders read depths; if there is none, they use [`TargetImage::view`].
    depth_view: Option<DepthView>,
    aspect: vk::ImageAspectFlags,
    /// The number of layers to draw to, from the first on.
    layers: u32,
    origin: Origin,
    /// The last access in the recording that uses the image.
    pub(super) access: Access,
}

/// The owner of an image.
enum Origin {
    /// The target, which also destroys the image.
    Ours { _image: Image },
    /// A host, with the states before and after the engine uses the image.
    Host { entry: ImageState, exit: Option<ImageState> },
}

impl TargetImage {
    pub(super) fn new(
        device: &Device,
        name: &str,
        size: [u32; 2],
        layers: u32,
        formats: ImageFormats,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let image = Image::layered(device, name, size, layers, formats, usage, aspect)?;
        Ok(Self::of_ours(image, layers, aspect))
    }

    /// Creates an image of one layer with a number of samples per pixel.
    pub(super) fn multisampled(
        device: &Device,
        name: &str,
        size: [u32; 2],
        samples: SampleCount,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> Result<Self, Error> {
        let size_samples = samples.flags();
        let image = Image::multisampled(device, name, size, size_samples, format, usage, aspect)?;
        Ok(Self::of_ours(image, 1, aspect))
    }

    fn of_ours(image: Image, layers: u32, aspect: vk::ImageAspectFlags) -> Self {
        let raw = image.raw;
        let view = image.view;
        let access = Access::Nothing;
        let origin = Origin::Ours { _image: image };
        Self { raw, view, depth_view: None, aspect, layers, origin, access }
    }

    /// Adds a view of the depths only, because a view that shaders read must have a single aspect.
    pub(super) fn with_depth_view(
        self,
        device: &Device,
        format: vk::Format,
    ) -> Result<Self, Error> {
        Ok(Self { depth_view: Some(DepthView::new(device, self.raw, format)?), ..self })
    }

    /// Returns the view with which shaders read depths.
    pub(super) fn depth_view(&self) -> vk::ImageView {
        self.depth_view.as_ref().map_or(self.view, |depths| depths.raw)
    }

    /// Creates an attachment for `attachment` from `layers` layers of a host's image.
    pub(super) fn of_host(image: &HostImage, layers: u32, attachment: Access) -> Self {
        let aspect = match attachment {
            Access::Depth if has_stencil(image.format) => {
                vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL
            }
            Access::Depth => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let origin = Origin::Host { entry: image.entry, exit: image.exit };
        let raw = image.image;
        let view = image.view;
        let access = Access::Nothing;
        Self { raw, view, depth_view: None, aspect, layers, origin, access }
    }

    /// Returns the change to `to` for the first command of a recording that uses the image. An
    /// image of the engine loses its contents; the change is ordered after all accesses in `uses`.
    pub(super) fn first_change(&mut self, uses: &[Access], to: Access) -> LayoutChange {
        self.access = to;
        let change = match &self.origin {
            Origin::Ours { .. } => LayoutChange::forgetting(self.raw, self.aspect, uses, to),
            Origin::Host { entry, .. } => {
                let after = MemoryBarrier::between(&[], &[to]);
                let barrier =
                    MemoryBarrier { from_stages: entry.stages, from_access: entry.access, ..after };
                LayoutChange {
                    barrier,
                    old_layout: entry.layout,
                    ..LayoutChange::new(self.raw, self.aspect, Access::Nothing, to)
                }
            }
        };
        change.of_layers(self.layers)
    }

    /// Returns the change from the last access to `to`.
    pub(super) fn change(&mut self, to: Access) -> LayoutChange {
        let from = std::mem::replace(&mut self.access, to);
        LayoutChange::new(self.raw, self.aspect, from, to).of_layers(self.layers)
    }

    /// Returns the change to the state that the host expects, if it named one.
    pub(super) fn last_change(&mut self) -> Option<LayoutChange> {
        let Origin::Host { exit: Some(exit), .. } = self.origin else { return None };
        let change = self.change(Access::Nothing);
        let barrier =
            MemoryBarrier { to_stages: exit.stages, to_access: exit.access, ..change.barrier };
        Some(LayoutChange { barrier, new_layout: exit.layout, ..change })
    }
}
