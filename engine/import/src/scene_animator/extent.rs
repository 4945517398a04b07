//! The extent of a scene while clips play.

use cull::Aabb;
use glam::Vec3;
use scene::{Object, PoseBounds, Scene};

use super::SceneAnimator;
use crate::gltf_scene::PlacedNode;

/// The most samples of a clip from its beginning to its end.
const MAX_SAMPLES_PER_CLIP: usize = 32;

/// The most samples of all clips together.
const MAX_SAMPLES: usize = 256;

/// The most sampled places of nodes and moving parts; each clip is sampled at least once.
const MAX_SAMPLED_PLACES: usize = 1 << 22;

/// Returns the box of [`SceneAnimator::bounds_playing`].
pub(super) fn bounds_playing(animator: &mut SceneAnimator, scene: &Scene) -> Aabb {
    let transparent = scene.surfaces.iter().flat_map(|surfaces| &surfaces.transparent);
    let objects: Vec<&Object> = scene.objects.iter().chain(transparent).collect();
    let place = |(placed, _): (PlacedNode, _)| match placed {
        PlacedNode::Object(id) => Some(id.0 as usize),
        PlacedNode::Transparent(id) => Some(scene.objects.len() + id.0 as usize),
        PlacedNode::Light(_) => None,
    };
    let mut is_part = vec![false; objects.len()];
    let mut all = Aabb::EMPTY;
    let parts = 0..animator.parts.len();
    for place in parts.clone().filter_map(|part| place(animator.parts.placed(part)?)) {
        if let Some(is_part) = is_part.get_mut(place) {
            *is_part = true;
        }
    }
    let still = objects.iter().zip(&is_part).filter(|(_, is_part)| !**is_part);
    for bounds in still.filter_map(|(object, _)| scene.bounds_of(object)) {
        all = all.union(&bounds);
    }
    let skinned_meshes =
        scene.surfaces.as_ref().map_or(&[][..], |surfaces| &surfaces.skinned_meshes);
    let form = |part| {
        let (_, skinned_mesh) = animator.parts.placed(part)?;
        let skinned_mesh = skinned_meshes.get(skinned_mesh?.0 as usize)?;
        Some(PoseBounds::of(scene.meshes.get(skinned_mesh.mesh.0 as usize)?, skinned_mesh))
    };
    let forms: Vec<Option<PoseBounds>> = parts.clone().map(form).collect();
    for seconds in sample_times(animator) {
        animator.changes(seconds);
        for (part, form) in parts.clone().zip(&forms) {
            let Some(place) = animator.parts.placed(part).and_then(place) else { continue };
            let mesh =
                objects.get(place).and_then(|object| scene.meshes.get(object.mesh.0 as usize));
            if let Some(bounds) =
                animator.parts.seen_in(part, mesh.map(|mesh| mesh.bounds), form.as_ref())
            {
                all = all.union(&bounds);
            }
        }
    }
    animator.reset(scene);
    if all.is_usable() { all } else { Aabb::new(Vec3::ZERO, Vec3::ZERO) }
}

/// Returns the sampled times, in seconds.
fn sample_times(animator: &SceneAnimator) -> Vec<f64> {
    let durations: Vec<f32> =
        animator.playing.to().iter().filter_map(|clip| animator.duration_s(*clip)).collect();
    let places = (animator.moving.len() + animator.parts.len()).max(1);
    let most = (MAX_SAMPLED_PLACES / places).clamp(1, MAX_SAMPLES);
    let per_clip = (most / durations.len().max(1)).clamp(1, MAX_SAMPLES_PER_CLIP);
    let all = durations.iter().flat_map(|seconds| {
        (0..per_clip).map(move |sample| f64::from(*seconds) * sample as f64 / per_clip as f64)
    });
    // The beginning is sampled even if nothing plays.
    std::iter::once(0.0).chain(all).take(most.max(durations.len()).min(MAX_SAMPLES)).collect()
}
