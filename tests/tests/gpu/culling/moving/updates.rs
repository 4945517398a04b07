//! Updates are applied whole or not at all.

use cull::{Aabb, ObjectId, Strategy};
use glam::{Affine3A, Vec3};
use gpu::Readback;
use render::{ChangeError, Error, Renderer, RendererOptions, UpdateReport};
use scene::{MeshId, Object, ObjectChange, pack_unorm};
use scenes::{Cast, PathKind};
use tests::shapes::{box_scene, square_camera};
use tests::walk::{SceneKind, show_motion};
use tests::{Driver, run};

use super::{Moving, SIZE, options, render, wall_and_crowd};

/// Returns the box of every object, empty where there is none.
fn boxes(renderer: &Renderer) -> Vec<Aabb> {
    let hierarchy = renderer.hierarchy();
    let ids = (0..hierarchy.leaf_objects().len() as u32).map(ObjectId);
    ids.map(|id| hierarchy.node_of(id).map_or(Aabb::EMPTY, |node| hierarchy.bounds(node))).collect()
}

#[test]
fn a_motion_that_could_not_be_shown_is_shown_later() {
    run(Driver::Lavapipe, |device| {
        let moving = Moving::new(SceneKind::City.build(300), PathKind::Street, 100);
        let mut renderer = Renderer::new(device, &moving.scene, &options(2)).unwrap();
        let mut cast = Cast::new(&moving.motion);
        // Another object takes the room of an object that will return.
        let away = |frame| {
            moving.scene.objects.len() - moving.motion.scene_at(&moving.scene, frame).objects.len()
        };
        let fewest = (0..200).min_by_key(|frame| away(*frame)).unwrap();
        let most = (0..200).max_by_key(|frame| away(*frame)).unwrap();
        assert!(away(most) > away(fewest), "nobody comes and goes");
        show_motion(&mut renderer, &moving.motion, &mut cast, most).unwrap();
        let add = ObjectChange::Add { object: moving.scene.objects[0] };
        let intruders = renderer.update(&vec![add; away(most)]).unwrap().added;
        let refused = show_motion(&mut renderer, &moving.motion, &mut cast, fewest).unwrap_err();
        let names = ["no free leaf", "`RendererOptions::spare_objects`"];
        assert!(names.iter().all(|name| refused.to_string().contains(name)), "{refused}");
        let gone = |object: &ObjectId| ObjectChange::Remove { object: *object };
        renderer.update(&intruders.iter().map(gone).collect::<Vec<_>>()).unwrap();
        for frame in [fewest, most, fewest] {
            show_motion(&mut renderer, &moving.motion, &mut cast, frame).unwrap();
            let there = boxes(&renderer).iter().filter(|bounds| !bounds.is_empty()).count();
            assert_eq!(there, moving.motion.scene_at(&moving.scene, frame).objects.len());
        }
    });
}

/// Returns the index of a refused change, and the reason.
fn refused(update: Result<UpdateReport, Error>) -> (usize, ChangeError) {
    match update {
        Err(Error::Change { index, reason }) => (index, reason),
        other => panic!("{other:?}"),
    }
}

#[test]
fn changes_are_made_all_or_none_and_the_first_that_cannot_be_is_named() {
    run(Driver::Lavapipe, |device| {
        let scene = box_scene(&wall_and_crowd(20));
        let options = RendererOptions { spare_objects: 2, ..options(2) };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let far = Affine3A::from_translation(Vec3::X * 90.0);
        let nowhere = Affine3A::from_translation(Vec3::NAN);
        let too_far = Affine3A::from_translation(Vec3::Y * 1e16);
        let someone = Object { mesh: MeshId(0), transform: far, tint: pack_unorm([1.0; 4]) };
        let add = ObjectChange::Add { object: someone };
        let moved = |object, transform| ObjectChange::Move { object: ObjectId(object), transform };
        let removed = |object| ObjectChange::Remove { object: ObjectId(object) };
        let unknown = |object| ChangeError::UnknownObject { object: ObjectId(object) };
        let before: Vec<Aabb> = boxes(&renderer);
        let bad = [
            (moved(0, nowhere), ChangeError::BadTransform),
            (moved(0, too_far), ChangeError::BadTransform),
            (moved(21, far), unknown(21)),
            (moved(99, far), unknown(99)),
            (removed(22), unknown(22)),
            // The object is removed, and the new object with this id is not known yet.
            (removed(5), unknown(5)),
            (moved(5, far), unknown(5)),
            (
                ObjectChange::Add { object: Object { mesh: MeshId(7), ..someone } },
                ChangeError::UnknownMesh { mesh: MeshId(7) },
            ),
            (
                ObjectChange::Add { object: Object { transform: nowhere, ..someone } },
                ChangeError::BadTransform,
            ),
        ];
        for (change, expected) in bad {
            let good = [moved(3, far), add, removed(5), add];
            let changes = [&good[..], &[change], &good].concat();
            assert_eq!(refused(renderer.update(&changes)), (4, expected));
            assert_eq!(boxes(&renderer), before);
        }
        let changes = [add, removed(4), add, add, add];
        assert_eq!(refused(renderer.update(&changes)), (4, ChangeError::NoFreeLeaf));
        assert_eq!(boxes(&renderer), before);
        // There is room for two more objects, and for each object that is removed.
        let report = renderer.update(&[add, add]).unwrap();
        assert_eq!(report.added.len(), 2);
        assert_eq!(refused(renderer.update(&[add])), (0, ChangeError::NoFreeLeaf));
        let gone = ObjectChange::Remove { object: report.added[0] };
        assert_eq!(renderer.update(&[gone, add]).unwrap().added, report.added[..1]);

        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        render(&mut renderer, &mut view, Strategy::ANTUMBRA, square_camera(), &image);
        device.wait_idle().unwrap();
    });
}
