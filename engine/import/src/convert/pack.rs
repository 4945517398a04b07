//! Packs geometry into the engine's vertices.

use glam::Vec3;
use scene::{
    MaterialId, Mesh, SurfaceMesh, SurfaceVertex, Vertex, bounds_of_vertices, pack_normal,
    pack_unorm, round_half_away,
};

use super::geometry::Geometry;

/// Returns a number from -1 to 1 as a signed normalised integer.
pub(super) fn snorm16(value: f32) -> i16 {
    round_half_away(value.clamp(-1.0, 1.0) * 32767.0) as i16
}

/// Returns a number from 0 to 1 as an unsigned normalised integer.
fn unorm16(value: f32) -> u16 {
    round_half_away(value.clamp(0.0, 1.0) * 65535.0) as u16
}

/// Returns both halves of a mesh. `base_colour` is the material's colour, for renderers without
/// surfaces.
pub(super) fn pack(
    geometry: &Geometry,
    name: String,
    material: MaterialId,
    base_colour: [f32; 4],
) -> (Mesh, SurfaceMesh) {
    let mut vertices = Vec::with_capacity(geometry.positions.len());
    let mut surface = Vec::with_capacity(geometry.positions.len());
    for (place, position) in geometry.positions.iter().enumerate() {
        let normal = geometry.normals.get(place).copied().unwrap_or(Vec3::Y);
        let [x, y, z] = normal.to_array().map(snorm16);
        let tangent =
            geometry.tangents.get(place).map_or([1.0, 0.0, 0.0, 1.0], |tangent| tangent.to_array());
        let uv =
            geometry.uvs.each_ref().map(|set| set.get(place).map_or([0.0; 2], |uv| uv.to_array()));
        let colour = geometry.colours.get(place).copied().unwrap_or([1.0; 4]);
        let [red, green, blue] = std::array::from_fn(|part| colour[part] * base_colour[part]);
        vertices.push(Vertex {
            position: position.to_array(),
            normal: pack_normal(normal),
            colour: pack_unorm([red, green, blue, 0.0]),
        });
        surface.push(SurfaceVertex {
            normal: [x, y, z, if geometry.has_both_sides { i16::MAX } else { 0 }],
            tangent: tangent.map(snorm16),
            uv,
            colour: colour.map(unorm16),
        });
    }
    let bounds = bounds_of_vertices(&vertices);
    let indices = geometry.triangles.as_flattened().to_vec();
    let has_backs = geometry.has_backs;
    let mesh = Mesh { name, vertices, indices, bounds, has_backs };
    (mesh, SurfaceMesh { vertices: surface, material })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec4};

    #[test]
    fn everything_is_where_the_shader_looks_for_it() {
        let geometry = Geometry {
            positions: vec![Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO],
            normals: vec![Vec3::NEG_X, Vec3::Y],
            tangents: vec![Vec4::new(0.0, 0.0, 1.0, -1.0), Vec4::new(1.0, 0.0, 0.0, 1.0)],
            uvs: [Vec::new(), vec![Vec2::new(0.25, -7.0), Vec2::ZERO]],
            colours: vec![[1.0, 0.5, 0.0, 0.2], [2.0, -1.0, 1.0, 1.0]],
            triangles: vec![[0, 1, 0]],
            ..Geometry::default()
        };
        let (mesh, surface) = pack(&geometry, "it".to_owned(), MaterialId(3), [0.5, 1.0, 1.0, 1.0]);
        assert_eq!((mesh.name.as_str(), &mesh.indices), ("it", &vec![0, 1, 0]));
        assert_eq!(mesh.vertices[0].position, [1.0, 2.0, 3.0]);
        assert_eq!(mesh.vertices[0].colour, pack_unorm([0.5, 0.5, 0.0, 0.0]));
        assert_eq!(mesh.bounds, bounds_of_vertices(&mesh.vertices));
        assert_eq!(surface.material, MaterialId(3));
        assert_eq!(surface.vertices[0].normal, [-32767, 0, 0, 0]);
        assert_eq!(surface.vertices[0].tangent, [0, 0, 32767, -32767]);
        assert_eq!(surface.vertices[0].uv, [[0.0, 0.0], [0.25, -7.0]]);
        assert_eq!(surface.vertices[0].colour, [65535, 32768, 0, 13107]);
        assert_eq!(surface.vertices[1].colour, [65535, 0, 65535, 65535]);
    }
}
