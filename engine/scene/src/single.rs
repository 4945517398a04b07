//! The smallest scene: one mesh, once.

use glam::{Affine3A, Vec3};

use super::{
    Light, Mesh, MeshId, Object, Scene, Vertex, bounds_of_vertices, pack_normal, pack_unorm,
};

impl Mesh {
    /// Returns a mesh of triangles, three corners each: a corner is its position (metres, y is up)
    /// and its linear red, green and blue. Triangles are counter-clockwise seen from outside;
    /// surplus corners are left out.
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
}

impl Scene {
    /// Returns a scene of one object, at the place of its mesh.
    pub fn single(mesh: Mesh) -> Self {
        let (transform, tint) = (Affine3A::IDENTITY, u32::MAX);
        Self {
            name: mesh.name.clone(),
            meshes: vec![mesh],
            objects: vec![Object { mesh: MeshId(0), transform, tint }],
            light: Light::afternoon(),
            surfaces: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_corners_are_a_triangle() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3]];
        let mesh = Mesh::of_triangles("triangle", &corners.map(|corner| (corner, [1.0; 3])));
        assert_eq!((mesh.triangles(), mesh.vertices[0].normal), (1, pack_normal(Vec3::Z)));
        assert_eq!(mesh.bounds.max, Vec3::new(1.0, 1.0, 0.0));
        let scene = Scene::single(mesh);
        assert_eq!(scene.validate(), Ok(()));
        assert_eq!(scene.triangles(), 1);
        Scene::single(Mesh::of_triangles("nothing", &[])).validate().unwrap();
    }
}
