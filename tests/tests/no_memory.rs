//! The creation of a renderer without enough memory returns an error, and the process goes on. The
//! process has a single test, and an allocator with a limit. Allocations of drivers are not
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
use cull::HierarchyError;
use render::{CostModel, Error, Renderer, RendererOptions};
use scene::{Material, MaterialId, Mesh, Object, Scene, Surfaces};
use tests::shapes::surface_of;
use tests::{Driver, run};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const MIB: usize = 1 << 20;

fn scene(triangles: usize) -> Scene {
    let corners = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|at| (at, [1.0; 3]));
    Scene::single(Mesh::of_triangles("many", &corners.repeat(triangles)))
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
