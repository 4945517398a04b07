//! The leaf-box pass, the second level of a test: it tests each leaf below a visible node
//! individually.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, BufferSlice, Commands, Device, FragmentChoice, GraphicsPipeline,
    GraphicsPipelineInfo, LINKED, LeafDrawBuffers, SpecializationConstant, StorageLayout,
};

use crate::error::Error;
use crate::passes::eyes::ProxyEyes;
use crate::passes::proxy::ProxyBox;
use crate::shader_set::ShaderSet;

/// The pass that draws the front faces of the leaves' proxies against the depth so far. Fragments
/// that pass enable the draws of their leaves.
pub struct LeafBoxPass {
    /// For leaves with one draw each, which has the number of the leaf.
    single: GraphicsPipeline,
    /// For leaves with lists of draws.
    linked: GraphicsPipeline,
}

/// The buffers of the pass. The leaves' boxes and the depth that is being rendered to are read;
/// draws and their list are written.
#[derive(Clone, Copy)]
pub struct LeafBoxIo {
    /// One [`super::ProxyBox`] per leaf, not yet enlarged.
    pub boxes: BufferSlice,
    /// The draws that are enabled.
    pub leaf_draws: LeafDrawBuffers,
    /// The draws of each leaf; `None` if each leaf has one draw, with the number of the leaf.
    pub links: Option<LeafLinks>,
}

/// Lists of draws, for leaves with any number of draws.
#[derive(Clone, Copy)]
pub struct LeafLinks {
    /// One more than the number of the first draw of each leaf, or [`gpu::DrawLink::NO_DRAW`].
    pub firsts: BufferSlice,
    /// A [`gpu::DrawLink`] per draw.
    pub links: BufferSlice,
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

impl Constants {
    fn of(view: &CullView) -> Self {
        Self {
            view_proj: view.proxy_view_proj().to_cols_array(),
            eye: view.rays.eye().to_array(),
            row_w: view.rays.row_w().to_array(),
            margin_m: view.margin.metres(),
        }
    }
}

impl LeafBoxPass {
    /// Compiles the pass for renderings to `attachments`, on a device whose fragment shaders can
    /// write to buffers.
    ///
    /// # Errors
    /// [`gpu::Error::Unsupported`] for several views at once where the device has no multiview; a
    /// failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let fragment = shaders.find("leaf_box.frag")?;
        let (vertex, storage) = match attachments.views {
            1 => ("leaf_box.vert", StorageLayout::new::<Constants>(5)),
            // The eyes are the last buffer.
            _ => ("leaf_box_multiview.vert", StorageLayout::new::<[u8; 0]>(6)),
        };
        let vertex = shaders.find(vertex)?;
        let pipeline = |name, fragment| -> Result<GraphicsPipeline, Error> {
            let info = GraphicsPipelineInfo {
                fragment: Some(fragment),
                fragments: FragmentChoice::Representative,
                storage,
                attachments,
                ..GraphicsPipelineInfo::of(name, vertex).numbered::<ProxyBox>()
            };
            Ok(GraphicsPipeline::new(device, &info)?)
        };
        Ok(Self {
            single: pipeline("leaf boxes", fragment)?,
            linked: pipeline(
                "leaf boxes of lists",
                &fragment.specialised(&[SpecializationConstant { id: LINKED, value: 1 }]),
            )?,
        })
    }

    /// Binds everything. The caller then draws boxes, with the leaf as the instance. The number of
    /// views must be the number that the pass was compiled for.
    pub fn bind<'a>(&self, commands: &Commands, io: &LeafBoxIo, eyes: impl Into<ProxyEyes<'a>>) {
        let LeafBoxIo { boxes, leaf_draws: LeafDrawBuffers { draws, list }, links } = *io;
        let pipeline = if links.is_some() { &self.linked } else { &self.single };
        // Without lists the shader does not read these buffers.
        let LeafLinks { firsts, links } =
            links.unwrap_or(LeafLinks { firsts: boxes, links: boxes });
        let view = match eyes.into() {
            ProxyEyes::One(view) => view,
            ProxyEyes::Several(eyes) => {
                commands.bind(pipeline, &[boxes, draws, list, firsts, links, eyes]);
                return;
            }
        };
        commands.bind(pipeline, &[boxes, draws, list, firsts, links]);
        commands.push_constants(pipeline, &Constants::of(view));
    }
}

#[cfg(test)]
mod tests {
    use cull::{Aabb, Camera, Projection};
    use glam::{Vec3, vec3};

    use super::*;

    #[test]
    fn boxes_of_leaves_grow_as_much_as_proxies() {
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(1.0),
            near: 0.1,
        };
        let view = CullView::new(&camera, [64, 48], 4);
        let bounds = Aabb::new(vec3(-1.0, -1.0, -40.0), vec3(1.0, 1.0, -30.0));
        let proxy = view.margin.proxy(&bounds).unwrap();
        // The formula of `leaf_box.glsl`.
        let [of_depth, least] = Constants::of(&view).margin_m;
        let grown_m = (1.0 + 1.0 / 65536.0) * (of_depth * 40.0 + least.max(3.814_697_3e-6 * 40.0));
        assert!(grown_m >= proxy.max.x - bounds.max.x && of_depth > 0.0, "{grown_m}");
    }
}
