//! The part of the screen that a box covers: its outline and its approximate number of pixels.

use glam::{Vec2, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::margin::rounding;
use crate::geom::rays::Rays;
use crate::geom::view::CullView;

/// The outline of a box on the screen, in pixels; its corners are in one direction of rotation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    corners: [Vec2; Self::MOST],
    count: usize,
}

impl Outline {
    /// The most corners: an outline has at most six of a box's eight corners, and each side of the
    /// screen can add one.
    const MOST: usize = 12;

    /// The outline of nothing.
    pub(crate) const EMPTY: Self = Self { corners: [Vec2::ZERO; Self::MOST], count: 0 };

    /// Returns the outline of a box with these corners on the screen: the convex hull, by Andrew's
    /// monotone chain.
    pub(crate) fn around(mut points: [Vec2; 8]) -> Self {
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let mut hull = Self::EMPTY;
        for backwards in [false, true] {
            let start = hull.count;
            for step in 0..points.len() {
                let point = points[if backwards { points.len() - 1 - step } else { step }];
                while hull.count >= start + 2 && hull.turns_right(point) {
                    hull.count -= 1;
                }
                if hull.count < Self::MOST {
                    hull.corners[hull.count] = point;
                    hull.count += 1;
                }
            }
            // The last point of one chain is the first of the other.
            hull.count = hull.count.saturating_sub(1);
        }
        hull
    }

    /// Returns true if rounding moves the outline only by a little, both on the CPU and in the
    /// rasterizer.
    pub(crate) fn is_sharp(&self, bounds: &Aabb, view: &CullView) -> bool {
        const MOST_PIXELS: f32 = 1.0 / 16.0;
        // Beyond this, fractions of a pixel are lost, and products of two such coordinates no
        // longer separate the sides.
        const FARTHEST_PIXELS: f32 = 32_768.0;
        let reach = view.rays.forward.abs().dot(bounds.half_extent());
        let nearest = view.rays.depth_m(bounds.centre()) - reach;
        rounding(bounds, view.rays.coordinate) <= MOST_PIXELS * view.pixel_m(nearest)
            && self.points().all(|point| point.abs().max_element() <= FARTHEST_PIXELS)
    }

    fn turns_right(&self, point: Vec2) -> bool {
        let before = self.corners[self.count - 2];
        let last = self.corners[self.count - 1];
        (last - before).perp_dot(point - last) <= 0.0
    }

    pub(crate) fn points(&self) -> impl Iterator<Item = Vec2> {
        self.corners[..self.count].iter().copied()
    }

    fn edges(&self) -> impl Iterator<Item = (Vec2, Vec2)> {
        let corners = &self.corners[..self.count];
        let next = corners.iter().skip(1).chain(corners.first());
        corners.iter().copied().zip(next.copied())
    }

    /// Returns the part of the outline on the screen, which may be empty.
    pub(crate) fn clipped(&self, size: [f32; 2]) -> Self {
        let [width, height] = size;
        let sides = [(Vec2::X, 0.0), (Vec2::NEG_X, width), (Vec2::Y, 0.0), (Vec2::NEG_Y, height)];
        sides.into_iter().fold(*self, |outline, (normal, offset)| {
            if outline.points().all(|point| normal.dot(point) + offset >= 0.0) {
                return outline;
            }
            let mut kept = Self::EMPTY;
            let mut keep = |point| {
                if kept.count < Self::MOST {
                    kept.corners[kept.count] = point;
                    kept.count += 1;
                }
            };
            for (from, to) in outline.edges() {
                let [inside, next] = [from, to].map(|point| normal.dot(point) + offset);
                if inside >= 0.0 {
                    keep(from);
                }
                if (inside >= 0.0) != (next >= 0.0) {
                    keep(from + (to - from) * (inside / (inside - next)));
                }
            }
            kept
        })
    }

    /// Returns the area of the outline (square pixels).
    pub(crate) fn area(&self) -> f32 {
        0.5 * self.edges().map(|(from, to)| from.perp_dot(to)).sum::<f32>().abs()
    }

    /// Returns true if a point is inside, with an allowance for rounding that is far below the
    /// margin.
    pub(crate) fn holds(&self, point: Vec2) -> bool {
        const ALLOWED_PIXELS: f32 = 1.0 / 64.0;
        self.count >= 3
            && self.edges().all(|(from, to)| {
                let edge = to - from;
                edge.perp_dot(point - from) >= -ALLOWED_PIXELS * edge.length()
            })
    }
}

/// The rectangle around a part of the screen (pixels): the low corner, and the high corner negated,
/// so that one comparison decides about all four sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenExtent(Vec4);

impl ScreenExtent {
    /// The extent of nothing, which every extent contains.
    pub(crate) const NOTHING: Self = Self(Vec4::INFINITY);

    pub(crate) fn around(points: impl Iterator<Item = Vec2>) -> Self {
        Self(points.fold(Vec4::INFINITY, |extent, point| {
            extent.min(Vec4::new(point.x, point.y, -point.x, -point.y))
        }))
    }

    /// Returns the extent of the whole image of a view.
    pub(crate) fn of_screen(view: &CullView) -> Self {
        let [width, height] = view.size.map(|pixels| pixels as f32);
        Self(Vec4::new(0.0, 0.0, -width, -height))
    }

    pub(crate) fn is_nothing(self) -> bool {
        self.0.x == f32::INFINITY
    }

    pub(crate) fn contains(self, other: Self) -> bool {
        self.0.cmple(other.0).all()
    }

    /// Returns the area (square pixels).
    pub(crate) fn area(self) -> f32 {
        if self.is_nothing() { 0.0 } else { (self.0.x + self.0.z) * (self.0.y + self.0.w) }
    }
}

/// Returns the positions on the screen (pixels) of the corners of a box that is completely in front
/// of the eye. `None` if it is not, or if the numbers fail.
pub(crate) fn screen_corners(bounds: &Aabb, view: &CullView) -> Option<[Vec2; 8]> {
    let scale = Vec2::new(view.size[0] as f32, view.size[1] as f32) * 0.5;
    let matrix = &view.view_proj;
    // The products of the columns and the six coordinates, which the corners share.
    let along = |column: Vec4, axis: usize| [bounds.min, bounds.max].map(|at| column * at[axis]);
    let x = along(matrix.x_axis, 0);
    let y = along(matrix.y_axis, 1);
    let z = along(matrix.z_axis, 2);
    let mut nearest = f32::INFINITY;
    let corners = std::array::from_fn(|corner| {
        let clip = x[corner & 1] + y[corner >> 1 & 1] + z[corner >> 2] + matrix.w_axis;
        nearest = nearest.min(clip.w);
        ((clip / clip.w).truncate().truncate() + 1.0) * scale
    });
    let is_sound = nearest > 0.0 && corners.iter().all(|corner: &Vec2| corner.is_finite());
    is_sound.then_some(corners)
}

/// Returns the approximate number of pixels of `view` that a box covers, at most all pixels. Takes
/// the silhouette in the direction of its centre, as if the whole box were at the distance of its
/// centre.
pub(crate) fn covered_pixels(view: &CullView, bounds: &Aabb) -> f32 {
    let [width, height] = view.size.map(|pixels| pixels as f32);
    let Rays { origin, near, .. } = view.rays;
    if view.rays.distance_squared(bounds) == 0.0 {
        return width * height;
    }
    let sides = 2.0 * bounds.half_extent();
    let towards = view.rays.towards(bounds.centre());
    let distance = towards.dot(bounds.centre() - origin).max(near);
    let along = towards.abs();
    let area =
        along.x * sides.y * sides.z + along.y * sides.z * sides.x + along.z * sides.x * sides.y;
    let pixel_m = view.pixel_m(distance);
    let pixels = area / (pixel_m * pixel_m);
    if pixels.is_nan() { width * height } else { pixels.min(width * height) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::camera::{Camera, Projection};

    #[test]
    fn a_box_before_the_eye_covers_its_face() {
        let camera = Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: Projection::perspective(std::f32::consts::FRAC_PI_2),
            near: 0.1,
        };
        let view = CullView::new(&camera, [200, 100], 8);
        let at = |z: f32, half: f32| {
            let centre = Vec3::new(0.0, 0.0, z);
            covered_pixels(&view, &Aabb::new(centre - half, centre + half))
        };
        assert!((at(-10.0, 1.0) - 100.0).abs() < 1.0, "{}", at(-10.0, 1.0));
        assert_eq!(at(-10.0, 1_000.0), 20_000.0);
        assert_eq!(at(0.0, 1.0), 20_000.0);
    }
}
