//! The simplest shapes: boxes as occluders, as tests, and as whole scenes.

use bytemuck::{Pod, Zeroable};
use cull::{Aabb, Camera, CullView, Projection};
use glam::{Affine3A, Quat, Vec3};
use gpu::{
    Attachments, BufferSlice, Commands, DepthMode, Device, GraphicsPipeline, GraphicsPipelineInfo,
    Spirv, StorageLayout,
};
use occlusion::{ProxyBox, ProxyPass, ShaderSet};
use scene::{
    Light, Material, MaterialId, Mesh, MeshId, Object, Scene, SurfaceMesh, SurfaceVertex, Surfaces,
    Vertex, bounds_of_vertices, pack_normal, pack_unorm, unpack_normal,
};

/// A pipeline that draws boxes into the depth buffer only.
pub struct DepthBoxes {
    pipeline: GraphicsPipeline,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    view_proj: [f32; 16],
    eye: [f32; 4],
}

impl DepthBoxes {
    /// Compiles the pipeline.
    pub fn new(device: &Device) -> Self {
        Self::of(device, Attachments::default())
    }

    /// Compiles the pipeline for renderings to `attachments`.
    pub fn of(device: &Device, attachments: Attachments) -> Self {
        let shader = shaders::find("proxy.vert");
        let spirv =
            Spirv::from_bytes("proxy.vert", shader.expect("the shader").spirv).expect("SPIR-V");
        let info = GraphicsPipelineInfo {
            storage: StorageLayout::new::<Constants>(1),
            depth: DepthMode::TestAndWrite,
            attachments,
            ..GraphicsPipelineInfo::of("depth boxes", &spirv).numbered::<ProxyBox>()
        };
        Self { pipeline: GraphicsPipeline::new(device, &info).expect("a pipeline") }
    }

    /// Draws box `index` of `boxes`.
    pub fn draw(&self, commands: &Commands, boxes: BufferSlice, view: &CullView, index: u32) {
        let view_proj = view.view_proj.to_cols_array();
        let eye = view.rays.eye().to_array();
        commands.bind(&self.pipeline, &[boxes]);
        commands.push_constants(&self.pipeline, &Constants { view_proj, eye });
        commands.draw(18, index);
    }
}

/// Returns the engine's own proxy pass.
pub fn proxy_pass(device: &Device) -> ProxyPass {
    let shaders = ShaderSet::embedded().expect("shaders");
    ProxyPass::new(device, &shaders, Attachments::default()).expect("a pipeline")
}

/// Returns a camera at the origin that looks along -z, with a field of view of 90 degrees.
pub fn square_camera() -> Camera {
    Camera {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
        near: 0.1,
    }
}

/// Returns the view of [`square_camera`] on a square image.
pub fn square_view(device: &Device, side: u32) -> CullView {
    CullView::new(&square_camera(), [side, side], device.adapter().limits.sub_pixel_precision_bits)
}

/// Returns a box around `centre`.
pub fn box_at(centre: Vec3, half: Vec3) -> Aabb {
    Aabb { min: centre - half, max: centre + half }
}

/// Returns a scene of solid boxes that fill their bounds exactly: the hardest case for proxies.
pub fn box_scene(boxes: &[Aabb]) -> Scene {
    let mesh = cube(pack_unorm([1.0; 4]), QUADS);
    let objects = boxes.iter().enumerate().map(|(number, bounds)| Object {
        mesh: MeshId(0),
        transform: Affine3A::from_scale_rotation_translation(
            bounds.max - bounds.min,
            Quat::IDENTITY,
            bounds.min,
        ),
        tint: pack_unorm([(number % 7) as f32 / 7.0, (number % 5) as f32 / 5.0, 0.6, 1.0]),
    });
    Scene {
        name: "boxes".to_owned(),
        meshes: vec![mesh],
        objects: objects.collect(),
        light: Light::afternoon(),
        surfaces: None,
    }
}

/// Returns unit cubes in several colours, with a mesh per colour, placed by `objects`. Their
/// surfaces have these colours in any light.
pub fn coloured_cubes(colours: u32, objects: Vec<Object>) -> Scene {
    let channel =
        |number: u32, by: u32| 0.1 + 0.9 * (number * by % colours) as f32 / colours as f32;
    let colours =
        (0..colours).map(|index| [channel(index, 1), channel(index, 2), channel(index, 3), 1.0]);
    let colours: Vec<[f32; 4]> = colours.collect();
    let meshes: Vec<Mesh> = colours.iter().map(|colour| cube(pack_unorm(*colour), 1)).collect();
    let material =
        |colour: &[f32; 4]| Material { base_colour: *colour, is_unlit: true, ..Default::default() };
    let surfaces = Surfaces {
        meshes: (0..)
            .map(MaterialId)
            .zip(&meshes)
            .map(|(material, mesh)| surface_of(mesh, material))
            .collect(),
        materials: colours.iter().map(material).collect(),
        ..Default::default()
    };
    Scene { meshes, objects, surfaces: Some(surfaces), ..box_scene(&[]) }
}

/// Returns the plainest surface for a mesh.
pub fn surface_of(mesh: &Mesh, material: MaterialId) -> SurfaceMesh {
    let part = |value: f32| (value * 32767.0).round() as i16;
    let vertex = |vertex: &Vertex| {
        let normal = unpack_normal(vertex.normal);
        let tangent = normal.any_orthonormal_vector().to_array();
        SurfaceVertex {
            normal: [part(normal[0]), part(normal[1]), part(normal[2]), 0],
            tangent: [part(tangent[0]), part(tangent[1]), part(tangent[2]), 32767],
            uv: [[0.0; 2]; 2],
            colour: [u16::MAX; 4],
        }
    };
    SurfaceMesh { vertices: mesh.vertices.iter().map(vertex).collect(), material }
}

/// Quads along a side of a face: an odd number, so that no vertex is in the middle of a face.
const QUADS: u32 = 7;

/// Returns the unit cube, counter-clockwise from outside, with faces cut into quads. Each vertex
/// along an edge is snapped to the sub-pixel grid individually, unlike the long edge of a proxy.
pub fn cube(colour: u32, quads: u32) -> Mesh {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let mut normal = Vec3::ZERO;
            normal[axis] = side * 2.0 - 1.0;
            let first = vertices.len() as u32;
            for point in 0..(quads + 1) * (quads + 1) {
                let mut position = Vec3::ZERO;
                position[axis] = side;
                position[(axis + 1) % 3] = (point % (quads + 1)) as f32 / quads as f32;
                position[(axis + 2) % 3] = (point / (quads + 1)) as f32 / quads as f32;
                let normal = pack_normal(normal);
                vertices.push(Vertex { position: position.to_array(), normal, colour });
            }
            let turn = if side > 0.5 { [0, 1, 3, 0, 3, 2] } else { [0, 3, 1, 0, 2, 3] };
            for quad in 0..quads * quads {
                let corner = first + quad % quads + quad / quads * (quads + 1);
                let corners = [corner, corner + 1, corner + quads + 1, corner + quads + 2];
                indices.extend(turn.map(|which| corners[which]));
            }
        }
    }
    let bounds = bounds_of_vertices(&vertices);
    Mesh { name: "cube".to_owned(), vertices, indices, bounds, has_backs: false }
}

/// Returns screens at many distances for an image of `side` pixels. Behind each is a small box, or
/// a box that reaches past the screen by less than a pixel, or by less than the distance from the
/// middle of a pixel to a sample.
pub fn slivers(side: u32) -> Scene {
    let pixel = 2.0 / side as f32;
    let boxes = (0..14 * 14).flat_map(|cell: u32| {
        let place = |number: u32| (number as f32 - 6.5) * 0.14;
        let centre = Vec3::new(place(cell % 14), place(cell / 14), -1.0);
        let half = 0.02 + 0.002 * (cell % 11) as f32;
        let past = [-4.0, -0.05, 0.05, 0.2, 0.5][cell as usize % 5] * pixel;
        let near = 4.0 + 0.3 * (cell % 13) as f32;
        let far = 10.0 + (cell % 17) as f32;
        let flat = |half: f32| Vec3::new(half, half, 0.001);
        [box_at(centre * near, flat(half * near)), box_at(centre * far, flat((half + past) * far))]
    });
    box_scene(&boxes.collect::<Vec<_>>())
}
