//! The triangles of a volume's boundary, as the geometry shader emits them.

use glam::{Vec3, Vec4};

use super::counting::Caps;
use super::end::VolumeEnd;
use super::mesh::{VolumeKind, VolumeMesh};

/// A triangle of the boundary of a shadow volume: corners in homogeneous coordinates,
/// counter-clockwise seen from outside of the volume. Those at infinity have w = 0.
pub type VolumeTriangle = [Vec4; 3];

/// The extrusion of a mesh away from a light: the reference for the shaders, which do the same per
/// triangle (`shaders/volume.glsl`).
#[derive(Clone, Copy, Debug)]
pub struct Extrusion {
    /// The light in homogeneous coordinates: a point with w = 1, or the direction towards it with
    /// w = 0.
    pub light: Vec4,
    /// The algorithm.
    pub kind: VolumeKind,
    /// The caps.
    pub caps: Caps,
    /// The far end.
    pub end: VolumeEnd,
}

/// A corner of a triangle or of its neighbour.
#[derive(Clone, Copy, Debug)]
struct NamedCorner {
    name: u32,
    at: Vec3,
}

impl Extrusion {
    /// Returns the boundary of a mesh's shadow volumes, with the vertices at these positions.
    #[must_use]
    pub fn volumes(&self, mesh: &VolumeMesh, positions: &[Vec3]) -> Vec<VolumeTriangle> {
        let place = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or_default();
        let mut boundary = Vec::new();
        for corners in mesh.triangles() {
            self.add_triangle(corners, corners.map(place), &mut boundary);
        }
        boundary
    }

    fn add_triangle(&self, names: &[u32; 6], at: [Vec3; 6], boundary: &mut Vec<VolumeTriangle>) {
        let corner = |name, at| NamedCorner { name, at };
        let [a, _, b, _, c, _] = at;
        let [name_a, name_ab, name_b, name_bc, name_c, name_ca] = *names;
        let faces = self.faces([corner(name_a, a), corner(name_b, b), corner(name_c, c)]);
        if self.kind == VolumeKind::Plain && !faces {
            return;
        }
        let towards_light = if faces { [a, b, c] } else { [a, c, b] };
        if self.caps != Caps::None {
            boundary.push(towards_light.map(|corner| corner.extend(1.0)));
        }
        if self.caps == Caps::Both && self.has_far_end() {
            let [a, b, c] = towards_light.map(|corner| self.end.behind(corner, self.light));
            boundary.push([a, c, b]);
        }
        let [_, ab, _, bc, _, ca] = at;
        let edges = [
            [corner(name_a, a), corner(name_ab, ab), corner(name_b, b)],
            [corner(name_b, b), corner(name_bc, bc), corner(name_c, c)],
            [corner(name_c, c), corner(name_ca, ca), corner(name_a, a)],
        ];
        for [from, far, to] in edges {
            // The neighbour runs along the edge in the other direction.
            if far.name == from.name || self.faces([to, from, far]) != faces {
                if faces {
                    self.add_side(from.at, to.at, boundary);
                } else {
                    self.add_side(to.at, from.at, boundary);
                }
            }
        }
    }

    fn add_side(&self, from: Vec3, to: Vec3, boundary: &mut Vec<VolumeTriangle>) {
        let [far_from, far_to] = [from, to].map(|corner| self.end.behind(corner, self.light));
        let [from, to] = [from, to].map(|corner| corner.extend(1.0));
        boundary.push([from, far_from, to]);
        if self.has_far_end() {
            boundary.push([to, far_from, far_to]);
        }
    }

    /// Returns false if the far end is a single point, as with a sun and an end at infinity.
    fn has_far_end(&self) -> bool {
        self.light.w > 0.0 || self.end.w > 0.0
    }

    /// Returns true if a triangle of named corners faces the light.
    ///
    /// A triangle is tested once for itself and once for each neighbour. All four tests must agree,
    /// even where rounding decides. So the arithmetic begins at the corner of the least name,
    /// whatever the order of the corners.
    fn faces(&self, corners: [NamedCorner; 3]) -> bool {
        let [a, b, c] = corners;
        let from_least = if a.name < b.name && a.name < c.name {
            [a, b, c]
        } else if b.name < c.name {
            [b, c, a]
        } else {
            [c, a, b]
        };
        let [p, q, r] = from_least.map(|corner| corner.at);
        let to_light = self.light.truncate() - self.light.w * p;
        (q - p).cross(r - p).dot(to_light) > 0.0
    }
}
