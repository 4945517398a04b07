//! Builds meshes from quads, boxes, rings, turned and extruded shapes, and welds equal vertices.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3, vec3};
use scene::{Mesh, Vertex, bounds_of_vertices, pack_normal, pack_unorm};

/// A surface colour: linear, with the share of the object's tint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Paint {
    linear: [f32; 3],
    tint_share: f32,
}

/// Returns a channel in linear light: the electro-optical transfer function of sRGB (IEC
/// 61966-2-1).
fn linear_of_srgb(byte: u32) -> f32 {
    let value = byte as f32 / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

impl Paint {
    /// Returns the colour `0xRRGGBB` of web pages, which tints do not affect.
    pub(crate) fn srgb(hex: u32) -> Self {
        let channel = |shift: u32| linear_of_srgb(hex >> shift & 0xFF);
        Self { linear: [channel(16), channel(8), channel(0)], tint_share: 0.0 }
    }

    /// Returns the colour with the share, 0 to 1, to which the object tints it.
    pub(crate) fn tinted(self, share: f32) -> Self {
        Self { tint_share: share, ..self }
    }

    /// Returns the colour multiplied by a factor: darker below 1, or lighter.
    pub(crate) fn shade(self, factor: f32) -> Self {
        Self { linear: self.linear.map(|value| value * factor), ..self }
    }

    /// Returns the colour of a vertex, or of an object's tint, as linear unorm8x4.
    pub(crate) fn packed(self) -> u32 {
        let [red, green, blue] = self.linear;
        pack_unorm([red, green, blue, self.tint_share])
    }
}

/// The faces of a box that are built; hidden faces are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Faces {
    /// All six faces, for a box that is visible from everywhere.
    All,
    /// All faces except the bottom, for a box that stands on something.
    Standing,
    /// The four sides.
    Sides,
}

/// A wall seen from its front: `u` to the right, `y` up, `n` towards the viewer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: Vec3,
    u: Vec3,
    n: Vec3,
}

impl Frame {
    /// Returns the wall on side `side` (0: +z, 1: +x, 2: -z, 3: -x) of a box of these half extents;
    /// the origin is the lower left corner, seen from outside.
    pub(crate) fn of_side(side: usize, half: Vec2, centre: Vec3) -> Self {
        let (corner, u, n) = match side % 4 {
            0 => (vec3(-half.x, 0.0, half.y), Vec3::X, Vec3::Z),
            1 => (vec3(half.x, 0.0, half.y), Vec3::NEG_Z, Vec3::X),
            2 => (vec3(half.x, 0.0, -half.y), Vec3::NEG_X, Vec3::NEG_Z),
            _ => (vec3(-half.x, 0.0, -half.y), Vec3::Z, Vec3::NEG_X),
        };
        Self { origin: centre + corner, u, n }
    }

    /// Returns a wall whose normal is turned by `turn` radians from +z towards +x, `out` metres
    /// from the y axis; the origin is in front of this axis.
    pub(crate) fn facing(turn: f32, out: f32) -> Self {
        let (sin, cos) = turn.sin_cos();
        let n = vec3(sin, 0.0, cos);
        Self { origin: n * out, u: vec3(cos, 0.0, -sin), n }
    }

    /// Returns a point: `u` metres to the right, `v` up, `d` out of the wall.
    pub(crate) fn at(&self, u: f32, v: f32, d: f32) -> Vec3 {
        self.origin + self.u * u + Vec3::Y * v + self.n * d
    }
}

/// A rectangle on a wall: from (`u0`, `v0`) to (`u1`, `v1`) in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel {
    pub(crate) u0: f32,
    pub(crate) v0: f32,
    pub(crate) u1: f32,
    pub(crate) v1: f32,
}

/// Returns the rectangle with these edges.
pub(crate) fn panel(u0: f32, v0: f32, u1: f32, v1: f32) -> Panel {
    Panel { u0, v0, u1, v1 }
}

/// A collector of triangles that stores equal vertices once.
#[derive(Default)]
pub(crate) struct MeshBuilder {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    known: HashMap<[u32; 5], u32>,
}

impl MeshBuilder {
    fn vertex(&mut self, position: Vec3, normal: Vec3, paint: Paint) -> u32 {
        // Adding zero turns -0 into +0, which would otherwise keep equal vertices apart.
        let position = (position + Vec3::ZERO).to_array();
        let vertex = Vertex { position, normal: pack_normal(normal), colour: paint.packed() };
        let [x, y, z] = position.map(f32::to_bits);
        let vertices = &mut self.vertices;
        *self.known.entry([x, y, z, vertex.normal, vertex.colour]).or_insert_with(|| {
            vertices.push(vertex);
            vertices.len() as u32 - 1
        })
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners;
        if a != b && b != c && c != a {
            self.indices.extend(corners);
        }
    }

    /// Adds a flat convex polygon, counter-clockwise from its front.
    pub(crate) fn polygon(&mut self, points: &[Vec3], paint: Paint) {
        let [first, rest @ ..] = points else { return };
        let first = *first;
        let normal: Vec3 =
            rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum();
        let normal = normal.normalize_or_zero();
        let corners: Vec<u32> =
            points.iter().map(|&point| self.vertex(point, normal, paint)).collect();
        for pair in corners[1..].windows(2) {
            self.triangle([corners[0], pair[0], pair[1]]);
        }
    }

    /// Adds a flat polygon as a fan around `centre`, from which the whole outline must be visible.
    pub(crate) fn fan(&mut self, centre: Vec3, outline: &[Vec3], paint: Paint) {
        for (position, &point) in outline.iter().enumerate() {
            let next = outline[(position + 1) % outline.len()];
            self.polygon(&[centre, point, next], paint);
        }
    }

    /// Adds a rectangle in front of a wall, at a distance of `d` metres.
    pub(crate) fn rectangle(&mut self, frame: &Frame, area: Panel, d: f32, paint: Paint) {
        let Panel { u0, v0, u1, v1 } = area;
        let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| frame.at(u, v, d));
        self.polygon(&corners, paint);
    }

    /// Adds the wall between `cell` and the `hole` in it, and the four sides of the hole. The hole
    /// is `depth` metres deep and open at the back; the caller closes it.
    pub(crate) fn recess(
        &mut self,
        frame: &Frame,
        cell: Panel,
        hole: Panel,
        depth: f32,
        paints: [Paint; 2],
    ) {
        let [wall, reveal] = paints;
        let corners = |area: Panel, d: f32| {
            let Panel { u0, v0, u1, v1 } = area;
            [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| frame.at(u, v, d))
        };
        let outer = corners(cell, 0.0);
        let inner = corners(hole, 0.0);
        let deep = corners(hole, -depth);
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            self.polygon(&[outer[corner], outer[next], inner[next], inner[corner]], wall);
            self.polygon(&[inner[corner], inner[next], deep[next], deep[corner]], reveal);
        }
    }

    /// Adds a box that protrudes from a wall by `d` metres, without its back.
    pub(crate) fn ledge(&mut self, frame: &Frame, area: Panel, d: f32, paint: Paint) {
        let Panel { u0, v0, u1, v1 } = area;
        let corners =
            |d: f32| [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| frame.at(u, v, d));
        let wall = corners(0.0);
        let front = corners(d);
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            self.polygon(&[wall[corner], wall[next], front[next], front[corner]], paint);
        }
        self.polygon(&front, paint);
    }

    /// Adds an axis-aligned box.
    pub(crate) fn cuboid(&mut self, min: Vec3, max: Vec3, faces: Faces, paint: Paint) {
        self.tapered(min, max, Vec2::ZERO, faces, paint);
    }

    /// Adds a box whose top is smaller by `inset` metres on each side along x and z.
    pub(crate) fn tapered(
        &mut self,
        min: Vec3,
        max: Vec3,
        inset: Vec2,
        faces: Faces,
        paint: Paint,
    ) {
        let ring = |y: f32, dx: f32, dz: f32| {
            [
                vec3(min.x + dx, y, max.z - dz),
                vec3(max.x - dx, y, max.z - dz),
                vec3(max.x - dx, y, min.z + dz),
                vec3(min.x + dx, y, min.z + dz),
            ]
        };
        let bottom = ring(min.y, 0.0, 0.0);
        let top = ring(max.y, inset.x, inset.y);
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            self.polygon(&[bottom[corner], bottom[next], top[next], top[corner]], paint);
        }
        if matches!(faces, Faces::All | Faces::Standing) {
            self.polygon(&top, paint);
        }
        if faces == Faces::All {
            let [a, b, c, d] = bottom;
            self.polygon(&[d, c, b, a], paint);
        }
    }

    /// Adds a band around a box of these half extents, from height `low` to `high`. It protrudes
    /// from the box's walls by `out` metres.
    pub(crate) fn band(&mut self, half: Vec2, out: f32, heights: [f32; 2], paint: Paint) {
        let corners = |half: Vec2, y: f32| {
            [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
                .map(|(x, z)| vec3(x * half.x, y, z * half.y))
        };
        let [low, high] = heights;
        let wide = half + Vec2::splat(out);
        let wall_low = corners(half, low);
        let wall_high = corners(half, high);
        let out_low = corners(wide, low);
        let out_high = corners(wide, high);
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            self.polygon(
                &[wall_low[corner], wall_low[next], out_low[next], out_low[corner]],
                paint,
            );
            self.polygon(
                &[out_low[corner], out_low[next], out_high[next], out_high[corner]],
                paint,
            );
            self.polygon(
                &[out_high[corner], out_high[next], wall_high[next], wall_high[corner]],
                paint,
            );
        }
    }

    /// Adds a solid of revolution about the local y axis. The profile is (radius, height), from the
    /// bottom up; a radius of 0 closes an end. Normals are smooth around the axis, with an edge at
    /// each point of the profile.
    pub(crate) fn turned(
        &mut self,
        place: &Affine3A,
        profile: &[(f32, f32)],
        segments: u32,
        paint: Paint,
    ) {
        for pair in profile.windows(2) {
            let (r0, y0) = pair[0];
            let (r1, y1) = pair[1];
            let slope = Vec2::new(y1 - y0, r0 - r1).normalize_or_zero();
            self.turned_band(place, [(r0, y0), (r1, y1)], [slope, slope], segments, [paint, paint]);
        }
    }

    /// Adds an ellipsoid with smooth normals; `paints` are the colours of its bottom and its top.
    pub(crate) fn ellipsoid(
        &mut self,
        centre: Vec3,
        radii: Vec2,
        detail: [u32; 2],
        paints: [Paint; 2],
    ) {
        let [segments, rings] = detail;
        let place = Affine3A::from_translation(centre);
        let point = |ring: u32| {
            let (sin, cos) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
            // The poles are exact, so that their triangles have no area instead of being slivers.
            let sin = if ring == 0 || ring == rings { 0.0 } else { sin };
            let normal = Vec2::new(sin / radii.x, -cos / radii.y).normalize_or_zero();
            let [low, high] = paints;
            let paint = if ring * 2 < rings { low } else { high };
            ((radii.x * sin, -radii.y * cos), normal, paint)
        };
        for ring in 0..rings {
            let (low, low_normal, low_paint) = point(ring);
            let (high, high_normal, high_paint) = point(ring + 1);
            self.turned_band(
                &place,
                [low, high],
                [low_normal, high_normal],
                segments,
                [low_paint, high_paint],
            );
        }
    }

    fn turned_band(
        &mut self,
        place: &Affine3A,
        rim: [(f32, f32); 2],
        normals: [Vec2; 2],
        segments: u32,
        paints: [Paint; 2],
    ) {
        let corner = |builder: &mut Self, end: usize, segment: u32| {
            let turn = std::f32::consts::TAU * (segment % segments) as f32 / segments as f32;
            let (sin, cos) = turn.sin_cos();
            let (radius, y) = rim[end];
            let position = place.transform_point3(vec3(radius * sin, y, radius * cos));
            let normal = vec3(normals[end].x * sin, normals[end].y, normals[end].x * cos);
            builder.vertex(position, place.transform_vector3(normal), paints[end])
        };
        for segment in 0..segments {
            let a = corner(self, 0, segment);
            let b = corner(self, 0, segment + 1);
            let c = corner(self, 1, segment + 1);
            let d = corner(self, 1, segment);
            if rim[0].0 > 0.0 {
                self.triangle([a, b, c]);
            }
            if rim[1].0 > 0.0 {
                self.triangle([if rim[0].0 > 0.0 { a } else { b }, c, d]);
            }
        }
    }

    /// Adds a prism: a convex outline in (z, y), clockwise with z to the right and y up, extruded
    /// from the first x to the second, larger one.
    pub(crate) fn extruded(&mut self, outline: &[Vec2], ends: [f32; 2], paint: Paint) {
        let [x0, x1] = ends;
        let at = |x: f32, point: &Vec2| vec3(x, point.y, point.x);
        for (position, point) in outline.iter().enumerate() {
            let next = &outline[(position + 1) % outline.len()];
            self.polygon(&[at(x1, point), at(x0, point), at(x0, next), at(x1, next)], paint);
        }
        let right: Vec<Vec3> = outline.iter().map(|point| at(x1, point)).collect();
        let left: Vec<Vec3> = outline.iter().rev().map(|point| at(x0, point)).collect();
        self.polygon(&right, paint);
        self.polygon(&left, paint);
    }

    /// Darkens the vertices near the ground, as if they received less light of the sky: from
    /// `darkest` at y = 0 to unchanged at `height_m`.
    pub(crate) fn darken_foot(&mut self, darkest: f32, height_m: f32) {
        for vertex in &mut self.vertices {
            let share = (vertex.position[1] / height_m).clamp(0.0, 1.0);
            let factor = darkest + (1.0 - darkest) * share;
            let [red, green, blue, tint_share] = scene::unpack_unorm(vertex.colour);
            vertex.colour = pack_unorm([red * factor, green * factor, blue * factor, tint_share]);
        }
    }

    pub(crate) fn finish(self, name: &str) -> Mesh {
        let bounds = bounds_of_vertices(&self.vertices);
        Mesh {
            name: name.to_owned(),
            vertices: self.vertices,
            indices: self.indices,
            bounds,
            has_backs: false,
        }
    }
}
