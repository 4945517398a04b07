//! Solids that section planes cut, and images of them.

use cull::{Camera, Projection, SectionMode, SectionPlane, SectionPlanes, Strategy};
use glam::{Affine3A, DVec3, Vec3};
use gpu::{Device, Readback};
use render::{CostModel, FrameRequest, RenderView, Renderer, RendererOptions};
use scene::{
    Light, Mesh, MeshId, Object, Scene, Vertex, bounds_of_vertices, pack_normal, pack_unorm,
};

/// Triangles of a solid, counter-clockwise from outside.
#[derive(Debug, Clone, Default)]
pub struct Solid {
    /// The corners of each triangle (metres).
    pub triangles: Vec<[Vec3; 3]>,
}

impl Solid {
    /// Returns a cube around the origin.
    pub fn cube(side_m: f32) -> Self {
        let half = side_m * 0.5;
        let corner = |number: usize| {
            let at = |bit: usize| if number >> bit & 1 == 1 { half } else { -half };
            Vec3::new(at(0), at(1), at(2))
        };
        let mut solid = Self::default();
        for face in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            solid.push_quad(face.map(corner));
        }
        solid
    }

    /// Returns a cube around the origin with a hole along y, a polygon with this number of corners.
    pub fn bored_cube(side_m: f32, radius_m: f32, corners: u32) -> Self {
        let half = side_m * 0.5;
        let mut solid = Self::default();
        let at = |number: u32, y: f32| {
            let angle = (number % corners) as f32 / corners as f32 * std::f32::consts::TAU;
            Vec3::new(angle.cos() * radius_m, y, angle.sin() * radius_m)
        };
        // The corner of the square in the same direction as a point of the polygon.
        let outer = |number: u32, y: f32| {
            let inner = at(number, y);
            let scale = half / inner.x.abs().max(inner.z.abs());
            Vec3::new(inner.x * scale, y, inner.z * scale)
        };
        for number in 0..corners {
            let next = number + 1;
            for y in [half, -half] {
                let ring = [at(number, y), outer(number, y), outer(next, y), at(next, y)];
                solid.push_quad(if y > 0.0 { [ring[3], ring[2], ring[1], ring[0]] } else { ring });
            }
            let hole = [at(number, half), at(number, -half), at(next, -half), at(next, half)];
            solid.push_quad([hole[0], hole[1], hole[2], hole[3]]);
            let side =
                [outer(next, half), outer(next, -half), outer(number, -half), outer(number, half)];
            solid.push_quad(side);
        }
        solid
    }

    /// Adds a quad, counter-clockwise from outside.
    pub fn push_quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners;
        self.triangles.push([a, b, c]);
        self.triangles.push([a, c, d]);
    }

    /// Returns a mesh in one colour.
    pub fn mesh(&self, colour: [f32; 3]) -> Mesh {
        let colour = pack_unorm([colour[0], colour[1], colour[2], 0.0]);
        let mut vertices = Vec::new();
        for [a, b, c] in &self.triangles {
            let normal = pack_normal((*b - *a).cross(*c - *a).normalize_or_zero());
            let vertex = |at: &Vec3| Vertex { position: at.to_array(), normal, colour };
            vertices.extend([a, b, c].map(vertex));
        }
        let bounds = bounds_of_vertices(&vertices);
        let indices = (0..vertices.len() as u32).collect();
        Mesh { name: "solid".to_owned(), vertices, indices, bounds, has_backs: false }
    }
}

/// Returns a scene of solids, each with its own colour and place.
pub fn scene_of(solids: &[(Solid, [f32; 3], Vec3)]) -> Scene {
    let object = |(mesh, (.., place)): (u32, &(Solid, [f32; 3], Vec3))| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_translation(*place),
        tint: u32::MAX,
    };
    Scene {
        name: "solids".to_owned(),
        meshes: solids.iter().map(|(solid, colour, _)| solid.mesh(*colour)).collect(),
        objects: (0..).zip(solids).map(object).collect(),
        light: Light { sky: [0.0; 3], ..Light::afternoon() },
        surfaces: None,
    }
}

/// Returns a plane that keeps the points with `normal · p + offset_m >= 0`.
pub fn plane(normal: [f64; 3], offset_m: f64) -> SectionPlane {
    SectionPlane::new(DVec3::from(normal), offset_m).expect("a plane")
}

/// Returns section planes that keep the points on the inner side of every plane.
pub fn planes(planes: &[SectionPlane]) -> SectionPlanes {
    SectionPlanes::new(planes, SectionMode::Intersection).expect("planes")
}

/// Returns an orthographic camera that looks along -z at the origin of a scene.
pub fn front(height_m: f32) -> Camera {
    Camera {
        eye: Vec3::Z,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::Orthographic { height: height_m, far: 2.0 },
        near: 0.0,
    }
}

/// A renderer with a view, and its image.
pub struct CutScene {
    /// The renderer.
    pub renderer: Renderer,
    /// The view.
    pub view: RenderView,
    /// The image.
    pub image: Readback,
}

impl CutScene {
    /// Creates a renderer with all methods.
    pub fn new(device: &Device, scene: &Scene, options: RendererOptions) -> Self {
        let options =
            RendererOptions { cost_model: CostModel::Off, methods: methods::all(), ..options };
        let renderer = Renderer::new(device, scene, &options).expect("a renderer");
        let view = renderer.new_view().expect("a view");
        let image = Readback::new(device, options.size).expect("an image");
        Self { renderer, view, image }
    }

    /// Draws a frame and returns its pixels: red, green, blue.
    pub fn pixels(&mut self, camera: Camera, strategy: Strategy) -> Vec<[u8; 3]> {
        let image = Some(&self.image);
        let request = FrameRequest { image, ..FrameRequest::new(strategy, camera) };
        self.renderer.render(&mut self.view, request).expect("a frame");
        self.renderer.device().wait_idle().expect("an image");
        let pixels = self.image.rgba8().expect("pixels");
        pixels
            .as_chunks::<4>()
            .0
            .iter()
            .map(|[red, green, blue, _]| [*red, *green, *blue])
            .collect()
    }
}
