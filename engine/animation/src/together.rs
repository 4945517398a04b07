//! The box of a skinned mesh while any clips play together, mixed at any times with any weights.
//!
//! The union of the clips' own boxes is none: mixing acts on the local transforms of bones, so half of one
//! pose and half of another is a pose of neither, and a limb that is bent in both may be stretched between
//! them. Sampling pairs of times and weights would miss what is between samples, and pairs of clips are many.
//! So here each bone is bounded by itself, from the tips of the limbs to the root:
//!
//! - Its translations, rotations and scales stay within sets that hold those of every clip **and every
//!   mix of them**: a box, a [`RotationSet`], a box. (Mixes of places and scales lie between them; mixes of
//!   rotations in their cone, which is why [`Pose::blend`](crate::Pose::blend) takes the chord.)
//! - What hangs on it, itself or by its children, is a set of points known by its support function
//!   ([`Support`]), which says how far it reaches along every direction.
//! - So what hangs on its parent by it reaches along a direction `d` at most
//!   `max t.d + max h(S R^-1 d)` over those sets. `h` is convex, so the corners of the box of scales are
//!   enough; how corners of cells of rotations are, says [`RotationSet`].
//!
//! Nothing is assumed about times, weights, how many clips play, or that all bones follow the same mix, so it
//! holds for layers too. It does not know that bones move together: it holds poses where each bone is
//! at its own extreme, which makes it larger than what is reached, by as much as limbs have such bones.

use glam::{Mat3, Quat, Vec3, Vec3A, Vec4};

use crate::attached::Attached;
use crate::bone_tracks::NodeTracks;
use crate::hull::{Span, cones, hull};
use crate::rig::{Rest, Rig, Trs};
use crate::rotation_set::{RotationHull, RotationSet};
use crate::skeleton::Bone;
use crate::support::{Directions, Support};

/// All of a clip, and what it rests at when it is over.
pub(crate) const ALWAYS: Span = Span { from_s: 0.0, to_s: f32::INFINITY };
/// Turned directions that are looked up in all: some 0.1 s.
const MOST_LOOKUPS: usize = 4_000_000;

/// What reaches farther than this has no box: up to it nothing overflows on the way.
const FARTHEST: f32 = 1e30;

/// What hangs on a bone, in the bone's space.
#[derive(Clone)]
struct Hanging {
    support: Support,
    /// How far from the bone's origin.
    reach: f32,
}

/// The sets of a bone's local transforms.
struct Freedom {
    translation: [Vec3; 2],
    rotation: RotationSet,
    scale: [Vec3; 2],
}

/// How far all that is attached reaches along each direction, in the object's space. `clips` has the tracks of
/// all bones for each clip; none is the rig at rest. `None` if it reaches too far for numbers.
pub(crate) fn together(
    rig: &Rig,
    bones: &[Bone],
    clips: &[Vec<NodeTracks>],
    attached: &[Attached],
    directions: &Directions,
) -> Option<Support> {
    let mut hanging: Vec<Option<Hanging>> = vec![None; bones.len()];
    let mut all = None;
    for set in attached {
        let reach = Vec3::from(set.centre).length() + set.radius;
        match set.bone.and_then(|bone| hanging.get_mut(bone)) {
            Some(entry) => hang(entry, &set.support, reach),
            None => hang(&mut all, &set.support, reach),
        }
    }
    let most_corners = MOST_LOOKUPS / (directions.all().len() * bones.len().max(1));
    for (index, bone) in bones.iter().enumerate().rev() {
        let Some(below) = hanging.get_mut(index).and_then(Option::take) else { continue };
        let (support, reach) = match rig.nodes().get(bone.node.0 as usize).map(|node| node.rest) {
            Some(Rest::Matrix(matrix)) => {
                let rows = matrix.matrix3.transpose();
                let along = |d: Vec3A| {
                    matrix.translation.dot(d) + directions.along(&below.support, (rows * d).into())
                };
                let support = Support(directions.all().iter().map(|d| along(*d)).collect());
                let reach =
                    matrix.translation.length() + crate::bone_tracks::norm(&matrix) * below.reach;
                (support, reach)
            }
            rest => {
                let rest = if let Some(Rest::Parts(rest)) = rest { rest } else { Trs::IDENTITY };
                let tracks = clips.iter().filter_map(|clip| clip.get(index));
                let freedom = freedom(&rest, tracks, most_corners);
                (lift(&below, &freedom, directions), freedom.lengthened(below.reach))
            }
        };
        match bone.parent.and_then(|parent| hanging.get_mut(parent)) {
            Some(entry) => hang(entry, &support, reach),
            None => hang(&mut all, &support, reach),
        }
    }
    all.filter(|all| all.reach < FARTHEST).map(|all| all.support)
}

fn hang(entry: &mut Option<Hanging>, support: &Support, reach: f32) {
    // What is no number would be lost in the maximum.
    let reach = if reach.is_nan() { f32::INFINITY } else { reach };
    if let Some(hanging) = entry {
        hanging.support.unite(support);
        hanging.reach = hanging.reach.max(reach);
    } else {
        *entry = Some(Hanging { support: support.clone(), reach });
    }
}

/// What a bone can do in any of the clips; where one does not move it, it is at rest.
fn freedom<'a>(
    rest: &Trs,
    clips: impl Iterator<Item = &'a NodeTracks<'a>>,
    most_corners: usize,
) -> Freedom {
    const NONE: [Vec3; 2] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let include = |range: &mut [Vec3; 2], point: Vec3| {
        *range = [range[0].min(point), range[1].max(point)];
    };
    let (mut translation, mut scale) = (NONE, NONE);
    let mut rotation = RotationHull::default();
    let mut is_at_rest = [true; 3];
    for (number, tracks) in clips.enumerate() {
        if number == 0 {
            is_at_rest = [false; 3];
        }
        match tracks.translation {
            Some((track, values)) => {
                hull(track, values, (1, 0), ALWAYS, &mut |point| include(&mut translation, point));
            }
            None => is_at_rest[0] = true,
        }
        match tracks.rotation {
            Some((track, values)) => {
                cones(track, values, ALWAYS, &mut |points| rotation.add(points))
            }
            None => is_at_rest[1] = true,
        }
        match tracks.scale {
            Some((track, values)) => {
                hull(track, values, (1, 0), ALWAYS, &mut |point| include(&mut scale, point));
            }
            None => is_at_rest[2] = true,
        }
    }
    if is_at_rest[0] {
        include(&mut translation, rest.translation);
    }
    if is_at_rest[1] {
        rotation.add(&[Vec4::from(rest.rotation)]);
    }
    if is_at_rest[2] {
        include(&mut scale, rest.scale);
    }
    Freedom { translation, rotation: rotation.enclose(most_corners), scale }
}

impl Freedom {
    fn largest_scale(&self) -> f32 {
        self.scale[0].abs().max(self.scale[1].abs()).max_element()
    }

    fn lengthened(&self, reach: f32) -> f32 {
        let farthest = self.translation[0].abs().max(self.translation[1].abs()).length();
        farthest + self.largest_scale() * reach
    }

    /// The corners of the box of scales; those that are the same, once.
    fn scales(&self) -> Vec<Vec3> {
        let [least, largest] = self.scale;
        let mut corners: Vec<Vec3> = cull::Aabb::new(least, largest).corners().to_vec();
        corners.dedup();
        if least == largest {
            corners.truncate(1);
        }
        corners
    }
}

/// What hangs on the parent of a bone by it.
fn lift(below: &Hanging, freedom: &Freedom, directions: &Directions) -> Support {
    let reach = below.reach * freedom.largest_scale();
    let [least, largest] = freedom.translation;
    let shift = |d: Vec3| (least * d).max(largest * d).element_sum();
    let (corners, squared_radius, flat) = match &freedom.rotation {
        RotationSet::Any => {
            let farthest = |d: Vec3| shift(d) + d.length() * reach;
            let supports = directions.all().iter().map(|d| farthest(Vec3::from(*d)));
            return Support(supports.collect());
        }
        RotationSet::Cells { corners, squared_radius, flat } => (corners, *squared_radius, *flat),
    };
    let inverse = |corner: &Quat| Mat3::from_quat(corner.conjugate());
    let inverses: Vec<Mat3> = corners.iter().map(inverse).collect();
    let scales = freedom.scales();
    let supports = directions.all().iter().map(|direction| {
        let direction = Vec3::from(*direction);
        let turned = inverses.iter().map(|inverse| *inverse * direction);
        let scaled = turned.flat_map(|turned| scales.iter().map(move |scale| *scale * turned));
        let most = scaled.map(|d| directions.along(&below.support, d));
        let farthest = most.fold(f32::NEG_INFINITY, f32::max)
            + (squared_radius + flat) * reach * direction.length();
        let farthest = if farthest > 0.0 { farthest / (1.0 - squared_radius) } else { farthest };
        shift(direction) + farthest
    });
    Support(supports.collect())
}
