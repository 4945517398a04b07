//! Interpolation between the keys of tracks: glTF 2.0, appendix C.

use cull::trigonometry;
use glam::{Quat, Vec3, Vec4};

/// The position of a time among the keys of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// A time at a key, or before the first key or after the last.
    Key(usize),
    /// A time between this key and the next.
    Between {
        /// The key before.
        key: usize,
        /// The fraction of the interval that has passed, 0 to 1.
        fraction: f32,
        /// The length of the interval in seconds.
        interval_s: f32,
    },
}

/// A value that can be mixed; rotations are mixed as their four numbers.
pub(crate) trait Mix:
    Copy + std::ops::Add<Output = Self> + std::ops::Mul<f32, Output = Self>
{
}

impl Mix for f32 {}
impl Mix for Vec3 {}
impl Mix for Vec4 {}

/// Returns a point of a cubic Hermite spline whose tangents are scaled by the length of the
/// interval.
pub(crate) fn hermite<T: Mix>(from: T, leaving: T, arriving: T, to: T, t: f32) -> T {
    let t2 = t * t;
    let t3 = t * t * t;
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + leaving * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + arriving * (t3 - t2)
}

/// Returns the rotation between two by the shorter arc, at constant speed.
pub(crate) fn slerp(from: Quat, to: Quat, t: f32) -> Quat {
    /// The cosine above which the angle's sine is too small to divide by, and arc and chord are
    /// nearly equal.
    const NEARLY_SAME: f32 = 0.9995;
    let cosine = from.dot(to);
    let to = if cosine < 0.0 { -to } else { to };
    let cosine = cosine.abs();
    if cosine > NEARLY_SAME {
        return unit(Vec4::from(from) * (1.0 - t) + Vec4::from(to) * t, from);
    }
    let angle_rad = trigonometry::acos(cosine);
    let of_from = trigonometry::sin((1.0 - t) * angle_rad);
    let of_to = trigonometry::sin(t * angle_rad);
    let mixed = Vec4::from(from) * of_from + Vec4::from(to) * of_to;
    unit(mixed, from)
}

/// Returns the rotation in the direction of these four numbers, or `otherwise` if they have no
/// direction.
pub(crate) fn unit(value: Vec4, otherwise: Quat) -> Quat {
    let length = value.length();
    if length > 1e-6 && length.is_finite() { Quat::from_vec4(value / length) } else { otherwise }
}
