//! Certificates that boxes are hidden from every eye near a point: an experiment.
//!
//! A certificate is found on an image that is some frames old, and saves tests in later frames. Its
//! image has one number per pixel: the depth beyond which one occluder hides everything in the
//! pixel, from every eye within a radius. See [`occluders`] for the proof, [`soundness`] for its
//! test, and [`walks`] for the share of frames that need no test. docs/lab/performance.md has the
//! results.

mod occluders;
mod soundness;
mod streets;
mod walks;

use antumbra_cull::{Aabb, CullView};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// The distance of the corner of a pixel from its middle (pixels), slightly more.
const HALF_DIAGONAL: f64 = 0.7072;

/// The occluders of one view, as seen by all eyes within a radius.
pub struct Certificate {
    view: CullView,
    /// For each pixel the inverse of the view depth beyond which everything is hidden; 0 if nothing
    /// is.
    hidden_beyond: Vec<f64>,
    /// The distance by which boxes count as larger on the image (pixels): 0 if only the middles of
    /// pixels are looked at.
    reach_pixels: f64,
}

/// The sides of an image that a box crosses: left, right, upper, lower.
pub type Sides = [bool; 4];

impl Certificate {
    /// Returns the sides of the image that a box crosses if its part within the image is hidden;
    /// `None` if some of it may show.
    pub fn covers(&self, bounds: &Aabb) -> Option<Sides> {
        let pixels = Pixels::of(&self.view, bounds)?;
        let [width, _] = self.view.size;
        let along = Along::of(&self.view);
        let enlarged = pixels.farthest_m * self.reach_pixels * along.pixel_m;
        let eye = self.view.rays.origin.as_dvec3();
        let relative = Slabs {
            low: bounds.min.as_dvec3() - eye - enlarged,
            high: bounds.max.as_dvec3() - eye + enlarged,
        };
        for row in pixels.rows.clone() {
            for column in pixels.columns.clone() {
                let middle = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let Some(nearest) = relative.inverse_depth(along.at(middle)) else { continue };
                let beyond = self.hidden_beyond[(row * width + column) as usize];
                if beyond <= nearest {
                    return None;
                }
            }
        }
        Some(pixels.crossed)
    }

    /// Returns the sides of the image within which all of a later view lies.
    pub fn sides_around(&self, later: &CullView) -> Sides {
        let inside = |clip: glam::DVec4| {
            let distances = [clip.w + clip.x, clip.w - clip.x, clip.w + clip.y, clip.w - clip.y];
            distances.map(|distance| distance >= -1.0e-6)
        };
        let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| later.rays.along(Vec2::new(x, y))));
        let matrix = self.view.from_anchor.as_dmat4();
        let directions = corners.as_flattened().iter();
        let directions = directions.map(|along| inside(matrix * along.as_dvec3().extend(0.0)));
        let eye = inside(self.view.clip(later.rays.origin));
        directions.fold(eye, |all, one| std::array::from_fn(|side| all[side] && one[side]))
    }
}

/// The directions through an image.
struct Along {
    corner: DVec3,
    /// The steps from pixel to pixel, to the right and down, over one metre of view depth.
    steps: [DVec3; 2],
    /// The size of a pixel over one metre of view depth (metres).
    pixel_m: f64,
}

impl Along {
    fn of(view: &CullView) -> Self {
        let [width, height] = view.size.map(f64::from);
        let right = view.rays.right.as_dvec3();
        let down = view.rays.down.as_dvec3();
        let steps = [right * 2.0 / width, down * 2.0 / height];
        let pixel_m = steps[0].length().max(steps[1].length());
        Self { corner: view.rays.middle.as_dvec3() - right - down, steps, pixel_m }
    }

    /// Returns the ray at a position (pixels), over one metre of view depth.
    fn at(&self, position: DVec2) -> DVec3 {
        self.corner + self.steps[0] * position.x + self.steps[1] * position.y
    }
}

/// A box relative to the eye.
#[derive(Clone, Copy)]
struct Slabs {
    low: DVec3,
    high: DVec3,
}

impl Slabs {
    /// Returns the inverse view depth at which a ray enters the plane of the face of each axis that
    /// the eye sees; infinite for an axis on which it sees none. Each is linear over the image.
    fn inverse_fronts(&self, along: DVec3) -> DVec3 {
        let front = |axis: usize| {
            if self.low[axis] > 0.0 {
                along[axis] / self.low[axis]
            } else if self.high[axis] < 0.0 {
                along[axis] / self.high[axis]
            } else {
                f64::INFINITY
            }
        };
        DVec3::new(front(0), front(1), front(2))
    }

    /// Returns the inverse view depth at which a ray enters the box; `None` if it misses the box.
    /// At the inverse depth `w`, a point is inside if `low * w <= along <= high * w`.
    fn inverse_depth(&self, along: DVec3) -> Option<f64> {
        let entry = self.inverse_fronts(along).min_element();
        let mut exit = 0.0_f64;
        for axis in 0..3 {
            if self.low[axis] < 0.0 {
                exit = exit.max(along[axis] / self.low[axis]);
            }
            if self.high[axis] > 0.0 {
                exit = exit.max(along[axis] / self.high[axis]);
            }
        }
        (entry > 0.0 && entry >= exit).then_some(entry)
    }
}

/// The pixels that a box may touch.
struct Pixels {
    columns: std::ops::Range<u32>,
    rows: std::ops::Range<u32>,
    crossed: Sides,
    /// The largest view depth of a corner (metres).
    farthest_m: f64,
}

impl Pixels {
    /// Returns the pixels of a box; `None` if a part of it is not in front of the near plane.
    fn of(view: &CullView, bounds: &Aabb) -> Option<Self> {
        let size = view.size.map(f64::from);
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        let mut farthest_m = 0.0_f64;
        for corner in bounds.corners() {
            let clip = view.clip(corner);
            if clip.w <= f64::from(view.rays.near) {
                return None;
            }
            farthest_m = farthest_m.max(clip.w);
            let ndc = DVec2::new(clip.x, clip.y) / clip.w;
            let position = (ndc + 1.0) * 0.5 * DVec2::from(size);
            low = low.min(position);
            high = high.max(position);
        }
        let slack = 0.01;
        let crossed =
            [low.x < slack, high.x > size[0] - slack, low.y < slack, high.y > size[1] - slack];
        let range = |axis: usize| {
            let start = (low[axis] - 1.0).clamp(0.0, size[axis]);
            start as u32..(high[axis] + 2.0).clamp(start, size[axis]) as u32
        };
        Some(Self { columns: range(0), rows: range(1), crossed, farthest_m })
    }
}

/// Returns the distance from a point to the farthest corner of a box.
fn farthest_m(bounds: &Aabb, point: Vec3) -> f32 {
    let away = (bounds.min - point).abs().max((bounds.max - point).abs());
    away.length()
}
