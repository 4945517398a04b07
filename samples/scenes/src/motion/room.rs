//! Finds motions without collisions: the sweeps of all moving objects are kept in a hierarchy.

use cull::{Aabb, Hierarchy, NodeId, ObjectId};
use glam::Vec3;
use scene::Scene;

use super::GROUND;
use super::act::{Act, Pace};
use crate::generated::HOVER_M;
use crate::random::Random;

/// The distance between sweeps, and between sweeps and resting objects, in metres.
const CLEARANCE_M: f32 = HOVER_M * 0.5;

/// The space that all objects occupy.
pub(super) struct Room {
    /// The hierarchy over all objects except the ground: moving objects are lifted clear of it.
    taken: Option<Hierarchy>,
    /// The height of the highest kerb.
    ground_top_m: f32,
    stack: Vec<NodeId>,
}

impl Room {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut ground_top_m = f32::NEG_INFINITY;
        let boxes: Vec<Aabb> = scene
            .objects
            .iter()
            .map(|object| {
                let bounds = scene.bounds_of(object).unwrap_or(Aabb::EMPTY);
                if scene.mesh_of(object).is_some_and(|mesh| mesh.name.starts_with(GROUND)) {
                    ground_top_m = ground_top_m.max(bounds.max.y);
                    return Aabb::EMPTY;
                }
                bounds
            })
            .collect();
        Self { taken: Hierarchy::build(&boxes).ok(), ground_top_m, stack: Vec::new() }
    }

    /// Returns a motion for an object, and marks its sweep as occupied.
    pub(super) fn act_for(
        &mut self,
        scene: &Scene,
        index: u32,
        random: &mut Random,
    ) -> Option<Act> {
        let object = ObjectId(index);
        let bounds = scene.bounds_of(scene.objects.get(index as usize)?)?;
        let mut acts = self.acts(&bounds, random);
        random.shuffle(&mut acts);
        for act in acts {
            let sweep = act.sweep(&bounds);
            if self.is_free(object, &sweep.enlarged(CLEARANCE_M)) {
                self.taken.as_mut()?.refit([(object, sweep)]).ok()?;
                return Some(act);
            }
        }
        None
    }

    /// Returns the possible motions of an object with this box, to be tried in order.
    fn acts(&self, bounds: &Aabb, random: &mut Random) -> [Act; 7] {
        let size = bounds.max - bounds.min;
        let lift_m = (self.ground_top_m + HOVER_M - bounds.min.y).max(0.0);
        // Farther than its length, so that objects behind become visible.
        let far = |along: f32, random: &mut Random| (along * 1.2).max(1.0) + random.unit();
        let mut slide = |direction: Vec3| Act::Slide {
            reach: direction * far(direction.abs().dot(size), random),
            lift_m: if direction.y > 0.0 { 0.0 } else { lift_m },
            pace: Pace::new(random),
        };
        let [east, west, south, north, up] =
            [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::Y].map(&mut slide);
        let middle = bounds.centre();
        let angle_rad = random.between(0.2, 0.7);
        let turn = Act::Turn { centre: middle, angle_rad, lift_m, pace: Pace::new(random) };
        let shrink = Act::Shrink {
            foot: middle.with_y(bounds.min.y),
            least: random.between(0.4, 0.8),
            pace: Pace::new(random),
        };
        [east, west, south, north, up, turn, shrink]
    }

    /// Returns true if a box meets no other object's space.
    fn is_free(&mut self, object: ObjectId, space: &Aabb) -> bool {
        let Some(taken) = &self.taken else {
            return false;
        };
        self.stack.clear();
        self.stack.extend(taken.root());
        while let Some(node) = self.stack.pop() {
            if !meets(&taken.bounds(node), space) {
                continue;
            }
            match taken.children(node) {
                Some(children) => self.stack.extend(children),
                None if taken.node_of(object) != Some(node) => return false,
                None => {}
            }
        }
        true
    }
}

fn meets(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}
