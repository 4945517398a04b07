//! The count pass: counts the samples of single objects, and of their proxies, in a finished
//! image.

use bytemuck::{Pod, Zeroable};
use cull::View;
use gpu::{
    BOX_VERTICES, Blend, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    IndirectDraw, Polygon, StorageLayout, VertexLayout, vk,
};
use scene::Vertex;

use crate::passes::seen::SeenConstants;
use occlusion::ProxyIo;

use crate::passes::OpaqueIo;
use occlusion::{Error, ShaderSet};

/// The pass that draws objects a second time against their own depth, and proxies at any depth.
/// Writes nothing: queries around the draws count. The positions of objects are invariant, so a
/// sample passes where the object is the nearest.
pub struct CountPass {
    objects: GraphicsPipeline,
    proxies: GraphicsPipeline,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ProxyConstants {
    view_proj: [f32; 16],
    eye: [f32; 4],
}

const _: () = assert!(size_of::<ProxyConstants>() == 80);

impl CountPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let proxies = GraphicsPipelineInfo {
            name: "counted proxies",
            vertex: shaders.find("proxy.vert")?,
            fragment: None,
            vertices: VertexLayout::default(),
            storage: StorageLayout {
                buffers: 1,
                textures: 0,
                texture_arrays: 0,
                push_bytes: size_of::<ProxyConstants>() as u32,
            },
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            polygon: Polygon::Filled,
            cull: vk::CullModeFlags::NONE,
            depth: DepthMode::Ignored,
            blend: Blend::NoColour,
        };
        let objects = GraphicsPipelineInfo {
            name: "counted objects",
            vertex: shaders.find("seen.vert")?,
            fragment: None,
            vertices: VertexLayout {
                stride_bytes: size_of::<Vertex>() as u32,
                attributes: &[(vk::Format::R32G32B32_SFLOAT, 0)],
                beside: None,
            },
            storage: StorageLayout {
                buffers: 1,
                textures: 0,
                texture_arrays: 0,
                push_bytes: size_of::<SeenConstants>() as u32,
            },
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            polygon: Polygon::Filled,
            cull: vk::CullModeFlags::BACK,
            depth: DepthMode::TestOnly,
            blend: Blend::NoColour,
        };
        Ok(Self {
            objects: GraphicsPipeline::new(device, &objects)?,
            proxies: GraphicsPipeline::new(device, &proxies)?,
        })
    }

    /// Binds everything for objects; the caller then records [`CountPass::draw`] for each.
    pub fn bind_objects(&self, commands: &Commands, io: &OpaqueIo, view: &View) {
        commands.bind(&self.objects, &[io.instances]);
        commands.bind_geometry(io.vertices, Some(io.indices));
        commands.push_constants(&self.objects, &SeenConstants::of(view));
    }

    /// Draws an object. Not indirectly: Mesa 22.3's lavapipe lets an indirect draw take the count
    /// of the previous counted one.
    pub fn draw(&self, commands: &Commands, draw: &IndirectDraw) {
        commands.draw_indexed(draw);
    }

    /// Binds everything for proxies as if nothing hid them; the caller then records
    /// [`CountPass::draw_proxy`] for each.
    pub fn bind_proxies(&self, commands: &Commands, io: &ProxyIo, view: &View) {
        commands.bind(&self.proxies, &[io.boxes]);
        let (view_proj, eye) = (view.view_proj.to_cols_array(), view.eye.extend(1.0).to_array());
        commands.push_constants(&self.proxies, &ProxyConstants { view_proj, eye });
    }

    /// Draws the front faces of a proxy.
    pub fn draw_proxy(&self, commands: &Commands, number: u32) {
        commands.draw(BOX_VERTICES, number);
    }
}
