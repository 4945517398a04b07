//! The depth pyramid strategy is exact on every device, culls, and never waits. The pyramid holds
//! the farthest depths.

use cull::{Camera, Strategy};
use glam::Vec3;
use gpu::{Access, Buffer, FrameRing, MemoryBarrier, MemoryKind, Target, vk};
use methods::{HzbLevel, HzbPass, hzb_levels};
use occlusion::{ProxyBox, Rect, ShaderSet};
use render::{Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::run_on_all;
use tests::shapes::{DepthBoxes, box_at, slivers, square_camera, square_view};
use tests::walk::{SceneKind, frame_loop, images_that_differ, walk_cameras_with};

fn options(size: [u32; 2], frames_in_flight: usize) -> RendererOptions {
    RendererOptions { methods: methods::all(), size, frames_in_flight, ..Default::default() }
}

#[test]
fn slivers_of_less_than_a_pixel_are_not_lost() {
    run_on_all(|device| {
        let scene = slivers(256);
        // Slightly rolled and moved, so that edges meet samples in many ways.
        let cameras: Vec<Camera> = (0..12)
            .map(|number| Camera {
                eye: Vec3::new(0.001 * number as f32, 0.0007 * number as f32, 0.0),
                up: Vec3::new(0.02 * number as f32, 1.0, 0.0),
                ..square_camera()
            })
            .collect();
        let options = options([256, 256], 2);
        let found = walk_cameras_with(device, &scene, &cameras, &options, methods::HZB);
        assert_eq!((found.pixels_wrong, found.blocking_waits), (0, 0), "{found:?}");
        assert!(found.draws[1] < found.draws[0], "{found:?}");
    });
}

#[test]
fn a_frame_tells_what_it_drew() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(600);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        let mut view = renderer.new_view().unwrap();
        let still = vec![path.camera(0); 6];
        let walked = frame_loop(&mut renderer, &mut view, methods::HZB, &still);
        let outcomes = &walked.outcomes;
        assert!(walked.reports.iter().all(|report| report.queries == 0));
        // Nothing is known in the first frame, and everything in later frames.
        assert_eq!(outcomes[0].revealed, outcomes[0].draws);
        assert!(outcomes[0].draws > 0 && outcomes[0].triangles > outcomes[0].draws);
        assert!(outcomes[2..].iter().all(|outcome| outcome.revealed == 0), "{outcomes:?}");
        assert!(outcomes[3].draws < outcomes[0].draws, "{outcomes:?}");
        let frames: Vec<u64> = outcomes.iter().map(|outcome| outcome.frame.0).collect();
        assert_eq!(frames, [1, 2, 3, 4, 5, 6]);
        // Another strategy in between: the view starts over.
        let other = frame_loop(&mut renderer, &mut view, Strategy::FRUSTUM, &still[..2]);
        let again = frame_loop(&mut renderer, &mut view, methods::HZB, &still[..2]);
        assert_eq!(again.outcomes[0].revealed, again.outcomes[0].draws);
        assert_eq!(again.outcomes[0].draws, outcomes[0].draws);
        assert_eq!(
            again.outcomes[1],
            render::FrameStats { frame: again.outcomes[1].frame, ..outcomes[1] }
        );
        let plain = &other.images[1];
        let ours = &again.images[1];
        assert_eq!(images_that_differ(plain, ours), 0);
        // A new view knows nothing.
        let mut fresh = renderer.new_view().unwrap();
        let seen = frame_loop(&mut renderer, &mut fresh, methods::HZB, &still[..1]);
        assert_eq!(seen.outcomes[0].revealed, outcomes[0].draws);
    });
}

#[test]
fn strategies_and_views_change_from_frame_to_frame() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(700);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 3)).unwrap();
        let mut views = [renderer.new_view().unwrap(), renderer.new_view().unwrap()];
        let mut plain = renderer.new_view().unwrap();
        for turn in 0..9 {
            let cameras: Vec<Camera> =
                (0..3).map(|frame| path.camera(turn as u32 * 7 + frame)).collect();
            let strategy = [methods::HZB, methods::HZB, Strategy::ANTUMBRA][turn % 3];
            let view = &mut views[(turn / 2) % 2];
            let expected = frame_loop(&mut renderer, &mut plain, Strategy::FRUSTUM, &cameras);
            let got = frame_loop(&mut renderer, view, strategy, &cameras);
            assert_eq!(got.outcomes.len(), cameras.len());
            for (expected, got) in expected.images.iter().zip(&got.images) {
                assert_eq!(images_that_differ(expected, got), 0, "turn {turn}");
            }
        }
    });
}

#[test]
fn passes_are_timed_by_their_labels() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = SceneKind::City.build(300);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options([160, 90], 2)).unwrap();
        renderer.time_passes().unwrap();
        let mut view = renderer.new_view().unwrap();
        let cameras: Vec<_> = (0..6).map(|frame| path.camera(frame)).collect();
        frame_loop(&mut renderer, &mut view, methods::HZB, &cameras);
        let labels: Vec<_> = renderer.pass_times().iter().map(|time| time.label).collect();
        let expected = [
            "cull remembered",
            "draw visible",
            "depth pyramid",
            "test boxes",
            "draw revealed",
            "copy results",
            "copy image",
        ];
        assert_eq!(labels, expected);
    });
}

/// Returns the farthest of the texels of `below` under texel (x, y) of the level above.
fn farthest(below: &[f32], size: [u32; 2], x: u32, y: u32) -> f32 {
    let [width, height] = size;
    let mut farthest = f32::INFINITY;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let x = 2 * x + dx;
        let y = 2 * y + dy;
        if x < width && y < height {
            farthest = farthest.min(below[(y * width + x) as usize]);
        }
    }
    farthest
}

#[test]
fn every_level_is_the_farthest_of_the_one_below() {
    run_on_all(|device| {
        let boxes_pass = DepthBoxes::new(device);
        let shaders = ShaderSet::embedded().unwrap();
        let boxes = (0..200).map(|number: u32| {
            let at = |step: u32| (number * step % 101) as f32 / 50.0 - 1.0;
            let centre = Vec3::new(at(37), at(59), -1.0) * (2.0 + (number % 23) as f32);
            ProxyBox::from(box_at(centre, Vec3::splat(0.05 + 0.02 * (number % 7) as f32)))
        });
        // Behind these boxes is one that fills every image.
        let wall = box_at(Vec3::new(0.0, 0.0, -60.0), Vec3::new(60.0, 60.0, 1.0));
        let boxes: Vec<ProxyBox> = boxes.chain([ProxyBox::from(wall)]).collect();
        for size in [[1, 1], [5, 1], [4, 9], [333, 7], [641, 363], [256, 256]] {
            let view = square_view(device, 64);
            let mut target = Target::new(device, size, "target").unwrap();
            let pyramid = HzbPass::new(device, &shaders, size).unwrap();
            let all = pyramid.depths();
            let levels: Vec<HzbLevel> = hzb_levels(size).collect();
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let readback =
                Buffer::new(device, "readback", all.size_bytes, usage, MemoryKind::ReadBack)
                    .unwrap();
            let mut ring = FrameRing::new(device, 2).unwrap();
            // A frame without boxes in between: nothing of the previous frame may stay.
            for count in [boxes.len() as u32, 0, boxes.len() as u32] {
                let mut frame = ring.begin().unwrap();
                let slice = frame.uploads().push(&boxes).unwrap();
                let commands = frame.commands();
                target.prepare(commands);
                commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
                    (0..count).for_each(|index| boxes_pass.draw(commands, slice, &view, index));
                });
                pyramid.record(commands, &mut target, Rect { origin: [0, 0], size });
                commands.copy_buffer(all, readback.whole());
                commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
                frame.submit(None).unwrap();
                device.wait_idle().unwrap();
                let depths = readback.read::<f32>(0..all.size_bytes as usize / 4);
                let level_texels = |number: usize| {
                    let level = levels[number];
                    let start = level.start as usize;
                    (level.size, &depths[start..start + (level.size[0] * level.size[1]) as usize])
                };
                assert_eq!(level_texels(0).0, size);
                let drawn = level_texels(0).1.iter().filter(|depth| **depth > 0.0).count();
                assert_eq!(drawn > 0, count > 0, "{size:?}");
                for number in 1..levels.len() {
                    let (below_size, below) = level_texels(number - 1);
                    let (level_size, level) = level_texels(number);
                    for (place, texel) in level.iter().enumerate() {
                        let x = place as u32 % level_size[0];
                        let y = place as u32 / level_size[0];
                        let expected = farthest(below, below_size, x, y);
                        assert_eq!(*texel, expected, "{size:?} level {number} at {x}, {y}");
                    }
                }
            }
        }
    });
}
