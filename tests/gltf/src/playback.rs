//! Playback of loaded scenes: all clips, faded into each other, at any time and at none.

use cull::Aabb;
use glam::Affine3A;
use import::{GltfScene, LevelOptions, SceneAnimator};
use scene::{LightMove, ObjectChange, PoseBounds, SceneUpdate};

/// The times to look at, in this order: seeks forwards and back, before the beginning, NaN and
/// infinity.
const SECONDS: [f64; 7] = [0.0, 0.37, 1.0e9, -3.5, f64::NAN, f64::INFINITY, 0.5];
/// The most clips that are played one after the other.
const MOST_CLIPS: usize = 4;
/// The largest coordinate of a box.
const FARTHEST: f32 = 1.001e15;

/// Makes coarser levels of detail, then plays; panics if a change would reach a renderer that the
/// renderer refuses.
pub fn play(mut imported: GltfScene) {
    imported.make_levels(&LevelOptions { least_triangles: 1, ..LevelOptions::default() });
    imported.scene.validate().expect("it can be drawn with its levels");
    let (scene, mut animator, cameras, _) = SceneAnimator::of(imported);
    let clips = animator.clips().len();
    let mut shown = Shown::new(&scene);
    let first = (0..clips.min(MOST_CLIPS)).map(|clip| vec![clip]);
    let together = animator.compatible(None);
    let mut now_s = 0.0;
    for playing in first.chain([together, (0..clips).collect(), vec![usize::MAX], Vec::new()]) {
        // Each goes on from amid of the fade before.
        animator.play(&playing, now_s, 1.0);
        for seconds in [0.25, 0.5] {
            shown.check(animator.changes(now_s + seconds));
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
        shown.check(animator.changes(seconds));
    }
}

/// A renderer's knowledge of the scene: the objects' transforms, and their boxes.
struct Shown<'a> {
    scene: &'a scene::Scene,
    surfaces: &'a scene::Surfaces,
    /// The transforms of the objects, and of the transparent ones behind them.
    transforms: Vec<Affine3A>,
    /// The boxes by mesh, in the mesh's own space.
    bounds: Vec<Aabb>,
    forms: Vec<PoseBounds>,
}

impl<'a> Shown<'a> {
    fn new(scene: &'a scene::Scene) -> Self {
        let surfaces = scene.surfaces.as_ref().expect("surfaces");
        let objects = scene.objects.iter().chain(&surfaces.transparent);
        let form = |skinned_mesh: &scene::SkinnedMesh| {
            PoseBounds::of(&scene.meshes[skinned_mesh.mesh.0 as usize], skinned_mesh)
        };
        Self {
            scene,
            surfaces,
            transforms: objects.map(|object| object.transform).collect(),
            bounds: scene.meshes.iter().map(|mesh| mesh.bounds).collect(),
            forms: surfaces.skinned_meshes.iter().map(form).collect(),
        }
    }

    /// Applies changes in the order in which a renderer does, and panics if a renderer would refuse
    /// one.
    fn check(&mut self, changes: &SceneUpdate) {
        for moved in &changes.objects {
            let ObjectChange::Move { object, transform } = *moved else {
                panic!("files bring and take no objects: {moved:?}");
            };
            assert!(transform.is_finite(), "{moved:?}");
            self.transforms[object.0 as usize] = transform;
        }
        for moved in &changes.transparent {
            let place = self.scene.objects.len() + moved.transparent.0 as usize;
            self.transforms[place] = moved.transform;
        }
        for light in &changes.lights {
            let LightMove { to, .. } = light;
            assert!(to.position.is_finite() && to.direction.is_normalized(), "{light:?}");
        }
        for update in &changes.poses {
            let number = update.skinned_mesh.0 as usize;
            let skinned_mesh = &self.surfaces.skinned_meshes[number];
            let joints = &changes.joints[update.joints.clone()];
            let weights = &changes.weights[update.weights.clone()];
            let joint_count =
                skinned_mesh.skin.as_ref().map_or(0, |skin| skin.joint_count as usize);
            assert_eq!((joints.len(), weights.len()), (joint_count, skinned_mesh.targets.len()));
            assert!(joints.iter().all(|joint| joint.is_finite()));
            assert!(weights.iter().all(|weight| weight.is_finite()));
            let bounds = self.forms[number].bounds(joints, weights);
            self.bounds[skinned_mesh.mesh.0 as usize] = bounds.expect("a pose that has a box");
        }
        let objects = self.scene.objects.iter().chain(&self.surfaces.transparent);
        for (object, transform) in objects.zip(&self.transforms) {
            let corners = self.bounds[object.mesh.0 as usize].corners();
            let mut corners = corners.map(|corner| transform.transform_point3(corner)).into_iter();
            assert!(corners.all(|at| at.abs().max_element() <= FARTHEST), "{transform:?}");
        }
    }
}
