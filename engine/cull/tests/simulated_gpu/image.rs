//! A depth buffer that boxes are drawn into by casting the ray of each pixel.
//!
//! Rays are 64-bit, depths are 32-bit and reversed as on the device. Snapping to the sub-pixel grid
//! is simulated by shifting the rays of a box by up to one step of the grid.

use antumbra_cull::{Aabb, View};
use glam::DVec3;

/// A ray and what it may hit: the depths along `forward` where it enters and leaves a box.
struct Span {
    enters: f64,
    leaves: f64,
}

/// The shift of the rays of a box (pixels), to the right and down.
pub type Shift = [f64; 2];

pub struct Image {
    size: [u32; 2],
    /// The depth of each pixel: 0 is infinitely far; larger is nearer.
    pub depths: Vec<f32>,
}

impl Image {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, depths: vec![0.0; (size[0] * size[1]) as usize] }
    }

    pub fn clear(&mut self) {
        self.depths.fill(0.0);
    }

    /// Draws a solid box and returns the number of samples that passed. From inside its far faces
    /// are seen.
    pub fn draw(&mut self, view: &View, bounds: &Aabb, shift: Shift) -> u32 {
        let near = f64::from(view.near);
        let mut passed = 0;
        cast(self.size, view, bounds, shift, |pixel, span| {
            let depth = if span.enters >= near { span.enters } else { span.leaves };
            let stored = &mut self.depths[pixel];
            let depth = (near / depth) as f32;
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
        let near = f64::from(view.near);
        let mut passed = 0;
        cast(self.size, view, bounds, shift, |pixel, span| {
            let is_clipped = span.enters < near;
            passed += u32::from(!is_clipped && (near / span.enters) as f32 >= self.depths[pixel]);
        });
        passed
    }
}

/// Calls `hit` for each pixel whose ray meets the box beyond the near plane.
fn cast(
    size: [u32; 2],
    view: &View,
    bounds: &Aabb,
    shift: Shift,
    mut hit: impl FnMut(usize, Span),
) {
    let eye = view.eye.as_dvec3();
    let (min, max) = (bounds.min.as_dvec3() - eye, bounds.max.as_dvec3() - eye);
    let [right, up, forward] = [view.right, view.up, view.forward].map(|axis| axis.as_dvec3());
    let tangents = view.tan_half.map(f64::from);
    let Some([columns, rows]) = rectangle(size, view, bounds) else {
        return;
    };
    for row in rows {
        let down = (f64::from(row) + 0.5 + shift[1]) / f64::from(size[1]) * 2.0 - 1.0;
        let start = forward - up * (down * tangents[1]);
        for column in columns.clone() {
            let across = (f64::from(column) + 0.5 + shift[0]) / f64::from(size[0]) * 2.0 - 1.0;
            // The component along `forward` is 1, so the parameter of the ray is the view depth.
            let inverse = (start + right * (across * tangents[0])).recip();
            let (a, b) = (min * inverse, max * inverse);
            let span = Span { enters: lowest(a, b), leaves: highest(a, b) };
            if span.enters <= span.leaves && span.leaves >= f64::from(view.near) {
                hit((row * size[0] + column) as usize, span);
            }
        }
    }
}

fn lowest(a: DVec3, b: DVec3) -> f64 {
    a.min(b).max_element()
}

fn highest(a: DVec3, b: DVec3) -> f64 {
    a.max(b).min_element()
}

/// Returns the pixels that a box can touch, with some to spare; `None` if it is behind the eye.
fn rectangle(size: [u32; 2], view: &View, bounds: &Aabb) -> Option<[std::ops::Range<u32>; 2]> {
    let whole = size.map(|pixels| 0..pixels);
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    let mut behind = 0;
    for corner in bounds.corners() {
        let offset = (corner - view.eye).as_dvec3();
        let depth = offset.dot(view.forward.as_dvec3());
        if depth < f64::from(view.near) {
            behind += 1;
            continue;
        }
        let across = offset.dot(view.right.as_dvec3()) / depth / f64::from(view.tan_half[0]);
        let down = -offset.dot(view.up.as_dvec3()) / depth / f64::from(view.tan_half[1]);
        for (axis, position) in [across, down].into_iter().enumerate() {
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
