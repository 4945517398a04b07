//! Section planes: the parts of objects on the removed side are cut away and not drawn.
//!
//! A node whose box lies completely on the removed side counts as outside of a view, as if it were
//! outside of the frustum. Proxies stay whole: the uncut box is nearer than any remaining part
//! inside of it, so a test of it can only reveal too much.

use glam::{DVec3, DVec4};
use thiserror::Error;

use crate::geom::bounds::Aabb;
use crate::geom::margin::rounding;

/// The combination of several section planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SectionMode {
    /// The part that all planes keep.
    #[default]
    Intersection,
    /// The part that at least one plane keeps.
    Union,
}

/// The part of an object that section planes leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SectionMember {
    /// The part that the planes keep.
    #[default]
    Cut,
    /// The whole object: section planes do not apply to it.
    Whole,
}

/// The reason why planes are not a valid section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SectionError {
    /// A normal that is zero or not finite.
    #[error("a section plane needs a normal that is not zero and finite: give it a direction")]
    Normal,
    /// An offset that is not finite.
    #[error("the offset of a section plane must be a finite number of metres")]
    Offset,
    /// More planes than [`SectionPlanes::MAX`].
    #[error("{count} section planes: there may be up to {}", SectionPlanes::MAX)]
    Count {
        /// The number of planes.
        count: usize,
    },
}

/// A plane that keeps the points `p` with `normal · p + offset >= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlane {
    normal: DVec3,
    offset_m: f64,
}

impl SectionPlane {
    /// Creates a plane. A normal whose length is not 1 is normalised together with the offset, so
    /// that the same points are kept.
    ///
    /// # Errors
    /// [`SectionError::Normal`] or [`SectionError::Offset`].
    pub fn new(normal: DVec3, offset_m: f64) -> Result<Self, SectionError> {
        if !normal.is_finite() {
            return Err(SectionError::Normal);
        }
        // Scaled first: the squared length of a normal beyond 1e150 overflows, and below 1e-150 it
        // underflows.
        let scale = normal.abs().max_element();
        if scale <= 0.0 {
            return Err(SectionError::Normal);
        }
        let scaled = normal / scale;
        let offset_m = offset_m / scale / scaled.length();
        if offset_m.is_finite() {
            Ok(Self { normal: scaled.normalize(), offset_m })
        } else {
            Err(SectionError::Offset)
        }
    }

    /// Returns the unit normal, which points to the kept side.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Returns the offset: the distance of the origin from the plane, positive on the kept side
    /// (metres).
    #[must_use]
    pub fn offset_m(&self) -> f64 {
        self.offset_m
    }

    /// Returns the signed distance of a point, positive on the kept side (metres).
    #[must_use]
    pub fn distance_m(&self, point: DVec3) -> f64 {
        self.normal.dot(point) + self.offset_m
    }

    /// Returns the coefficients of the plane for points relative to `anchor`.
    #[must_use]
    pub fn from_anchor(&self, anchor: DVec3) -> DVec4 {
        self.normal.extend(self.distance_m(anchor))
    }

    /// Returns the smallest and the largest signed distance of the points of a box (metres).
    pub(crate) fn reach_m(&self, bounds: &Aabb) -> [f64; 2] {
        let low = bounds.min.as_dvec3();
        let high = bounds.max.as_dvec3();
        let middle = self.distance_m((low + high) * 0.5);
        let reach = self.normal.abs().dot((high - low) * 0.5);
        [middle - reach, middle + reach]
    }
}

impl Default for SectionPlane {
    /// Creates the horizontal plane through the origin that keeps the points above it.
    fn default() -> Self {
        Self { normal: DVec3::Y, offset_m: 0.0 }
    }
}

/// The section planes of a view, at most six. By default there are none, which keeps everything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionPlanes {
    planes: [SectionPlane; Self::MAX],
    count: usize,
    mode: SectionMode,
}

impl SectionPlanes {
    /// The most planes.
    pub const MAX: usize = 6;

    /// Creates a section from planes and their combination. Without planes everything is kept in
    /// either mode.
    ///
    /// # Errors
    /// [`SectionError::Count`] for more than [`SectionPlanes::MAX`] planes.
    pub fn new(planes: &[SectionPlane], mode: SectionMode) -> Result<Self, SectionError> {
        let mut section = Self { mode, ..Self::default() };
        let Some(places) = section.planes.get_mut(..planes.len()) else {
            return Err(SectionError::Count { count: planes.len() });
        };
        places.copy_from_slice(planes);
        section.count = planes.len();
        Ok(section)
    }

    /// Returns the planes.
    #[must_use]
    pub fn planes(&self) -> &[SectionPlane] {
        self.planes.get(..self.count).unwrap_or_default()
    }

    /// Returns the same planes in coordinates whose origin is at the point `origin_m` of the
    /// present ones.
    #[must_use]
    pub fn from_origin(&self, origin_m: DVec3) -> Self {
        let mut section = *self;
        for plane in &mut section.planes {
            plane.offset_m += plane.normal.dot(origin_m);
        }
        section
    }

    /// Returns the combination of the planes.
    #[must_use]
    pub fn mode(&self) -> SectionMode {
        self.mode
    }

    /// Returns true if there are no planes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns true if the planes keep a point.
    #[must_use]
    pub fn keeps(&self, point: DVec3) -> bool {
        let keeps = |plane: &SectionPlane| plane.distance_m(point) >= 0.0;
        match self.mode {
            _ if self.is_empty() => true,
            SectionMode::Intersection => self.planes().iter().all(keeps),
            SectionMode::Union => self.planes().iter().any(keeps),
        }
    }

    /// Returns true if a plane may cut or touch the contents of a box.
    #[must_use]
    pub fn meets(&self, bounds: &Aabb) -> bool {
        let slack_m = f64::from(rounding(bounds, 0.0));
        self.planes().iter().any(|plane| {
            let [nearest, farthest] = plane.reach_m(bounds);
            nearest <= slack_m && farthest >= -slack_m
        })
    }

    /// Returns true if no point within `slack_m` of a box is kept. In an intersection one plane
    /// must remove the box, in a union all planes must.
    #[must_use]
    pub fn removes(&self, bounds: &Aabb, slack_m: f32) -> bool {
        let removes = |plane: &SectionPlane| {
            let [_, farthest] = plane.reach_m(bounds);
            farthest < -f64::from(slack_m)
        };
        match self.mode {
            _ if self.is_empty() => false,
            SectionMode::Intersection => self.planes().iter().any(removes),
            SectionMode::Union => self.planes().iter().all(removes),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn plane(normal: DVec3, offset_m: f64) -> SectionPlane {
        SectionPlane::new(normal, offset_m).unwrap()
    }

    #[test]
    fn a_plane_is_the_same_whatever_the_length_of_its_normal() {
        for scale in [1.0, 2.0, 1.0e-300, 1.0e300] {
            let plane = plane(DVec3::new(0.0, 3.0, 4.0) * scale, 10.0 * scale);
            assert!((plane.normal() - DVec3::new(0.0, 0.6, 0.8)).length() < 1.0e-15);
            assert!((plane.offset_m() - 2.0).abs() < 1.0e-14);
        }
    }

    #[test]
    fn what_is_no_plane_is_refused_with_a_sentence() {
        for normal in [DVec3::ZERO, DVec3::NAN, DVec3::new(0.0, f64::INFINITY, 0.0)] {
            assert_eq!(SectionPlane::new(normal, 0.0), Err(SectionError::Normal));
        }
        assert_eq!(SectionPlane::new(DVec3::X, f64::NAN), Err(SectionError::Offset));
        let seven = [SectionPlane::default(); 7];
        let error = SectionPlanes::new(&seven, SectionMode::Union).unwrap_err();
        assert_eq!(error.to_string(), "7 section planes: there may be up to 6");
    }

    #[test]
    fn an_intersection_removes_by_one_plane_and_a_union_by_all() {
        let planes = [plane(DVec3::X, 0.0), plane(DVec3::Y, 0.0)];
        let both = SectionPlanes::new(&planes, SectionMode::Intersection).unwrap();
        let either = SectionPlanes::new(&planes, SectionMode::Union).unwrap();
        let cube = |x: f32, y: f32| {
            let centre = Vec3::new(x, y, 0.0);
            Aabb::new(centre - 1.0, centre + 1.0)
        };
        for (bounds, of_both, of_either) in [
            (cube(2.0, 2.0), false, false),
            (cube(-2.0, 2.0), true, false),
            (cube(-2.0, -2.0), true, true),
            (cube(-0.5, -0.5), false, false),
            // It touches the plane, so it is not certain to be removed.
            (cube(-1.0, 2.0), false, false),
        ] {
            assert_eq!(both.removes(&bounds, 1.0e-6), of_both, "{bounds:?}");
            assert_eq!(either.removes(&bounds, 1.0e-6), of_either, "{bounds:?}");
        }
        let none = SectionPlanes::default();
        assert!(!none.removes(&cube(0.0, 0.0), 0.0) && none.keeps(DVec3::NEG_ONE));
    }
}
