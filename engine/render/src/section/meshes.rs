//! Meshes in the form that section planes need: the points that decide if a plane meets an object,
//! and if it encloses an inside to close. Only renderers with section planes have them.

use std::collections::HashMap;

use cull::SectionPlane;
use glam::{DVec3, Vec3};
use occlusion::MeshDrawId;
use scene::{Mesh, MeshId, PreparedMesh, Shell, Vertex};

use crate::resources::instance::Instance;
use crate::resources::mesh_slots::MeshPlace;

/// All meshes.
#[derive(Default)]
pub(crate) struct SectionMeshes {
    meshes: HashMap<MeshId, SectionMesh>,
    /// The shell of each draw, by its number.
    shells: Vec<Shell>,
}

/// A mesh whose shape does not change.
struct SectionMesh {
    points: Vec<Vec3>,
    /// The colour of its first vertex, packed like the colours of vertices.
    colour: u32,
}

/// The extent of an object along a plane's normal, and its size (metres).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// The lowest and the highest distance of its points from the plane.
    pub(crate) low_m: f64,
    pub(crate) high_m: f64,
    pub(crate) size_m: f64,
    /// The magnitude of its position: the sum of the absolute terms along the normal.
    pub(crate) place_m: f64,
}

impl SectionMeshes {
    /// Takes a mesh that is being uploaded.
    pub(crate) fn add(&mut self, id: MeshId, prepared: &PreparedMesh, place: &MeshPlace) {
        let mesh: &Mesh = prepared.mesh();
        self.add_vertices(id, &mesh.vertices);
        let levels = prepared.levels().iter().map(|level| level.indices.as_slice());
        let triangles = std::iter::once(mesh.indices.as_slice()).chain(levels);
        self.add_shells(id, place.draws(id).map(|(draw, _)| draw).zip(triangles));
    }

    pub(super) fn add_vertices(&mut self, id: MeshId, vertices: &[Vertex]) {
        let points = vertices.iter().map(|vertex| vertex.position.into()).collect();
        let colour = vertices.first().map_or(0, |vertex| vertex.colour);
        self.meshes.insert(id, SectionMesh { points, colour });
    }

    pub(super) fn add_shells<'a>(
        &mut self,
        id: MeshId,
        draws: impl Iterator<Item = (MeshDrawId, &'a [u32])>,
    ) {
        let Some(mesh) = self.meshes.get(&id) else { return };
        let positions: Vec<[f32; 3]> = mesh.points.iter().map(Vec3::to_array).collect();
        for (draw, triangles) in draws {
            let place = draw.0 as usize;
            self.shells.resize(self.shells.len().max(place + 1), Shell::Open);
            self.shells[place] = Shell::of(&positions, triangles);
        }
    }

    /// Returns the kind of shell that the triangles of a draw form.
    pub(crate) fn shell(&self, draw: MeshDrawId) -> Shell {
        self.shells.get(draw.0 as usize).copied().unwrap_or_default()
    }

    /// Returns the colour of a mesh, packed like the colours of vertices.
    pub(crate) fn colour(&self, mesh: MeshId) -> u32 {
        self.meshes.get(&mesh).map_or(u32::MAX, |mesh| mesh.colour)
    }

    /// Returns the extent of an object along the normal of a plane, if its mesh keeps its shape.
    pub(crate) fn extent(
        &self,
        mesh: MeshId,
        instance: &Instance,
        plane: &SectionPlane,
    ) -> Option<Extent> {
        let points = &self.meshes.get(&mesh).filter(|mesh| !mesh.points.is_empty())?.points;
        let rows = instance.rows.map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into()));
        let origin = DVec3::from(instance.rows.map(|[.., w]| f64::from(w)));
        let [x, y, z] = rows;
        let normal = plane.normal();
        let along = x * normal.x + y * normal.y + z * normal.z;
        let mut extent =
            Extent { low_m: f64::INFINITY, high_m: f64::NEG_INFINITY, size_m: 0.0, place_m: 0.0 };
        for point in points {
            let at = along.dot(point.as_dvec3());
            extent.low_m = extent.low_m.min(at);
            extent.high_m = extent.high_m.max(at);
        }
        let from = plane.distance_m(origin);
        extent.size_m = extent.low_m.abs().max(extent.high_m.abs());
        extent.place_m = (origin * normal).abs().element_sum();
        extent.low_m += from;
        extent.high_m += from;
        Some(extent)
    }
}
