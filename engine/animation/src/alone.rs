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
use glam::Affine3A;

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
    /// Bones above all that is attached, counted once for each.
    chains: usize,
}

/// Beyond this sum of the lengths of all chains one error is taken for all that is attached.
const LONGEST_CHAINS: usize = 100_000;

impl<'a> Alone<'a> {
    pub fn new(
        rig: &'a Rig,
        bones: &'a [Bone],
        tracks: Vec<NodeTracks<'a>>,
        attached: &'a [Attached],
        directions: &'a Directions,
    ) -> Self {
        let mut depths: Vec<usize> = Vec::with_capacity(bones.len());
        for bone in bones {
            let above = bone.parent.and_then(|parent| depths.get(parent)).copied();
            depths.push(above.unwrap_or_default() + 1);
        }
        let depth = |attached: &Attached| attached.bone.and_then(|bone| depths.get(bone)).copied();
        let chains = attached.iter().filter_map(depth).fold(0, usize::saturating_add);
        let (swings, transforms) = (Vec::new(), Vec::new());
        Self { rig, bones, tracks, attached, directions, swings, transforms, chains }
    }

    /// What one estimate costs, in bones; at least 1.
    pub fn work(&self) -> usize {
        1 + self.bones.len() + self.attached.len() + self.chains.min(LONGEST_CHAINS) / 8
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
        let common = (self.chains > LONGEST_CHAINS).then(|| self.common_error());
        let (mut inner, mut outer) = (Aabb::EMPTY, Aabb::EMPTY);
        for attached in self.attached {
            let bone = attached.bone.and_then(|bone| self.transforms.get(bone));
            let transform = bone.copied().unwrap_or(Affine3A::IDENTITY);
            let [min, max] = box_of(&attached.support, self.directions, &transform);
            let error = common.unwrap_or_else(|| self.error(attached));
            // What is no number would be lost in unions: it may be anywhere.
            let error = if error.is_finite() { error } else { f32::INFINITY };
            inner = inner.union(&Aabb::new(min, max));
            outer = outer.union(&Aabb::new(min - error, max + error));
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

    /// The same for all that is attached at once: the farthest of all that hangs on a bone stands for it.
    fn common_error(&self) -> f32 {
        let mut hanging = vec![(0.0_f32, 0.0_f32); self.bones.len()];
        for attached in self.attached {
            let distance = attached.centre.length() + attached.radius;
            if let Some((farthest, _)) = attached.bone.and_then(|bone| hanging.get_mut(bone)) {
                *farthest = farthest.max(distance);
            }
        }
        let mut most = 0.0_f32;
        for (index, (bone, swing)) in self.bones.iter().zip(&self.swings).enumerate().rev() {
            let Some((distance, error)) = hanging.get(index).copied() else { continue };
            let change = swing.turned * swing.scale + swing.scaled;
            let error = (swing.scale + swing.scaled) * error + swing.moved + change * distance;
            let distance = swing.local.translation.length() + swing.scale * distance;
            let or_anywhere = |number: f32| if number.is_nan() { f32::INFINITY } else { number };
            match bone.parent.and_then(|parent| hanging.get_mut(parent)) {
                Some(above) => {
                    let farthest = above.0.max(or_anywhere(distance));
                    *above = (farthest, above.1.max(or_anywhere(error)));
                }
                None => most = most.max(or_anywhere(error)),
            }
        }
        most
    }
}
