//! The edge pass: segments of edges as lines with a width in pixels, drawn against an existing
//! depth.

use bytemuck::{Pod, Zeroable};
use cull::{CullView, ProjectionKind};
use gpu::{
    Attachments, Blend, Buffer, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, OptionalFeature, StencilMode, StencilTarget, StorageLayout,
    UnindexedDraw, vk,
};
use occlusion::{Error, ShaderSet};

use super::opaque::{OpaquePass, anchored};
use super::section::{SectionIo, section_buffers, with_section};
use crate::resources::instance::Instance;

/// The shader stage that widens lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgePath {
    /// A geometry shader. For devices with [`OptionalFeature::GeometryShaders`].
    GeometryShader,
    /// The vertex shader, which computes the line of its segment for each corner of a strip. The
    /// image is the same to the bit, at several times the work.
    Quads,
}

impl EdgePath {
    /// Returns the path for a device.
    pub fn of(device: &Device) -> Self {
        if device.capabilities().has(OptionalFeature::GeometryShaders) {
            Self::GeometryShader
        } else {
            Self::Quads
        }
    }

    /// Returns the name of the path for users.
    pub const fn name(self) -> &'static str {
        match self {
            Self::GeometryShader => "a geometry shader",
            Self::Quads => "quads",
        }
    }

    /// Returns the number of vertices that a segment is drawn with.
    fn vertices(self) -> u32 {
        match self {
            Self::GeometryShader => 1,
            Self::Quads => 18,
        }
    }

    /// Returns the draw of segments with the instance of this index.
    pub(crate) fn draw(self, segments: &std::ops::Range<u32>, instance: u32) -> UnindexedDraw {
        UnindexedDraw {
            vertex_count: self.vertices().saturating_mul(segments.len() as u32),
            instance_count: u32::from(!segments.is_empty()),
            first_vertex: self.vertices().saturating_mul(segments.start),
            first_instance: instance,
        }
    }
}

/// The lines that are drawn, by their depth test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeTest {
    /// Lines that nothing hides.
    Visible,
    /// Hidden lines.
    Hidden,
}

/// The style of lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeStyle {
    pub(crate) width_pixels: f32,
    /// The colour: linear red, green and blue.
    pub(crate) colour: [f32; 3],
    /// The length of a dash in pixels; 0 for lines without gaps.
    pub(crate) dash_pixels: f32,
    pub(crate) gap_pixels: f32,
}

/// The buffers of the pass. Instances, segments and the vertices of all meshes are read; the colour
/// that is being rendered to is written.
#[derive(Clone, Copy)]
pub(crate) struct EdgeIo {
    /// An instance per leaf, or per draw.
    pub(crate) instances: BufferSlice,
    /// [`EdgeSegment`]s.
    pub(crate) segments: BufferSlice,
    /// The vertices, as a storage buffer.
    pub(crate) vertices: BufferSlice,
    /// The section planes that cut lines, if there are any.
    pub(crate) section: Option<SectionIo>,
}

/// A segment of an edge; mirrors `edge_line.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct EdgeSegment {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) left: u32,
    pub(crate) right: u32,
    pub(crate) run: u32,
}

const _: () = assert!(size_of::<EdgeSegment>() == 20);

impl EdgeSegment {
    /// Stands for the corner of a missing second face.
    pub(crate) const NO_FACE: u32 = u32::MAX;
    /// Stands for the run of a smooth edge.
    pub(crate) const SMOOTH: u32 = u32::MAX;
}

/// Mirrors `edge_constants.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    /// See [`anchored`].
    anchored: [f32; 16],
    eye: [f32; 4],
    half_size: [f32; 2],
    half_width: f32,
    anchor_w: f32,
    colour: [f32; 3],
    dash: f32,
    depth_step: [f32; 2],
    period: f32,
}

const _: () = assert!(size_of::<Constants>() == 124);

impl Constants {
    fn new(view: &CullView, style: &EdgeStyle) -> Self {
        let eye = view.rays.eye();
        Self {
            anchored: anchored(view),
            eye: (eye - view.anchor.extend(0.0) * eye.w).to_array(),
            half_size: view.size.map(|side| side.max(1) as f32 / 2.0),
            half_width: style.width_pixels / 2.0,
            anchor_w: view.from_anchor.w_axis.w,
            colour: style.colour,
            dash: style.dash_pixels,
            depth_step: depth_step(view),
            period: style.dash_pixels + style.gap_pixels,
        }
    }
}

/// Returns the change of depth over the width of a pixel along the view, as a linear function of
/// the depth: its factor and its constant.
fn depth_step(view: &CullView) -> [f32; 2] {
    let [_, height] = view.size;
    // In metres; in perspective at a distance of one metre.
    let pixel_m = 2.0 * view.rays.down.length() / height.max(1) as f32;
    let [constant, scaled] = view.rays.depth;
    match view.rays.kind {
        ProjectionKind::Perspective => [pixel_m, -constant * pixel_m],
        ProjectionKind::Orthographic => [0.0, scaled.abs() * pixel_m],
    }
}

/// The pipelines that draw edges.
pub(crate) struct EdgePass {
    visible: GraphicsPipeline,
    hidden: GraphicsPipeline,
    all: Buffer,
}

/// The pipelines that mark objects in a stencil, and draw edges where there is no mark.
pub(crate) struct OutlinePass {
    pub(crate) mark: OpaquePass,
    edges: GraphicsPipeline,
    all: Buffer,
}

impl EdgePass {
    /// Compiles the pass for renderings to `attachments`.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let pipeline = |name, depth| {
            let info = GraphicsPipelineInfo { depth, attachments, ..info(device, shaders, name)? };
            Ok::<_, Error>(GraphicsPipeline::new(device, &info)?)
        };
        Ok(Self {
            visible: pipeline("visible edges", DepthMode::TestOnly)?,
            hidden: pipeline("hidden edges", DepthMode::TestFarther)?,
            all: all_draws(device)?,
        })
    }

    /// Binds the pipeline of a test. The caller then [draws](EdgePass::draw).
    pub(crate) fn bind(
        &self,
        commands: &Commands,
        io: &EdgeIo,
        view: &CullView,
        test: EdgeTest,
        style: &EdgeStyle,
    ) {
        let pipeline = match test {
            EdgeTest::Visible => &self.visible,
            EdgeTest::Hidden => &self.hidden,
        };
        bind(commands, pipeline, io, view, style);
    }

    /// Draws [`UnindexedDraw`]s with the bound pipeline.
    pub(crate) fn draw(&self, commands: &Commands, draws: BufferSlice) {
        commands.draw_all_unindexed_indirect(draws, self.all.whole());
    }
}

impl OutlinePass {
    /// Compiles the pass for renderings to the colours of `attachments` with a stencil.
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        let attachments = StencilTarget::attachments_beside(&attachments);
        let edges = GraphicsPipelineInfo {
            depth: DepthMode::Ignored,
            stencil: StencilMode::Unmarked,
            attachments,
            ..info(device, shaders, "outlines")?
        };
        Ok(Self {
            mark: OpaquePass::marking(device, shaders, attachments)?,
            edges: GraphicsPipeline::new(device, &edges)?,
            all: all_draws(device)?,
        })
    }

    /// Draws the edges of objects where there is no mark.
    pub(crate) fn draw(
        &self,
        commands: &Commands,
        io: &EdgeIo,
        view: &CullView,
        style: &EdgeStyle,
        draws: BufferSlice,
    ) {
        bind(commands, &self.edges, io, view, style);
        commands.draw_all_unindexed_indirect(draws, self.all.whole());
    }
}

fn bind(
    commands: &Commands,
    pipeline: &GraphicsPipeline,
    io: &EdgeIo,
    view: &CullView,
    style: &EdgeStyle,
) {
    let own = [io.instances, io.segments, io.vertices];
    with_section(&own, io.section, |all| commands.bind(pipeline, all));
    commands.push_constants(pipeline, &Constants::new(view, style));
}

fn info<'a>(
    device: &Device,
    shaders: &'a ShaderSet,
    name: &'a str,
) -> Result<GraphicsPipelineInfo<'a>, Error> {
    let path = EdgePath::of(device);
    let vertex = match path {
        EdgePath::GeometryShader => "edge",
        EdgePath::Quads => "edge_quads",
    };
    let section = shaders.section();
    let topology = match path {
        EdgePath::GeometryShader => vk::PrimitiveTopology::POINT_LIST,
        EdgePath::Quads => vk::PrimitiveTopology::TRIANGLE_LIST,
    };
    let has_stage = path == EdgePath::GeometryShader;
    Ok(GraphicsPipelineInfo {
        geometry: has_stage.then(|| shaders.find_of_objects("edge", "geom")).transpose()?,
        fragment: Some(shaders.find_of_objects("edge", "frag")?),
        storage: StorageLayout::new::<Constants>(3 + section_buffers(section)),
        topology,
        blend: Blend::Opaque,
        ..GraphicsPipelineInfo::of(name, shaders.find_of_objects(vertex, "vert")?)
            .numbered::<Instance>()
    })
}

/// Returns a buffer with a draw count that exceeds every number of draws.
fn all_draws(device: &Device) -> Result<Buffer, Error> {
    let most = [device.adapter().limits.max_draw_indirect_count.max(1)];
    Ok(device.upload("all edges", &most, vk::BufferUsageFlags::INDIRECT_BUFFER)?)
}
