//! The count pass: counts the samples of single objects, and of their proxies, in a finished
//! image.

use cull::CullView;
use gpu::{
    Attachments, BOX_VERTICES, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    IndirectDraw, StorageLayout, vk,
};

use crate::passes::seen::SeenConstants;
use occlusion::{ProxyBox, ProxyConstants, ProxyIo};

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::passes::section::{culled_faces, cut_depth_stages, section_buffers, with_section};
use crate::resources::instance::Instance;
use occlusion::{Error, ShaderSet};

/// The pass that draws objects again against their own depth, and proxies with and without a depth
/// test. It writes nothing: queries around the draws count samples. The positions of objects are
/// invariant, so a sample passes where the object is the nearest.
pub struct CountPass {
    objects: GraphicsPipeline,
    proxies: GraphicsPipeline,
}

impl CountPass {
    /// Compiles the pass for renderings to `attachments`.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let section = shaders.section();
        let proxy = shaders.find("proxy.vert")?;
        let (seen, fragment) = cut_depth_stages(shaders)?;
        let proxies = GraphicsPipelineInfo {
            storage: StorageLayout::new::<ProxyConstants>(1),
            depth: DepthMode::Ignored,
            attachments,
            ..GraphicsPipelineInfo::of("counted proxies", proxy).numbered::<ProxyBox>()
        };
        let objects = GraphicsPipelineInfo {
            fragment,
            vertices: POSITIONS,
            storage: StorageLayout::new::<SeenConstants>(1 + section_buffers(section)),
            cull: culled_faces(section, vk::CullModeFlags::BACK),
            attachments,
            ..GraphicsPipelineInfo::of("counted objects", seen).numbered::<Instance>()
        };
        Ok(Self {
            objects: GraphicsPipeline::new(device, &objects)?,
            proxies: GraphicsPipeline::new(device, &proxies)?,
        })
    }

    /// Binds everything for objects. The caller then records [`CountPass::draw`] for each.
    pub fn bind_objects(&self, commands: &Commands, io: &OpaqueIo, view: &CullView) {
        with_section(&[io.instances], io.section, |all| commands.bind(&self.objects, all));
        commands.bind_geometry(io.vertices, Some(io.indices));
        commands.push_constants(&self.objects, &SeenConstants::of(view));
    }

    /// Draws an object. The draw is direct, since on Mesa 22.3's Lavapipe an indirect draw takes
    /// the count of an earlier counted draw.
    pub fn draw(&self, commands: &Commands, draw: &IndirectDraw) {
        commands.draw_indexed(draw);
    }

    /// Binds everything for proxies without a depth test. The caller then records
    /// [`CountPass::draw_proxy`] for each.
    pub fn bind_proxies(&self, commands: &Commands, io: &ProxyIo, view: &CullView) {
        commands.bind(&self.proxies, &[io.boxes]);
        commands.push_constants(&self.proxies, &ProxyConstants::of(view));
    }

    /// Draws the front faces of a proxy.
    pub fn draw_proxy(&self, commands: &Commands, number: u32) {
        commands.draw(BOX_VERTICES, number);
    }
}
