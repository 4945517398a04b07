//! The scene in GPU memory, in the order of the hierarchy's leaves: a subtree is a range of everything.

use bytemuck::{Pod, Zeroable};
use cull::{Hierarchy, LeafIndex, LeafRange};
use gpu::{Buffer, Device, IndirectDraw, vk};

use crate::error::Error;
use crate::passes::ProxyBox;
use crate::scene::{Scene, Vertex, unpack_unorm};

/// What the vertex shader knows of an object; mirrors `instance.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Instance {
    rows: [[f32; 4]; 3],
    tint: [f32; 4],
}

const _: () = assert!(size_of::<Instance>() == 64);

/// Meshes, instances and what the CPU must know to draw a leaf.
pub(crate) struct Geometry {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) instances: Buffer,
    /// One box per leaf.
    pub(crate) leaf_boxes: Buffer,
    mesh_draws: Vec<IndirectDraw>,
    leaf_meshes: Vec<u32>,
    // Triangles of all leaves before each leaf: a range's triangles are one subtraction.
    triangles_before: Vec<u64>,
}

impl Geometry {
    pub(crate) fn upload(
        device: &Device,
        scene: &Scene,
        hierarchy: &Hierarchy,
    ) -> Result<Self, Error> {
        let (vertices, indices, mesh_draws) = join_meshes(scene);
        let objects = || hierarchy.leaf_objects().iter();
        let object = |id: &cull::ObjectId| scene.objects.get(id.0 as usize);
        let leaf_meshes: Vec<u32> = objects().filter_map(object).map(|o| o.mesh.0).collect();
        let mut triangles = 0;
        let mut triangles_before = Vec::with_capacity(leaf_meshes.len() + 1);
        triangles_before.push(0);
        for mesh in &leaf_meshes {
            triangles +=
                mesh_draws.get(*mesh as usize).map_or(0, |draw| draw.index_count / 3) as u64;
            triangles_before.push(triangles);
        }
        let limit = device.adapter().limits.max_storage_buffer_range.into();
        let instance_bytes = (leaf_meshes.len() * size_of::<Instance>()) as u64;
        if instance_bytes > limit {
            let most = limit / size_of::<Instance>() as u64;
            let wanted = leaf_meshes.len() as u64;
            let what = "the number of objects".to_owned();
            return Err(gpu::Error::TooLarge { what, wanted, limit: most }.into());
        }
        let instances: Vec<Instance> = objects()
            .filter_map(object)
            .map(|object| {
                let matrix = object.transform.matrix3;
                let at = object.transform.translation;
                let row = |r: usize| {
                    let row = matrix.row(r);
                    [row.x, row.y, row.z, at[r]]
                };
                Instance { rows: [row(0), row(1), row(2)], tint: unpack_unorm(object.tint) }
            })
            .collect();
        let (vertex, index) =
            (vk::BufferUsageFlags::VERTEX_BUFFER, vk::BufferUsageFlags::INDEX_BUFFER);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Ok(Self {
            vertices: device.upload("vertices", &vertices, vertex)?,
            indices: device.upload("indices", &indices, index)?,
            instances: device.upload("instances", &instances, storage)?,
            leaf_boxes: device.upload("leaf boxes", &leaf_boxes(hierarchy), storage)?,
            mesh_draws,
            leaf_meshes,
            triangles_before,
        })
    }

    /// The draw of one leaf.
    pub(crate) fn draw(&self, leaf: LeafIndex) -> IndirectDraw {
        let mesh = self.leaf_meshes.get(leaf.0 as usize).copied().unwrap_or(u32::MAX);
        let draw = self.mesh_draws.get(mesh as usize).copied().unwrap_or_default();
        IndirectDraw { first_instance: leaf.0, ..draw }
    }

    /// The draws of all leaves, in their order.
    pub(crate) fn draws(&self) -> Vec<IndirectDraw> {
        (0..self.leaf_meshes.len() as u32).map(|leaf| self.draw(LeafIndex(leaf))).collect()
    }

    /// The triangles of a range of leaves.
    pub(crate) fn triangles(&self, leaves: LeafRange) -> u64 {
        let before = |leaf: u32| self.triangles_before.get(leaf as usize).copied().unwrap_or(0);
        let end = leaves.first.0 + leaves.count;
        before(end).saturating_sub(before(leaves.first.0))
    }
}

/// The box of each leaf, in their order.
fn leaf_boxes(hierarchy: &Hierarchy) -> Vec<ProxyBox> {
    let nodes = hierarchy.leaf_objects().iter().filter_map(|object| hierarchy.node_of(*object));
    nodes.map(|node| ProxyBox::from(hierarchy.bounds(node))).collect()
}

/// All meshes in one vertex and one index buffer, so that any objects can share a draw call.
fn join_meshes(scene: &Scene) -> (Vec<Vertex>, Vec<u32>, Vec<IndirectDraw>) {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    let mut draws = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        draws.push(IndirectDraw {
            index_count: mesh.indices.len() as u32,
            instance_count: 1,
            first_index: indices.len() as u32,
            vertex_offset: vertices.len() as i32,
            first_instance: 0,
        });
        vertices.extend_from_slice(&mesh.vertices);
        indices.extend_from_slice(&mesh.indices);
    }
    (vertices, indices, draws)
}
