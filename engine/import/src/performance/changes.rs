//! What is new in a moment, as plain values.

use std::ops::Range;

use animation::{Clip, Pose, Rig};
use cull::{Aabb, ObjectId};
use glam::{Affine3A, Vec3};
use render::scene::{BlendedId, DeformerId, LightId, PunctualLight};

use super::Part;
use crate::imported::Placed;

/// An object that is somewhere else, or needs more room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectMove {
    /// Which one.
    pub object: ObjectId,
    /// Where it is now.
    pub transform: Affine3A,
    /// The box that it stays in, in its own space; `None` where its form does not change.
    pub bounds: Option<Aabb>,
}

/// The same of a blended object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendedMove {
    /// Which one.
    pub blended: BlendedId,
    /// Where it is now.
    pub transform: Affine3A,
    /// As for [`ObjectMove`].
    pub bounds: Option<Aabb>,
}

/// A light that shines from elsewhere, or elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMove {
    /// Which one.
    pub light: LightId,
    /// As it is now.
    pub to: PunctualLight,
}

/// A mesh in another form.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Which one.
    pub deformer: DeformerId,
    /// Its joints' matrices, in [`Changes::joints`]; none without a skin.
    pub joints: Range<usize>,
    /// Its morph targets' weights, in [`Changes::weights`]; none without targets.
    pub weights: Range<usize>,
}

/// What is new, all of it together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Objects elsewhere.
    pub objects: Vec<ObjectMove>,
    /// Blended objects elsewhere.
    pub blended: Vec<BlendedMove>,
    /// Lights elsewhere.
    pub lights: Vec<LightMove>,
    /// Meshes in another form.
    pub deformations: Vec<Deformation>,
    /// What the vertices of these are multiplied with.
    pub joints: Vec<Affine3A>,
    /// How much of their targets is added.
    pub weights: Vec<f32>,
    /// A form in the making.
    matrices: Vec<Affine3A>,
}

impl Changes {
    pub(super) fn clear(&mut self) {
        self.objects.clear();
        self.blended.clear();
        self.lights.clear();
        self.deformations.clear();
        self.joints.clear();
        self.weights.clear();
    }

    /// Whether nothing is new.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
            && self.blended.is_empty()
            && self.lights.is_empty()
            && self.deformations.is_empty()
    }
}

/// What a mesh's vertices follow.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Form {
    joints: Vec<Affine3A>,
    weights: Vec<f32>,
    /// Whether it was shown at all.
    is_known: bool,
}

impl Part {
    /// Notes its form if it is another.
    pub(super) fn change(&mut self, rig: &Rig, pose: &Pose, changes: &mut Changes) {
        let Some((deformer, _)) = self.placement.deformer else { return };
        let mut matrices = std::mem::take(&mut changes.matrices);
        matrices.clear();
        if let Some(skeleton) = &self.skeleton {
            skeleton.joint_matrices(rig, pose, &mut matrices);
        }
        let weights = pose.weights(self.placement.node);
        let form = &mut self.shown_form;
        if !form.is_known || form.joints != matrices || form.weights != weights {
            form.is_known = true;
            form.joints.clone_from(&matrices);
            form.weights.clear();
            form.weights.extend_from_slice(weights);
            let (joints, first) = (changes.joints.len(), changes.weights.len());
            changes.joints.extend_from_slice(&matrices);
            changes.weights.extend_from_slice(weights);
            changes.deformations.push(Deformation {
                deformer,
                joints: joints..changes.joints.len(),
                weights: first..changes.weights.len(),
            });
        }
        changes.matrices = matrices;
    }

    /// The box that it stays in while poses of these clips are mixed, one group with another; `None` where
    /// it has its form for ever. The pose of a group that does not form it is that of the rest, so a single
    /// clip's box holds only where there is nothing to mix it with.
    pub(super) fn bounds<'a>(
        &self,
        groups: impl Iterator<Item = &'a [usize]> + Clone,
        all: &[Clip],
    ) -> Option<Aabb> {
        self.placement.deformer?;
        let forms = |clip: &&usize| all.get(**clip).is_some_and(|clip| self.is_formed_by(clip));
        let mut forming = groups.clone().flatten().filter(forms);
        let Some(first) = forming.next() else { return Some(self.placement.rest_bounds) };
        let is_alone = groups.count() == 1 && forming.all(|clip| clip == first);
        if !is_alone {
            return Some(self.placement.blend_bounds);
        }
        Some(self.placement.clip_bounds.get(*first).copied().unwrap_or(self.placement.rest_bounds))
    }

    /// Notes where it is if that is elsewhere.
    pub(super) fn change_place(
        &mut self,
        world: &[Affine3A],
        bounds: Option<Aabb>,
        lights: &mut [PunctualLight],
        changes: &mut Changes,
    ) {
        let transform = self.place(world);
        let is_same_box = bounds.is_none_or(|bounds| bounds == self.shown_bounds);
        if transform == self.shown && is_same_box {
            return;
        }
        self.shown = transform;
        self.shown_bounds = bounds.unwrap_or(self.shown_bounds);
        match self.placement.placed {
            Placed::Object(object) => {
                changes.objects.push(ObjectMove { object, transform, bounds });
            }
            Placed::Blended(blended) => {
                changes.blended.push(BlendedMove { blended, transform, bounds });
            }
            Placed::Light(light) => {
                let Some(to) = lights.get_mut(light.0 as usize) else { return };
                let along = Vec3::from(-transform.matrix3.z_axis);
                to.position = transform.translation.into();
                to.direction = along.try_normalize().unwrap_or(to.direction);
                changes.lights.push(LightMove { light, to: *to });
            }
        }
    }
}
