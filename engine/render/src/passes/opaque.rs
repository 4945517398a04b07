//! The opaque pass: the colour of objects, under every strategy.

use bytemuck::{Pod, Zeroable};
use cull::CullView;
use gpu::{
    Attachments, Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline,
    GraphicsPipelineInfo, Polygon, StencilMode, StorageLayout, VertexLayout, vk,
};
use scene::{Light, Vertex};

use crate::passes::section::{SectionIo, culled_faces, section_buffers, with_section};
use crate::resources::instance::Instance;
use occlusion::{Error, SectionShaders, ShaderSet};

/// The pass that draws opaque objects with a depth test.
pub struct OpaquePass {
    pipeline: GraphicsPipeline,
}

/// The attachments that a pass writes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Depth,
    Colour,
    Wireframe,
    Mark,
}

/// The buffers of the pass. Vertices, indices and instances are read; the colour and depth that are
/// being rendered to are written.
#[derive(Clone, Copy)]
pub struct OpaqueIo {
    /// The vertices of all meshes.
    pub vertices: BufferSlice,
    /// The 32-bit indices of all meshes, three per triangle.
    pub indices: BufferSlice,
    /// An instance per leaf.
    pub instances: BufferSlice,
    /// Section planes, for passes that were compiled with section planes.
    pub section: Option<SectionIo>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    /// See [`anchored`].
    anchored: [f32; 16],
    towards_sun: [f32; 4],
    sun: [f32; 4],
    ambient_above: [f32; 4],
    ambient_below: [f32; 4],
}

const _: () = assert!(size_of::<Constants>() == 128);

/// Returns the matrix for positions relative to the anchor, packed with the anchor. The first three
/// columns are columns of the matrix. The last column would have clip x and y of 0: it holds the
/// anchor and clip z instead, and clip w is passed separately.
pub(super) fn anchored(view: &CullView) -> [f32; 16] {
    let mut matrix = view.from_anchor;
    matrix.w_axis = view.anchor.extend(matrix.w_axis.z);
    matrix.to_cols_array()
}

/// The positions of [`Vertex`]es, for passes that read nothing else.
pub(super) const POSITIONS: VertexLayout<'static> = VertexLayout {
    stride_bytes: size_of::<Vertex>() as u32,
    attributes: &[(vk::Format::R32G32B32_SFLOAT, 0)],
    beside: None,
};

impl OpaquePass {
    /// Compiles the pass for renderings to `attachments`.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_kind(device, shaders, attachments, Kind::Whole)
    }

    /// Compiles a pass that writes the same depth as [`OpaquePass::new`], to the bit, and no
    /// colour. Queries on its draws also count samples that are as near as the depth so far.
    ///
    /// # Errors
    /// A failed call.
    pub fn depth_only(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_kind(device, shaders, attachments, Kind::Depth)
    }

    /// Compiles a pass that adds the colour to the objects of [`OpaquePass::depth_only`].
    ///
    /// # Errors
    /// A failed call.
    pub fn colour_only(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_kind(device, shaders, attachments, Kind::Colour)
    }

    /// Compiles a pass that draws the edges of the objects of [`OpaquePass::new`], in one colour.
    ///
    /// # Errors
    /// A device that lacks [`gpu::OptionalFeature::Wireframe`]; a failed call.
    pub fn wireframe(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_kind(device, shaders, attachments, Kind::Wireframe)
    }

    /// Compiles a pass that marks the pixels of objects in the stencil of `attachments`, including
    /// hidden ones, and writes nothing else.
    pub(crate) fn marking(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
    ) -> Result<Self, Error> {
        Self::of_kind(device, shaders, attachments, Kind::Mark)
    }

    fn of_kind(
        device: &Device,
        shaders: &ShaderSet,
        attachments: Attachments,
        kind: Kind,
    ) -> Result<Self, Error> {
        let section = shaders.section();
        let fragment = shaders.find_of_objects("opaque", "frag")?;
        let mut of_depth = None;
        let mut of_mark = None;
        if section == SectionShaders::Cut {
            of_depth = Some(shaders.find("section_depth.frag")?);
            of_mark = Some(shaders.find("section_mark.frag")?);
        }
        let (name, fragment, depth, blend) = match kind {
            Kind::Whole => ("opaque", Some(fragment), DepthMode::TestAndWrite, Blend::Opaque),
            Kind::Depth => {
                ("opaque depth", of_depth, DepthMode::TestEqualAndWrite, Blend::NoColour)
            }
            Kind::Colour => ("opaque colour", Some(fragment), DepthMode::TestOnly, Blend::Opaque),
            Kind::Wireframe => (
                "wireframe",
                Some(shaders.find_of_objects("wireframe", "frag")?),
                DepthMode::TestOnly,
                Blend::Opaque,
            ),
            Kind::Mark => ("mark", of_mark, DepthMode::Ignored, Blend::NoColour),
        };
        let stencil = if kind == Kind::Mark { StencilMode::Mark } else { StencilMode::Ignored };
        let polygon = if kind == Kind::Wireframe { Polygon::Wireframe } else { Polygon::Filled };
        // A vertex shader may write only what its fragment shader reads.
        let has_positions_alone =
            section == SectionShaders::Cut && matches!(kind, Kind::Depth | Kind::Mark);
        let vertex = if has_positions_alone {
            shaders.find("opaque_depth_section.vert")?
        } else {
            shaders.find_of_objects("opaque", "vert")?
        };
        let all = VertexLayout {
            attributes: &[
                (vk::Format::R32G32B32_SFLOAT, 0),
                (vk::Format::R8G8B8A8_SNORM, 12),
                (vk::Format::R8G8B8A8_UNORM, 16),
            ],
            ..POSITIONS
        };
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsPipelineInfo {
                fragment,
                vertices: if has_positions_alone { POSITIONS } else { all },
                storage: StorageLayout::new::<Constants>(1 + section_buffers(section)),
                polygon,
                cull: culled_faces(section, vk::CullModeFlags::BACK),
                depth,
                stencil,
                blend,
                attachments,
                ..GraphicsPipelineInfo::of(name, vertex).numbered::<Instance>()
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Binds everything. The caller then records draws, each a leaf or a range of leaves.
    pub fn bind(&self, commands: &Commands, io: &OpaqueIo, view: &CullView, light: &Light) {
        self.bind_inputs(commands, io);
        self.set_view(commands, view, light);
    }

    fn bind_inputs(&self, commands: &Commands, io: &OpaqueIo) {
        with_section(&[io.instances], io.section, |all| commands.bind(&self.pipeline, all));
        commands.bind_geometry(io.vertices, Some(io.indices));
    }

    fn set_view(&self, commands: &Commands, view: &CullView, light: &Light) {
        let with = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        let [steps_across, steps_up] = view.snap_steps;
        commands.push_constants(
            &self.pipeline,
            &Constants {
                anchored: anchored(view),
                towards_sun: with(light.towards_sun.normalize_or_zero().to_array(), steps_across),
                sun: with(light.sun, steps_up),
                ambient_above: with(light.ambient_above, view.from_anchor.w_axis.w),
                ambient_below: with(light.ambient_below, 0.0),
            },
        );
    }
}
