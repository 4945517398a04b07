//! Layers of depth images of one size, such as shadow maps. They are drawn tile by tile and also
//! sampled in later frames.

use ash::vk;

use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::ownership::{OfDevice, of_device};
use crate::memory::image::Image;
use crate::memory::sampled_texture::{Contents, SampledTexture};
use crate::record::access::{Access, LayoutChange};
use crate::record::attachments::{Attachments, COLOURS_MAX, ColourFormats, DEPTH_FORMAT};
use crate::record::commands::Commands;
use crate::record::render_target::{AttachmentStore, Load, RenderTarget};

/// Layers of reversed depth: 0 is the farthest. The contents persist over frames and can be sampled
/// between any two calls.
pub struct DepthLayers {
    device: Device,
    image: Image,
    /// A view of each layer for drawing.
    views: Vec<vk::ImageView>,
    /// The sampler that compares, and averages the results of four texels if the device supports
    /// it.
    comparing: vk::Sampler,
    /// The sampler that reads single texels.
    reading: vk::Sampler,
    side: u32,
    contents: Contents,
}

of_device!(DepthLayers: "layers of depth (`DepthLayers`)");

/// A square of texels in a layer, for [`DepthLayers::copy_from`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthTile {
    /// The layer.
    pub layer: u32,
    /// The upper left corner in texels.
    pub origin: [u32; 2],
    /// The side in texels.
    pub side: u32,
}

impl DepthLayers {
    /// Creates layers of `side` by `side` texels.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for a side or a number of layers that is 0 or beyond the device's
    /// limits; no memory.
    pub fn new(device: &Device, side: u32, layers: u32, name: &str) -> Result<Self, Error> {
        let limits = &device.adapter().limits;
        for (what, wanted, limit) in [
            ("the side", side, limits.max_image_dimension2_d),
            ("the number of layers", layers, limits.max_image_array_layers),
        ] {
            if wanted == 0 || wanted > limit {
                let what = format!("{what} of the {name}");
                return Err(Error::TooLarge { what, wanted: wanted.into(), limit: limit.into() });
            }
        }
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::depth_array(device, name, [side; 2], layers, DEPTH_FORMAT, usage)?;
        // Owned from here on: if it is dropped while incomplete, it retires its existing objects.
        let mut made = Self {
            device: device.clone(),
            image,
            views: Vec::with_capacity(layers as usize),
            comparing: vk::Sampler::null(),
            reading: vk::Sampler::null(),
            side,
            contents: Contents::Undefined,
        };
        for layer in 0..layers {
            let view = made.create_view(layer)?;
            device.name(view, name);
            made.views.push(view);
        }
        made.reading = create_sampler(device, vk::Filter::NEAREST, false)?;
        device.name(made.reading, name);
        let linear = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
        let filter = if device.has_format_feature(DEPTH_FORMAT, linear) {
            vk::Filter::LINEAR
        } else {
            vk::Filter::NEAREST
        };
        made.comparing = create_sampler(device, filter, true)?;
        device.name(made.comparing, name);
        Ok(made)
    }

    fn create_view(&self, layer: u32) -> Result<vk::ImageView, Error> {
        let part = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::DEPTH,
            level_count: 1,
            base_array_layer: layer,
            layer_count: 1,
            ..Default::default()
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.image.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(DEPTH_FORMAT)
            .subresource_range(part);
        // SAFETY: a layer of a live image.
        unsafe { self.device.raw().create_image_view(&info, self.device.callbacks()) }
            .called("vkCreateImageView")
    }

    /// Returns the side of a layer in texels.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Returns the number of layers.
    pub fn layers(&self) -> u32 {
        self.views.len() as u32
    }

    /// Returns the attachments of pipelines that draw to a layer.
    pub fn attachments() -> Attachments {
        Attachments { colours: ColourFormats::new(&[]), ..Attachments::default() }
    }

    /// Records draws to layers, outside of rendering: `record` opens a rendering to each
    /// [`DepthLayers::target`]. The rest of the layers stays unchanged. Before the first draw all
    /// depths are the farthest.
    pub fn draw(&mut self, commands: &Commands, record: impl FnOnce(&Commands, &Self)) {
        if commands.check_owner(self).is_err() {
            return;
        }
        self.define(commands);
        self.change(commands, Access::FragmentSample, Access::Depth);
        record(commands, self);
        self.change(commands, Access::Depth, Access::FragmentSample);
    }

    /// Returns a layer as a render target that keeps its contents.
    pub fn target(&self, layer: u32) -> Option<RenderTarget> {
        Some(RenderTarget {
            device: self.device_id(),
            colours: [vk::ImageView::null(); COLOURS_MAX],
            colour_count: 0,
            depth: *self.views.get(layer as usize)?,
            average: vk::ImageView::null(),
            has_stencil: false,
            view_mask: 0,
            origin: [0, 0],
            size: [self.side; 2],
            colour_load: Load::Forget,
            depth_load: Load::Keep,
            colour_store: AttachmentStore::Keep,
            depth_store: AttachmentStore::Keep,
        })
    }

    /// Copies tiles of `from` to the same positions in these layers, outside of rendering. Tiles
    /// that are not completely inside of both are left out.
    pub fn copy_from(&mut self, commands: &Commands, from: &mut Self, tiles: &[DepthTile]) {
        if commands.check_owner(self).is_err()
            || commands.check_owner(from).is_err()
            || tiles.is_empty()
        {
            return;
        }
        self.define(commands);
        from.define(commands);
        from.change(commands, Access::FragmentSample, Access::CopyRead);
        self.change(commands, Access::FragmentSample, Access::CopyWrite);
        let is_in = |layers: &Self, tile: &DepthTile| {
            let ends = tile.origin.map(|texel| u64::from(texel) + u64::from(tile.side));
            tile.layer < layers.layers() && ends.iter().all(|end| *end <= u64::from(layers.side))
        };
        for tile in tiles.iter().filter(|tile| is_in(self, tile) && is_in(from, tile)) {
            self.copy_tile(commands, from, tile);
        }
        from.change(commands, Access::CopyRead, Access::FragmentSample);
        self.change(commands, Access::CopyWrite, Access::FragmentSample);
    }

    fn copy_tile(&self, commands: &Commands, from: &Self, tile: &DepthTile) {
        let part = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::DEPTH,
            base_array_layer: tile.layer,
            layer_count: 1,
            ..Default::default()
        };
        let [x, y] = tile.origin.map(|texel| texel as i32);
        let corner = vk::Offset3D { x, y, z: 0 };
        let region = vk::ImageCopy::default()
            .src_subresource(part)
            .src_offset(corner)
            .dst_subresource(part)
            .dst_offset(corner)
            .extent(vk::Extent3D { width: tile.side, height: tile.side, depth: 1 });
        // SAFETY: the tile lies in both images, which have the same format and are in the given
        // layouts.
        unsafe {
            self.device.raw().cmd_copy_image(
                commands.raw(),
                from.image.raw,
                Access::CopyRead.layout(),
                self.image.raw,
                Access::CopyWrite.layout(),
                &[region],
            );
        }
    }

    /// Notes that the last recording was submitted, so that later recordings can use its contents.
    pub fn submitted(&mut self) {
        self.contents = self.contents.submitted();
    }

    /// Prepares the layers to be sampled, outside of rendering: if nothing was ever drawn to them,
    /// all depths become the farthest.
    pub fn prepare(&mut self, commands: &Commands) {
        if commands.check_owner(self).is_ok() {
            self.define(commands);
        }
    }

    /// Returns the layers for a shader that compares: the result is 1 if a given depth is as near
    /// as the texel or nearer, averaged over four texels.
    pub fn comparing(&self) -> SampledTexture<'_> {
        SampledTexture::new(self.device.id(), self.image.view, self.comparing, self.contents)
    }

    /// Returns the layers for a shader that reads depths of single texels.
    pub fn reading(&self) -> SampledTexture<'_> {
        SampledTexture::new(self.device.id(), self.image.view, self.reading, self.contents)
    }

    fn whole(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::DEPTH,
            level_count: 1,
            layer_count: self.layers(),
            ..Default::default()
        }
    }

    fn change(&self, commands: &Commands, from: Access, to: Access) {
        let change = LayoutChange::of_part(self.image.raw, self.whole(), from, to);
        commands.change_layouts([change]);
    }

    /// Clears the contents if no submitted recording has defined them.
    fn define(&mut self, commands: &Commands) {
        if self.contents.is_known_to(commands) {
            return;
        }
        let depth = vk::ImageAspectFlags::DEPTH;
        // A recording that was never submitted may have used the image, but no other.
        let uses = [Access::CopyWrite, Access::Depth, Access::FragmentSample];
        let fresh = LayoutChange::forgetting(self.image.raw, depth, &uses, Access::CopyWrite)
            .of_layers(self.layers());
        commands.change_layouts([fresh]);
        // SAFETY: the image is a transfer destination in the given layout.
        unsafe {
            self.device.raw().cmd_clear_depth_stencil_image(
                commands.raw(),
                self.image.raw,
                Access::CopyWrite.layout(),
                &vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 },
                &[self.whole()],
            );
        }
        self.change(commands, Access::CopyWrite, Access::FragmentSample);
        self.contents = Contents::OfRecording(commands.recording());
    }
}

fn create_sampler(
    device: &Device,
    filter: vk::Filter,
    compares: bool,
) -> Result<vk::Sampler, Error> {
    let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(filter)
        .min_filter(filter)
        .address_mode_u(edge)
        .address_mode_v(edge)
        .address_mode_w(edge)
        .compare_enable(compares)
        .compare_op(vk::CompareOp::GREATER_OR_EQUAL);
    // SAFETY: a plain sampler.
    unsafe { device.raw().create_sampler(&info, device.callbacks()) }.called("vkCreateSampler")
}

impl Drop for DepthLayers {
    fn drop(&mut self) {
        for view in self.views.drain(..) {
            self.device.retire(Retired::ImageView(view));
        }
        self.device.retire(Retired::Sampler(self.comparing));
        self.device.retire(Retired::Sampler(self.reading));
    }
}
