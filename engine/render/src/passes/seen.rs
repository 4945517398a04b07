//! The seen passes: find the objects that own a pixel of a finished image, or one of its pixels.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, BufferSlice, Commands, DepthMode, Device, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, OptionalFeature, StorageLayout, vk,
};

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{culled_faces, section_buffers, with_section};
use crate::resources::instance::Instance;
use occlusion::{Error, ShaderSet};

/// A pass that draws objects again against their own depth. A fragment that passes is visible and
/// records its leaf. The positions are invariant, so equal objects have equal depths.
pub struct SeenPass {
    pipeline: GraphicsPipeline,
}

/// The buffers of a pass. The buffers of the opaque pass and the finished depth are read; `seen` is
/// written.
#[derive(Clone, Copy)]
pub struct SeenIo {
    /// The buffers of the draws.
    pub opaque: OpaqueIo,
    /// The result, as [`SeenPass::new`] or [`SeenPass::of_pointer`] writes it.
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
    /// Compiles the pass that sets the values of visible leaves to 1, for renderings to
    /// `attachments`. There is a value per leaf of the scene; other values stay.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        device.require(OptionalFeature::FragmentStores, "finding out which objects are seen")?;
        let vertex = shaders.find_of_objects("seen", "vert")?;
        let info = GraphicsPipelineInfo { attachments, ..GraphicsPipelineInfo::of("seen", vertex) };
        Self::described(device, shaders, &info)
    }

    /// Compiles the pass that finds the first leaf that owns a pixel, on a device whose fragment
    /// shaders write to buffers. It writes two words, initially 0: the complement of the leaf, and
    /// the bits of its depth. A fragment passes exactly where its object was drawn, and not in a
    /// hole of a masked material.
    pub(crate) fn of_pointer(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let vertex = shaders.find_of_objects("seen", "vert")?;
        let info = GraphicsPipelineInfo {
            depth: DepthMode::Equal,
            // Leaf and depth are written separately, and must belong to the same object.
            fragments: FragmentChoice::FirstSample,
            attachments,
            ..GraphicsPipelineInfo::of("pointer", vertex)
        };
        Self::described(device, shaders, &info)
    }

    fn described(
        device: &Device,
        shaders: &ShaderSet,
        info: &GraphicsPipelineInfo<'_>,
    ) -> Result<Self, Error> {
        let section = shaders.section();
        let info = GraphicsPipelineInfo {
            fragment: Some(shaders.find_of_objects(info.name, "frag")?),
            vertices: POSITIONS,
            storage: StorageLayout::new::<SeenConstants>(2 + section_buffers(section)),
            cull: culled_faces(section, vk::CullModeFlags::BACK),
            ..info.numbered::<Instance>()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Binds everything. The caller then records the same draws as before.
    pub fn bind(&self, commands: &Commands, io: &SeenIo, view: &CullView) {
        let own = [io.opaque.instances, io.seen];
        with_section(&own, io.opaque.section, |all| commands.bind(&self.pipeline, all));
        commands.bind_geometry(io.opaque.vertices, Some(io.opaque.indices));
        commands.push_constants(&self.pipeline, &SeenConstants::of(view));
    }
}
