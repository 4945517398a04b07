//! The creation of a renderer without enough memory returns an error, and the process goes on. The
//! process has an allocator with a limit, and its tests take turns. Allocations of drivers are not
//! counted.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::alloc::System;

use cap::Cap;
use cull::{HierarchyError, ObjectId, SectionMode, SectionPlane, SectionPlanes};
use glam::{Affine3A, DVec3};
use render::{CostModel, Error, Renderer, RendererOptions};
use scene::{Material, MaterialId, Mesh, Object, ObjectChange, Scene, Surfaces};
use tests::shapes::surface_of;
use tests::{Driver, run};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const MIB: usize = 1 << 20;

/// The objects of a scene with large lists.
const OBJECTS: u32 = 20_000;
/// The objects that come.
const MORE_OBJECTS: usize = 8_000;

fn scene(triangles: usize) -> Scene {
    let corners = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|at| (at, [1.0; 3]));
    Scene::single(Mesh::of_triangles("many", &corners.repeat(triangles)))
}

/// Returns a mesh of triangles that share no corner, the most that its edges can be.
fn plates(triangles: u16) -> Mesh {
    let corners = (0..triangles).flat_map(|level| {
        let y = f32::from(level);
        [[-1.0, y, 0.0], [1.0, y, 0.0], [0.0, y, 1.0]].map(|at| (at, [1.0; 3]))
    });
    Mesh::of_triangles("plates", &corners.collect::<Vec<_>>())
}

fn with_surfaces(scene: Scene) -> Scene {
    let meshes = scene.meshes.iter().map(|mesh| surface_of(mesh, MaterialId(0))).collect();
    let materials = vec![Material::default()];
    Scene { surfaces: Some(Surfaces { meshes, materials, ..Surfaces::default() }), ..scene }
}

fn with_objects(scene: Scene, count: usize) -> Scene {
    let objects: Vec<Object> = scene.objects.iter().copied().cycle().take(count).collect();
    Scene { objects, ..scene }
}

#[test]
fn a_scene_that_there_is_no_memory_for_is_refused() {
    run(Driver::Lavapipe, |device| {
        let options =
            RendererOptions { size: [64, 64], cost_model: CostModel::Off, ..Default::default() };
        // 20 bytes per vertex, 4 per index, and 40 for the surface of a vertex.
        let cases = [
            (scene(1_000_000), 40, "the vertices of all meshes"),
            (with_surfaces(scene(1_000_000)), 90, "what the vertices of all meshes look like"),
        ];
        for (scene, free_mib, expected) in cases {
            let refused = with_free_mib(free_mib, || Renderer::new(device, &scene, &options));
            let refused = refused.map(drop).unwrap_err();
            let Error::NoMemory { what, .. } = &refused else { panic!("{refused}") };
            assert_eq!(*what, expected);
            Renderer::new(device, &scene, &options).unwrap();
        }
        // 296 bytes per object while the hierarchy is built, and 20 per node for each view.
        let many = with_objects(scene(1), 200_000);
        let refused = with_free_mib(30, || Renderer::new(device, &many, &options));
        assert_no_memory_to_cull(refused.map(drop), 57);
        let renderer = Renderer::new(device, &many, &options).unwrap();
        assert_no_memory_to_cull(with_free_mib(4, || renderer.new_view()).map(drop), 8);
        renderer.new_view().unwrap();
    });
}

/// The free memory of the lowest limit: room for what is small, whatever the scene.
const SMALL_KIB: usize = 1_024;

/// The free memory of the highest limit, many times what any call here needs.
const MOST_KIB: usize = 256 << 10;

/// The difference between two limits.
const STEP_KIB: usize = 96;

/// Returns the result of a call at the first of rising limits at which it succeeds. At each limit
/// below it is refused; a call that asks too late aborts this process.
fn at_rising_limits<T>(what: &str, call: impl FnMut() -> Result<T, Error>) -> T {
    at_limits(what, STEP_KIB, call)
}

/// Returns the result of a call as [`at_rising_limits`] does, with this difference between two
/// limits.
fn at_limits<T>(what: &str, step_kib: usize, mut call: impl FnMut() -> Result<T, Error>) -> T {
    for free_kib in (SMALL_KIB..MOST_KIB).step_by(step_kib) {
        println!("{what} with {free_kib} KiB");
        ALLOCATOR.set_limit(ALLOCATOR.allocated() + free_kib * 1_024).unwrap();
        let done = call();
        ALLOCATOR.set_limit(usize::MAX).unwrap();
        match done {
            Ok(done) => {
                assert!(free_kib > SMALL_KIB, "{what} was never refused");
                return done;
            }
            Err(Error::NoMemory { .. } | Error::Hierarchy(HierarchyError::NoMemory { .. })) => {}
            Err(error) => panic!("{what} with {free_kib} KiB: {error}"),
        }
    }
    panic!("{what} is still refused with {MOST_KIB} KiB");
}

#[test]
fn at_every_limit_a_call_is_refused_or_succeeds() {
    run(Driver::Lavapipe, |device| {
        let scene = scenes::city(OBJECTS, 7).unwrap().scene;
        let options = RendererOptions {
            size: [64, 36],
            cost_model: CostModel::Off,
            spare_objects: MORE_OBJECTS,
            ..Default::default()
        };
        let mut renderer =
            at_rising_limits("a renderer", || Renderer::new(device, &scene, &options));
        at_rising_limits("a view", || renderer.new_view());
        let aside = |was: &Object| Affine3A::from_translation(glam::Vec3::Y) * was.transform;
        let objects = &scene.objects[..MORE_OBJECTS];
        let copies = objects.iter().map(|was| Object { transform: aside(was), ..*was });
        let add: Vec<ObjectChange> = copies.map(|object| ObjectChange::Add { object }).collect();
        let added = at_rising_limits("objects that come", || renderer.update(&add)).added;
        let ids = (0..).map(ObjectId);
        let moves = ids.zip(objects).map(|(object, was)| {
            let transform = aside(was);
            ObjectChange::Move { object, transform }
        });
        let moves: Vec<ObjectChange> = moves.collect();
        at_rising_limits("objects that move", || renderer.update(&moves));
        let gone = added.iter().map(|object| ObjectChange::Remove { object: *object });
        let gone: Vec<ObjectChange> = gone.collect();
        at_rising_limits("objects that go", || renderer.update(&gone));
        at_rising_limits("another hierarchy", || renderer.rebuild_hierarchy());
        let plane = SectionPlane::new(DVec3::X, 0.0).unwrap();
        let planes = SectionPlanes::new(&[plane], SectionMode::Union).unwrap();
        at_rising_limits("section planes", || renderer.set_section(planes));
        let plates = Scene::single(plates(60_000));
        let mut renderer = Renderer::new(device, &plates, &options).unwrap();
        at_limits("planes and a large mesh", 1_024, || renderer.set_section(planes));
    });
}

/// Returns the result of `make` with a limit of free memory.
fn with_free_mib<T>(free_mib: usize, make: impl FnOnce() -> T) -> T {
    ALLOCATOR.set_limit(ALLOCATOR.allocated() + free_mib * MIB).unwrap();
    let made = make();
    ALLOCATOR.set_limit(usize::MAX).unwrap();
    made
}

fn assert_no_memory_to_cull(refused: Result<(), Error>, wanted_mib: usize) {
    let refused = refused.unwrap_err();
    let Error::Hierarchy(HierarchyError::NoMemory { count, size_bytes }) = refused else {
        panic!("{refused}")
    };
    assert_eq!((count, size_bytes.div_ceil(MIB)), (200_000, wanted_mib));
}
