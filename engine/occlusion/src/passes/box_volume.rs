//! The pass that tests shadow volumes of boxes. It writes no colour or depth.

use bytemuck::{Pod, Zeroable};
use cull::{Aabb, CullView, VolumeLength};
use glam::Vec4;
use gpu::{
    Attachments, BufferSlice, Commands, Device, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, StorageLayout,
};

use crate::error::Error;
use crate::shader_set::ShaderSet;

/// The pass that draws the [shadow volumes](cull::BoxShadowVolumes) of boxes against the depth of a
/// view, without colour and depth writes. Each fragment that passes sets a flag.
pub struct BoxVolumePass(GraphicsPipeline);

/// The buffers of the pass.
#[derive(Clone, Copy)]
pub struct BoxVolumeIo {
    /// A [`BoxVolume`] per test; read.
    pub boxes: BufferSlice,
    /// A result per test; written.
    pub flags: BufferSlice,
}

/// A box and the lengths of its volume as the shader reads them; mirrors `box_volume.vert`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct BoxVolume {
    low: [f32; 3],
    towards: f32,
    high: [f32; 3],
    away: f32,
}

impl BoxVolume {
    /// Creates the volume of a box that is already enlarged.
    pub fn new(proxy: &Aabb, VolumeLength { towards, away }: VolumeLength) -> Self {
        Self { low: proxy.min.to_array(), towards, high: proxy.max.to_array(), away }
    }
}

/// The push constants of the pass.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct BoxVolumeConstants {
    view_proj: [f32; 16],
    light: [f32; 4],
}

/// The vertices of six faces and twelve edges, two triangles each.
const VERTICES: u32 = 108;

impl BoxVolumePass {
    /// The number of triangles in a volume.
    pub const TRIANGLES: u64 = VERTICES as u64 / 3;

    /// Compiles the pass for renderings to `attachments`, on a device whose fragment shaders can
    /// write ([`OptionalFeature::FragmentStores`](gpu::OptionalFeature::FragmentStores)).
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let vertex = shaders.find("box_volume.vert")?;
        let info = GraphicsPipelineInfo {
            fragment: Some(shaders.find("proxy.frag")?),
            fragments: FragmentChoice::Representative,
            storage: StorageLayout::new::<BoxVolumeConstants>(2),
            attachments,
            ..GraphicsPipelineInfo::of("shadow proxies", vertex).numbered::<BoxVolume>()
        };
        Ok(Self(GraphicsPipeline::new(device, &info)?))
    }

    /// Tests the volumes of some boxes under one light, given in homogeneous coordinates.
    pub fn draw(
        &self,
        commands: &Commands,
        io: &BoxVolumeIo,
        view: &CullView,
        light: Vec4,
        tests: std::ops::Range<u32>,
    ) {
        let view_proj = view.proxy_view_proj().to_cols_array();
        commands.bind(&self.0, &[io.boxes, io.flags]);
        commands
            .push_constants(&self.0, &BoxVolumeConstants { view_proj, light: light.to_array() });
        commands.draw_instances(VERTICES, tests);
    }
}
