//! Meshes as plain data: packed vertices, triangles, bounds.

use cull::Aabb;
use glam::{Affine3A, Vec3, Vec3A};

/// The id of a mesh of its scene: an index into [`Scene::meshes`](super::Scene::meshes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MeshId(pub u32);

/// A vertex of 20 bytes, ready for the GPU.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position in metres, in the space of the mesh; y is up.
    pub position: [f32; 3],
    /// Unit normal as snorm8x4: x in the lowest byte, w is 0.
    pub normal: u32,
    /// **Linear** red, green, blue as unorm8x4, red in the lowest byte. Alpha is not opacity but
    /// the share of the object's tint: `albedo = rgb * mix(vec3(1), tint.rgb, alpha)`.
    pub colour: u32,
}

const _: () = assert!(size_of::<Vertex>() == 20);

/// Triangles that several objects may share. Counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The name, for people.
    pub name: String,
    /// The vertices, in the space of the mesh.
    pub vertices: Vec<Vertex>,
    /// Three indices into `vertices` for each triangle.
    pub indices: Vec<u32>,
    /// The tight box around the vertices, in the space of the mesh, in metres.
    pub bounds: Aabb,
    /// True if the back of each triangle is a triangle of its own, as for double-sided materials.
    pub has_backs: bool,
}

impl Mesh {
    /// Returns a mesh of triangles. Three corners make a triangle; a corner is a position (metres,
    /// y is up) and a linear colour (red, green, blue). Triangles are counter-clockwise seen from
    /// outside; surplus corners are left out.
    pub fn of_triangles(name: &str, corners: &[([f32; 3], [f32; 3])]) -> Self {
        let (triangles, _) = corners.as_chunks::<3>();
        let vertices = triangles.iter().flat_map(|triangle| {
            let [a, b, c] = triangle.map(|(position, _)| Vec3::from_array(position));
            let normal = pack_normal((b - a).cross(c - a).normalize_or_zero());
            triangle.map(|(position, [red, green, blue])| Vertex {
                position,
                normal,
                colour: pack_unorm([red, green, blue, 0.0]),
            })
        });
        let vertices: Vec<Vertex> = vertices.collect();
        Self {
            name: name.to_owned(),
            indices: (0..vertices.len() as u32).collect(),
            bounds: bounds_of_vertices(&vertices),
            vertices,
            has_backs: false,
        }
    }

    /// Returns the number of triangles; a triangle and its back count once.
    pub fn triangles(&self) -> u64 {
        self.triangles_of(self.indices.len())
    }

    /// Returns the number of triangles of the mesh that `indices` indices make.
    pub fn triangles_of(&self, indices: usize) -> u64 {
        let sides = if self.has_backs { 2 } else { 1 };
        // A coarser level may keep a triangle without its back.
        (indices as u64 / 3).div_ceil(sides)
    }
}

/// An instance of a mesh in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// The mesh, one of the scene's.
    pub mesh: MeshId,
    /// The transform from the mesh's space to the world's, in metres; y is up.
    pub transform: Affine3A,
    /// Linear red, green, blue as unorm8x4, red in the lowest byte; alpha has no meaning. See
    /// [`Vertex::colour`].
    pub tint: u32,
}

/// Returns the tight box around the vertices; an empty list gives a box of no size at the origin.
pub fn bounds_of_vertices(vertices: &[Vertex]) -> Aabb {
    let mut points = vertices.iter().map(|vertex| Vec3::from_array(vertex.position));
    let Some(first) = points.next() else {
        return Aabb { min: Vec3::ZERO, max: Vec3::ZERO };
    };
    let (min, max) =
        points.fold((first, first), |(min, max), point| (min.min(point), max.max(point)));
    Aabb { min, max }
}

/// Returns the box around a transformed box; see [`Scene::bounds_of`](super::Scene::bounds_of) for
/// its precision.
#[inline]
pub fn bounds_of_transformed(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let extremes = |column: Vec3A, low: f32, high: f32| {
        let a = column * low;
        let b = column * high;
        (a.min(b), a.max(b))
    };
    let x = extremes(transform.matrix3.x_axis, bounds.min.x, bounds.max.x);
    let y = extremes(transform.matrix3.y_axis, bounds.min.y, bounds.max.y);
    let z = extremes(transform.matrix3.z_axis, bounds.min.z, bounds.max.z);
    Aabb {
        min: (x.0 + y.0 + z.0 + transform.translation).into(),
        max: (x.1 + y.1 + z.1 + transform.translation).into(),
    }
}

/// Packs a unit vector as snorm8x4 with w = 0.
pub fn pack_normal(normal: Vec3) -> u32 {
    let byte = |value: f32| u32::from(round_half_away(value.clamp(-1.0, 1.0) * 127.0) as i8 as u8);
    byte(normal.x) | byte(normal.y) << 8 | byte(normal.z) << 16
}

/// Returns the inverse of [`pack_normal`], not normalised again.
pub fn unpack_normal(packed: u32) -> Vec3 {
    let part = |shift: u32| (f32::from((packed >> shift) as u8 as i8) / 127.0).max(-1.0);
    Vec3::new(part(0), part(8), part(16))
}

/// Packs four numbers of `0.0..=1.0` as unorm8x4, the first in the lowest byte.
pub fn pack_unorm(values: [f32; 4]) -> u32 {
    let byte = |value: f32| round_half_away(value.clamp(0.0, 1.0) * 255.0) as u8;
    u32::from_le_bytes(values.map(byte))
}

/// Returns the nearest integer, of two the one farther from 0, like [`f32::round`]. Most processors
/// have no instruction for that, and packing rounds twenty numbers per vertex. NaN becomes 0.
#[inline]
pub fn round_half_away(value: f32) -> i32 {
    // In double precision, the sum is exact.
    let value = f64::from(value);
    (value + 0.5_f64.copysign(value)) as i32
}

/// Returns the inverse of [`pack_unorm`].
pub fn unpack_unorm(packed: u32) -> [f32; 4] {
    packed.to_le_bytes().map(|byte| f32::from(byte) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_and_colours_survive_packing() {
        for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, -0.64, 0.48)] {
            assert!(unpack_normal(pack_normal(normal)).distance(normal) < 0.01);
        }
        let colour = [0.0, 0.25, 0.5, 1.0];
        for (packed, given) in unpack_unorm(pack_unorm(colour)).iter().zip(colour) {
            assert!((packed - given).abs() < 0.003);
        }
        assert_eq!(pack_unorm([1.0, 0.0, 0.0, 0.0]), 0xFF);
    }

    #[test]
    fn halves_are_rounded_away_from_zero() {
        // `f32::round` is no reference: mingw-w64's C library rounds -0.49999997 to -1.
        let expected = |value: f32| {
            let away = (f64::from(value.abs()) + 0.5).floor();
            away.copysign(value.into()) as i32
        };
        let halves = (-70_000..70_000).map(|half| half as f32 * 0.5);
        for value in halves.flat_map(|half| [half.next_down(), half, half.next_up()]) {
            assert_eq!(round_half_away(value), expected(value), "{value:?}");
        }
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE] {
            assert_eq!(round_half_away(value), expected(value), "{value:?}");
        }
    }

    #[test]
    fn an_empty_mesh_has_bounds_without_size() {
        assert_eq!(bounds_of_vertices(&[]), Aabb { min: Vec3::ZERO, max: Vec3::ZERO });
    }
}
