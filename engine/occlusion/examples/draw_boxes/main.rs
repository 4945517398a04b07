//! Walks past a wall with a thousand boxes behind it, drawn by a pipeline of the example's own, and
//! prints how many boxes the GPU drew.

mod boxes;

use std::error::Error;

use antumbra_occlusion::{
    BucketDraw, BucketId, CulledScene, CulledSceneOptions, HostObject, ObjectRenderer, ShaderSet,
};
use boxes::{Boxes, INDICES};
use cull::{Aabb, Camera, CullView, Projection};
use glam::{Vec3, vec3};
use gpu::{FrameRing, IndirectDraw};

/// Returns a wall and a thousand boxes, some of which show beside it.
fn bounds() -> Vec<Aabb> {
    let wall = Aabb::new(vec3(-4.0, -3.0, -6.0), vec3(4.0, 3.0, -5.5));
    let small = (0..1000).map(|number| {
        let [x, y, z] = [number % 20, number / 20 % 10, number / 200].map(|part| part as f32);
        let low = vec3(x * 0.7 - 7.0, y * 0.7 - 3.5, -12.0 - z * 1.3);
        Aabb::new(low, low + 0.45)
    });
    std::iter::once(wall).chain(small).collect()
}

/// Returns the draw of a box, whose instance is its number.
fn draw(number: u32) -> [BucketDraw; 1] {
    let draw = IndirectDraw {
        index_count: INDICES,
        instance_count: 1,
        first_instance: number,
        ..Default::default()
    };
    [BucketDraw { bucket: BucketId(0), draw, triangles: INDICES / 3 }]
}

fn main() -> Result<(), Box<dyn Error>> {
    let device = gpu::open()?;
    let shaders = ShaderSet::embedded()?;
    let bounds = bounds();
    let mut objects = Boxes::new(&device, &shaders, &bounds)?;
    let size = objects.target().size();
    let options = CulledSceneOptions {
        object_capacity: bounds.len(),
        draw_capacity: bounds.len() as u32,
        ..Default::default()
    };
    let mut scene = CulledScene::new(&device, objects.target().attachments(), &options)?;
    for (number, bounds) in (0..).zip(&bounds) {
        let object = HostObject { bounds: *bounds, draws: &draw(number) };
        scene.add(&[object], &mut Vec::new())?;
    }
    let mut state = scene.new_view(objects.target())?;
    let mut frames = FrameRing::new(&device, 2)?;
    for step in 0..40_u8 {
        let eye = vec3(f32::from(step) * 0.1, 0.0, 3.0);
        let camera = Camera {
            eye,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(0.9),
            near: 0.1,
        };
        let view = CullView::new(&camera, size, device.adapter().limits.sub_pixel_precision_bits);
        let mut scope = scene.begin(frames.begin()?)?;
        scope.draw(&mut state, &view, &mut objects)?;
        scope.submit(None)?;
        // The outcomes of earlier frames, which are known by now.
        for outcome in state.drain_stats().filter(|outcome| outcome.frame.0 % 8 == 0) {
            println!("frame {}: {} of 1001 boxes drawn", outcome.frame.0, outcome.draws);
        }
    }
    Ok(())
}
