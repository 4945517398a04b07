//! What is new in a moment, as plain values.

use std::ops::Range;

use cull::{Aabb, ObjectId};
use glam::Affine3A;
use render::scene::{BlendedId, DeformerId, LightId, PunctualLight};

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
    /// Its joints' matrices, in [`Changes::joints`], which those that hang on the same joints share; none
    /// without a skin.
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
    /// Joints in the making.
    pub(super) matrices: Vec<Affine3A>,
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
