//! What a clip does to the bones of a skeleton, and how far from a moment it goes in a span of time.

use glam::{Affine3A, Quat, Vec3, Vec4};

use crate::clip::{Excerpt, Track, Values};
use crate::hull::{Span, cones, hull};
use crate::rig::{NodeId, Rest, Rig, Trs};
use crate::skeleton::Skeleton;

/// The tracks of one node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NodeTracks<'a> {
    pub translation: Option<(&'a Track, &'a [Vec3])>,
    pub rotation: Option<(&'a Track, &'a [Quat])>,
    pub scale: Option<(&'a Track, &'a [Vec3])>,
}

/// The tracks of each bone in a clip.
pub(crate) fn bone_tracks<'a>(skeleton: &Skeleton, clip: &Excerpt<'a>) -> Vec<NodeTracks<'a>> {
    let mut tracks = vec![NodeTracks::default(); skeleton.bones.len()];
    for channel in clip.channels.iter().copied() {
        let bone = skeleton.bone_of(channel.node);
        let Some(tracks) = bone.and_then(|bone| tracks.get_mut(bone)) else { continue };
        let track = &channel.track;
        match &track.values {
            Values::Translation(values) => tracks.translation = Some((track, values)),
            Values::Rotation(values) => tracks.rotation = Some((track, values)),
            Values::Scale(values) => tracks.scale = Some((track, values)),
            Values::Weights(_) => {}
        }
    }
    tracks
}

/// A bone's local transform at the middle of a span, and how far from it the bone goes within.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Swing {
    /// At the middle.
    pub local: Affine3A,
    /// How far its origin goes from there.
    pub moved: f32,
    /// The operator norm of the difference of its rotations: the chord of the largest angle, 0 to 2.
    pub turned: f32,
    /// The largest difference of its scales.
    pub scaled: f32,
    /// The largest scale at the middle.
    pub scale: f32,
}

/// At a larger angle than this between a rotation and the points of its cone nothing is claimed.
const WIDEST_COSINE: f32 = 0.05;

impl NodeTracks<'_> {
    pub fn swing(&self, rig: &Rig, node: NodeId, span: Span) -> Swing {
        let rest = match rig.nodes().get(node.0 as usize).map(|node| node.rest) {
            Some(Rest::Parts(rest)) => rest,
            Some(Rest::Matrix(local)) => {
                let scale = norm(&local);
                return Swing { local, moved: 0.0, turned: 0.0, scaled: 0.0, scale };
            }
            None => Trs::IDENTITY,
        };
        let middle_s = span.from_s * 0.5 + span.to_s * 0.5;
        let mut parts = rest;
        let (mut moved, mut turned, mut scaled) = (0.0_f32, 0.0, 0.0_f32);
        if let Some((track, values)) = self.translation {
            parts.translation = track.vector_at(values, middle_s).unwrap_or(rest.translation);
            hull(track, values, (1, 0), span, &mut |point: Vec3| {
                moved = moved.max(point.distance(parts.translation));
            });
        }
        if let Some((track, values)) = self.rotation {
            parts.rotation = track.rotation_at(values, middle_s).unwrap_or(rest.rotation);
            turned = largest_turn(track, values, parts.rotation, span);
        }
        if let Some((track, values)) = self.scale {
            parts.scale = track.vector_at(values, middle_s).unwrap_or(rest.scale);
            hull(track, values, (1, 0), span, &mut |point: Vec3| {
                scaled = scaled.max((point - parts.scale).abs().max_element());
            });
        }
        let scale = parts.scale.abs().max_element();
        Swing { local: parts.to_affine(), moved, turned, scaled, scale }
    }
}

/// A bound of how much a matrix lengthens vectors: its Frobenius norm.
pub(crate) fn norm(matrix: &Affine3A) -> f32 {
    let [x, y, z] = [matrix.matrix3.x_axis, matrix.matrix3.y_axis, matrix.matrix3.z_axis];
    (x.length_squared() + y.length_squared() + z.length_squared()).sqrt()
}

/// The operator norm of the largest difference between a rotation and those of a track within a span. The
/// product of the middle and a sum of points is at least the least of their products, so the angle to the
/// points bounds the angle to all between them, as long as all are on one side.
fn largest_turn(track: &Track, values: &[Quat], middle: Quat, span: Span) -> f32 {
    let middle = Vec4::from(middle);
    let mut chord = 0.0_f32;
    cones(track, values, span, &mut |points| {
        let side =
            if points.first().is_some_and(|point| point.dot(middle) < 0.0) { -1.0 } else { 1.0 };
        for point in points {
            let length = point.length();
            let point = *point * (side / length);
            let is_near = length > 1e-3 && point.dot(middle) > WIDEST_COSINE;
            chord = if is_near { chord.max(point.distance(middle)) } else { f32::INFINITY };
        }
    });
    // From the chord of the angle between quaternions, half of the rotation's, to that of the rotation.
    if chord < std::f32::consts::SQRT_2 {
        2.0 * chord * (1.0 - chord * chord * 0.25).sqrt()
    } else {
        2.0
    }
}
