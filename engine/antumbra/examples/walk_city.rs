//! Walks down a street of a city of blocks, and prints the number of blocks that each frame drew.

use antumbra::glam::{Affine3A, Quat, vec3};
use antumbra::render::CostModel;
use antumbra::scene::{Mesh, Object};
use antumbra::{Camera, Renderer, RendererOptions, Scene};

/// The number of houses along each side of the city.
const SIDE: u16 = 50;

/// Returns a cube of 1 m.
fn cube() -> Mesh {
    let corner = |number: usize| [number & 1, number >> 1 & 1, number >> 2].map(|bit| bit as f32);
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let corners = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d].map(corner));
    Mesh::of_triangles("cube", &corners.map(|at| (at, [0.6, 0.5, 0.4])).collect::<Vec<_>>())
}

fn main() -> antumbra::Result<()> {
    let mut scene = Scene::single(cube());
    let first = scene.objects.remove(0);
    scene.objects.extend((0..SIDE.pow(2)).map(|number| {
        let [x, z] = [number % SIDE, number / SIDE].map(|place| f32::from(place) * 12.0);
        let size = vec3(10.0, 12.0 + (x * 0.7 + z * 1.3).sin() * 6.0, 10.0);
        let place = vec3(x + 1.0, 0.0, -z);
        Object {
            transform: Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, place),
            ..first
        }
    }));
    // Tests everything: on some devices, drawing 12 triangles is faster than a test.
    let options = RendererOptions { cost_model: CostModel::Off, ..Default::default() };
    let mut renderer = Renderer::headless(&scene).options(options).build()?;
    let mut view = renderer.new_view()?;
    for frame in 0..100_u8 {
        let z = -f32::from(frame);
        renderer.render(&mut view, Camera::look_at([300.0, 1.7, z], [300.0, 1.7, z - 1.0]))?;
        // The outcomes of the earlier frames that are known by now.
        for outcome in view.drain_stats().filter(|outcome| outcome.frame.0 % 10 == 0) {
            println!("frame {}: {} of {} houses", outcome.frame.0, outcome.draws, SIDE.pow(2));
        }
    }
    Ok(())
}
