//! Clips that move objects too far. A box beyond the drawable coordinates would be an error during
//! playback, so such clips are found when loading and left out.
//!
//! The distance of each node is bounded for all clips at once, mixed or not ([`Extents`]), so no
//! fade moves a node farther. Only if that bound is too large, clips are tried one after the other,
//! each together with the clips accepted before.

use std::collections::HashMap;

use animation::{Clip, Extents, Rig, Skeleton, Skin};
use cull::{Aabb, MAX_COORDINATE};
use scene::{Scene, Surfaces};

use super::nodes::Tree;
use super::skins::used_joints;
use crate::error::quoted;
use crate::gltf_scene::{NodeAttachment, PlacedNode, SceneCamera};
use crate::notes::Notes;

/// The number of nodes that are visited in the search for such clips; clips that were not tried by
/// then are left out.
const MOST_STEPS: usize = 1 << 26;
/// The number of clips that are tried in any case.
const LEAST_TRIES: usize = 8;

/// The contents of a scene that clips move.
pub(super) struct MovedContents<'a> {
    pub(super) placements: &'a [NodeAttachment],
    pub(super) scene: &'a Scene,
    pub(super) surfaces: &'a Surfaces,
    pub(super) skins: &'a [Skin],
    pub(super) cameras: &'a [SceneCamera],
}

/// Removes clips that could move an object beyond the drawable coordinates, and notes them.
/// `extents` are the extents of all clips.
pub(super) fn refuse_far(
    tree: &Tree,
    extents: &Extents,
    clips: &mut Vec<Clip>,
    contents: &MovedContents<'_>,
    notes: &mut Notes,
) {
    let rig = &tree.rig;
    let distances = distances(rig, contents);
    let is_too_far = |extents: &Extents| {
        let farthest = extents.farthest(rig, &distances);
        farthest.filter(|(_, distance)| *distance > MAX_COORDINATE).map(|(node, _)| node)
    };
    if clips.is_empty() || is_too_far(extents).is_none() {
        return;
    }
    let tries = (MOST_STEPS / rig.nodes().len().max(1)).max(LEAST_TRIES);
    let mut taken = Extents::new(rig, []);
    let mut is_taken = Vec::with_capacity(clips.len());
    for (number, clip) in clips.iter().enumerate() {
        let mut with = taken.clone();
        with.add(rig, clip);
        let far = if number < tries { is_too_far(&with).map(|node| tree.name(node)) } else { None };
        let is_near = number < tries && far.is_none();
        if is_near {
            taken = with;
        } else {
            let what = "it could take something farther than anything can be, alone or with those \
                        before it, and is not played";
            let whom = far.map_or(String::new(), |node| format!(" moves {node}"));
            notes.count(what, 1, || format!("{}{whom}", quoted(&clip.name)));
        }
        is_taken.push(is_near);
    }
    let mut is_taken = is_taken.into_iter();
    clips.retain(|_| is_taken.next() == Some(true));
}

/// Returns the reach of each node's contents from its origin; -1 for a node without contents.
fn distances(
    rig: &Rig,
    &MovedContents { placements, scene, surfaces, skins, cameras }: &MovedContents<'_>,
) -> Vec<f32> {
    let mut distances = vec![-1.0_f32; rig.nodes().len()];
    let mut spaces = HashMap::new();
    let mut reaches = |node: u32, distance: f32| {
        let distance = if distance.is_nan() { f32::INFINITY } else { distance };
        if let Some(entry) = distances.get_mut(node as usize) {
            *entry = entry.max(distance);
        }
    };
    for camera in cameras {
        reaches(camera.node.0, 0.0);
    }
    for placement in placements {
        let mut node = Some(placement.node);
        let mut bounds = placement.reach;
        if let Some((skinned_mesh, skin)) = placement.skinned_mesh {
            let skinned_mesh = surfaces.skinned_meshes.get(skinned_mesh.0 as usize);
            let weights = skinned_mesh.and_then(|skinned_mesh| skinned_mesh.skin.as_ref());
            if let Some((skin, weights)) = skin.zip(weights) {
                let key = (skin, used_joints(weights));
                let space = |(skin, used): &(usize, Vec<bool>)| {
                    Skeleton::new(rig, skins.get(*skin)?, used).ok()?.space()
                };
                node = *spaces.entry(key).or_insert_with_key(space);
            }
        } else {
            let object = match placement.placed {
                PlacedNode::Object(object) => scene.objects.get(object.0 as usize),
                PlacedNode::Transparent(transparent) => {
                    surfaces.transparent.get(transparent.0 as usize)
                }
                PlacedNode::Light(_) => None,
            };
            let mesh = object.and_then(|object| scene.mesh_of(object));
            bounds = mesh.map_or(Aabb::EMPTY, |mesh| mesh.bounds);
        }
        let Some(node) = node else { continue };
        let origin = placement.local.translation.length();
        let corners =
            bounds.corners().map(|corner| placement.local.transform_point3(corner).length());
        let farthest = if bounds.is_empty() {
            origin
        } else {
            corners.iter().fold(0.0, |farthest, distance| {
                if distance.is_nan() { *distance } else { distance.max(farthest) }
            })
        };
        reaches(node.0, farthest);
    }
    distances
}
