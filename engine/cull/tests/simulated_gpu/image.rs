//! A depth buffer that boxes are drawn into by casting the ray of each pixel.
//!
//! Objects and proxies are what their shaders make of them, in single precision and by a matrix
//! each. Snapping to the sub-pixel grid is simulated by shifting the rays of a box by up to one
//! step of the grid; the rounding of depths by an error of some units in the last place of their
//! terms, another one for each box and pixel.

use antumbra_cull::{Aabb, DepthConvention, ProjectionKind, View};
use glam::DVec2;

use crate::raster::{ClipBox, ClipPoint};

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
        let mut passed = 0;
        let solid = ClipBox::of_object(view, bounds);
        cast(self.size, view, &solid, (bounds, shift), |pixel, depth| {
            let stored = &mut self.depths[pixel];
            if depth >= *stored {
                *stored = depth;
                passed += 1;
            }
        });
        passed
    }

    /// Counts samples of the front faces of a box that pass, without writing; faces before the
    /// near plane are clipped away.
    pub fn test(&self, view: &View, bounds: &Aabb, shift: Shift) -> u32 {
        let mut passed = 0;
        let proxy = ClipBox::of_proxy(view, bounds);
        cast(self.size, view, &proxy, (bounds, shift), |pixel, depth| {
            passed += u32::from(depth >= self.depths[pixel]);
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

/// Calls `hit` for each pixel that the triangles of a box cover between the near and the far plane,
/// with the nearest depth there.
fn cast(
    size: [u32; 2],
    view: &View,
    clip_box: &ClipBox,
    (bounds, shift): (&Aabb, Shift),
    mut hit: impl FnMut(usize, f32),
) {
    let Some([columns, rows]) = rectangle(size, clip_box) else {
        return;
    };
    let seed = seed_of(bounds);
    let range = signed(view, view.depth.farthest())..=signed(view, view.depth.nearest());
    for row in rows {
        let down = (f64::from(row) + 0.5 + shift[1]) / f64::from(size[1]) * 2.0 - 1.0;
        for column in columns.clone() {
            let across = (f64::from(column) + 0.5 + shift[0]) / f64::from(size[0]) * 2.0 - 1.0;
            let pixel = (row * size[0] + column) as usize;
            let depth = |point: ClipPoint| {
                let noise = noise(seed, pixel) * terms(view, point);
                signed(view, ((point.z + noise) / point.w) as f32)
            };
            let depths = clip_box.points(DVec2::new(across, down)).map(depth);
            let nearest = depths.filter(|depth| range.contains(depth)).reduce(f32::max);
            if let Some(nearest) = nearest {
                hit(pixel, nearest);
            }
        }
    }
}

/// Returns the size of what clip z is the sum of: its constant share of w, and the rest.
fn terms(view: &View, clip: ClipPoint) -> f64 {
    let constant = match view.rays.kind {
        ProjectionKind::Perspective => f64::from(view.rays.depth[0]) * clip.w,
        ProjectionKind::Orthographic => f64::from(view.rays.depth[0]),
    };
    constant.abs() + (clip.z - constant).abs()
}

/// Returns a number that differs from box to box.
fn seed_of(bounds: &Aabb) -> u64 {
    let coordinates = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
    coordinates.fold(0, |hash, coordinate| mixed(hash ^ u64::from(coordinate.to_bits())))
}

/// Returns an error of rounding, up to four units in the last place, that the box of a seed has at
/// a pixel.
fn noise(seed: u64, pixel: usize) -> f64 {
    let hash = mixed(seed ^ pixel as u64);
    let share = (hash >> 40) as f64 / (1_u64 << 24) as f64;
    (share * 2.0 - 1.0) * 4.0 * f64::from(f32::EPSILON)
}

fn mixed(number: u64) -> u64 {
    number.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
}

/// Returns the pixels that a box can touch, with some to spare; `None` if it is behind the eye.
fn rectangle(size: [u32; 2], clip_box: &ClipBox) -> Option<[std::ops::Range<u32>; 2]> {
    let whole = size.map(|pixels| 0..pixels);
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    let mut behind = 0;
    for corner in clip_box.corners {
        let clip = corner.as_dvec4();
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
