//! All meshes of a scene in one vertex and one index buffer, so that any objects can share a draw
//! call.

use std::sync::Arc;

use gpu::IndirectDraw;
use occlusion::MeshDraw;
use scene::{Mesh, Scene, Vertex};

use crate::error::Error;
use crate::resources::limits::{check, check_memory, room};
use crate::resources::lod::LodTable;
use crate::resources::skinned_meshes::mesh_order;
use crate::resources::spare_capacity::SpareCapacity;
use crate::resources::sprites;

/// The vertices, indices and draws of the scene, followed by room for more.
pub(crate) struct JoinedMeshes {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) indices: Vec<u32>,
    /// The draws in this order: of the scene's meshes, room for more meshes, of the coarser levels
    /// of the scene's meshes, room for more levels.
    pub(crate) draws: Arc<[MeshDraw]>,
    pub(crate) lods: LodTable,
    /// The numbers of used vertices, indices and draws, without the room for more.
    pub(crate) used: [u32; 3],
}

impl JoinedMeshes {
    pub(crate) fn new(scene: &Scene, spare: &SpareCapacity) -> Result<Self, Error> {
        let (mut vertices, mut indices, mut draws) = join(scene, spare)?;
        let lods = LodTable::join(scene, &mut indices, &mut draws);
        sprites::add_pattern(scene, &mut vertices, &mut indices, &mut draws);
        let used = [vertices.len(), indices.len(), draws.len()].map(|count| count as u32);
        vertices.resize(vertices.len() + spare.vertices as usize, bytemuck::Zeroable::zeroed());
        indices.resize(indices.len() + spare.indices as usize, 0);
        draws.resize(draws.len() + spare.levels as usize, IndirectDraw::default());
        let draws = counted(scene, spare, &draws);
        Ok(Self { vertices, indices, draws, lods, used })
    }
}

/// Returns draws together with their numbers of triangles.
fn counted(scene: &Scene, spare: &SpareCapacity, draws: &[IndirectDraw]) -> Arc<[MeshDraw]> {
    let levels = scene.surfaces.as_ref().map_or(&[][..], |surfaces| &surfaces.levels);
    let coarser = scene.meshes.iter().zip(levels);
    let coarser = coarser.flat_map(|(mesh, levels)| levels.iter().map(move |_| Some(mesh)));
    let to_come = std::iter::repeat_n(None, spare.meshes as usize);
    let meshes = scene.meshes.iter().map(Some).chain(to_come).chain(coarser);
    let meshes = meshes.chain(std::iter::repeat(None));
    let counted = |(draw, mesh): (&IndirectDraw, Option<&Mesh>)| {
        let triangles = mesh.map_or(0, |mesh| mesh.triangles_of(draw.index_count as usize));
        MeshDraw { draw: *draw, triangles: triangles as u32 }
    };
    draws.iter().zip(meshes).map(counted).collect()
}

/// The most memory that a renderer takes for each mesh in addition to its vertices and indices
/// (bytes).
const BYTES_PER_MESH: usize = 256;

/// The vertices and indices of all meshes, and the draw of each mesh.
type Joined = (Vec<Vertex>, Vec<u32>, Vec<IndirectDraw>);

/// Joins all meshes, with room for their coarser levels, for the pattern of sprites, and for meshes
/// that are added later.
fn join(scene: &Scene, spare: &SpareCapacity) -> Result<Joined, Error> {
    let levels = scene.surfaces.iter().flat_map(|surfaces| surfaces.levels.iter().flatten());
    let levels: usize = levels.map(|level| level.indices.len()).sum();
    let [pattern_vertices, pattern_indices] = sprites::pattern_size(scene);
    let vertices = scene.meshes.iter().map(|mesh| mesh.vertices.len()).sum::<usize>();
    let vertices = vertices + pattern_vertices + spare.vertices as usize;
    let indices = scene.meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>();
    let indices = indices + levels + pattern_indices + spare.indices as usize;
    const INSTEAD: &str = "use simpler meshes, or less room for those that come";
    let most = i32::MAX as u64;
    check("vertices, with room for those that come,", vertices as u64, most, INSTEAD)?;
    check("indices, with room for those that come,", indices as u64, most, INSTEAD)?;
    let mut vertices = room("the vertices of all meshes", vertices)?;
    let mut indices = room("the triangles of all meshes", indices)?;
    let draws = scene.meshes.len() + spare.meshes as usize;
    let all = draws.saturating_add(spare.levels as usize);
    check_memory("meshes, with room for those that come", all, BYTES_PER_MESH)?;
    let mut draws = vec![IndirectDraw::default(); draws];
    for number in mesh_order(scene) {
        let (Some(mesh), Some(draw)) = (scene.meshes.get(number), draws.get_mut(number)) else {
            continue;
        };
        *draw = IndirectDraw {
            index_count: mesh.indices.len() as u32,
            instance_count: 1,
            first_index: indices.len() as u32,
            vertex_offset: vertices.len() as i32,
            first_instance: 0,
        };
        vertices.extend_from_slice(&mesh.vertices);
        indices.extend_from_slice(&mesh.indices);
    }
    Ok((vertices, indices, draws))
}
