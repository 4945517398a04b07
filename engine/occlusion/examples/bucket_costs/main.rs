//! Prints the costs of drawing in 1, 16 and 256 buckets: CPU time per frame, and memory per object
//! on the CPU and on the GPU. Arguments: the number of objects and the number of frames.

mod boxes;

use std::alloc::System;
use std::error::Error;
use std::time::{Duration, Instant};

use antumbra_occlusion::{
    BucketDraw, BucketId, CulledScene, CulledSceneOptions, HostObject, LeafTable, ObjectRenderer,
    ShaderSet,
};
use boxes::{Boxes, INDICES};
use cap::Cap;
use cull::{Aabb, Camera, CullView, Projection};
use glam::{Vec3, vec3};
use gpu::{Device, FrameRing, IndirectDraw};

/// The allocator, which counts the bytes in use.
#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

/// The costs of drawing in a number of buckets.
struct BucketCosts {
    /// The sorted times of planning and recording, per frame.
    frame_times: Vec<Duration>,
    /// The time that adding all objects took.
    added: Duration,
    /// Memory per object in bytes, on the CPU and on the GPU.
    bytes: [u64; 2],
}

/// Returns a street of walls with boxes between them.
fn bounds(count: usize) -> Vec<Aabb> {
    let place = |number: usize| {
        let [row, column] = [number / 100, number % 100].map(|part| part as f32);
        let low = vec3(column * 2.0 - 100.0, 0.0, -3.0 * row - 4.0);
        let height = if number.is_multiple_of(3) { 9.0 } else { 1.0 };
        Aabb::new(low, low + vec3(1.9, height, 0.8))
    };
    (0..count).map(place).collect()
}

/// Returns the bytes of a table per object, with two copies of its draws for one view.
fn bytes_per_object(leaves: &LeafTable, objects: usize) -> u64 {
    let draws = leaves.predicates().draws().size_bytes;
    let links = leaves.links().map_or(0, |links| links.firsts.size_bytes + links.links.size_bytes);
    (3 * draws + links + leaves.boxes().size_bytes) / objects.max(1) as u64
}

fn main() -> Result<(), Box<dyn Error>> {
    let number = |place| std::env::args().nth(place).and_then(|text| text.parse::<usize>().ok());
    let objects = number(1).unwrap_or(10_000);
    let frames = number(2).unwrap_or(60);
    let device = gpu::open()?;
    println!("buckets  median CPU ms per frame  ms to add all  bytes per object: CPU    GPU");
    for bucket_count in [1, 16, 256] {
        let costs = measure(&device, bucket_count, objects, frames)?;
        let median_ms = 1e3 * costs.frame_times[costs.frame_times.len() / 2].as_secs_f64();
        let added_ms = 1e3 * costs.added.as_secs_f64();
        let [cpu, gpu] = costs.bytes;
        println!("{bucket_count:7}  {median_ms:23.3}  {added_ms:13.1}  {cpu:21}  {gpu:5}");
    }
    Ok(())
}

/// Draws frames of a walk along the street.
fn measure(
    device: &Device,
    bucket_count: u32,
    objects: usize,
    frames: usize,
) -> Result<BucketCosts, Box<dyn Error>> {
    let shaders = ShaderSet::embedded()?;
    let options = CulledSceneOptions {
        object_capacity: objects,
        draw_capacity: objects as u32,
        bucket_count,
        ..Default::default()
    };
    let bounds = bounds(objects);
    let mut owner = Boxes::new(device, &shaders, &bounds)?;
    let draw = IndirectDraw { index_count: INDICES, instance_count: 1, ..Default::default() };
    let draws: Vec<BucketDraw> = (0..objects as u32)
        .map(|number| BucketDraw {
            bucket: BucketId(number.wrapping_mul(2_654_435_761) >> 16 & (bucket_count - 1)),
            draw: IndirectDraw { first_instance: number, ..draw },
            triangles: INDICES / 3,
        })
        .collect();
    let host_objects = bounds.iter().zip(draws.chunks(1));
    let host_objects: Vec<HostObject<'_>> =
        host_objects.map(|(bounds, draws)| HostObject { bounds: *bounds, draws }).collect();
    let used = HEAP.allocated();
    let mut scene = CulledScene::new(device, owner.target().attachments(), &options)?;
    let begun = Instant::now();
    scene.add(&host_objects, &mut Vec::new())?;
    let added = begun.elapsed();
    let mut state = scene.new_view(owner.target())?;
    let mut ring = FrameRing::new(device, 2)?;
    let mut frame_times = Vec::with_capacity(frames);
    for step in 0..frames {
        let eye = vec3(step as f32 * 0.05, 1.7, 3.0);
        let projection = Projection::perspective(0.9);
        let camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 };
        let view = CullView::new(
            &camera,
            owner.target().size(),
            device.adapter().limits.sub_pixel_precision_bits,
        );
        let frame = ring.begin()?;
        let begun = Instant::now();
        let mut scope = scene.begin(frame)?;
        scope.draw(&mut state, &view, &mut owner)?;
        frame_times.push(begun.elapsed());
        scope.submit(None)?;
    }
    frame_times.sort_unstable();
    device.wait_idle()?;
    let cpu = HEAP.allocated().saturating_sub(used) / objects.max(1);
    let gpu = bytes_per_object(scene.leaves(), objects);
    Ok(BucketCosts { frame_times, added, bytes: [cpu as u64, gpu] })
}
