//! Joins points of surfaces to the vertices of a mesh.

use super::grid::EvaluatedPoint;
use crate::{Mesh, Vertex, bounds_of_vertices, unpack_normal};

/// The cosine of the angle between normals at one place up to which they share a vertex: 8 degrees.
const SAME_NORMAL: f32 = 0.99;

/// The vertices that points have become. Points at one place become one vertex if their positions
/// are equal to the bit and their normals nearly equal.
pub(super) struct Welder {
    vertices: Vec<Vertex>,
    /// For each vertex the previous vertex at the same place.
    before: Vec<Option<u32>>,
    colour: u32,
}

impl Welder {
    pub(super) fn new(colour: u32) -> Self {
        Self { vertices: Vec::new(), before: Vec::new(), colour }
    }

    /// Returns the vertex of a point, which is added if none fits. `newest` is the newest vertex at
    /// its place.
    pub(super) fn vertex_of(&mut self, point: &EvaluatedPoint, newest: &mut Option<u32>) -> u32 {
        let mut next = *newest;
        while let Some(vertex) = next {
            if is_same(&self.vertices[vertex as usize], point) {
                return vertex;
            }
            next = self.before[vertex as usize];
        }
        let vertex = self.vertices.len() as u32;
        let EvaluatedPoint { position, normal } = *point;
        self.vertices.push(Vertex { position, normal, colour: self.colour });
        self.before.push(*newest);
        *newest = Some(vertex);
        vertex
    }

    /// Returns the mesh of these triangles.
    pub(super) fn into_mesh(self, indices: Vec<u32>, name: &str) -> Mesh {
        Mesh {
            name: name.to_owned(),
            indices,
            bounds: bounds_of_vertices(&self.vertices),
            vertices: self.vertices,
            has_backs: false,
        }
    }
}

/// Returns true if a vertex can stand for a point.
fn is_same(vertex: &Vertex, point: &EvaluatedPoint) -> bool {
    // Of 8 bits per axis, normals are a little shorter or longer than 1.
    let normal = unpack_normal(vertex.normal);
    let other = unpack_normal(point.normal);
    vertex.position.map(f32::to_bits) == point.position.map(f32::to_bits)
        && normal.dot(other) > SAME_NORMAL * normal.length() * other.length()
}
