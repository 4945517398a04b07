//! Curved surfaces that the GPU tessellates: equal to the oracle, without cracks, and streamed into
//! a renderer that draws and culls them like any other mesh.

use std::collections::{BTreeSet, HashMap};

use cull::{Camera, CullView, ObjectId, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, DeviceOptions, OptionalFeature, Readback, vk};
use render::{
    FrameRequest, RenderView, Renderer, RendererOptions, ShaderSet, SpareCapacity,
    TessellationPath, Tessellator,
};
use scene::{
    Mesh, MeshId, Object, ObjectChange, Patch, PatchSurface, PreparedMesh, TessellationLevels,
    TessellationView, ellipsoid, tessellated, unpack_normal,
};
use tests::fault_injection::FaultInjection;
use tests::shapes::{box_at, box_scene};
use tests::walk::pixels_that_differ;
use tests::window_fixture::Random;
use tests::{Driver, instance_with, run, run_on_all};

const SIZE: [u32; 2] = [320, 240];
const COLOUR: u32 = 0x00_40_80_C0;

fn random_levels(surface: &PatchSurface, seed: u64) -> TessellationLevels {
    let mut random = Random::new(seed);
    let levels: Vec<u32> = surface.edges().iter().map(|_| 1 << random.below(7)).collect();
    TessellationLevels::from_edges(surface, &levels)
}

fn tessellator(device: &Device) -> Tessellator {
    Tessellator::new(device, &ShaderSet::embedded().unwrap()).unwrap()
}

/// Returns a tessellator for each path of a device.
fn tessellators(device: &Device) -> Vec<Tessellator> {
    let mut paths = vec![TessellationPath::Compute];
    if device.capabilities().has(OptionalFeature::TessellationCapture) {
        paths.push(TessellationPath::Hardware);
    }
    let shaders = ShaderSet::embedded().unwrap();
    paths.iter().map(|path| Tessellator::by_path(device, &shaders, *path).unwrap()).collect()
}

/// Returns the GPU's tessellation of a surface.
fn captured(
    device: &Device,
    tessellator: &mut Tessellator,
    surface: &PatchSurface,
    levels: &TessellationLevels,
) -> Mesh {
    assert!(tessellator.request(surface, levels, "ball", COLOUR).unwrap());
    assert!(!tessellator.request(surface, levels, "another", COLOUR).unwrap(), "one at a time");
    device.wait_idle().unwrap();
    let mesh = tessellator.finished().unwrap().expect("a mesh");
    assert_eq!(tessellator.finished().unwrap(), None, "a mesh is returned once");
    mesh
}

/// Checks that each edge has exactly two triangles, one per side, with bit-equal ends.
fn walk_seams(mesh: &Mesh) {
    let mut walked: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
    let place = |index: u32| mesh.vertices[index as usize].position.map(f32::to_bits);
    for triangle in mesh.indices.as_chunks::<3>().0 {
        for [a, b] in [[0, 1], [1, 2], [2, 0]] {
            *walked.entry([place(triangle[a]), place(triangle[b])]).or_default() += 1;
        }
    }
    for ([a, b], times) in &walked {
        assert_eq!((*times, walked.get(&[*b, *a])), (1, Some(&1)), "a crack");
    }
}

#[test]
fn the_gpu_agrees_with_the_oracle_and_leaves_no_crack() {
    run_on_all(|device| {
        let surface = ellipsoid(vec3(0.7, 1.3, 1.0)).unwrap();
        let shaders = ShaderSet::embedded().unwrap();
        let path = TessellationPath::Compute;
        let mut tessellator = Tessellator::by_path(device, &shaders, path).unwrap();
        assert_eq!(tessellator.path(), path);
        for seed in 0..6 {
            let levels = random_levels(&surface, seed);
            let mesh = captured(device, &mut tessellator, &surface, &levels);
            let oracle = tessellated(&surface, &levels, "ball", COLOUR);
            walk_seams(&mesh);
            assert!(surface.bounds().contains(&mesh.bounds));
            assert_eq!((&mesh.name, mesh.indices.len()), (&oracle.name, oracle.indices.len()));
            for (index, of_oracle) in mesh.indices.iter().zip(&oracle.indices) {
                let vertex = mesh.vertices[*index as usize];
                let expected = oracle.vertices[*of_oracle as usize];
                let place = Vec3::from_array(vertex.position);
                assert!(place.distance(Vec3::from_array(expected.position)) < 1e-6, "{place}");
                let normal = unpack_normal(vertex.normal);
                assert!(normal.distance(unpack_normal(expected.normal)) < 0.03, "{place}");
            }
        }
    });
}

/// Returns the positions of the vertices, as bits.
fn places(mesh: &Mesh) -> BTreeSet<[u32; 3]> {
    mesh.vertices.iter().map(|vertex| vertex.position.map(f32::to_bits)).collect()
}

/// Returns the volume of a closed mesh, which is negative if its triangles face inwards.
fn volume(mesh: &Mesh) -> f32 {
    let of_triangle = |corners: &[u32; 3]| {
        let [a, b, c] =
            corners.map(|corner| Vec3::from_array(mesh.vertices[corner as usize].position));
        a.dot(b.cross(c)) / 6.0
    };
    mesh.indices.as_chunks::<3>().0.iter().map(of_triangle).sum()
}

#[test]
fn tessellation_shaders_make_the_points_of_the_compute_pass_and_leave_no_crack() {
    run(Driver::Lavapipe, |device| {
        let half_axes = vec3(0.7, 1.3, 1.0);
        let surface = ellipsoid(half_axes).unwrap();
        assert_eq!(tessellator(device).path(), TessellationPath::Hardware);
        let [mut compute, mut hardware] = tessellators(device).try_into().ok().unwrap();
        let random = (0..6).map(|seed| random_levels(&surface, seed));
        let uniform = [1, 2, 64].map(|level| TessellationLevels::uniform(&surface, level));
        for levels in random.chain(uniform) {
            let expected = captured(device, &mut compute, &surface, &levels);
            let mesh = captured(device, &mut hardware, &surface, &levels);
            walk_seams(&mesh);
            assert!(surface.bounds().contains(&mesh.bounds));
            assert_eq!(mesh.triangles(), expected.triangles(), "{levels:?}");
            let differ = places(&mesh).symmetric_difference(&places(&expected)).count();
            assert_eq!(differ, 0, "{levels:?}");
            let volume_m3 = volume(&mesh);
            let expected_m3 = volume(&expected);
            assert!(expected_m3 > 0.0, "it faces outside");
            for vertex in &mesh.vertices {
                let place = Vec3::from_array(vertex.position);
                let exact = (place / (half_axes * half_axes)).normalize();
                assert!(unpack_normal(vertex.normal).dot(exact) > 0.95, "{place}");
            }
            let share = volume_m3 / expected_m3;
            // A quad is divided along either diagonal.
            assert!((0.8..1.25).contains(&share), "{volume_m3}, {expected_m3}, {levels:?}");
        }
    });
}

#[test]
fn a_device_without_tessellation_shaders_computes_and_refuses_the_other_path() {
    let hides: fn(&mut vk::PhysicalDeviceFeatures) =
        |features| features.tessellation_shader = vk::FALSE;
    let faults = FaultInjection { hides: Some(hides), ..FaultInjection::default() };
    let instance = instance_with(faults.entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let missing = OptionalFeature::TessellationCapture;
    assert!(!device.capabilities().has(missing));
    let mut tessellator = tessellator(&device);
    assert_eq!(tessellator.path(), TessellationPath::Compute);
    let surface = ellipsoid(Vec3::ONE).unwrap();
    let levels = random_levels(&surface, 7);
    walk_seams(&captured(&device, &mut tessellator, &surface, &levels));
    let shaders = ShaderSet::embedded().unwrap();
    let refused = Tessellator::by_path(&device, &shaders, TessellationPath::Hardware);
    let refused = refused.err().unwrap().to_string();
    assert!(refused.contains(missing.name()), "{refused}");
    drop(tessellator);
    drop(device);
    assert_eq!(instance.validation_log().drain(), []);
}

#[test]
fn a_surface_of_too_many_points_is_refused_before_it_takes_memory() {
    run(Driver::Lavapipe, |device| {
        let patch =
            Patch { control_points: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] };
        let points = (0..16).map(|point: u8| Vec3::splat(f32::from(point))).collect();
        let surface = PatchSurface::new(points, vec![patch; 4000]).unwrap();
        let finest = TessellationLevels::uniform(&surface, 64);
        let coarse = TessellationLevels::uniform(&surface, 1);
        for mut tessellator in tessellators(device) {
            let refused = tessellator.request(&surface, &finest, "many", COLOUR).unwrap_err();
            assert!(refused.to_string().contains("points of a curved surface"), "{refused}");
            assert!(tessellator.request(&surface, &coarse, "many", COLOUR).unwrap());
            device.wait_idle().unwrap();
            assert_eq!(tessellator.finished().unwrap().unwrap().triangles(), 8000);
        }
    });
}

/// A renderer with a curved object behind the edge of a wall, which is tessellated again as the
/// camera comes nearer.
struct Stage {
    renderer: Renderer,
    views: [RenderView; 2],
    images: [Readback; 2],
    shown: Option<(MeshId, ObjectId)>,
}

impl Stage {
    fn new(device: &Device) -> Self {
        let scene = box_scene(&[box_at(Vec3::ZERO, vec3(1.0, 1.0, 0.1))]);
        let spare = SpareCapacity {
            meshes: 2,
            vertices: 1 << 16,
            indices: 1 << 18,
            ..SpareCapacity::default()
        };
        let options =
            RendererOptions { size: SIZE, spare, spare_objects: 2, ..RendererOptions::default() };
        let renderer = Renderer::new(device, &scene, &options).unwrap();
        Self {
            views: [(); 2].map(|()| renderer.new_view().unwrap()),
            images: [(); 2].map(|()| Readback::new(device, SIZE).unwrap()),
            renderer,
            shown: None,
        }
    }

    /// Replaces the shown mesh.
    fn show(&mut self, mesh: Mesh, transform: Affine3A) {
        let mesh = PreparedMesh::new(mesh).unwrap();
        let [id] = self.renderer.add_meshes(vec![mesh]).unwrap()[..] else { panic!("one id") };
        let object = Object { mesh: id, transform, tint: u32::MAX };
        let added = self.renderer.update(&[ObjectChange::Add { object }]).unwrap().added[0];
        if let Some((old, object)) = self.shown.replace((id, added)) {
            self.renderer.update(&[ObjectChange::Remove { object }]).unwrap();
            self.renderer.remove_meshes(&[old]).unwrap();
        }
    }

    /// Returns the image, which is the same with and without culling.
    fn image(&mut self, camera: Camera) -> Vec<u8> {
        for _ in 0..6 {
            self.draw(0, Strategy::ANTUMBRA, camera);
        }
        self.draw(1, Strategy::FRUSTUM, camera);
        self.renderer.device().wait_idle().unwrap();
        let [culled, all] = self.images.each_ref().map(|image| image.rgba8().unwrap().to_vec());
        assert_eq!(pixels_that_differ(&culled, &all), 0);
        culled
    }

    fn draw(&mut self, number: usize, strategy: Strategy, camera: Camera) {
        let request = FrameRequest::new(strategy, camera);
        let request = FrameRequest { image: Some(&self.images[number]), ..request };
        self.renderer.render(&mut self.views[number], request).unwrap();
    }
}

#[test]
fn captured_surfaces_stream_into_a_renderer_and_cull_exactly() {
    run_on_all(|device| {
        for tessellator in tessellators(device) {
            stream(device, tessellator);
        }
    });
}

/// Streams a surface into a renderer as the camera comes nearer.
fn stream(device: &Device, mut tessellator: Tessellator) {
    let surface = ellipsoid(Vec3::splat(0.8)).unwrap();
    let transform = Affine3A::from_translation(vec3(0.9, 0.2, -1.5));
    let mut stage = Stage::new(device);
    let mut levels: Option<TessellationLevels> = None;
    let mut triangles = Vec::new();
    let mut images = Vec::new();
    for z in [30.0, 8.0, 3.0] {
        let projection = Projection::perspective(0.9);
        let eye = vec3(0.0, 0.3, z);
        let camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
        let view = CullView::new(&camera, SIZE, 8);
        let wanted = TessellationView::new(&view, &transform, 4.0);
        let now = TessellationLevels::new(&surface, &wanted, levels.as_ref());
        let mesh = captured(device, &mut tessellator, &surface, &now);
        triangles.push(mesh.triangles());
        levels = Some(now);
        let empty = stage.image(camera);
        stage.show(mesh, transform);
        let full = stage.image(camera);
        assert!(pixels_that_differ(&empty, &full) > 0, "the surface shows at {z} m");
        images.push(full);
    }
    assert!(triangles.is_sorted() && triangles[0] * 4 < triangles[2], "{triangles:?}");
    assert_ne!(images[0], images[2]);
}
