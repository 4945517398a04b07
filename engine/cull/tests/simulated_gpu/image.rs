//! A depth buffer that boxes are drawn to by casting the ray of each pixel.
//!
//! Objects and proxies are transformed as in their shaders, in single precision and with different
//! matrices. Shifting the rays of a box by up to one step of the grid simulates the snapping to the
//! sub-pixel grid. An error of some units in the last place of the terms, different for each box
//! and pixel, simulates the rounding of depths.

use antumbra_cull::{
    Aabb, CullView, DepthConvention, ProjectionKind, SectionMode, SectionPlane, SectionPlanes,
};
use glam::{DMat4, DVec2, DVec4};

use crate::raster::{ClipBox, ClipPoint};

/// The shift of the rays of a box (pixels), to the right and down.
pub type Shift = [f64; 2];

#[derive(Clone)]
pub struct Image {
    size: [u32; 2],
    /// The depth of each pixel; larger is nearer. If depth is not reversed, it is stored with the
    /// other sign.
    pub depths: Vec<f32>,
}

impl Image {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, depths: vec![f32::NEG_INFINITY; (size[0] * size[1]) as usize] }
    }

    pub fn clear(&mut self) {
        self.depths.fill(f32::NEG_INFINITY);
    }

    /// Draws a solid box and returns the number of samples that passed. From inside of the box, its
    /// far faces are visible.
    pub fn draw(&mut self, view: &CullView, bounds: &Aabb, shift: Shift) -> u32 {
        let mut passed = 0;
        let solid = ClipBox::of_object(view, bounds);
        cast(self.size, view, &solid, bounds, shift, |pixel, depth| {
            let stored = &mut self.depths[pixel];
            if depth >= *stored {
                *stored = depth;
                passed += 1;
            }
        });
        passed
    }

    /// Draws the faces that section planes cut through a solid box.
    pub fn draw_caps(&mut self, view: &CullView, bounds: &Aabb) {
        let cut = Cut::of(view);
        let range = signed(view, view.depth.farthest())..=signed(view, view.depth.nearest());
        let [width, height] = self.size.map(f64::from);
        for plane in view.section.planes() {
            let row = cut.to_world.transpose() * plane.from_anchor(cut.anchor);
            for (pixel, stored) in self.depths.iter_mut().enumerate() {
                let column = pixel as u32 % self.size[0];
                let line = pixel as u32 / self.size[0];
                let across = (f64::from(column) + 0.5) / width * 2.0 - 1.0;
                let down = (f64::from(line) + 0.5) / height * 2.0 - 1.0;
                let z = -(row.x * across + row.y * down + row.w) / row.z;
                let place = cut.place(DVec4::new(across, down, z, 1.0));
                let depth = signed(view, z as f32);
                let is_in = bounds.contains_point(place.as_vec3());
                if is_in && range.contains(&depth) && cut.shows(plane, place) {
                    *stored = stored.max(depth);
                }
            }
        }
    }

    /// Counts samples of the front faces of a box that pass, without writing; faces before the
    /// near plane are clipped away.
    pub fn test(&self, view: &CullView, bounds: &Aabb, shift: Shift) -> u32 {
        let mut passed = 0;
        let proxy = ClipBox::of_proxy(view, bounds);
        // Proxies are not cut.
        let view = &CullView { section: SectionPlanes::default(), ..*view };
        cast(self.size, view, &proxy, bounds, shift, |pixel, depth| {
            passed += u32::from(depth >= self.depths[pixel]);
        });
        passed
    }
}

/// The section planes of a view, as they cut objects.
struct Cut {
    section: SectionPlanes,
    to_world: DMat4,
    anchor: glam::DVec3,
}

impl Cut {
    fn of(view: &CullView) -> Self {
        let to_world = view.from_anchor.as_dmat4().inverse();
        Self { section: view.section, to_world, anchor: view.anchor.as_dvec3() }
    }

    fn place(&self, clip: DVec4) -> glam::DVec3 {
        let place = self.to_world * clip;
        place.truncate() / place.w + self.anchor
    }

    fn keeps(&self, ndc: DVec2, point: &ClipPoint) -> bool {
        let clip = DVec4::new(ndc.x * point.w, ndc.y * point.w, point.z, point.w);
        self.section.is_empty() || self.section.keeps(self.place(clip))
    }

    /// Returns true if a point of a plane lies on a cut face: the other planes keep it in an
    /// intersection, and remove it in a union.
    fn shows(&self, of: &SectionPlane, place: glam::DVec3) -> bool {
        let mut others = self.section.planes().iter().filter(|plane| *plane != of);
        let keeps = |plane: &SectionPlane| plane.distance_m(place) >= 0.0;
        match self.section.mode() {
            SectionMode::Intersection => others.all(keeps),
            SectionMode::Union => !others.any(keeps),
        }
    }
}

/// Returns a depth in its stored form, in which larger is nearer.
fn signed(view: &CullView, depth: f32) -> f32 {
    match view.depth {
        DepthConvention::Reversed => depth,
        DepthConvention::Standard => -depth,
    }
}

/// Calls `hit` for each pixel that the triangles of a box cover between the near and the far plane,
/// with the nearest depth there.
fn cast(
    size: [u32; 2],
    view: &CullView,
    clip_box: &ClipBox,
    bounds: &Aabb,
    shift: Shift,
    mut hit: impl FnMut(usize, f32),
) {
    let Some([columns, rows]) = rectangle(size, clip_box) else {
        return;
    };
    let seed = seed_of(bounds);
    let cut = Cut::of(view);
    let range = signed(view, view.depth.farthest())..=signed(view, view.depth.nearest());
    for row in rows {
        let down = (f64::from(row) + 0.5 + shift[1]) / f64::from(size[1]) * 2.0 - 1.0;
        for column in columns.clone() {
            let across = (f64::from(column) + 0.5 + shift[0]) / f64::from(size[0]) * 2.0 - 1.0;
            let pixel = (row * size[0] + column) as usize;
            let is_kept = |point: &ClipPoint| cut.keeps(DVec2::new(across, down), point);
            let depth = |point: ClipPoint| {
                let noise = noise(seed, pixel) * terms(view, point);
                signed(view, ((point.z + noise) / point.w) as f32)
            };
            let points = clip_box.points(DVec2::new(across, down)).filter(is_kept);
            let depths = points.map(depth);
            let nearest = depths.filter(|depth| range.contains(depth)).reduce(f32::max);
            if let Some(nearest) = nearest {
                hit(pixel, nearest);
            }
        }
    }
}

/// Returns the size of the terms of clip z: its constant share of w, and the rest.
fn terms(view: &CullView, clip: ClipPoint) -> f64 {
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

/// Returns the rounding error, up to four units in the last place, of the box with this seed at a
/// pixel.
fn noise(seed: u64, pixel: usize) -> f64 {
    let hash = mixed(seed ^ pixel as u64);
    let share = (hash >> 40) as f64 / (1_u64 << 24) as f64;
    (share * 2.0 - 1.0) * 4.0 * f64::from(f32::EPSILON)
}

fn mixed(number: u64) -> u64 {
    number.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
}

/// Returns the pixels that a box can touch, with some reserve; `None` if it is behind the eye.
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
