//! The surface pass: the depth and the colour of objects made of metallic-roughness materials.

use bytemuck::{Pod, Zeroable};
use cull::View;
use gpu::{
    Blend, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    StorageLayout, VertexLayout, vk,
};
use scene::limits::MAX_PAGES;
use scene::{Light, SurfaceVertex};

use crate::passes::opaque::POSITIONS;
use crate::shading::surfaces::SurfaceResources;
use occlusion::{Error, ShaderSet};

/// The output of a surface pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Depth alone, with the holes of masked materials. Where there are none,
    /// [`OpaquePass::depth_only`](crate::passes::OpaquePass::depth_only) draws the same depth for
    /// less.
    Depth,
    /// The colour of the surfaces that own a pixel of the finished depth, drawn by either of the
    /// two. Of equally near surfaces the larger value of each channel is kept, so the order of
    /// draws decides nothing: start from black.
    Colour,
    /// Transparent objects over the finished image, hidden by nearer surfaces; draw them back to
    /// front.
    Transparent,
}

/// The pass that draws objects of a scene with surfaces. Compiled for the features that its
/// materials and lights use.
pub struct SurfacePass {
    pipeline: GraphicsPipeline,
}

/// The inputs of the pass: reads positions, surface vertices, indices, instances, materials,
/// textures, lights and their lists; writes the colour and depth that are being rendered to.
#[derive(Clone, Copy)]
pub struct SurfaceIo<'a> {
    /// [`Vertex`](scene::Vertex)es of all meshes.
    pub vertices: BufferSlice,
    /// The 32-bit indices of all meshes, three per triangle.
    pub indices: BufferSlice,
    /// One instance per leaf, or per transparent object; their last values are
    /// [`SurfaceResources::instance_tail`]s.
    pub instances: BufferSlice,
    /// The scene's surfaces, with the second half of its vertices.
    pub surfaces: &'a SurfaceResources,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    view_proj: [f32; 16],
    eye: [f32; 4],
    ambient_above: [f32; 4],
    ambient_below: [f32; 4],
    exposure: f32,
}

const _: () = assert!(size_of::<Constants>() == 116);

/// The attributes of a [`SurfaceVertex`]: normal, tangent, both sets of texture coordinates,
/// colour.
const ATTRIBUTES: [(vk::Format, u32); 5] = [
    (vk::Format::R16G16B16A16_SNORM, 0),
    (vk::Format::R16G16B16A16_SNORM, 8),
    (vk::Format::R32G32_SFLOAT, 16),
    (vk::Format::R32G32_SFLOAT, 24),
    (vk::Format::R16G16B16A16_UNORM, 32),
];

impl SurfacePass {
    /// Compiles the pass for a scene.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(
        device: &Device,
        shaders: &ShaderSet,
        kind: SurfaceKind,
        surfaces: &SurfaceResources,
    ) -> Result<Self, Error> {
        let (name, shader, depth, blend) = match kind {
            SurfaceKind::Depth => {
                ("surface depth", "surface_depth", DepthMode::TestEqualAndWrite, Blend::NoColour)
            }
            SurfaceKind::Colour => ("surface", "surface", DepthMode::Equal, Blend::Max),
            SurfaceKind::Transparent => {
                ("transparent surface", "surface", DepthMode::TestOnly, Blend::Alpha)
            }
        };
        let is_transparent = kind == SurfaceKind::Transparent;
        let constants = surfaces.features(is_transparent).constants(is_transparent);
        let stage = |end: &str| {
            shaders.find(&format!("{shader}.{end}")).map(|shader| shader.specialised(&constants))
        };
        // Holes are a matter of texture coordinates and colours alone, the last three.
        let attributes = &ATTRIBUTES[if kind == SurfaceKind::Depth { 2 } else { 0 }..];
        let surface_vertices = VertexLayout {
            stride_bytes: size_of::<SurfaceVertex>() as u32,
            attributes,
            beside: None,
        };
        let vertex = stage("vert")?;
        let info = GraphicsPipelineInfo {
            fragment: Some(&stage("frag")?),
            vertices: VertexLayout { beside: Some(&surface_vertices), ..POSITIONS },
            storage: StorageLayout {
                texture_arrays: MAX_PAGES as u32,
                ..StorageLayout::new::<Constants>(5)
            },
            cull: vk::CullModeFlags::BACK,
            depth,
            blend,
            ..GraphicsPipelineInfo::of(name, &vertex)
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &info)? })
    }

    /// Binds everything; the caller then records draws of one instance each, since a draw has one
    /// material.
    pub fn bind(&self, commands: &Commands, io: &SurfaceIo<'_>, view: &View, light: &Light) {
        let with = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        let [steps_across, steps_up] = view.snap_steps;
        let [materials, transforms, lights, lists] = io.surfaces.buffers();
        let buffers = [io.instances, materials, transforms, lights, lists];
        let pages = io.surfaces.pages();
        let pages = pages.as_ref().map_or(&[][..], |pages| &pages[..]);
        commands.bind_sampled(&self.pipeline, &buffers, &[], pages);
        commands.bind_geometry_beside([io.vertices, io.surfaces.vertices()], io.indices);
        commands.push_constants(
            &self.pipeline,
            &Constants {
                view_proj: view.view_proj.to_cols_array(),
                eye: view.rays.eye().to_array(),
                ambient_above: with(light.ambient_above, steps_across),
                ambient_below: with(light.ambient_below, steps_up),
                exposure: io.surfaces.exposure(),
            },
        );
    }
}
