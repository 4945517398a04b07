//! The box of a skinned mesh while one clip plays alone.
//!
//! Within a short span of time each bone's local transform stays near to what it is at the middle of the
//! span: its origin within `moved`, its rotation within the angle whose chord is `turned`, its scale within
//! `scaled` ([`Swing`]), which is known from the hull of the tracks. A point that hangs on a joint is brought
//! to the object by a product of such transforms. Replacing them one after the other by those of the middle,
//! the one nearest to the joint first, moves the point by at most
//!
//! ```text
//! error(bone) = largest scale(bone) * error(below) + moved + (turned * scale + scaled) * |point|
//! ```
//!
//! where `|point|` is its distance from the bone's origin at the middle. So at any time of the span all that
//! hangs on the joint is in its box at the middle, enlarged by this error. Shorter spans have smaller errors:
//! [`refine`](crate::refine) halves those that make the whole too large.

use cull::Aabb;
use glam::{Affine3A, Vec3};

use crate::attached::{Attached, box_of};
use crate::bone_tracks::{NodeTracks, Swing};
use crate::hull::Span;
use crate::refine::Estimate;
use crate::rig::Rig;
use crate::skeleton::Bone;
use crate::support::Directions;
use crate::world::finite;

/// A skinned mesh and a clip.
pub(crate) struct Alone<'a> {
    pub rig: &'a Rig,
    pub bones: &'a [Bone],
    pub tracks: Vec<NodeTracks<'a>>,
    pub attached: &'a [Attached],
    pub directions: &'a Directions,
    swings: Vec<Swing>,
    transforms: Vec<Affine3A>,
}

impl<'a> Alone<'a> {
    pub fn new(
        rig: &'a Rig,
        bones: &'a [Bone],
        tracks: Vec<NodeTracks<'a>>,
        attached: &'a [Attached],
        directions: &'a Directions,
    ) -> Self {
        let (swings, transforms) = (Vec::new(), Vec::new());
        Self { rig, bones, tracks, attached, directions, swings, transforms }
    }

    /// The boxes of a span.
    pub fn estimate(&mut self, span: Span) -> Estimate {
        self.swings.clear();
        self.transforms.clear();
        for (bone, tracks) in self.bones.iter().zip(&self.tracks) {
            let swing = tracks.swing(self.rig, bone.node, span);
            let parent = bone.parent.and_then(|parent| self.transforms.get(parent));
            self.transforms
                .push(finite(parent.map_or(swing.local, |parent| *parent * swing.local)));
            self.swings.push(swing);
        }
        let (mut inner, mut outer) = (Aabb::EMPTY, Aabb::EMPTY);
        for attached in self.attached {
            let bone = attached.bone.and_then(|bone| self.transforms.get(bone));
            let transform = bone.copied().unwrap_or(Affine3A::IDENTITY);
            let [min, max] = box_of(&attached.support, self.directions, &transform);
            let error = self.error(attached);
            inner = inner.union(&Aabb::new(min, max));
            outer = outer.union(&Aabb::new(min - Vec3::splat(error), max + Vec3::splat(error)));
        }
        Estimate { inner, outer }
    }

    fn error(&self, attached: &Attached) -> f32 {
        let (mut centre, mut radius, mut error) = (attached.centre, attached.radius, 0.0);
        let mut next = attached.bone;
        while let Some((bone, swing)) =
            next.and_then(|bone| Some((self.bones.get(bone)?, self.swings.get(bone)?)))
        {
            let distance = centre.length() + radius;
            let change = swing.turned * swing.scale + swing.scaled;
            error = (swing.scale + swing.scaled) * error + swing.moved + change * distance;
            centre = swing.local.transform_point3a(centre);
            radius *= swing.scale;
            next = bone.parent;
        }
        error
    }
}
