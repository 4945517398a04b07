//! The caps of a view: the choice of objects, and the shaders' data to draw them.

use cull::{
    Aabb, Containment, CullView, Hierarchy, ObjectId, PlaneMask, ProjectionKind, SectionPlane,
};
use glam::{DVec3, DVec4, Vec2, Vec3};

use super::{MetObject, Section};
use crate::passes::{CapDraw, CapRow, ImageRows};
use crate::resources::geometry::Geometry;

/// The approximate distance between the lines of a hatch (pixels).
const HATCH_PIXELS: f64 = 9.0;

/// Lists the caps that a view sees from the removed side.
pub(super) fn plan_caps(
    section: &mut Section,
    geometry: &Geometry,
    hierarchy: &Hierarchy,
    view: &CullView,
) {
    let planes = section.planes;
    let image = ImageRows::of(view);
    for number in 0..section.met.len() {
        let Some(met) = section.met.get(number).copied() else { continue };
        let cuts = section.caps_of(&met);
        let bounds = hierarchy.node_of(met.object).map(|node| hierarchy.bounds(node));
        let (Some(bounds), true) = (bounds, cuts != 0) else { continue };
        if view.frustum.classify(&bounds, PlaneMask::ALL).0 == Containment::Outside {
            continue;
        }
        let Some(draw) = geometry.leaf_draw(met.draw, met.leaf) else { continue };
        for (number, plane) in (0..).zip(planes.planes()) {
            if cuts >> number & 1 == 0 || !is_seen_open(plane, view) {
                continue;
            }
            let colour = geometry.section_colour(met.object);
            let origin = geometry
                .transform(met.object)
                .map_or(Vec3::ZERO, |transform| transform.translation.into());
            let cap = Cap { met: &met, bounds, number, plane, colour, origin };
            section.cap_rows.push(cap.row(view, &image));
            section.cap_draws.push(CapDraw { draw, shell: met.shell });
        }
    }
}

/// Returns true if rays through the image reach a plane from its removed side.
fn is_seen_open(plane: &SectionPlane, view: &CullView) -> bool {
    match view.rays.kind {
        ProjectionKind::Perspective => {
            // If the anchor is the eye, this is the eye to the bit.
            let eye = view.from_anchor.as_dmat4().inverse() * DVec4::Z;
            let eye = view.anchor.as_dvec3() + eye.truncate() / eye.w;
            plane.distance_m(eye) < 0.0
        }
        ProjectionKind::Orthographic => plane.normal().dot(view.rays.forward.as_dvec3()) > 0.0,
    }
}

/// The cap of an object in a plane.
struct Cap<'a> {
    met: &'a MetObject,
    bounds: Aabb,
    number: u32,
    plane: &'a SectionPlane,
    /// The linear colour.
    colour: [f32; 3],
    /// The position of the object in the world, which its hatch is fixed to.
    origin: Vec3,
}

impl Cap<'_> {
    fn row(&self, view: &CullView, image: &ImageRows) -> CapRow {
        let anchor = view.anchor.as_dvec3();
        // The cap is slightly larger than the object.
        let margin = self.bounds.largest_coordinate() * 4.0 * f32::EPSILON;
        let half = self.bounds.half_extent() * 1.001 + margin;
        let middle = self.bounds.centre().as_dvec3() - anchor;
        let half = half.as_dvec3().max(DVec3::splat(1.0e-30));
        let axis = |axis: usize| {
            let mut row = DVec4::ZERO;
            row[axis] = 1.0 / half[axis];
            row.w = -middle[axis] / half[axis];
            image.row(row).as_vec4().to_array()
        };
        let [red, green, blue] = self.colour.map(|part| part * self.light());
        CapRow {
            box_rows: [axis(0), axis(1), axis(2)],
            w: image.row(DVec4::W).as_vec4().to_array(),
            hatch: image.row(self.hatch(view)).as_vec4().to_array(),
            colour: [red, green, blue, 0.0],
            area: area_of(view, &self.bounds),
            plane: self.number,
            state: self.met.state.into(),
            leaf: self.met.leaf.0,
            unused: 0,
        }
    }

    /// Returns the share of light that the plane receives: more from above, and never 0.
    fn light(&self) -> f32 {
        // The eye sees the removed side.
        0.8 - 0.2 * self.plane.normal().y as f32
    }

    /// Returns the row that counts the lines of the hatch across them. The lines lie in the plane,
    /// so they do not crawl when the eye moves. Their distance doubles or halves with the object's
    /// size in the image.
    fn hatch(&self, view: &CullView) -> DVec4 {
        let normal = self.plane.normal();
        let along = normal.any_orthonormal_vector();
        let up = normal.cross(along);
        let pattern = pattern_of(self.met.object);
        let across = along * pattern.angle_rad.cos() + up * pattern.angle_rad.sin();
        let pixel_m = f64::from(view.pixels_per_metre(&self.bounds)).recip();
        let wanted_m = (HATCH_PIXELS * pattern.scale * pixel_m).clamp(1.0e-30, 1.0e30);
        let spacing_m = wanted_m.log2().round().exp2() * pattern.scale;
        let across = across / spacing_m;
        // Whole lines between anchor and object are left out, to keep digits.
        let anchor = view.anchor.as_dvec3() - self.origin.as_dvec3();
        across.extend(across.dot(anchor).rem_euclid(1.0))
    }
}

/// The hatch of an object.
struct Pattern {
    angle_rad: f64,
    /// The distance between lines as a share of the standard distance.
    scale: f64,
}

/// Returns the hatch of an object by its id, such that consecutive ids differ.
fn pattern_of(object: ObjectId) -> Pattern {
    const DEGREES: [f64; 4] = [45.0, 135.0, 20.0, 110.0];
    let hash = object.0.wrapping_mul(0x9E37_79B1);
    let degrees = DEGREES.get((hash >> 30) as usize).copied().unwrap_or_default();
    let scale = if hash >> 29 & 1 == 0 { 1.0 } else { 0.7 };
    Pattern { angle_rad: degrees.to_radians(), scale }
}

/// Returns the part of a view that a box may cover, as its lower and upper corner in normalised
/// device coordinates.
fn area_of(view: &CullView, bounds: &Aabb) -> [f32; 4] {
    const WHOLE: [f32; 4] = [-1.0, -1.0, 1.0, 1.0];
    let corners = bounds.corners().map(|corner| view.clip(corner));
    let nearest_w = corners.iter().fold(f64::INFINITY, |least, clip| least.min(clip.w));
    if nearest_w < f64::from(view.rays.near).max(1.0e-6) {
        return WHOLE;
    }
    let mut low = Vec2::INFINITY;
    let mut high = Vec2::NEG_INFINITY;
    for clip in corners {
        let at = (clip.truncate().truncate() / clip.w).as_vec2();
        (low, high) = (low.min(at), high.max(at));
    }
    // Vertices are snapped by parts of a pixel.
    let pixel = Vec2::from(view.size.map(|side| 4.0 / side.max(1) as f32));
    let low = (low - pixel).max(Vec2::NEG_ONE);
    let high = (high + pixel).min(Vec2::ONE);
    if low.is_finite() && high.is_finite() { [low.x, low.y, high.x, high.y] } else { WHOLE }
}
