//! A depth buffer that boxes are drawn into by casting the ray of each pixel.
//!
//! All of it follows from the view's matrix alone: rays are those of its inverse, in 64 bits, and
//! depths are its own. Snapping to the sub-pixel grid is simulated by shifting the rays of a box by
//! up to one step of the grid; the rounding of depths by an error of some units in the last place
//! of their terms, another one for each box and pixel.

use antumbra_cull::{Aabb, DepthConvention, ProjectionKind, View};
use glam::{DMat4, DVec3, DVec4, Mat4};

/// The points where a ray enters and leaves a box.
struct Span {
    enters: Hit,
    leaves: Hit,
}

/// A point on a ray.
#[derive(Clone, Copy)]
struct Hit {
    /// The way from the near plane, of any scale; negative before it.
    way: f64,
    /// The depth, nearer ones larger. Beyond the far plane it is below that of the far plane.
    depth: f32,
}

/// The shift of the rays of a box (pixels), to the right and down.
pub type Shift = [f64; 2];

#[derive(Clone)]
pub struct Image {
    size: [u32; 2],
    /// The depth of each pixel; larger is nearer, also where depth is not reversed: it has the
    /// other sign then.
    pub depths: Vec<f32>,
}

impl Image {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, depths: vec![f32::NEG_INFINITY; (size[0] * size[1]) as usize] }
    }

    pub fn clear(&mut self) {
        self.depths.fill(f32::NEG_INFINITY);
    }

    /// Draws a solid box and returns the number of samples that passed. From inside its far faces
    /// are seen.
    pub fn draw(&mut self, view: &View, bounds: &Aabb, shift: Shift) -> u32 {
        let farthest = signed(view, view.depth.farthest());
        let mut passed = 0;
        cast(self.size, view, bounds, (shift, &view.view_proj), |pixel, span| {
            let hit = if span.enters.way >= 0.0 { span.enters } else { span.leaves };
            let stored = &mut self.depths[pixel];
            if hit.depth >= *stored && hit.depth >= farthest {
                *stored = hit.depth;
                passed += 1;
            }
        });
        passed
    }

    /// Counts samples of the front faces of a box that pass, without writing; faces before the
    /// near plane are clipped away.
    pub fn test(&self, view: &View, bounds: &Aabb, shift: Shift) -> u32 {
        let nearest = signed(view, view.depth.nearest());
        let farthest = signed(view, view.depth.farthest());
        let mut passed = 0;
        let matrix = view.proxy_view_proj();
        cast(self.size, view, bounds, (shift, &matrix), |pixel, Span { enters, .. }| {
            let is_clipped = enters.way < 0.0 || !(farthest..=nearest).contains(&enters.depth);
            passed += u32::from(!is_clipped && enters.depth >= self.depths[pixel]);
        });
        passed
    }
}

/// Returns a depth as it is stored, nearer ones larger.
fn signed(view: &View, depth: f32) -> f32 {
    match view.depth {
        DepthConvention::Reversed => depth,
        DepthConvention::Standard => -depth,
    }
}

/// Calls `hit` for each pixel whose ray meets the box beyond the near plane, with the depths of
/// another matrix.
fn cast(
    size: [u32; 2],
    view: &View,
    bounds: &Aabb,
    (shift, drawn): (Shift, &Mat4),
    mut hit: impl FnMut(usize, Span),
) {
    let matrix = view.view_proj.as_dmat4();
    let inverse = matrix.inverse();
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let Some([columns, rows]) = rectangle(size, &matrix, bounds) else {
        return;
    };
    let [nearest, farthest] = [view.depth.nearest(), view.depth.farthest()].map(f64::from);
    // An infinite far plane is where an unproject would divide by zero.
    let middle = 0.5 * (nearest + farthest);
    let at = |x: f64, y: f64, depth: f64| {
        let point = inverse * DVec4::new(x, y, depth, 1.0);
        point.truncate() / point.w
    };
    for row in rows {
        let down = (f64::from(row) + 0.5 + shift[1]) / f64::from(size[1]) * 2.0 - 1.0;
        for column in columns.clone() {
            let across = (f64::from(column) + 0.5 + shift[0]) / f64::from(size[0]) * 2.0 - 1.0;
            let start = at(across, down, nearest);
            let ray = at(across, down, middle) - start;
            let recip = ray.recip();
            let (a, b) = ((min - start) * recip, (max - start) * recip);
            let ways = [lowest(a, b), highest(a, b)];
            if !(ways[0] <= ways[1] && ways[1] >= 0.0) {
                continue;
            }
            let pixel = (row * size[0] + column) as usize;
            let hits = ways.map(|way| {
                let clip = matrix * (start + ray * way).extend(1.0);
                let noise = noise(bounds, pixel) * terms(view, clip);
                let z = drawn.row(2).as_dvec4().dot((start + ray * way).extend(1.0)) + noise;
                Hit { way, depth: signed(view, (z / clip.w) as f32) }
            });
            hit(pixel, Span { enters: hits[0], leaves: hits[1] });
        }
    }
}

/// Returns the size of what clip z is the sum of: its constant share of w, and the rest.
fn terms(view: &View, clip: DVec4) -> f64 {
    let constant = match view.rays.kind {
        ProjectionKind::Perspective => f64::from(view.rays.depth[0]) * clip.w,
        ProjectionKind::Orthographic => f64::from(view.rays.depth[0]),
    };
    constant.abs() + (clip.z - constant).abs()
}

/// Returns an error of rounding, up to four units in the last place, that a box has at a pixel.
fn noise(bounds: &Aabb, pixel: usize) -> f64 {
    let seed = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
    let hash = seed.fold(pixel as u64, |hash, coordinate| {
        (hash ^ u64::from(coordinate.to_bits())).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
    });
    let share = (hash >> 40) as f64 / (1_u64 << 24) as f64;
    (share * 2.0 - 1.0) * 4.0 * f64::from(f32::EPSILON)
}

fn lowest(a: DVec3, b: DVec3) -> f64 {
    a.min(b).max_element()
}

fn highest(a: DVec3, b: DVec3) -> f64 {
    a.max(b).min_element()
}

/// Returns the pixels that a box can touch, with some to spare; `None` if it is behind the eye.
fn rectangle(size: [u32; 2], matrix: &DMat4, bounds: &Aabb) -> Option<[std::ops::Range<u32>; 2]> {
    let whole = size.map(|pixels| 0..pixels);
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    let mut behind = 0;
    for corner in bounds.corners() {
        let clip = *matrix * corner.as_dvec3().extend(1.0);
        if clip.w <= 0.0 {
            behind += 1;
            continue;
        }
        for (axis, position) in [clip.x / clip.w, clip.y / clip.w].into_iter().enumerate() {
            let pixel = (position + 1.0) * 0.5 * f64::from(size[axis]);
            low[axis] = low[axis].min(pixel);
            high[axis] = high[axis].max(pixel);
        }
    }
    match behind {
        8 => None,
        0 => Some(std::array::from_fn(|axis| {
            let end = (high[axis] + 2.0).clamp(0.0, f64::from(size[axis])) as u32;
            let start = (low[axis] - 2.0).clamp(0.0, f64::from(end)) as u32;
            start..end
        })),
        _ => Some(whole),
    }
}
