//! The depth texture that boxes are tested against.

use std::sync::Arc;

use cull::{ClipY, CullView, DepthConvention, ViewProjection};
use glam::Mat4;
use gpu::{Attachments, HostImage, HostImages, ImageState, NearDepth, Target, vk};
use wgpu::hal::api::Vulkan;

use crate::device::{DeviceParts, WgpuDevice};
use crate::error::Error;

/// The depth texture of a view. Make another one when the size changes; scene and history remain.
pub struct WgpuTarget {
    pub(crate) target: Target,
    pub(crate) depth: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
    convention: DepthConvention,
    sub_pixel_bits: u32,
    parts: Arc<DeviceParts>,
}

impl WgpuTarget {
    /// Describes the texture that the render passes of a view use as depth. With the format
    /// `Depth32Float`, one sample and the usage `COPY_SRC` boxes can be tested by a compute shader
    /// too.
    ///
    /// # Errors
    /// [`Error::NotDepth`], [`Error::NoDepth`]; [`Error::Gpu`] for a size beyond the limits.
    pub fn new(
        device: &WgpuDevice,
        depth: &wgpu::Texture,
        convention: DepthConvention,
    ) -> Result<Self, Error> {
        let is_flat = depth.dimension() == wgpu::TextureDimension::D2
            && depth.depth_or_array_layers() == 1
            && depth.mip_level_count() == 1;
        let is_depth = depth.format().has_depth_aspect()
            && depth.usage().contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        if !is_flat || !is_depth {
            return Err(Error::NotDepth {
                dimension: depth.dimension(),
                format: depth.format(),
                usage: depth.usage(),
            });
        }
        let parts = &device.shared;
        let view = depth.create_view(&wgpu::TextureViewDescriptor::default());
        let image = host_image(parts, depth, &view)?;
        let images = HostImages {
            samples: vk::SampleCountFlags::from_raw(depth.sample_count()),
            near_depth: match convention {
                DepthConvention::Reversed => NearDepth::One,
                DepthConvention::Standard => NearDepth::Zero,
            },
            ..HostImages::new(image, &[], [depth.width(), depth.height()])
        };
        // SAFETY: each frame keeps texture and view alive until it is over, lets wgpu bring the
        // texture to the state of a depth attachment, and lies between commands of wgpu in one
        // submit, so that nothing uses it at once (`WgpuFrame::submit`).
        let target = unsafe { Target::of_host(&parts.gpu, &images) }?;
        Ok(Self {
            target,
            depth: depth.clone(),
            view,
            convention,
            sub_pixel_bits: parts.gpu.adapter().limits.sub_pixel_precision_bits,
            parts: Arc::clone(parts),
        })
    }

    /// Returns the view of a camera whose shaders multiply positions with `matrix`, which covers
    /// the whole texture. The y axis of wgpu's clip space points up. The vertex shader moves
    /// vertices to the grid of [`CullView::snap_steps`].
    ///
    /// # Errors
    /// [`Error::View`] for a matrix that is not a projection with the depths of this target.
    pub fn view(&self, matrix: Mat4) -> Result<CullView, Error> {
        let projection = ViewProjection { matrix, depth: self.convention, y: ClipY::Up };
        Ok(CullView::from_matrix(&projection, self.target.size(), self.sub_pixel_bits)?)
    }

    /// Returns the formats for which the passes of a scene are compiled.
    pub(crate) fn attachments(&self) -> Attachments {
        self.target.attachments()
    }

    /// Returns true if the target was made for this device.
    pub(crate) fn is_of(&self, parts: &Arc<DeviceParts>) -> bool {
        Arc::ptr_eq(&self.parts, parts)
    }
}

/// Describes the depth in the state in which render passes of wgpu use it.
fn host_image(
    parts: &DeviceParts,
    depth: &wgpu::Texture,
    view: &wgpu::TextureView,
) -> Result<HostImage, Error> {
    // SAFETY: the handle is only asked for formats.
    let adapter = unsafe { parts.adapter.as_hal::<Vulkan>() }.ok_or(Error::NotVulkan)?;
    let format = adapter.texture_format_as_raw(depth.format());
    // SAFETY: the handles are not destroyed; frames keep texture and view.
    let image = unsafe { depth.as_hal::<Vulkan>().ok_or(Error::NoDepth)?.raw_handle() };
    // SAFETY: as above.
    let view = unsafe { view.as_hal::<Vulkan>().ok_or(Error::NoDepth)?.raw_handle() };
    let mut usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
    if depth.usage().contains(wgpu::TextureUsages::COPY_SRC) {
        usage |= vk::ImageUsageFlags::TRANSFER_SRC;
    }
    let drawn = ImageState::depth_attachment();
    Ok(HostImage { image, view, format, usage, entry: drawn, exit: Some(drawn) })
}
