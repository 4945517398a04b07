//! A renderer without enough memory is refused with an error, and the process goes on: one test in
//! a process, whose allocator has a limit. Allocations of drivers are not counted.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::alloc::System;

use cap::Cap;
use render::{Costs, Error, Renderer, RendererOptions};
use scene::{Material, MaterialId, Mesh, Scene, Surfaces};
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

#[test]
fn a_scene_that_there_is_no_memory_for_is_refused() {
    run(Driver::Lavapipe, |device| {
        let options =
            RendererOptions { size: [64, 64], costs: Costs::Ignored, ..Default::default() };
        // 20 bytes a vertex, 4 an index, and 40 for what a vertex looks like.
        let cases = [
            (scene(1_000_000), 40, "the vertices of all meshes"),
            (with_surfaces(scene(1_000_000)), 90, "what the vertices of all meshes look like"),
        ];
        for (scene, free_mib, expected) in cases {
            ALLOCATOR.set_limit(ALLOCATOR.allocated() + free_mib * MIB).unwrap();
            let refused = Renderer::new(device, &scene, &options).map(drop);
            ALLOCATOR.set_limit(usize::MAX).unwrap();
            let refused = refused.unwrap_err();
            let Error::NoMemory { what, .. } = &refused else { panic!("{refused}") };
            assert_eq!(*what, expected);
            Renderer::new(device, &scene, &options).unwrap();
        }
    });
}
