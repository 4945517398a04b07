//! The costs of updates depend on the changes, in time and in memory.

use cull::{ObjectId, Strategy};
use glam::{Affine3A, Vec3};
use gpu::Readback;
use render::Renderer;
use scene::ObjectChange;
use scenes::{Cast, PathKind};
use tests::shapes::square_camera;
use tests::walk::{SceneKind, show_motion};
use tests::{Driver, run, run_on_all};

use super::{Moving, SIZE, options, render};

#[test]
fn an_update_costs_what_changed_and_not_what_there_is() {
    run(Driver::Lavapipe, |device| {
        for objects in [1_000, 8_000] {
            let scene = SceneKind::Field.build(objects).scene;
            let mut renderer = Renderer::new(device, &scene, &options(2)).unwrap();
            let mut view = renderer.new_view().unwrap();
            let image = Readback::new(device, SIZE).unwrap();
            let camera = square_camera();
            for moved in [1_usize, 10, 100] {
                let lifted = |frame: usize| {
                    let lift = Affine3A::from_translation(Vec3::Y * (0.1 + frame as f32 * 0.01));
                    let step = objects as usize / moved;
                    let change = |n: usize| ObjectChange::Move {
                        object: ObjectId((n * step) as u32),
                        transform: lift * scene.objects[n * step].transform,
                    };
                    (0..moved).map(change).collect::<Vec<_>>()
                };
                for frame in 0..4 {
                    let report = renderer.update(&lifted(frame)).unwrap();
                    let levels = u64::from(2 * objects.ilog2());
                    assert_eq!(report.dirty_leaves, moved);
                    assert!(report.refitted_nodes <= moved as u64 * levels, "{report:?}");
                    assert_eq!(report.rebuilt_leaves, 0);
                    assert!(report.added.is_empty() && !report.is_degraded);
                    render(&mut renderer, &mut view, Strategy::ANTUMBRA, camera, &image);
                }
            }
            // Without changes nothing is uploaded.
            assert_eq!(renderer.update(&[]).unwrap().dirty_leaves, 0);
            device.wait_idle().unwrap();
        }
    });
}

#[test]
fn memory_does_not_grow_while_objects_come_and_go() {
    run_on_all(|device| {
        let moving = Moving::new(SceneKind::City.build(600), PathKind::Street, 100);
        let mut renderer = Renderer::new(device, &moving.scene, &options(2)).unwrap();
        let mut cast = Cast::new(&moving.motion);
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        let mut bytes = Vec::new();
        for frame in 0..90 {
            show_motion(&mut renderer, &moving.motion, &mut cast, frame).unwrap();
            let camera = moving.path.camera(0);
            render(&mut renderer, &mut view, Strategy::ANTUMBRA, camera, &image);
            bytes.push(device.memory_use().used_bytes);
        }
        device.wait_idle().unwrap();
        assert_eq!(bytes[30], bytes[89], "{bytes:?}");
    });
}
