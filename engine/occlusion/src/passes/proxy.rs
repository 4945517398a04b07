//! The proxy pass, which tests boxes. It writes no colour or depth.

use bytemuck::{Pod, Zeroable};
use cull::{Aabb, CullView};
use gpu::{
    Attachments, BOX_VERTICES, BufferSlice, Commands, Device, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, OptionalFeature, StorageLayout,
};

use crate::error::Error;
use crate::passes::eyes::ProxyEyes;
use crate::shader_set::ShaderSet;

/// The pass that draws the front faces of boxes against the depth so far, without colour and depth
/// writes. The result of a box is a query around its draw, or a flag that its fragments set.
pub struct ProxyPass {
    queried: GraphicsPipeline,
    // Where fragment shaders can write to buffers.
    flagged: Option<GraphicsPipeline>,
}

/// The buffers of the pass. Boxes and the depth that is being rendered to are read; flags, if there
/// are any, are written.
#[derive(Clone, Copy)]
pub struct ProxyIo {
    /// A [`ProxyBox`] per test.
    pub boxes: BufferSlice,
    /// A result per test, for [`ProxyPass::bind_flags`].
    pub flags: Option<BufferSlice>,
}

/// A box as the shaders read it; mirrors `box.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ProxyBox {
    low: [f32; 3],
    /// The number of triangles in the box, for testers that count; others ignore it.
    triangles: u32,
    high: [f32; 3],
    unused: u32,
}

impl From<Aabb> for ProxyBox {
    fn from(bounds: Aabb) -> Self {
        let [low, high] = [bounds.min, bounds.max].map(|corner| corner.to_array());
        Self { low, triangles: 0, high, unused: 0 }
    }
}

impl ProxyBox {
    /// Returns the box with the number of triangles in it.
    pub fn counting(self, triangles: u32) -> Self {
        Self { triangles, ..self }
    }
}

/// The push constants that `proxy.vert` computes positions from.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ProxyConstants {
    view_proj: [f32; 16],
    eye: [f32; 4],
}

const _: () = assert!(size_of::<ProxyConstants>() == 80);

impl ProxyConstants {
    /// Creates the constants for the proxies of a view.
    pub fn of(view: &CullView) -> Self {
        Self { view_proj: view.proxy_view_proj().to_cols_array(), eye: view.rays.eye().to_array() }
    }
}

impl ProxyPass {
    /// Compiles the pass for renderings to `attachments`. The pass has no flags if fragment shaders
    /// of the device cannot write.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for several views at once where the device has no multiview; a
    /// failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_fragments(device, shaders, attachments, FragmentChoice::Representative)
    }

    /// Compiles the pass like [`ProxyPass::new`], with a choice of the fragments that set flags.
    /// The choice affects the cost but not the flags.
    ///
    /// # Errors
    /// The errors of [`ProxyPass::new`].
    pub fn of_fragments(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        flagging: FragmentChoice,
    ) -> Result<Self, Error> {
        let vertex = shaders.find(match attachments.views {
            1 => "proxy.vert",
            _ => "proxy_multiview.vert",
        })?;
        let pipeline = |name, fragment, buffers| -> Result<GraphicsPipeline, Error> {
            let info = GraphicsPipelineInfo {
                fragment,
                // Queries count all fragments.
                fragments: match fragment {
                    Some(_) => flagging,
                    None => FragmentChoice::All,
                },
                storage: match attachments.views {
                    1 => StorageLayout::new::<ProxyConstants>(buffers),
                    // Boxes, flags, eyes.
                    _ => StorageLayout::new::<[u8; 0]>(3),
                },
                attachments,
                ..GraphicsPipelineInfo::of(name, vertex).numbered::<ProxyBox>()
            };
            Ok(GraphicsPipeline::new(device, &info)?)
        };
        let can_flag = device.capabilities().has(OptionalFeature::FragmentStores);
        let fragment = shaders.find("proxy.frag")?;
        let flagged = can_flag.then(|| pipeline("flagged proxies", Some(fragment), 2));
        Ok(Self { queried: pipeline("queried proxies", None, 1)?, flagged: flagged.transpose()? })
    }

    /// Returns true if the pass has flags on this device.
    pub fn can_flag(&self) -> bool {
        self.flagged.is_some()
    }

    /// Binds everything for tests by queries. The caller then records [`ProxyPass::draw`] for each
    /// test. The number of views must be the number that the pass was compiled for.
    pub fn bind<'a>(&self, commands: &Commands, io: &ProxyIo, eyes: impl Into<ProxyEyes<'a>>) {
        match eyes.into() {
            ProxyEyes::One(view) => {
                commands.bind(&self.queried, &[io.boxes]);
                commands.push_constants(&self.queried, &ProxyConstants::of(view));
            }
            // Without flags the shader does not read the second buffer.
            ProxyEyes::Several(eyes) => commands.bind(&self.queried, &[io.boxes, io.boxes, eyes]),
        }
    }

    /// Binds everything for tests by flags. The caller then records [`ProxyPass::draw_all`].
    pub fn bind_flags<'a>(
        &self,
        commands: &Commands,
        io: &ProxyIo,
        eyes: impl Into<ProxyEyes<'a>>,
    ) {
        let (Some(pipeline), Some(flags)) = (&self.flagged, io.flags) else { return };
        match eyes.into() {
            ProxyEyes::One(view) => {
                commands.bind(pipeline, &[io.boxes, flags]);
                commands.push_constants(pipeline, &ProxyConstants::of(view));
            }
            ProxyEyes::Several(eyes) => commands.bind(pipeline, &[io.boxes, flags, eyes]),
        }
    }

    /// Draws box `test`.
    pub fn draw(&self, commands: &Commands, test: u32) {
        commands.draw(BOX_VERTICES, test);
    }

    /// Draws the boxes of all `tests` in one call.
    pub fn draw_all(&self, commands: &Commands, tests: std::ops::Range<u32>) {
        commands.draw_instances(BOX_VERTICES, tests);
    }
}
