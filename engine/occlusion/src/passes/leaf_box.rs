//! The leaf-box pass: the second level of a test, leaf by leaf below a node that showed.

use bytemuck::{Pod, Zeroable};
use cull::View;
use gpu::{
    Attachments, BufferSlice, Commands, Device, GraphicsPipeline, GraphicsPipelineInfo,
    LeafDrawBuffers, StorageLayout,
};

use crate::error::Error;
use crate::shader_set::ShaderSet;

/// The pass that draws the front faces of the leaves' proxies against the depth so far. The
/// fragments that pass switch on the draws of their leaves.
pub struct LeafBoxPass {
    pipeline: GraphicsPipeline,
}

/// The buffers of the pass: reads the leaves' boxes and the depth that is being rendered to; writes
/// draws and their list.
#[derive(Clone, Copy)]
pub struct LeafBoxIo {
    /// One [`super::ProxyBox`] per leaf, not yet enlarged.
    pub boxes: BufferSlice,
    /// The draws that are switched on.
    pub leaf_draws: LeafDrawBuffers,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    view_proj: [f32; 16],
    eye: [f32; 4],
    row_w: [f32; 4],
    margin_m: [f32; 2],
}

const _: () = assert!(size_of::<Constants>() == 104);

impl LeafBoxPass {
    /// Compiles the pass for renderings to `attachments`, on a device whose fragment shaders can
    /// write to buffers.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let info = GraphicsPipelineInfo {
            fragment: Some(shaders.find("leaf_box.frag")?),
            storage: StorageLayout::new::<Constants>(3),
            attachments,
            ..GraphicsPipelineInfo::of("leaf boxes", shaders.find("leaf_box.vert")?)
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Binds everything; the caller then draws boxes, with the leaf as the instance.
    pub fn bind(&self, commands: &Commands, io: &LeafBoxIo, view: &View) {
        commands.bind(&self.pipeline, &[io.boxes, io.leaf_draws.draws, io.leaf_draws.list]);
        commands.push_constants(
            &self.pipeline,
            &Constants {
                view_proj: view.proxy_view_proj().to_cols_array(),
                eye: view.rays.eye().to_array(),
                row_w: view.rays.row_w().to_array(),
                margin_m: view.margin.metres(),
            },
        );
    }
}
