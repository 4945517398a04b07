//! The way of counting at a volume's boundary, and the caps that it requires.

use cull::{Aabb, ProjectionKind, Rays};
use glam::{Vec2, Vec3, Vec4};

use super::mesh::{VolumeKind, rounding};

/// The part of a volume's boundary that changes a pixel's stencil count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VolumeCounting {
    /// The part in front of the visible surface, where the depth test passes. Wrong if the eye is
    /// in a volume.
    ZPass,
    /// The part at or behind the visible surface, where the depth test fails. Always right, but
    /// slower.
    ZFail,
}

/// The caps of a volume that are drawn in addition to its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Caps {
    /// None.
    None,
    /// The triangles themselves.
    Near,
    /// The triangles, and their copies at the far end.
    Both,
}

impl VolumeCounting {
    /// Returns the caps that volumes of this kind need.
    ///
    /// With z-pass, a far cap is never in front of the visible surface. The near cap of a closed
    /// mesh is not either, since the mesh's own surface covers it. A mesh that is not closed may be
    /// seen from its back, which covers nothing.
    #[must_use]
    pub fn caps(self, kind: VolumeKind) -> Caps {
        match (self, kind) {
            (Self::ZFail, _) => Caps::Both,
            (Self::ZPass, VolumeKind::Plain) => Caps::None,
            (Self::ZPass, VolumeKind::Robust) => Caps::Near,
        }
    }
}

/// The corners of the near plane's rectangle and the eye: the points whose hull is the part of a
/// view that its near plane cuts off. Empty if this part is infinite, as in a parallel view.
#[derive(Clone, Copy, Debug)]
pub struct NearSpan<'a>(pub &'a [Vec3]);

impl NearSpan<'_> {
    /// Returns the points of a view.
    #[must_use]
    pub fn points_of(rays: &Rays) -> Vec<Vec3> {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|corner| rays.point(Vec2::from(corner), rays.near));
        match rays.kind {
            ProjectionKind::Perspective => corners.into_iter().chain([rays.origin]).collect(),
            ProjectionKind::Orthographic => Vec::new(),
        }
    }
}

const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

impl NearSpan<'_> {
    /// Returns the way of counting that is right for casters in a box: [`VolumeCounting::ZFail`] if
    /// the hull of the span and of a light may meet the box.
    ///
    /// The light is in homogeneous coordinates: a point with w = 1, or the direction towards it
    /// with w = 0. The test looks for a plane between box and hull. If none is found, as with
    /// numbers that are not finite, the result is z-fail.
    #[must_use]
    pub fn counting(self, bounds: &Aabb, light: Vec4) -> VolumeCounting {
        let reach = self.0.iter().fold(light.truncate().abs(), |most, at| most.max(at.abs()));
        let bounds = bounds.enlarged(rounding(bounds, reach));
        let axes = AXES.into_iter().chain(self.edge_normals(light)).chain(self.side_normals(light));
        let is_apart = |axis: Vec3| {
            self.is_beyond(&bounds, light, axis) || self.is_beyond(&bounds, light, -axis)
        };
        if axes.into_iter().any(is_apart) { VolumeCounting::ZPass } else { VolumeCounting::ZFail }
    }

    /// Returns the normals of planes that contain an edge direction of the box and a line to the
    /// light.
    fn edge_normals(self, light: Vec4) -> impl Iterator<Item = Vec3> {
        self.0.iter().flat_map(move |point| {
            let to_light = light.truncate() - light.w * point;
            AXES.map(|axis| axis.cross(to_light).normalize_or_zero())
        })
    }

    /// Returns the normals of planes through the light and two points, and through three points.
    fn side_normals(self, light: Vec4) -> impl Iterator<Item = Vec3> {
        let pairs = self.0.iter().enumerate();
        pairs.flat_map(move |(place, &a)| {
            let rest = self.0.iter().skip(place + 1);
            rest.enumerate().flat_map(move |(next, &b)| {
                let to_light = light.truncate() - light.w * a;
                let third = self.0.get(place + next + 2).map(|c| (b - a).cross(*c - a));
                let corners = [Some((b - a).cross(to_light)), third];
                corners.into_iter().flatten().map(Vec3::normalize_or_zero)
            })
        })
    }

    /// Returns true if the hull lies farther along an axis than the whole box.
    fn is_beyond(self, bounds: &Aabb, light: Vec4, axis: Vec3) -> bool {
        let most = bounds.centre().dot(axis) + bounds.half_extent().dot(axis.abs());
        let towards = light.truncate().dot(axis);
        let is_light_beyond = if light.w > 0.0 { towards > most * light.w } else { towards >= 0.0 };
        // A zero axis separates nothing.
        axis != Vec3::ZERO
            && !self.0.is_empty()
            && is_light_beyond
            && self.0.iter().all(|point| point.dot(axis) > most)
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    const SUN: Vec4 = Vec4::Y;

    fn span() -> [Vec3; 5] {
        [
            vec3(0.0, 2.0, 0.0),
            vec3(-0.1, 1.9, -0.1),
            vec3(0.1, 1.9, -0.1),
            vec3(0.1, 2.1, -0.1),
            vec3(-0.1, 2.1, -0.1),
        ]
    }

    fn of(low: Vec3, high: Vec3, light: Vec4) -> VolumeCounting {
        NearSpan(&span()).counting(&Aabb::new(low, high), light)
    }

    #[test]
    fn open_meshes_have_a_near_cap_where_closed_ones_have_none() {
        let caps = [VolumeCounting::ZPass, VolumeCounting::ZFail].map(|counting| {
            [VolumeKind::Plain, VolumeKind::Robust].map(|kind| counting.caps(kind))
        });
        assert_eq!(caps, [[Caps::None, Caps::Near], [Caps::Both; 2]]);
    }

    #[test]
    fn casters_between_eye_and_light_are_counted_by_z_fail() {
        let roof = (vec3(-5.0, 4.0, -5.0), vec3(5.0, 4.5, 5.0));
        assert_eq!(of(roof.0, roof.1, SUN), VolumeCounting::ZFail);
        assert_eq!(of(roof.0 + Vec3::X * 5.2, roof.1 + Vec3::X * 9.0, SUN), VolumeCounting::ZPass);
        // A caster below the eye casts no shadow up to it.
        assert_eq!(of(vec3(-5.0, 0.0, -5.0), vec3(5.0, 1.0, 5.0), SUN), VolumeCounting::ZPass);
        assert_eq!(of(vec3(-5.0, 0.0, -5.0), vec3(5.0, 1.95, 5.0), SUN), VolumeCounting::ZFail);
    }

    #[test]
    fn a_lamp_spans_a_pyramid() {
        let lamp = vec3(4.0, 2.0, 0.0).extend(1.0);
        let at = |x: f32| of(vec3(x, 1.5, -1.0), vec3(x + 0.2, 2.5, 1.0), lamp);
        assert_eq!(
            [at(2.0), at(4.5), at(-2.0)],
            [VolumeCounting::ZFail, VolumeCounting::ZPass, VolumeCounting::ZPass]
        );
        // Beside the thin end of the pyramid, but inside the pyramid's box.
        assert_eq!(of(vec3(3.0, 2.07, -0.1), vec3(3.2, 2.2, 0.1), lamp), VolumeCounting::ZPass);
        let lamp = vec3(4.0, 6.0, 3.0).extend(1.0);
        assert_eq!(of(vec3(2.5, 2.5, 0.2), vec3(3.5, 3.2, 0.9), lamp), VolumeCounting::ZPass);
        assert_eq!(of(vec3(1.9, 3.9, 1.3), vec3(2.1, 4.1, 1.6), lamp), VolumeCounting::ZFail);
    }

    #[test]
    fn what_is_unclear_is_counted_by_z_fail() {
        let bounds = Aabb::new(Vec3::ZERO, Vec3::ONE);
        assert_eq!(NearSpan(&[]).counting(&bounds, SUN), VolumeCounting::ZFail);
        let lost = [Vec3::NAN; 5];
        assert_eq!(NearSpan(&lost).counting(&bounds, SUN), VolumeCounting::ZFail);
        assert_eq!(of(Vec3::splat(f32::NAN), Vec3::ONE, SUN), VolumeCounting::ZFail);
        assert_eq!(of(Vec3::ZERO, Vec3::splat(f32::INFINITY), SUN), VolumeCounting::ZFail);
        let point = [vec3(0.0, 9.0, 0.0)];
        assert_eq!(NearSpan(&point).counting(&bounds, Vec4::NAN), VolumeCounting::ZFail);
    }

    #[test]
    fn a_light_inside_needs_the_robust_algorithm() {
        let bounds = Aabb::new(Vec3::ZERO, Vec3::ONE);
        let of = |light| VolumeKind::Plain.towards(&bounds, light);
        assert_eq!(of(Vec3::splat(0.5).extend(1.0)), VolumeKind::Robust);
        assert_eq!(of(vec3(0.5, 1.0, 0.5).extend(1.0)), VolumeKind::Robust);
        assert_eq!(of(vec3(0.5, 1.1, 0.5).extend(1.0)), VolumeKind::Plain);
        assert_eq!(of(Vec3::splat(0.5).extend(0.0)), VolumeKind::Plain);
        let robust = VolumeKind::Robust.towards(&bounds, SUN);
        assert_eq!(robust, VolumeKind::Robust);
    }
}
