//! What was loaded plays: all clips, faded into each other, at any time and at none.

use import::{GltfScene, LevelOptions, SceneAnimator};
use scene::{ObjectChange, SceneUpdate};

/// Times to look at, in this order: seeks forwards and back, before the beginning, and what is no time.
const SECONDS: [f64; 7] = [0.0, 0.37, 1.0e9, -3.5, f64::NAN, f64::INFINITY, 0.5];
/// Clips that are played one after the other.
const MOST_CLIPS: usize = 4;
/// No coordinate of a box is beyond this.
const FARTHEST: f32 = 1.001e15;

/// Makes coarser forms, then plays; fails where something would reach a renderer that it refuses.
pub fn perform(mut imported: GltfScene) {
    imported.make_levels(&LevelOptions { least_triangles: 1, ..LevelOptions::default() });
    imported.scene.validate().expect("it can be drawn with its levels");
    let (scene, mut animator, cameras, _) = SceneAnimator::of(imported);
    let clips = animator.clips().len();
    let first = (0..clips.min(MOST_CLIPS)).map(|clip| vec![clip]);
    let together = animator.compatible(None);
    let mut now_s = 0.0;
    for playing in first.chain([together, (0..clips).collect(), vec![usize::MAX], Vec::new()]) {
        // Each goes on from amid of the fade before.
        animator.play(&playing, now_s, 1.0);
        for seconds in [0.25, 0.5] {
            check(animator.changes(now_s + seconds), &scene);
        }
        now_s += 0.5;
        for camera in &cameras {
            let seen = animator.seen_by(camera, [3, 2]);
            assert!(seen.eye.is_finite() && (seen.forward.length() - 1.0).abs() < 1e-3, "{seen:?}");
            let _ = animator.clip_of(camera);
        }
    }
    animator.play(&(0..clips).collect::<Vec<_>>(), 0.0, 0.0);
    for seconds in SECONDS {
        check(animator.changes(seconds), &scene);
    }
}

fn check(changes: &SceneUpdate, scene: &scene::Scene) {
    let surfaces = scene.surfaces.as_ref().expect("surfaces");
    for moved in &changes.objects {
        let (object, transform, bounds) = match *moved {
            ObjectChange::Move { object, transform } => (object, transform, None),
            ObjectChange::Reshape { object, transform, bounds } => {
                (object, transform, Some(bounds))
            }
            other => panic!("files bring and take no objects: {other:?}"),
        };
        let mesh = scene.mesh_of(&scene.objects[object.0 as usize]).expect("its mesh");
        let corners = bounds.unwrap_or(mesh.bounds).corners();
        let corners = corners.map(|corner| transform.transform_point3(corner));
        assert!(transform.is_finite(), "{moved:?}");
        assert!(corners.iter().all(|at| at.abs().max_element() <= FARTHEST), "{moved:?}");
    }
    for moved in &changes.blended {
        let mesh = scene.mesh_of(&surfaces.blended[moved.blended.0 as usize]).expect("its mesh");
        let corners = moved.bounds.unwrap_or(mesh.bounds).corners();
        let corners = corners.map(|corner| moved.transform.transform_point3(corner));
        assert!(corners.iter().all(|at| at.abs().max_element() <= FARTHEST), "{moved:?}");
    }
    for light in &changes.lights {
        assert!(light.to.position.is_finite() && light.to.direction.is_normalized(), "{light:?}");
    }
    assert!(changes.joints.iter().all(|joint| joint.is_finite()));
    assert!(changes.weights.iter().all(|weight| weight.is_finite()));
    for deformed in &changes.deformations {
        let deformer = &surfaces.deformers[deformed.deformer.0 as usize];
        let joints = deformer.skin.as_ref().map_or(0, |skin| skin.joint_count as usize);
        assert_eq!(
            (deformed.joints.len(), deformed.weights.len()),
            (joints, deformer.targets.len())
        );
    }
}
