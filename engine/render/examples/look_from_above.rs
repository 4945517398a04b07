//! Draws a wall and a field of tiles behind it, and moves the wall aside. Explains the decision
//! about a tile before and after, and saves the view from above: `look_from_above [FILE.png]`.

use std::error::Error;

use antumbra_render::{CostModel, FrameRequest, Renderer, RendererOptions};
use cull::{Camera, Decision, ObjectId, Projection, Strategy};
use glam::{Affine3A, Vec3, vec3};
use scene::{Mesh, MeshId, Object, ObjectChange, Scene, SceneUpdate};

/// Returns a square of 2 m that faces +z.
fn square(name: &str, colour: [f32; 3]) -> Mesh {
    let a = [-1.0, -1.0, 0.0];
    let b = [1.0, -1.0, 0.0];
    let c = [1.0, 1.0, 0.0];
    let d = [-1.0, 1.0, 0.0];
    Mesh::of_triangles(name, &[a, b, c, a, c, d].map(|corner| (corner, colour)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::single(square("wall", [0.6, 0.6, 0.5]));
    scene.meshes.push(square("tile", [0.8, 0.1, 0.1]));
    scene.objects.extend((0..400_u16).map(|number| {
        let at = vec3(f32::from(number % 20) * 0.1 - 1.0, 0.0, -1.0 - f32::from(number / 20) * 0.2);
        let transform = Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::splat(0.04));
        Object { mesh: MeshId(1), transform, tint: u32::MAX }
    }));
    let device = gpu::open()?;
    // Tests everything: on some devices, drawing 2 triangles is faster than a test.
    let size = [640, 360];
    let cost_model = CostModel::Off;
    let options = RendererOptions { size, cost_model, ..Default::default() };
    let mut renderer = Renderer::new(&device, &scene, &options)?;
    let mut view = renderer.new_view()?;
    let camera = Camera {
        eye: Vec3::Z * 3.0,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
        near: 0.1,
    };
    for aside in [0.0, 1.2] {
        let transform = Affine3A::from_translation(Vec3::X * aside);
        let moved = ObjectChange::Move { object: ObjectId(0), transform };
        renderer.apply(&SceneUpdate { objects: vec![moved], ..Default::default() })?;
        for _ in 0..20 {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera))?;
        }
        renderer.wait_idle(&mut view)?;
        let drawn = view.drain_stats().next_back().map_or(0, |outcome| outcome.draws);
        println!("wall at {aside} m: {drawn} of 401 objects drawn");
        let tile = renderer.explain_object(&view, &renderer.view_of(&camera), ObjectId(1));
        match tile.ok_or("the scene has no tile")?.0.decision {
            Decision::Tested { leaves, .. } => println!("tile 1: one test for {leaves} tiles"),
            decision => println!("tile 1: {decision:?}"),
        }
    }
    let snapshot = renderer.snapshot(&mut view, renderer.view_of(&camera))?;
    let image = gpu::Readback::new(&device, renderer.size())?;
    renderer.top_down(&snapshot, &image)?;
    let file = std::env::args().nth(1).unwrap_or_else(|| "from_above.png".to_owned());
    let [width, height] = renderer.size();
    let mut png = png::Encoder::new(std::fs::File::create(&file)?, width, height);
    png.set_color(png::ColorType::Rgba);
    png.write_header()?.write_image_data(&image.rgba8()?)?;
    println!("{file}: {} hidden boxes", snapshot.hidden.len());
    Ok(())
}
