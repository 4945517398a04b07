//! The layers pass: counts the surfaces at each pixel of a view, including hidden ones, and shows
//! the counts as colours.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, OptionalFeature, StorageLayout, vk,
};
use occlusion::{Error, ShaderSet};

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{culled_faces, section_buffers, with_section};
use crate::passes::seen::SeenConstants;
use crate::resources::instance::Instance;

/// The pass that counts the fragments of objects, and shows the counts.
pub(crate) struct LayersPass {
    counting: GraphicsPipeline,
    showing: GraphicsPipeline,
}

/// The buffers of the pass. The buffers of the opaque pass are read; a value per pixel counts.
#[derive(Clone, Copy)]
pub(crate) struct LayersIo {
    /// The buffers of the draws.
    pub(crate) opaque: OpaqueIo,
    /// A value per pixel of the view, in rows from the top, initially 0.
    pub(crate) layers: BufferSlice,
}

/// The counted part of the image; mirrors the end of the constants in `layers_main.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AreaConstants {
    origin: [u32; 2],
    width: u32,
}

const _: () = assert!(size_of::<AreaConstants>() == 12);

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct CountingConstants {
    seen: SeenConstants,
    area: AreaConstants,
}

const _: () = assert!(size_of::<CountingConstants>() == 100);

impl AreaConstants {
    fn of(view: &CullView) -> Self {
        Self { origin: view.origin, width: view.size[0] }
    }
}

impl LayersPass {
    /// Compiles the pass for renderings to `attachments`.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        device.require(OptionalFeature::FragmentStores, "showing the depth complexity")?;
        let section = shaders.section();
        let counting = GraphicsPipelineInfo {
            fragment: Some(shaders.find_of_objects("layers", "frag")?),
            vertices: POSITIONS,
            storage: StorageLayout::new::<CountingConstants>(2 + section_buffers(section)),
            cull: culled_faces(section, vk::CullModeFlags::BACK),
            depth: DepthMode::Ignored,
            attachments,
            ..GraphicsPipelineInfo::of("layers", shaders.find_of_objects("layers", "vert")?)
                .numbered::<Instance>()
        };
        let showing = GraphicsPipelineInfo {
            fragment: Some(shaders.find("depth_complexity.frag")?),
            storage: StorageLayout::new::<AreaConstants>(1),
            depth: DepthMode::Ignored,
            blend: Blend::Opaque,
            attachments,
            ..GraphicsPipelineInfo::of("depth complexity", shaders.find("sky.vert")?)
        };
        Ok(Self {
            counting: GraphicsPipeline::new(device, &counting)?,
            showing: GraphicsPipeline::new(device, &showing)?,
        })
    }

    /// Binds everything for counting. The caller then records draws.
    pub(crate) fn bind(&self, commands: &Commands, io: &LayersIo, view: &CullView) {
        let own = [io.opaque.instances, io.layers];
        with_section(&own, io.opaque.section, |all| commands.bind(&self.counting, all));
        commands.bind_geometry(io.opaque.vertices, Some(io.opaque.indices));
        let constants =
            CountingConstants { seen: SeenConstants::of(view), area: AreaConstants::of(view) };
        commands.push_constants(&self.counting, &constants);
    }

    /// Draws the counts over the whole view.
    pub(crate) fn show(&self, commands: &Commands, layers: BufferSlice, view: &CullView) {
        commands.bind(&self.showing, &[layers]);
        commands.push_constants(&self.showing, &AreaConstants::of(view));
        commands.draw(3, 0);
    }
}
