//! The seen pass: finds the objects that own a pixel of a finished image.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, BufferSlice, Commands, Device, GraphicsPipeline, GraphicsPipelineInfo,
    OptionalFeature, StorageLayout, vk,
};

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{culled_faces, section_buffers, with_section};
use crate::resources::instance::Instance;
use occlusion::{Error, ShaderSet};

/// The pass that draws objects again against their own depth. A fragment that passes is visible and
/// records its leaf. The positions are invariant, so equal objects have equal depths.
pub struct SeenPass {
    pipeline: GraphicsPipeline,
}

/// The buffers of the pass. The buffers of the opaque pass and the finished depth are read; a value
/// per leaf is written.
#[derive(Clone, Copy)]
pub struct SeenIo {
    /// The buffers of the draws.
    pub opaque: OpaqueIo,
    /// A value per leaf of the scene. Visible leaves are set to 1; other values stay.
    pub seen: BufferSlice,
}

/// The push constants that `seen.vert` computes positions from.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct SeenConstants {
    from_anchor: [f32; 16],
    anchor: [f32; 4],
    snap_steps: [f32; 2],
}

const _: () = assert!(size_of::<SeenConstants>() == 88);

impl SeenConstants {
    pub(super) fn of(view: &CullView) -> Self {
        Self {
            from_anchor: view.from_anchor.to_cols_array(),
            anchor: view.anchor.extend(0.0).to_array(),
            snap_steps: view.snap_steps,
        }
    }
}

impl SeenPass {
    /// Compiles the pass for renderings to `attachments`.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        device.require(OptionalFeature::FragmentStores, "finding out which objects are seen")?;
        let vertex = shaders.find_of_objects("seen", "vert")?;
        let section = shaders.section();
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsPipelineInfo {
                fragment: Some(shaders.find_of_objects("seen", "frag")?),
                vertices: POSITIONS,
                storage: StorageLayout::new::<SeenConstants>(2 + section_buffers(section)),
                cull: culled_faces(section, vk::CullModeFlags::BACK),
                attachments,
                ..GraphicsPipelineInfo::of("seen", vertex).numbered::<Instance>()
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Binds everything. The caller then records the same draws as before.
    pub fn bind(&self, commands: &Commands, io: &SeenIo, view: &CullView) {
        let own = [io.opaque.instances, io.seen];
        with_section(&own, io.opaque.section, |all| commands.bind(&self.pipeline, all));
        commands.bind_geometry(io.opaque.vertices, Some(io.opaque.indices));
        commands.push_constants(&self.pipeline, &SeenConstants::of(view));
    }
}
