//! The copied depth of a pixel with several samples: the farthest sample, if any sample is behind
//! an edge.

use cull::{Camera, CullView};
use glam::{Vec2, Vec3, vec2, vec3};
use gpu::{Access, Buffer, Device, FrameRing, MemoryBarrier, MemoryKind, SampleCount, Target, vk};
use occlusion::ProxyBox;
use tests::run_on_all;
use tests::shapes::{DepthBoxes, square_camera};

const SIDE: u32 = 64;

/// The positions of four samples in a pixel (Vulkan, "Multisampling", `standardSampleLocations`).
const PLACES: [[f32; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Copies the depth of a wall, ten metres away, that fills the left of the image of a rolled
/// camera. The image begins at `origin`.
fn copied(device: &Device, view: &CullView, origin: [u32; 2], size: [u32; 2]) -> Vec<f32> {
    let samples = SampleCount::Four;
    let mut target = Target::multisampled(device, [SIDE; 2], samples, "samples").unwrap();
    assert!(target.can_copy_depth() && target.needs_resolve());
    let walls = DepthBoxes::of(device, target.attachments());
    let wall = ProxyBox::from(cull::Aabb::new(vec3(-40.0, -40.0, -11.0), vec3(0.0, 40.0, -10.0)));
    let size_bytes = u64::from(size[0] * size[1]) * 4;
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::TRANSFER_DST
        | vk::BufferUsageFlags::TRANSFER_SRC;
    let depths = Buffer::new(device, "depths", size_bytes, usage, MemoryKind::Device).unwrap();
    let to = vk::BufferUsageFlags::TRANSFER_DST;
    let readback = Buffer::new(device, "readback", size_bytes, to, MemoryKind::ReadBack).unwrap();
    let mut ring = FrameRing::new(device, 2).unwrap();
    let mut frame = ring.begin().unwrap();
    let boxes = frame.uploads().push(&[wall]).unwrap();
    let commands = frame.commands();
    target.prepare(commands);
    commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
        walls.draw(commands, boxes, view, 0);
    });
    target.copy_depth_to(commands, origin, size, depths.whole());
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::CopyRead]));
    commands.copy_buffer(depths.whole(), readback.whole());
    commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    frame.submit(None).unwrap();
    device.wait_idle().unwrap();
    readback.read::<f32>(0..(size[0] * size[1]) as usize).to_vec()
}

#[test]
fn a_pixel_is_as_far_as_its_farthest_sample() {
    run_on_all(|device| {
        assert_eq!(device.adapter().limits.standard_sample_locations, vk::TRUE);
        let camera = Camera { up: Vec3::new(0.37, 1.0, 0.0), ..square_camera() };
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(&camera, [SIDE; 2], bits);
        let across = view.view_proj * vec3(1.0, 0.0, -10.0).extend(1.0);
        let out = vec2(across.x, across.y).normalize();
        let middle = Vec2::splat(SIDE as f32 * 0.5);
        let origin = [3, 5];
        let size = [SIDE - 7, SIDE - 11];
        let depths = copied(device, &view, origin, size);
        let mut covered = 0;
        let mut mixed = 0;
        for (number, depth) in depths.iter().enumerate() {
            let at = [number as u32 % size[0] + origin[0], number as u32 / size[0] + origin[1]];
            let from_edge = PLACES.map(|place| {
                (Vec2::from(at.map(|side| side as f32)) + Vec2::from(place) - middle).dot(out)
            });
            // Snapping moves vertices by up to a 32nd of a pixel in both directions.
            if from_edge.iter().any(|distance| distance.abs() < 0.05) {
                continue;
            }
            let outside = from_edge.iter().filter(|distance| **distance > 0.0).count();
            let expected = if outside == 0 { 0.01 } else { 0.0 };
            assert!((depth - expected).abs() < 1.0e-5, "{at:?}: {depth}, {outside} are outside");
            covered += u32::from(outside == 0);
            mixed += u32::from((1..4).contains(&outside));
        }
        assert!(covered > 500 && mixed > 30, "{covered} {mixed}");
    });
}
