//! Sets of rotations: all that lie between some, however they are mixed.
//!
//! Slerps, nlerps and normalised cubics of rotations are sums of quaternions with factors that are not
//! negative, brought to unit length: they lie in the cone of the quaternions. Dividing by the part along a
//! central one (Rodrigues' vector, the axis times the tangent of half the angle) makes such a cone a convex
//! set in space, and a box around the vectors of all keys holds every mix of them. The box is cut into
//! cells, whose corners stand for what is between them.
//!
//! **What a cell's corners say about the cell.** Let `q` be a sum of unit quaternions `q_k` with factors
//! `m_k` that together are 1, and `R_k` their rotations. Turning a vector by `q` is quadratic in `q`, and by
//! the parallelogram law
//!
//! ```text
//! |q|^2 R(q) d = sum m_k R_k d - 1/2 sum m_k m_l |q_k - q_l|^2 U_kl d,     |q|^2 = 1 - v,
//! v = 1/2 sum m_k m_l |q_k - q_l|^2 <= r^2
//! ```
//!
//! where `U_kl` are rotations and `r` is the radius of a sphere around the corners. So for a support function
//! `h` of points that are nowhere farther than `reach` from the origin
//!
//! ```text
//! h(R(q) d) <= (max h(R_k d) + r^2 reach) / (1 - r^2)
//! ```
//!
//! and without the division where that is negative. The error is of second order: cells of 16 degrees
//! across cost half a percent.

use glam::{Quat, Vec3, Vec4, Vec4Swizzles};

/// The cosine of the largest angle between quaternions and the central one. Within it any two are less than
/// 90 degrees apart, so the shorter arc between any two mixes stays in the cone, and signs are clear.
const WIDEST_COSINE: f32 = 0.71;
/// The length of a cell's edges, in Rodrigues' vectors: 9 degrees of rotation.
const EDGE: f32 = 0.08;
/// What is flatter than this (0.01 degrees) has corners in its middle only; `Cells::flat` makes up for it.
const FLAT: f32 = 1e-4;

/// Rotations that stand for a set.
#[derive(Clone, Debug)]
pub(crate) enum RotationSet {
    /// Corners of cells; the square of the radius of the spheres around each cell's corners; how far beside
    /// the cells a rotation may be, in radians.
    Cells { corners: Vec<Quat>, squared_radius: f32, flat: f32 },
    /// Any rotation at all.
    Any,
}

/// Collects what a set must hold.
#[derive(Clone, Debug, Default)]
pub(crate) struct RotationHull {
    /// Unit quaternions, those of one piece with signs that fit each other.
    points: Vec<Vec4>,
    /// How many of them each piece has.
    pieces: Vec<usize>,
    /// A point had no direction.
    is_any: bool,
}

impl RotationHull {
    /// Adds the cone of these points.
    pub fn add(&mut self, points: &[Vec4]) {
        for point in points {
            let length = point.length();
            self.is_any |= !(length > 1e-3 && length.is_finite());
            self.points.push(*point / length);
        }
        self.pieces.push(points.len());
    }

    /// The set, of at most `most_corners` corners.
    pub fn enclose(&self, most_corners: usize) -> RotationSet {
        let any = RotationSet::Any;
        let Some(centre) = self.centre().filter(|_| !self.is_any && most_corners >= 8) else {
            return any;
        };
        let mut vectors = Vec::with_capacity(self.points.len());
        let mut points = self.points.iter();
        for piece in &self.pieces {
            let mut piece_side = 0.0;
            for point in points.by_ref().take(*piece) {
                let along = point.dot(centre);
                if along.abs() < WIDEST_COSINE || along * piece_side < 0.0 {
                    return any;
                }
                piece_side = along;
                let relative =
                    Vec4::from(Quat::from_vec4(centre).conjugate() * Quat::from_vec4(*point));
                vectors.push(relative.xyz() / relative.w);
            }
        }
        cells(Quat::from_vec4(centre), &vectors, most_corners)
    }

    /// The mean of all, with their signs turned to one side.
    fn centre(&self) -> Option<Vec4> {
        let mut centre = *self.points.first()?;
        for _ in 0..3 {
            let aligned = self.points.iter().map(|p| if p.dot(centre) < 0.0 { -*p } else { *p });
            centre = aligned.sum::<Vec4>().try_normalize()?;
        }
        Some(centre)
    }
}

/// A box around the vectors, turned to fit them, and its cells' corners.
fn cells(centre: Quat, vectors: &[Vec3], most_corners: usize) -> RotationSet {
    let axes = fitting_axes(vectors);
    let along = |axis: Vec3| vectors.iter().map(move |vector| vector.dot(axis));
    let spans = axes.map(|axis| {
        let least = along(axis).fold(f32::INFINITY, f32::min);
        (least, along(axis).fold(f32::NEG_INFINITY, f32::max) - least)
    });
    let mut edge = EDGE;
    let counts = loop {
        let count = |size: f32| if size < FLAT { 0 } else { (size / edge).ceil() as usize };
        let counts = spans.map(|(_, size)| count(size));
        if counts.iter().map(|count| count + 1).product::<usize>() <= most_corners {
            break counts;
        }
        edge *= 1.25;
    };
    let at = |axis: usize, step: usize| {
        let (Some((least, size)), Some(count)) = (spans.get(axis), counts.get(axis)) else {
            return 0.0;
        };
        // A flat side has its one corner in the middle.
        if *count == 0 { least + size * 0.5 } else { least + size * (step as f32 / *count as f32) }
    };
    let mut corners = Vec::new();
    let [first, second, third] = counts;
    for x in 0..=first {
        for y in 0..=second {
            for z in 0..=third {
                let vector = axes[0] * at(0, x) + axes[1] * at(1, y) + axes[2] * at(2, z);
                let relative = Quat::from_vec4(vector.extend(1.0)).normalize();
                corners.push(centre * relative);
            }
        }
    }
    let edges = [0, 1, 2].map(|axis| match (spans.get(axis), counts.get(axis)) {
        (Some((_, size)), Some(count)) => size / (*count).max(1) as f32,
        _ => 0.0,
    });
    // Bringing (vector, 1) to unit length brings no two of them farther apart.
    let squared_radius = Vec3::from(edges).length_squared() * 0.25;
    if squared_radius >= 0.5 {
        return RotationSet::Any;
    }
    let flats = spans.iter().zip(counts).filter(|(_, count)| *count == 0);
    // Half of the size, of half of the angle.
    let flat = flats.map(|((_, size), _)| size).sum();
    RotationSet::Cells { corners, squared_radius, flat }
}

/// Three axes: the first from the mean to the farthest vector, the second to the farthest beside that.
fn fitting_axes(vectors: &[Vec3]) -> [Vec3; 3] {
    let mean = vectors.iter().sum::<Vec3>() / vectors.len().max(1) as f32;
    let farthest = |beside: &dyn Fn(Vec3) -> Vec3| {
        let offsets = vectors.iter().map(|vector| beside(*vector - mean));
        let longest = offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        longest.and_then(Vec3::try_normalize)
    };
    let first = farthest(&|offset| offset).unwrap_or(Vec3::X);
    let second = farthest(&|offset| offset.reject_from_normalized(first));
    let second =
        second.map(|second| second.reject_from_normalized(first)).and_then(Vec3::try_normalize);
    let second = second.unwrap_or_else(|| first.any_orthonormal_vector());
    [first, second, first.cross(second)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector(size: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    proptest! {
        /// Any mix of rotations turns a point no farther along any direction than the set says.
        #[test]
        fn a_set_holds_all_mixes(
            turns in prop::collection::vec((vector(0.8), 0.0_f32..1.0), 1..5),
            base in vector(3.0), point in vector(1.0), direction in vector(1.0), most in 8_usize..500
        ) {
            let base = Quat::from_scaled_axis(base);
            let mut hull = RotationHull::default();
            let mut mix = Vec4::ZERO;
            for (turn, factor) in &turns {
                let point = Vec4::from(base * Quat::from_scaled_axis(*turn));
                hull.add(&[point]);
                mix += point * *factor;
            }
            let direction = direction.normalize_or(Vec3::X);
            let Some(mix) = mix.try_normalize() else { return Ok(()) };
            if let RotationSet::Cells { corners, squared_radius, flat } = hull.enclose(most) {
                prop_assert!(corners.len() <= most);
                let exact = (Quat::from_vec4(mix) * point).dot(direction);
                let most = corners.iter().map(|q| (*q * point).dot(direction));
                let bound =
                    most.fold(f32::NEG_INFINITY, f32::max) + (squared_radius + flat) * point.length();
                let bound = if bound > 0.0 { bound / (1.0 - squared_radius) } else { bound };
                prop_assert!(exact <= bound + 1e-5, "{exact} beyond {bound}");
            }
        }
    }
}
