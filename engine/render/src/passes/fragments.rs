//! The passes of transparent objects with sorted fragments.

use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, StorageLayout,
};
use occlusion::{Error, ShaderSet};

use crate::passes::{SurfaceKind, SurfacePass, SurfaceShadows};
use crate::shading::surfaces::SurfaceResources;

/// The buffers of the passes: the lists of a view, and the counts of a frame.
#[derive(Clone, Copy)]
pub(crate) struct FragmentIo {
    /// The lists and their fragments.
    pub(crate) fragments: BufferSlice,
    pub(crate) counts: BufferSlice,
}

/// The pass that stores the fragments of objects in a list per pixel, and the pass that blends each
/// list over the image in the order of depth.
pub(crate) struct FragmentPasses {
    pub(crate) storing: SurfacePass,
    sorting: GraphicsPipeline,
}

impl FragmentPasses {
    /// Compiles the passes for a scene and its shadows, and for renderings to `attachments`, on a
    /// device whose fragment shaders write to buffers.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        surfaces: &SurfaceResources,
        shadows: Option<SurfaceShadows>,
    ) -> Result<Self, Error> {
        let sorting = GraphicsPipelineInfo {
            fragment: Some(shaders.find("sorted_fragments.frag")?),
            storage: StorageLayout { buffers: 2, ..StorageLayout::default() },
            depth: DepthMode::Ignored,
            blend: Blend::Premultiplied,
            attachments,
            ..GraphicsPipelineInfo::of("sorted fragments", shaders.find("sky.vert")?)
        };
        Ok(Self {
            storing: SurfacePass::new(
                device,
                shaders,
                attachments,
                SurfaceKind::Fragments,
                surfaces,
                shadows,
            )?,
            sorting: GraphicsPipeline::new(device, &sorting)?,
        })
    }

    /// Blends the fragments of the view that is being rendered to.
    pub(crate) fn sort(&self, commands: &Commands, io: &FragmentIo) {
        commands.bind(&self.sorting, &[io.fragments, io.counts]);
        commands.draw(3, 0);
    }
}
