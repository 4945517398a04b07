//! The animation of a scene from a file: computes the scene update for a time.
//!
//! The work per update is proportional to the number of moving parts, not to the size of the scene.
//! Nodes without a playing clip are not visited, resting objects are not changed, and objects
//! outside of all views are not posed ([`SceneAnimator::changes_in`]).

mod extent;
mod parts;
mod playing;
#[cfg(test)]
mod tests;

use std::collections::HashSet;

use animation::{Clip, Pose, Rig, RigNodeId};
use cull::{Aabb, CullView};
use glam::Affine3A;
use parts::{Movers, Parts, Touched};
use playing::Playing;
use scene::{PunctualLight, Scene, SceneUpdate};

use crate::Note;
use crate::gltf_scene::{GltfScene, PlacedNode, SceneCamera};

/// The attachments of a file's nodes, and the clips that move them.
///
/// Times may be requested in any order: the state depends only on the time and the playing clips.
/// In the steady state nothing is allocated. A clone continues on its own: each renderer of a file
/// has one.
#[derive(Clone)]
pub struct SceneAnimator {
    rig: Rig,
    clips: Vec<Clip>,
    parts: Parts,
    playing: Playing,
    pose: Pose,
    /// The target pose of a fade.
    other: Pose,
    /// The pose in which a fade was interrupted by another fade.
    mix: Pose,
    /// The transform from each node's space to the world.
    world: Vec<Affine3A>,
    /// The nodes that the playing clips move, parents before children.
    moving: Vec<RigNodeId>,
    /// True for each node in `moving`.
    is_moving: Vec<bool>,
    /// The indices of the parts that change with these nodes.
    movers: Movers,
    /// True until the first update.
    is_new: bool,
    /// The lights as last shown.
    lights: Vec<PunctualLight>,
    changes: SceneUpdate,
}

impl SceneAnimator {
    /// Separates the animation of a loaded file from its scene, cameras and notes, and returns all
    /// of them. No clip plays at first.
    pub fn of(imported: GltfScene) -> (Scene, Self, Vec<SceneCamera>, Vec<Note>) {
        let GltfScene { scene, rig, clips, skins, placements, cameras, notes, .. } = imported;
        let pose = Pose::new(&rig);
        let mut world = Vec::new();
        rig.world(&pose, &mut world);
        let surfaces = scene.surfaces.as_ref();
        let skinned_meshes = surfaces.map_or(&[][..], |surfaces| &surfaces.skinned_meshes);
        let mut animator = Self {
            parts: Parts::new(&rig, &skins, skinned_meshes, placements, &world),
            playing: Playing::default(),
            other: pose.clone(),
            mix: pose.clone(),
            moving: Vec::new(),
            is_moving: Vec::new(),
            movers: Movers::default(),
            lights: scene.surfaces.iter().flat_map(|surfaces| &surfaces.lights).copied().collect(),
            is_new: true,
            changes: SceneUpdate::default(),
            rig,
            clips,
            pose,
            world,
        };
        // Skinned objects have no rest pose before the first update sets it.
        animator.find_movers();
        (scene, animator, cameras, notes)
    }

    /// Returns all clips.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

    /// Returns the duration of a clip in seconds; `None` if the clip does not exist or has no
    /// duration.
    pub fn duration_s(&self, clip: usize) -> Option<f32> {
        self.clips.get(clip).map(Clip::duration_s).filter(|seconds| *seconds > 0.0)
    }

    /// Returns the clip that moves a camera. If there are several, it is the clip with the camera's
    /// name, else the first.
    pub fn clip_of(&self, camera: &SceneCamera) -> Option<usize> {
        let above = self.above(camera.node);
        let mut moving = self.clips.iter().enumerate().filter(|(_, clip)| moves_any(clip, &above));
        let (first, clip) = moving.next()?;
        let named = |(_, clip): &(usize, &Clip)| clip.name == camera.name;
        let other = if named(&(first, clip)) { None } else { moving.find(named) };
        Some(other.map_or(first, |(place, _)| place))
    }

    /// Returns true if one of these clips moves a camera.
    pub fn drive(&self, clips: &[usize], camera: &SceneCamera) -> bool {
        let above = self.above(camera.node);
        clips.iter().filter_map(|clip| self.clips.get(*clip)).any(|clip| moves_any(clip, &above))
    }

    /// Returns a node and all its ancestors.
    fn above(&self, node: RigNodeId) -> HashSet<RigNodeId> {
        let parent =
            |id: &RigNodeId| self.rig.nodes().get(id.0 as usize).and_then(|node| node.parent);
        std::iter::successors(Some(node), parent).collect()
    }

    /// Returns true if the playing clips move `node`.
    pub fn moves(&self, node: RigNodeId) -> bool {
        self.is_moving.get(node.0 as usize) == Some(&true)
    }

    /// Returns the number of objects that the playing clips move or pose.
    pub fn moving_objects(&self) -> usize {
        let placed = self.movers.moved.iter().filter_map(|mover| self.parts.placed(*mover));
        placed.filter(|(placed, _)| matches!(placed, PlacedNode::Object(_))).count()
    }

    /// Returns clips that can play together, in their order: no two of them animate the same
    /// property of the same node. A clip is left out if an earlier clip animates one of its
    /// properties. `first` takes precedence over all others.
    pub fn compatible(&self, first: Option<usize>) -> Vec<usize> {
        playing::compatible(&self.clips, first)
    }

    /// Returns a camera for images of `size` pixels at the time of the last [`Self::pose`].
    pub fn seen_by(&self, camera: &SceneCamera, size: [u32; 2]) -> cull::Camera {
        let world = self.world.get(camera.node.0 as usize).copied().unwrap_or(Affine3A::IDENTITY);
        camera.seen_from(&world, size)
    }

    /// Plays these clips in loops that begin at time 0. From `seconds` on, they replace the clips
    /// that played before, in a fade of `fade_s` seconds. Of two clips that animate the same
    /// property, the later one wins. A new fade starts from the pose of an unfinished fade. The
    /// time is proportional to the size of the scene.
    pub fn play(&mut self, clips: &[usize], seconds: f64, fade_s: f64) {
        if self.playing.weight(seconds) < 1.0 {
            self.pose(seconds);
            self.mix.clone_from(&self.pose);
        }
        self.playing.change(clips, seconds, fade_s);
        self.find_movers();
    }

    /// Computes the pose of all nodes at a time.
    pub fn pose(&mut self, seconds: f64) {
        self.pose.reset(&self.rig);
        let weight = self.playing.weight(seconds);
        if weight < 1.0 {
            if self.playing.is_from_mix() {
                self.pose.blend(&self.mix, 1.0);
            } else {
                playing::sample(&mut self.pose, &self.clips, self.playing.from(), seconds);
            }
            self.other.reset(&self.rig);
            playing::sample(&mut self.other, &self.clips, self.playing.to(), seconds);
            self.pose.blend(&self.other, weight);
        } else {
            playing::sample(&mut self.pose, &self.clips, self.playing.to(), seconds);
        }
        self.rig.update_world(&self.moving, &self.pose, &mut self.world);
    }

    /// Returns the changes from the last update to a time.
    pub fn changes(&mut self, seconds: f64) -> &SceneUpdate {
        self.change(seconds, None)
    }

    /// Returns the changes from the last update to a time, for a host that draws only these views
    /// before the next update. If no view can show an object, in any mix of the clips, the object
    /// moves but is not posed until a view can show it. The bound behind this decision
    /// ([`animation::Extents`]) is valid for the file's clips only, not for poses from other
    /// sources.
    pub fn changes_in(&mut self, seconds: f64, views: &[CullView]) -> &SceneUpdate {
        self.change(seconds, Some(views))
    }

    fn change(&mut self, seconds: f64, views: Option<&[CullView]>) -> &SceneUpdate {
        self.pose(seconds);
        self.changes.clear();
        self.parts.begin();
        for mover in self.movers.moved.iter().chain(&self.movers.behind) {
            let changes = &mut self.changes;
            self.parts.change_place(*mover, &self.world, &mut self.lights, changes);
            self.parts.change(*mover, &self.rig, &self.pose, views, changes);
        }
        if self.playing.settles(seconds) | std::mem::take(&mut self.is_new) {
            // The nodes of the previous clips are at rest again and need no more visits.
            self.find_movers();
        }
        &self.changes
    }

    /// Returns a box around everything visible while the current clips play, from a limited number
    /// of samples in time; the origin if there is nothing. `scene` must be the scene of this
    /// animator's file.
    ///
    /// Resets the shown state, so call it before a renderer shows anything.
    pub fn bounds_playing(&mut self, scene: &Scene) -> Aabb {
        extent::bounds_playing(self, scene)
    }

    /// Resets the shown state.
    fn reset(&mut self, scene: &Scene) {
        self.rig.world(&Pose::new(&self.rig), &mut self.world);
        self.parts.reset(&self.world);
        let lights = scene.surfaces.iter().flat_map(|surfaces| &surfaces.lights);
        self.lights = lights.copied().collect();
        self.is_new = true;
        self.find_movers();
    }

    fn find_movers(&mut self) {
        let clips = self.playing.concerned().filter_map(|clip| self.clips.get(clip));
        self.moving = self.rig.moved_by(clips);
        self.is_moving.clear();
        self.is_moving.resize(self.rig.nodes().len(), false);
        for node in &self.moving {
            if let Some(is_moving) = self.is_moving.get_mut(node.0 as usize) {
                *is_moving = true;
            }
        }
        let clips = self.playing.concerned().filter_map(|clip| self.clips.get(clip));
        let touched = Touched::by(clips);
        self.movers = self.parts.movers(&touched, &self.is_moving, self.is_new);
    }
}

/// Returns true if a clip moves one of these nodes.
fn moves_any(clip: &Clip, nodes: &HashSet<RigNodeId>) -> bool {
    let mut moved = clip.channels.iter().filter(|channel| channel.is_transform());
    moved.any(|channel| nodes.contains(&channel.node))
}
