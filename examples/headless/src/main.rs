//! Draws a scene of its own without a window, and prints how much of it was drawn.
#![forbid(unsafe_code)]

use antumbra::glam::{Affine3A, Vec3, vec3};
use antumbra::scene::{Mesh, MeshId, Object};
use antumbra::{Camera, Renderer, RendererOptions, Scene};

const SIZE: [u32; 2] = [320, 180];

/// Returns a square of 2 m that faces +z.
fn square(name: &str, colour: [f32; 3]) -> Mesh {
    let a = [-1.0, -1.0, 0.0];
    let b = [1.0, -1.0, 0.0];
    let c = [1.0, 1.0, 0.0];
    let d = [-1.0, 1.0, 0.0];
    Mesh::of_triangles(name, &[a, b, c, a, c, d].map(|corner| (corner, colour)))
}

/// Returns a wall, a thousand hidden tiles behind it, and one tile that shows beside it.
fn scene() -> Scene {
    let object = |mesh: u32, scale: f32, at: Vec3| {
        let transform = Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::splat(scale));
        Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
    };
    let mut scene = Scene::single(square("wall", [0.6, 0.6, 0.5]));
    scene.meshes.push(square("tile", [0.8, 0.02, 0.02]));
    let tile = |number: u32| {
        let [x, y, z] = [number % 10, number / 10 % 10, number / 100].map(|part| part as f32);
        object(1, 0.04, vec3(x * 0.1 - 0.45, y * 0.1 - 0.45, -1.0 - z * 0.1))
    };
    scene.objects.extend((0..1000).map(tile));
    scene.objects.push(object(1, 0.2, vec3(2.0, 0.0, -1.0)));
    scene
}

fn main() -> antumbra::Result<()> {
    let options = RendererOptions { size: SIZE, ..Default::default() };
    let mut renderer = Renderer::headless(&scene()).options(options).build()?;
    let mut view = renderer.new_view()?;
    for frame in 0..30_u8 {
        let x = f32::from(frame) * 0.01;
        renderer.render(&mut view, Camera::look_at([x, 0.0, 3.0], [x, 0.0, 0.0]))?;
    }
    // Results of the last frames are on their way: this waits for them.
    let last = renderer.finish(&mut view)?;
    let pixels = last.image.pixels.chunks_exact(4);
    let red = pixels.filter(|pixel| pixel[0] / 2 > pixel[1]).count();
    println!("{} of 1002 objects drawn; {red} pixels of the tile beside the wall", last.drawn);
    Ok(())
}
