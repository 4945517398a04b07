//! The cap pass: closes solids where section planes cut them open, by the parity of the number of
//! faces behind the plane.
//!
//! ```text
//! per cap   count    the object's faces behind the plane, whatever hides them: odd is inside
//!           draw     the plane, at its own depth, where the number is odd; the stencil is 0 again
//! ```

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, DepthRange, Device, FragmentChoice,
    GraphicsPipeline, GraphicsPipelineInfo, IndirectDraw, OptionalFeature, StencilMode,
    StorageLayout, vk,
};
use occlusion::{Error, ShaderSet};
use scene::Shell;

use crate::passes::OpaqueIo;
use crate::passes::opaque::POSITIONS;
use crate::resources::instance::Instance;

/// The number of storage buffers of all pipelines of the pass.
const BUFFERS: u32 = 4;

/// The output of a rendering of caps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CapKind {
    /// Colour and depth, where nothing is nearer.
    Whole,
    /// Only depth.
    Depth,
    /// The colour of the caps that own a pixel of the finished depth. Where surfaces are equally
    /// near, the larger value of each channel is kept.
    Colour,
    /// The leaf of each cap that owns a pixel of the finished depth.
    Seen,
    /// The leaf and the depth of the nearest cap.
    Pointed,
}

/// A cap as shaders read it; mirrors `cap_constants.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct CapRow {
    pub(crate) box_rows: [[f32; 4]; 3],
    pub(crate) w: [f32; 4],
    pub(crate) hatch: [f32; 4],
    pub(crate) colour: [f32; 4],
    pub(crate) area: [f32; 4],
    pub(crate) plane: u32,
    pub(crate) state: u32,
    pub(crate) leaf: u32,
    pub(crate) unused: u32,
}

const _: () = assert!(size_of::<CapRow>() == 128);

/// The draw of the object of a cap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CapDraw {
    pub(crate) draw: IndirectDraw,
    pub(crate) shell: Shell,
}

/// The inputs of the pass: positions, indices, instances, caps and the planes of the view are read.
#[derive(Clone, Copy)]
pub(crate) struct CapIo<'a> {
    pub(crate) opaque: OpaqueIo,
    /// A [`CapRow`] for each draw.
    pub(crate) rows: BufferSlice,
    pub(crate) draws: &'a [CapDraw],
    /// The output of [`CapKind::Seen`], one value per leaf, or of [`CapKind::Pointed`], the leaf
    /// and the depth.
    pub(crate) notes: Option<BufferSlice>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    from_anchor: [f32; 16],
    anchor: [f32; 4],
    snap_steps: [f32; 2],
    cap: u32,
}

const _: () = assert!(size_of::<Constants>() == 92);

/// The pass that draws caps.
pub(crate) struct CapPass {
    count: GraphicsPipeline,
    /// The count for meshes in which the backs of triangles are separate triangles.
    count_fronts: GraphicsPipeline,
    whole: GraphicsPipeline,
    depth: GraphicsPipeline,
    colour: GraphicsPipeline,
    /// Keeps the parity of the caps that own a pixel.
    mark: GraphicsPipeline,
    seen: Option<GraphicsPipeline>,
    pointed: Option<GraphicsPipeline>,
}

impl CapPass {
    /// Compiles the pass for renderings to `attachments`, which have a stencil.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let storage = StorageLayout::new::<Constants>(BUFFERS);
        // Faces beyond the far plane of an orthographic view must count as well.
        let range = if device.capabilities().has(OptionalFeature::DepthClamp) {
            DepthRange::Clamped
        } else {
            DepthRange::Clipped
        };
        let count = |name, cull| {
            let info = GraphicsPipelineInfo {
                fragment: Some(shaders.find("cap_count.frag")?),
                vertices: POSITIONS,
                storage,
                cull,
                depth: DepthMode::Ignored,
                range,
                stencil: StencilMode::Parity,
                attachments,
                ..GraphicsPipelineInfo::of(name, shaders.find("cap_count.vert")?)
                    .numbered::<Instance>()
            };
            Ok::<_, Error>(GraphicsPipeline::new(device, &info)?)
        };
        let drawn = |name, fragment: &str, fragments, (depth, stencil, blend)| {
            let info = GraphicsPipelineInfo {
                fragments,
                fragment: Some(shaders.find(fragment)?),
                storage,
                topology: vk::PrimitiveTopology::TRIANGLE_STRIP,
                depth,
                stencil,
                blend,
                attachments,
                ..GraphicsPipelineInfo::of(name, shaders.find("cap.vert")?)
            };
            Ok::<_, Error>(GraphicsPipeline::new(device, &info)?)
        };
        let write = DepthMode::TestAndWrite;
        let equal = DepthMode::Equal;
        let odd = StencilMode::Odd;
        let none = Blend::NoColour;
        let all = FragmentChoice::All;
        let can_note = device.capabilities().has(OptionalFeature::FragmentStores);
        let seen = (DepthMode::Ignored, odd, none);
        let pointed = can_note
            .then(|| drawn("pointed caps", "cap_pointed.frag", FragmentChoice::FirstSample, seen))
            .transpose()?;
        let seen = can_note.then(|| drawn("seen caps", "cap_seen.frag", all, seen)).transpose()?;
        Ok(Self {
            count: count("cap count", vk::CullModeFlags::NONE)?,
            count_fronts: count("cap count of fronts", vk::CullModeFlags::BACK)?,
            whole: drawn("caps", "cap.frag", all, (write, odd, Blend::Opaque))?,
            depth: drawn("cap depth", "cap_depth.frag", all, (write, odd, none))?,
            colour: drawn("cap colour", "cap.frag", all, (equal, odd, Blend::Max))?,
            mark: drawn("cap mark", "cap_depth.frag", all, (equal, StencilMode::OddDrawn, none))?,
            seen,
            pointed,
        })
    }

    /// Draws the caps of a view in their order. The stencil must be 0.
    pub(crate) fn draw(&self, commands: &Commands, io: &CapIo<'_>, view: &CullView, kind: CapKind) {
        let (Some(first), Some(section)) = (io.draws.first(), io.opaque.section) else { return };
        let notes = io.notes.unwrap_or(section.planes);
        let all = [io.opaque.instances, io.rows, section.planes, notes];
        commands.bind(self.count_of(first.shell), &all);
        commands.bind_geometry(io.opaque.vertices, Some(io.opaque.indices));
        for (cap, CapDraw { draw, shell }) in (0..).zip(io.draws) {
            let count = self.count_of(*shell);
            commands.switch(count);
            let constants = Constants {
                from_anchor: view.from_anchor.to_cols_array(),
                anchor: view.anchor.extend(0.0).to_array(),
                snap_steps: view.snap_steps,
                cap,
            };
            commands.push_constants(count, &constants);
            commands.draw_indexed(draw);
            let drawn = match kind {
                CapKind::Whole => [Some(&self.whole), None],
                CapKind::Depth => [Some(&self.depth), None],
                CapKind::Colour => [Some(&self.colour), None],
                CapKind::Seen => [Some(&self.mark), self.seen.as_ref()],
                CapKind::Pointed => [Some(&self.mark), self.pointed.as_ref()],
            };
            for pipeline in drawn.into_iter().flatten() {
                commands.switch(pipeline);
                commands.draw(4, 0);
            }
        }
    }

    fn count_of(&self, shell: Shell) -> &GraphicsPipeline {
        match shell {
            Shell::Open | Shell::Closed => &self.count,
            Shell::ClosedTwice => &self.count_fronts,
        }
    }
}
