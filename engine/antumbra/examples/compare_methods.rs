//! Walks past a wall with a field of tiles behind it by every method. Prints the draws, tests and
//! waits of a frame by each.

use std::error::Error;

use antumbra::glam::{Affine3A, Vec3, vec3};
use antumbra::render::{CostModel, Rect};
use antumbra::scene::{Mesh, MeshId, Object};
use antumbra::{Camera, FrameRequest, Projection, Renderer, RendererOptions, Scene};

const SIZE: [u32; 2] = [640, 360];

/// Returns a square of 2 m that faces +z.
fn square(name: &str) -> Mesh {
    let a = [-1.0, -1.0, 0.0];
    let b = [1.0, -1.0, 0.0];
    let c = [1.0, 1.0, 0.0];
    let d = [-1.0, 1.0, 0.0];
    Mesh::of_triangles(name, &[a, b, c, a, c, d].map(|corner| (corner, [0.6; 3])))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::single(square("wall"));
    scene.meshes.push(square("tile"));
    scene.objects.extend((0..400_u16).map(|number| {
        let at = vec3(f32::from(number % 20) * 0.2 - 2.0, 0.0, -1.0 - f32::from(number / 20));
        let transform = Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::splat(0.08));
        Object { mesh: MeshId(1), transform, tint: u32::MAX }
    }));
    let device = antumbra::open()?;
    // Tests everything, since tests hardly ever pay with this number of triangles.
    let methods = antumbra::methods::all();
    let cost_model = CostModel::Off;
    let options = RendererOptions { size: SIZE, methods, cost_model, ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options)?;
    println!("{:18} {:>6} {:>6} {:>6}", "", "draws", "tests", "waits");
    for strategy in antumbra::methods::strategies() {
        if let Err(error) = renderer.supports(strategy) {
            println!("{strategy}: {error}");
            continue;
        }
        let mut view = renderer.new_view()?;
        let mut beforehand = renderer.new_view()?;
        let mut tests = 0;
        let mut waits = 0;
        for step in 0..20_u8 {
            let eye = vec3(f32::from(step) * 0.02, 0.0, 3.0);
            let camera = Camera {
                eye,
                forward: Vec3::NEG_Z,
                up: Vec3::Y,
                projection: Projection::perspective(0.9),
                near: 0.1,
            };
            // For the ideal method, which draws the known visible objects.
            let known = renderer.visible_set(&mut beforehand, camera, Rect::whole(SIZE))?;
            let request = FrameRequest::new(strategy, camera);
            let request = FrameRequest { visible: Some(&known), ..request };
            let report = renderer.render(&mut view, request)?;
            (tests, waits) = (report.tests, report.waits);
        }
        renderer.wait_idle(&mut view)?;
        let draws = view.drain_stats().next_back().map_or(0, |outcome| outcome.draws);
        println!("{:18} {draws:6} {tests:6} {waits:6}", strategy.name());
    }
    Ok(())
}
