//! Closed solids: lofts, turned and extruded shapes, and slabs with a relief. Each edge of a solid
//! has two faces with opposite directions, so its sections have an inside.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3, vec3};
use scene::{CREASE_RAD, Mesh, Vertex, bounds_of_vertices, creased, pack_normal};

use super::builder::Paint;

/// A closed surface of triangles that share their corners.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solid {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    known: HashMap<[u32; 3], u32>,
}

impl Solid {
    fn corner(&mut self, position: Vec3) -> u32 {
        // Adding zero turns -0 into +0, which would otherwise keep equal corners apart.
        let position = position + Vec3::ZERO;
        let positions = &mut self.positions;
        *self.known.entry(position.to_array().map(f32::to_bits)).or_insert_with(|| {
            positions.push(position);
            positions.len() as u32 - 1
        })
    }

    fn triangle(&mut self, a: Vec3, b: Vec3, c: Vec3) {
        let [a, b, c] = [a, b, c].map(|position| self.corner(position));
        if a != b && b != c && c != a {
            self.triangles.push([a, b, c]);
        }
    }

    /// Adds the surface between two rings with equal numbers of points. The second ring lies on the
    /// side from which the first one is counter-clockwise.
    fn band(&mut self, low: &[Vec3], high: &[Vec3]) {
        for (place, (&a, &d)) in low.iter().zip(high).enumerate() {
            let next = (place + 1) % low.len();
            let (Some(&b), Some(&c)) = (low.get(next), high.get(next)) else { continue };
            self.triangle(a, b, c);
            self.triangle(a, c, d);
        }
    }

    /// Closes a ring whose middle sees all of it; the ring is counter-clockwise seen from outside.
    fn cap(&mut self, ring: &[Vec3]) {
        let middle = ring.iter().copied().sum::<Vec3>() / ring.len().max(1) as f32;
        for (place, &point) in ring.iter().enumerate() {
            let next = ring.get((place + 1) % ring.len()).copied().unwrap_or(point);
            self.triangle(middle, point, next);
        }
    }

    /// Returns the solid between rings with equal numbers of points, from the bottom up and
    /// counter-clockwise seen from above; the first and the last are closed. Rings may go down
    /// again inside of others and form a cavity.
    pub(crate) fn loft(rings: &[Vec<Vec3>]) -> Self {
        let mut solid = Self::default();
        for pair in rings.windows(2) {
            solid.band(&pair[0], &pair[1]);
        }
        if let [first, .., last] = rings {
            let bottom: Vec<Vec3> = first.iter().rev().copied().collect();
            solid.cap(&bottom);
            solid.cap(last);
        }
        solid
    }

    /// Returns the solid between rings with equal numbers of points, of which the last one meets
    /// the first.
    pub(crate) fn hoop(rings: &[Vec<Vec3>]) -> Self {
        let mut solid = Self::default();
        for (place, ring) in rings.iter().enumerate() {
            if let Some(next) = rings.get((place + 1) % rings.len()) {
                solid.band(ring, next);
            }
        }
        solid
    }

    /// Returns a box.
    pub(crate) fn cuboid(min: Vec3, max: Vec3) -> Self {
        let ring = |y: f32| {
            vec![
                vec3(max.x, y, max.z),
                vec3(max.x, y, min.z),
                vec3(min.x, y, min.z),
                vec3(min.x, y, max.z),
            ]
        };
        Self::loft(&[ring(min.y), ring(max.y)])
    }

    /// Returns a box around the origin.
    pub(crate) fn centred(size: Vec3) -> Self {
        Self::cuboid(size * -0.5, size * 0.5)
    }

    /// Returns a solid of revolution about the y axis. The profile is (radius, height) from the
    /// bottom up; both ends are closed.
    pub(crate) fn turned(profile: &[(f32, f32)], segments: u32) -> Self {
        let rings = profile.iter().map(|(radius, y)| circle(*radius, *y, segments));
        Self::loft(&rings.collect::<Vec<_>>())
    }

    /// Returns a ring about the y axis between two radii and two heights.
    pub(crate) fn ring(radii: Vec2, heights: Vec2, segments: u32) -> Self {
        Self::pierced(&circle(radii.y, 0.0, segments), &circle(radii.x, 0.0, segments), heights)
    }

    /// Returns a plate between two heights, within an outline in the x-z plane, with a hole. Both
    /// have equal numbers of points, counter-clockwise seen from above. Points with the same index
    /// see each other.
    pub(crate) fn pierced(outline: &[Vec3], hole: &[Vec3], heights: Vec2) -> Self {
        let at =
            |ring: &[Vec3], y: f32| ring.iter().map(|point| vec3(point.x, y, point.z)).collect();
        Self::hoop(&[
            at(outline, heights.x),
            at(outline, heights.y),
            at(hole, heights.y),
            at(hole, heights.x),
        ])
    }

    /// Returns a slab from y = 0 up to the given height at each crossing of the lines `xs` and
    /// `zs`, both ascending.
    pub(crate) fn relief(xs: &[f32], zs: &[f32], height: impl Fn(usize, usize) -> f32) -> Self {
        let mut solid = Self::default();
        let at = |column: usize, row: usize, share: f32| {
            vec3(xs[column], share * height(column, row), zs[row])
        };
        for column in 1..xs.len() {
            for row in 1..zs.len() {
                for (share, is_top) in [(1.0, true), (0.0, false)] {
                    let a = at(column - 1, row - 1, share);
                    let b = at(column - 1, row, share);
                    let c = at(column, row, share);
                    let d = at(column, row - 1, share);
                    if is_top {
                        solid.triangle(a, b, c);
                        solid.triangle(a, c, d);
                    } else {
                        solid.triangle(a, c, b);
                        solid.triangle(a, d, c);
                    }
                }
            }
        }
        let columns = xs.len().saturating_sub(1);
        let rows = zs.len().saturating_sub(1);
        let near = (0..=columns).rev().map(|column| [column, rows]);
        let left = (0..=rows).rev().map(|row| [0, row]);
        let far = (0..=columns).map(|column| [column, 0]);
        let right = (0..=rows).map(|row| [columns, row]);
        let border: Vec<[usize; 2]> = right.chain(near).chain(left).chain(far).collect();
        let edge = |share: f32| {
            // Clockwise seen from above, so it is reversed.
            border.iter().rev().map(|[column, row]| at(*column, *row, share)).collect::<Vec<_>>()
        };
        solid.band(&edge(0.0), &edge(1.0));
        solid
    }

    /// Returns the transformed solid; a mirrored solid is reversed, so that it still faces
    /// outwards.
    #[must_use]
    pub(crate) fn placed(&self, place: Affine3A) -> Self {
        let mut placed = Self::default();
        let is_mirrored = place.matrix3.determinant() < 0.0;
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| self.positions[corner as usize]);
            let [a, b, c] = [a, b, c].map(|position| place.transform_point3(position));
            if is_mirrored { placed.triangle(a, c, b) } else { placed.triangle(a, b, c) }
        }
        placed
    }

    /// Returns the union of this solid and another one that it does not meet.
    #[must_use]
    pub(crate) fn and(mut self, other: &Self) -> Self {
        for triangle in &other.triangles {
            let [a, b, c] = triangle.map(|corner| other.positions[corner as usize]);
            self.triangle(a, b, c);
        }
        self
    }

    /// Returns this solid without the interior of another solid inside of it.
    #[must_use]
    pub(crate) fn without(mut self, inner: &Self) -> Self {
        for triangle in &inner.triangles {
            let [a, b, c] = triangle.map(|corner| inner.positions[corner as usize]);
            self.triangle(a, c, b);
        }
        self
    }

    /// Returns the mesh in one colour, smooth except at creases.
    pub(crate) fn mesh(&self, name: &str, paint: Paint) -> Mesh {
        let made = creased(&self.positions, &self.triangles, CREASE_RAD);
        let vertices = made.origins.iter().zip(&made.normals).map(|(origin, normal)| Vertex {
            position: self.positions[*origin as usize].to_array(),
            normal: pack_normal(*normal),
            colour: paint.packed(),
        });
        let vertices: Vec<Vertex> = vertices.collect();
        Mesh {
            name: name.to_owned(),
            bounds: bounds_of_vertices(&vertices),
            vertices,
            indices: made.triangles.into_flattened(),
            has_backs: false,
        }
    }
}

/// Returns a circle about the y axis, counter-clockwise seen from above.
pub(crate) fn circle(radius: f32, y: f32, segments: u32) -> Vec<Vec3> {
    let point = |segment: u32| {
        let (sin, cos) = (TAU * segment as f32 / segments as f32).sin_cos();
        vec3(radius * cos, y, -radius * sin)
    };
    (0..segments).map(point).collect()
}

/// Returns a rectangle around the y axis with rounded corners, counter-clockwise seen from above.
/// `half` are its half extents along x and z, `steps` the number of edges per corner.
pub(crate) fn rounded(half: Vec2, radius: f32, y: f32, steps: u32) -> Vec<Vec3> {
    let mut ring = Vec::new();
    for (corner, sign) in (0_u32..).zip([
        vec3(1.0, 0.0, -1.0),
        vec3(-1.0, 0.0, -1.0),
        vec3(-1.0, 0.0, 1.0),
        vec3(1.0, 0.0, 1.0),
    ]) {
        let centre = vec3(half.x - radius, 0.0, half.y - radius) * sign;
        for step in 0..=steps {
            let turn = TAU / 4.0 * (corner as f32 + step as f32 / steps as f32);
            let (sin, cos) = turn.sin_cos();
            ring.push(centre + vec3(radius * cos, y, -radius * sin));
        }
    }
    ring
}

/// Returns points on a rectangle in the x-z plane from `min` to `max`, `steps` per side, and
/// equally many points on a circle around `centre`: the outline and the hole of a plate. Each point
/// of the circle lies between the centre and its counterpart.
pub(crate) fn rectangle_and_hole(
    min: Vec2,
    max: Vec2,
    centre: Vec2,
    radius: f32,
    steps: u32,
) -> [Vec<Vec3>; 2] {
    let corners = [
        vec3(max.x, 0.0, max.y),
        vec3(max.x, 0.0, min.y),
        vec3(min.x, 0.0, min.y),
        vec3(min.x, 0.0, max.y),
    ];
    let mut outline = Vec::new();
    for (place, &corner) in corners.iter().enumerate() {
        let next = corners[(place + 1) % 4];
        let at = |step: u32| corner.lerp(next, step as f32 / steps as f32);
        outline.extend((0..steps).map(at));
    }
    let middle = vec3(centre.x, 0.0, centre.y);
    let on_circle = |point: &Vec3| middle + (*point - middle).normalize_or_zero() * radius;
    let hole = outline.iter().map(on_circle).collect();
    [outline, hole]
}
