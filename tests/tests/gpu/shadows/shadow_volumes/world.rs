//! Objects with their shadow volumes, as buffers and as triangles for rays.

use bytemuck::{Pod, Zeroable};
use cull::Aabb;
use glam::{Affine3A, Vec3, Vec4Swizzles};
use gpu::IndirectDraw;
use scene::{Mesh, Vertex};
use shadows::{VolumeKind, VolumeMesh, VolumeSource};

use super::meshes::Triangles;

/// Mirrors `instance.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Row {
    rows: [[f32; 4]; 3],
    tail: [u32; 4],
}

/// An object.
pub struct Thing {
    pub draw: IndirectDraw,
    pub volumes: IndirectDraw,
    pub kind: VolumeKind,
    pub bounds: Aabb,
    pub triangles: Triangles,
}

/// All objects.
#[derive(Default)]
pub struct World {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    pub adjacency: Vec<u32>,
    pub instances: Vec<Row>,
    pub things: Vec<Thing>,
}

impl World {
    /// Adds an object of triangles.
    pub fn add(&mut self, triangles: &Triangles, transform: Affine3A) {
        let corners = triangles.as_flattened().iter();
        let corners: Vec<_> = corners.map(|at| (at.to_array(), [1.0; 3])).collect();
        self.add_mesh(&Mesh::of_triangles("thing", &corners), transform);
    }

    /// Adds an object of a mesh.
    pub fn add_mesh(&mut self, mesh: &Mesh, transform: Affine3A) {
        let positions: Vec<Vec3> =
            mesh.vertices.iter().map(|vertex| vertex.position.into()).collect();
        let source = VolumeSource { positions: &positions, triangles: &mesh.indices, motions: &[] };
        let volumes = VolumeMesh::new(&source).unwrap();
        let instance = self.instances.len() as u32;
        let vertex_offset = self.vertices.len() as i32;
        let draw = |first: usize, count: usize| IndirectDraw {
            index_count: count as u32,
            instance_count: 1,
            first_index: first as u32,
            vertex_offset,
            first_instance: instance,
        };
        let placed: Vec<Vec3> =
            positions.iter().map(|at| transform.transform_point3(*at)).collect();
        let corner = |index: &u32| placed[*index as usize];
        let (triangles, _) = mesh.indices.as_chunks::<3>();
        let triangles = triangles.iter().map(|[a, b, c]| [corner(a), corner(b), corner(c)]);
        let bounds = placed.iter().fold(Aabb::EMPTY, |all, at| all.union(&Aabb::new(*at, *at)));
        self.things.push(Thing {
            draw: draw(self.indices.len(), mesh.indices.len()),
            volumes: draw(self.adjacency.len(), volumes.triangles().len() * 6),
            kind: volumes.kind_under(&transform.matrix3),
            bounds,
            triangles: triangles.collect(),
        });
        self.vertices.extend(&mesh.vertices);
        self.indices.extend(&mesh.indices);
        self.adjacency.extend(volumes.triangles().as_flattened());
        let [x, y, z] = [0, 1, 2].map(|row| {
            let columns = transform.matrix3;
            let a = columns.x_axis[row];
            let b = columns.y_axis[row];
            let c = columns.z_axis[row];
            [a, b, c, transform.translation[row]]
        });
        self.instances.push(Row { rows: [x, y, z], tail: [0; 4] });
    }

    /// Returns the vector from a point to a light.
    pub fn to_light(light: glam::Vec4, point: Vec3) -> Vec3 {
        if light.w > 0.0 { light.xyz() - point } else { light.xyz() * 1.0e3 }
    }
}
