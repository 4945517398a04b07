//! The edges of meshes on the GPU: the segments of each draw, and a draw of segments for each leaf.
//! Only renderers that draw edges have them. They are built from the meshes on the GPU, and from
//! meshes that are added later.
//!
//! A segment refers to vertices and holds no positions, so edges follow the poses of skinned
//! meshes. The choice of feature edges is made at rest.

use std::ops::Range;

use cull::{Hierarchy, LeafIndex, LeafRange, ObjectId};
use glam::Vec3;
use gpu::{
    Access, Buffer, BufferSlice, Commands, Device, Frame, MemoryBarrier, MemoryKind, UnindexedDraw,
    vk,
};
use occlusion::{LeafTable, MeshDrawId, ScatterIo, ScatterPass};
use scene::{EdgeRules, EdgeSource, FeatureEdges, MeshId, PreparedMesh, Vertex};

use crate::error::Error;
use crate::passes::{EdgePath, EdgeSegment};
use crate::resources::geometry::Geometry;
use crate::resources::limits::check_storage;
use crate::resources::mesh_slots::{MeshPlace, Residency};
use crate::resources::skinned_meshes::SkinnedMeshes;
use crate::resources::volume_meshes::Contents;

/// The highest number of segments in a chain with one dash pattern: the shader adds up their
/// lengths.
const RUN_SEGMENTS: u32 = 128;

const SEGMENT_BYTES: u64 = size_of::<EdgeSegment>() as u64;

/// The edges of all meshes.
pub(crate) struct EdgeMeshes {
    device: Device,
    path: EdgePath,
    rules: EdgeRules,
    segments: Buffer,
    /// The former, smaller buffer, until a frame that copies it has been submitted.
    former: Option<Buffer>,
    /// The number of segments, on the GPU and in `coming`.
    count: u32,
    /// The segments of each draw, by `MeshDrawId`.
    draws: Vec<Range<u32>>,
    /// Segments of meshes that were added later. The next frame uploads them after the segments on
    /// the GPU.
    coming: Vec<EdgeSegment>,
    /// A draw per leaf.
    leaf_draws: Buffer,
}

impl EdgeMeshes {
    /// Builds the edges of all meshes except sprites. Waits for copies.
    pub(crate) fn new(
        device: &Device,
        geometry: &Geometry,
        skinned_meshes: Option<&SkinnedMeshes>,
        hierarchy: &Hierarchy,
        rules: EdgeRules,
    ) -> Result<Self, Error> {
        const SIMPLER: &str = "use simpler meshes, or leave edges and outlines off";
        let vertex_bytes = size_of::<Vertex>() as u64;
        let vertices = geometry.vertices.size_bytes() / vertex_bytes;
        check_storage(device, "vertices with edges", vertices, vertex_bytes, SIMPLER)?;
        let contents = Contents::copied_back(device, geometry, skinned_meshes)?;
        let mut all = Vec::new();
        let mut draws = vec![0..0; geometry.mesh_draws().len()];
        let mut put = |id: MeshDrawId, source: &EdgeSource<'_>, place: &MeshPlace, rules| {
            if let Some(draw) = draws.get_mut(id.0 as usize) {
                *draw = append(&mut all, source, place, rules);
            }
        };
        for (mesh, residency, place) in geometry.meshes.placed() {
            let is_skinned = geometry.is_skinned(mesh);
            let are_sprites = residency == Residency::Kept && !is_skinned;
            if are_sprites || residency == Residency::Uploading {
                continue;
            }
            let (positions, _) = contents.vertices_of(mesh, place, skinned_meshes);
            for (id, indices) in place.draws(mesh) {
                let indices = indices.start as usize..indices.end as usize;
                let triangles = contents.indices.read::<u32>(indices);
                let source = EdgeSource { positions: &positions, triangles, faces: &[] };
                put(id, &source, place, EdgeRules { keeps_flat: is_skinned, ..rules });
            }
        }
        for (mesh, prepared, place) in geometry.uploads.meshes() {
            let positions = positions_of(prepared);
            for ((id, _), triangles) in place.draws(mesh).zip(levels_of(prepared)) {
                let source = EdgeSource { positions: &positions, triangles, faces: &[] };
                put(id, &source, place, rules);
            }
        }
        let path = EdgePath::of(device);
        check_segments(device, all.len())?;
        let none = [EdgeSegment { from: 0, to: 0, left: 0, right: 0, run: 0 }];
        let there = if all.is_empty() { &none[..] } else { &all[..] };
        let segments = device.upload("edges", there, segments_usage())?;
        let leaf_draw = |(leaf, object): (u32, &ObjectId)| {
            let segments = draws.get(geometry.draw_of(*object).0 as usize).cloned();
            path.draw(&segments.unwrap_or_default(), leaf)
        };
        let leaf_draws: Vec<_> = (0..).zip(hierarchy.leaf_objects()).map(leaf_draw).collect();
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
        let leaf_draws = device.upload("draws of edges", &leaf_draws, usage)?;
        Ok(Self {
            device: device.clone(),
            path,
            rules,
            segments,
            former: None,
            count: all.len() as u32,
            draws,
            coming: Vec::new(),
            leaf_draws,
        })
    }

    /// Returns the rules that make an edge a feature.
    pub(crate) fn rules(&self) -> &EdgeRules {
        &self.rules
    }

    /// Returns all segments on the GPU.
    pub(crate) fn segments(&self) -> BufferSlice {
        self.segments.whole()
    }

    pub(crate) fn leaf_draws(&self, leaves: LeafRange) -> BufferSlice {
        let first = leaves.first.0;
        self.leaf_draws.whole().elements::<UnindexedDraw>(first..first + leaves.count)
    }

    /// Returns the draw of the edges of a mesh by an instance.
    pub(crate) fn draw(&self, id: MeshDrawId, instance: u32) -> UnindexedDraw {
        let segments = self.draws.get(id.0 as usize).cloned().unwrap_or_default();
        self.path.draw(&segments, instance)
    }

    /// Takes a mesh that is being uploaded.
    pub(crate) fn add(&mut self, id: MeshId, mesh: &PreparedMesh, place: &MeshPlace) {
        let positions = positions_of(mesh);
        for ((id, _), triangles) in place.draws(id).zip(levels_of(mesh)) {
            let source = EdgeSource { positions: &positions, triangles, faces: &[] };
            let before = self.count - self.coming.len() as u32;
            let range = append(&mut self.coming, &source, place, self.rules);
            // Numbers continue after the segments on the GPU.
            for segment in &mut self.coming[range.start as usize..range.end as usize] {
                if segment.run != EdgeSegment::SMOOTH {
                    segment.run += before;
                }
            }
            let range = before + range.start..before + range.end;
            self.count = range.end;
            if let Some(draw) = self.draws.get_mut(id.0 as usize) {
                *draw = range;
            }
        }
    }

    /// Records the upload of new segments and of changed draws of leaves, before anything of
    /// `frame` reads them.
    pub(crate) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        leaves: &LeafTable,
        scatter: &ScatterPass,
        draw_of: impl Fn(&LeafIndex) -> MeshDrawId,
    ) -> Result<(), Error> {
        self.upload_coming(frame)?;
        let changed = leaves.dirty();
        if changed.is_empty() {
            return Ok(());
        }
        let draws = changed.iter().map(|leaf| self.draw(draw_of(leaf), leaf.0));
        let uploads = frame.uploads();
        let io = ScatterIo {
            elements: uploads.push_iter(draws)?,
            leaves: uploads.push_iter(changed.iter().map(|leaf| leaf.0))?,
            array: self.leaf_draws.whole(),
            element_bytes: size_of::<UnindexedDraw>(),
        };
        scatter.record(frame.commands(), changed.len() as u32, [io]);
        Ok(())
    }

    fn upload_coming(&mut self, frame: &mut Frame<'_>) -> Result<(), Error> {
        if self.coming.is_empty() {
            return Ok(());
        }
        check_segments(&self.device, self.count as usize)?;
        let coming = frame.uploads().push(&self.coming)?;
        let first = u64::from(self.count) * SEGMENT_BYTES - coming.size_bytes;
        let wanted = u64::from(self.count) * SEGMENT_BYTES;
        let between = MemoryBarrier::between;
        let commands: &Commands = frame.commands();
        if wanted > self.segments.size_bytes() {
            let most = u64::from(self.device.adapter().limits.max_storage_buffer_range);
            let size_bytes = wanted.max((2 * self.segments.size_bytes()).min(most));
            let memory = MemoryKind::Device;
            let larger = Buffer::new(&self.device, "edges", size_bytes, segments_usage(), memory)?;
            let former = std::mem::replace(&mut self.segments, larger);
            self.former.get_or_insert(former);
        }
        if let Some(former) = &self.former {
            commands.barrier(between(&[Access::CopyWrite], &[Access::CopyRead]));
            commands.copy_buffer(former.whole(), self.segments.whole());
        }
        let uses = [Access::VertexRead, Access::CopyWrite];
        commands.barrier(between(&uses, &[Access::CopyWrite]));
        commands.copy_buffer(coming, self.segments.whole().part(first, coming.size_bytes));
        commands.barrier(between(&[Access::CopyWrite], &[Access::VertexRead]));
        Ok(())
    }

    /// Notes that the frame of the last upload was submitted.
    pub(crate) fn submitted(&mut self) {
        self.coming.clear();
        self.former = None;
    }
}

fn segments_usage() -> vk::BufferUsageFlags {
    vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::TRANSFER_SRC
        | vk::BufferUsageFlags::TRANSFER_DST
}

/// Refuses more segments than the device's storage buffers hold, or than a draw with 18 vertices
/// per segment can address.
fn check_segments(device: &Device, count: usize) -> Result<(), Error> {
    const SIMPLER: &str = "use simpler meshes, or leave edges and outlines off";
    check_storage(device, "segments of edges", count as u64, SEGMENT_BYTES, SIMPLER)
}

/// Appends the segments of triangles. Returns their range.
fn append(
    all: &mut Vec<EdgeSegment>,
    source: &EdgeSource<'_>,
    place: &MeshPlace,
    rules: EdgeRules,
) -> Range<u32> {
    let edges = FeatureEdges::new(source, &rules);
    let start = all.len() as u32;
    let vertex = place.vertices.start;
    let mut push = |segment: &scene::EdgeSegment, run: u32| {
        all.push(EdgeSegment {
            from: vertex + segment.from,
            to: vertex + segment.to,
            left: vertex + segment.left,
            right: segment.right.map_or(EdgeSegment::NO_FACE, |right| vertex + right),
            run,
        });
    };
    for chain in edges.chains() {
        for number in chain.segments.clone() {
            let since = (number - chain.segments.start) % RUN_SEGMENTS;
            if let Some(segment) = edges.segments().get(number as usize) {
                push(segment, start + number - since);
            }
        }
    }
    edges.smooth().iter().for_each(|segment| push(segment, EdgeSegment::SMOOTH));
    start..all.len() as u32
}

fn positions_of(mesh: &PreparedMesh) -> Vec<Vec3> {
    mesh.mesh().vertices.iter().map(|vertex| vertex.position.into()).collect()
}

/// Returns the triangles of a mesh and of its coarser levels.
fn levels_of(mesh: &PreparedMesh) -> impl Iterator<Item = &[u32]> {
    let levels = mesh.levels().iter().map(|level| level.indices.as_slice());
    std::iter::once(mesh.mesh().indices.as_slice()).chain(levels)
}
