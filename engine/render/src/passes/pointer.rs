//! The pointer pass: finds the object that owns one pixel of a finished image, and its depth.

use cull::CullView;
use gpu::{
    Attachments, BufferSlice, Commands, DepthMode, Device, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, StorageLayout, vk,
};

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{culled_faces, section_buffers, with_section};
use crate::passes::seen::SeenConstants;
use crate::resources::instance::Instance;
use occlusion::{Error, ShaderSet};

/// The pass that draws objects again where their depth equals the finished depth. The positions are
/// invariant, so a fragment passes exactly where its object was drawn, and not in a hole of a
/// masked material.
pub(crate) struct PointerPass {
    pipeline: GraphicsPipeline,
}

/// The buffers of the pass. The buffers of the opaque pass and the finished depth are read; the
/// pointed object is written.
#[derive(Clone, Copy)]
pub(crate) struct PointerIo {
    /// The buffers of the draws.
    pub(crate) opaque: OpaqueIo,
    /// Two words, initially 0: the complement of the first leaf that owns the pixel, and the bits
    /// of its depth.
    pub(crate) pointed: BufferSlice,
}

impl PointerPass {
    /// Compiles the pass for renderings to `attachments`, on a device whose fragment shaders write
    /// to buffers.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let vertex = shaders.find_of_objects("seen", "vert")?;
        let section = shaders.section();
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsPipelineInfo {
                fragment: Some(shaders.find_of_objects("pointer", "frag")?),
                vertices: POSITIONS,
                storage: StorageLayout::new::<SeenConstants>(2 + section_buffers(section)),
                cull: culled_faces(section, vk::CullModeFlags::BACK),
                depth: DepthMode::Equal,
                // Leaf and depth are written separately, and must belong to the same object.
                fragments: FragmentChoice::FirstSample,
                attachments,
                ..GraphicsPipelineInfo::of("pointer", vertex).numbered::<Instance>()
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Binds everything. The caller then records the draws of the objects along the ray.
    pub(crate) fn bind(&self, commands: &Commands, io: &PointerIo, view: &CullView) {
        let own = [io.opaque.instances, io.pointed];
        with_section(&own, io.opaque.section, |all| commands.bind(&self.pipeline, all));
        commands.bind_geometry(io.opaque.vertices, Some(io.opaque.indices));
        commands.push_constants(&self.pipeline, &SeenConstants::of(view));
    }
}
