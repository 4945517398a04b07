//! The objects that costs are measured with: a triangle and a patch of many triangles, drawn like
//! the objects of the scene.

use cull::{CullView, Hierarchy};
use glam::{Affine3A, Vec3};
use gpu::{
    CancellationToken, Commands, Device, IndirectDraw, PredicationMode, RenderTarget, Target,
};
use occlusion::{
    BucketId, CalibrationScene, CostModel, DeviceCosts, ObjectRenderer, OcclusionPasses,
    PATCH_TRIANGLES, Rendering, ShaderSet,
};
use scene::{Mesh, MeshId, Object, Scene, Vertex, bounds_of_vertices, pack_normal, pack_unorm};

use crate::error::Error;
use crate::passes::OpaqueIo;
use crate::renderer::{Renderer, RendererOptions};
use crate::resources::geometry::Geometry;
use crate::resources::object_bounds::object_bounds;
use crate::scene_renderer::SceneRenderer;
use crate::shading::surfaces::SurfaceOptions;

/// The distance of the objects from the eye (metres).
const DISTANCE_M: f32 = 10.0;

/// The number of quads along each side of a patch.
const QUADS: u32 = 16;

const _: () = assert!(2 * QUADS * QUADS == PATCH_TRIANGLES);

/// Measures the costs of tests and draws on a device, for scenes of hosts
/// (`occlusion::CulledSceneOptions::costs`); a [renderer](crate::Renderer) measures its own. Size,
/// samples and shaders are taken from `options`. It measures the
/// [given](RendererOptions::predication) predication mode, or all modes that the device has and
/// that are not [disabled](RendererOptions::disabled). The time is described at
/// [`CostModel::Measured`]. Waits for the device many times: call it before the first frame.
///
/// # Errors
/// Impossible options, no memory, a shader that does not compile, a failed call; a device that was
/// adopted without a queue.
pub fn measure_costs(device: &Device, options: &RendererOptions) -> Result<DeviceCosts, Error> {
    let untested = RendererOptions { cost_model: CostModel::Off, ..options.clone() };
    let mut renderer = Renderer::new(device, &scene(), &untested)?;
    let Renderer { passes, scene, shaders, .. } = &mut renderer;
    let quirks = scene.passes().quirks();

    let executors =
        quirks.usable_executors(device, options.predication, 1, options.threshold_samples)?;
    measure(passes, scene.passes(), &executors, shaders, &options.cancellation)
}

/// Measures the costs of tests and draws on the device of `passes`, and of these executors.
pub(crate) fn measure(
    passes: &mut SceneRenderer,
    occlusion_passes: &OcclusionPasses,
    executors: &[PredicationMode],
    shaders: &ShaderSet,
    cancellation: &CancellationToken,
) -> Result<DeviceCosts, Error> {
    let device = passes.device.clone();
    let mut objects = CalibrationObjects::new(passes)?;
    Ok(occlusion::measure(CalibrationScene {
        device: &device,
        shaders,
        passes: occlusion_passes,
        executors,
        draws: objects.draws,
        objects: &mut objects,
        cancellation,
    })?)
}

/// The renderer of the measured objects, with the passes of a scene.
pub(crate) struct CalibrationObjects<'a> {
    passes: &'a mut SceneRenderer,
    geometry: Geometry,
    /// The draws of the triangle and of the patch.
    pub(crate) draws: [IndirectDraw; 2],
}

impl<'a> CalibrationObjects<'a> {
    pub(crate) fn new(passes: &'a mut SceneRenderer) -> Result<Self, Error> {
        let device = passes.device.clone();
        let scene = scene();
        let hierarchy = Hierarchy::build(&object_bounds(&scene)?)?;
        let options = SurfaceOptions::default();
        let geometry = Geometry::upload(&device, &scene, &hierarchy, &options, 0)?;
        let draws = [0, 1].map(|object| {
            let leaf = hierarchy.leaf_of(cull::ObjectId(object)).map_or(0, |leaf| leaf.0);
            IndirectDraw { first_instance: leaf, ..geometry.mesh_draw(MeshId(object)) }
        });
        Ok(Self { passes, geometry, draws })
    }
}

impl ObjectRenderer for CalibrationObjects<'_> {
    fn target(&mut self) -> &mut Target {
        &mut self.passes.target
    }

    fn rendering(&self, view: &CullView, rendering: Rendering) -> RenderTarget {
        self.passes.rendering(view, rendering)
    }

    fn bind(&self, commands: &Commands, view: &CullView, _bucket: BucketId) {
        let io = OpaqueIo {
            section: None,
            vertices: self.geometry.vertices.whole(),
            indices: self.geometry.indices.whole(),
            instances: self.geometry.instances.whole(),
        };
        self.passes.pipelines.opaque.bind(commands, &io, view, &self.passes.gpu_scene.light);
    }
}

/// Returns a scene of a triangle and a patch.
pub(crate) fn scene() -> Scene {
    let object = |(mesh, (z, scale)): (u32, (f32, f32))| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_scale_rotation_translation(
            Vec3::splat(scale),
            glam::Quat::IDENTITY,
            Vec3::new(0.0, 0.0, z),
        ),
        tint: pack_unorm([1.0; 4]),
    };
    // At this distance, the patch is about 40 of 720 pixels high.
    let places = [(-1.2 * DISTANCE_M, 0.1), (-1.2 * DISTANCE_M, 0.7)];
    Scene {
        name: "calibration".to_owned(),
        meshes: vec![single(), patch()],
        objects: (0..).zip(places).map(object).collect(),
        light: scene::Light::afternoon(),
        surfaces: None,
    }
}

fn mesh(name: &str, points: impl Iterator<Item = [f32; 2]>, indices: Vec<u32>) -> Mesh {
    let normal = pack_normal(Vec3::Z);
    let colour = pack_unorm([1.0; 4]);
    let vertex = |[x, y]: [f32; 2]| Vertex { position: [x, y, 0.0], normal, colour };
    let vertices: Vec<Vertex> = points.map(vertex).collect();
    let bounds = bounds_of_vertices(&vertices);
    Mesh { name: name.to_owned(), vertices, indices, bounds, has_backs: false }
}

fn single() -> Mesh {
    mesh("triangle", [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]].into_iter(), vec![0, 1, 2])
}

/// Returns a square of triangles, half of which face the eye.
fn patch() -> Mesh {
    let side = QUADS + 1;
    let at = |place: u32| place as f32 / QUADS as f32 - 0.5;
    let points = (0..side * side).map(|point| [at(point % side), at(point / side)]);
    let indices = (0..QUADS * QUADS).flat_map(|quad| {
        let first = quad / QUADS * side + quad % QUADS;
        let a = first;
        let b = first + 1;
        let c = first + side + 1;
        let d = first + side;
        if quad % 2 == 0 { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] }
    });
    mesh("patch", points, indices.collect())
}
