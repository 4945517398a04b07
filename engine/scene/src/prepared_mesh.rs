//! Meshes that a renderer can add while it runs.

use cull::Aabb;

use super::error::SceneError;
use super::{LodLevel, Mesh, Scene, SurfaceMesh, Surfaces};

/// A checked mesh with its surface and its coarser levels: everything that a renderer uploads for
/// it. It can be prepared on any thread, so that a frame only has to pass it to the renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedMesh {
    mesh: Mesh,
    surface: Option<SurfaceMesh>,
    levels: Vec<LodLevel>,
}

/// The surface of a mesh, with its coarser levels.
struct LeveledSurface {
    surface: SurfaceMesh,
    levels: Vec<LodLevel>,
}

impl PreparedMesh {
    /// Checks a mesh for a scene whose vertices hold the whole appearance.
    ///
    /// # Errors
    /// [`SceneError::BrokenMesh`].
    pub fn new(mesh: Mesh) -> Result<Self, SceneError> {
        Self::checked(mesh, None)
    }

    /// Checks a mesh for a scene with [`Surfaces`], with any number of coarser levels. Its material
    /// must belong to the scene to which the mesh is added.
    ///
    /// # Errors
    /// [`SceneError::BrokenMesh`], [`SceneError::BrokenSurfaces`].
    pub fn with_surface(
        mesh: Mesh,
        surface: SurfaceMesh,
        levels: Vec<LodLevel>,
    ) -> Result<Self, SceneError> {
        Self::checked(mesh, Some(LeveledSurface { surface, levels }))
    }

    fn checked(mesh: Mesh, surface: Option<LeveledSurface>) -> Result<Self, SceneError> {
        if mesh.indices.is_empty() {
            let fault = "it has no triangles";
            return Err(SceneError::BrokenMesh { mesh: mesh.name, fault });
        }
        let mut scene = Scene::single(mesh);
        scene.surfaces = surface.map(|leveled| Surfaces {
            meshes: vec![leveled.surface],
            levels: vec![leveled.levels],
            ..Surfaces::default()
        });
        scene.validate()?;
        let Scene { mut meshes, surfaces, .. } = scene;
        let (surface, levels) = match surfaces {
            Some(Surfaces { mut meshes, mut levels, .. }) => {
                (Some(meshes.swap_remove(0)), levels.swap_remove(0))
            }
            None => (None, Vec::new()),
        };
        Ok(Self { mesh: meshes.swap_remove(0), surface, levels })
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Returns the surface; `None` if the vertices hold the whole appearance.
    pub fn surface(&self) -> Option<&SurfaceMesh> {
        self.surface.as_ref()
    }

    /// Returns the coarser levels, the finest first.
    pub fn levels(&self) -> &[LodLevel] {
        &self.levels
    }

    /// Returns the tight box around the vertices, in the space of the mesh, in metres.
    pub fn bounds(&self) -> Aabb {
        self.mesh.bounds
    }

    /// Returns the number of indices, including the indices of the coarser levels.
    pub fn index_count(&self) -> usize {
        self.mesh.indices.len() + self.levels.iter().map(|level| level.indices.len()).sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MaterialId, SurfaceVertex};

    fn mesh() -> Mesh {
        let corners = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Mesh::of_triangles("triangle", &corners.map(|corner| (corner, [1.0; 3])))
    }

    fn surface(vertices: usize) -> SurfaceMesh {
        let vertex: SurfaceVertex = bytemuck::Zeroable::zeroed();
        SurfaceMesh { vertices: vec![vertex; vertices], material: MaterialId(0) }
    }

    #[test]
    fn a_mesh_comes_back_as_it_was_given() {
        let level = LodLevel { indices: vec![0, 1, 2], error_m: 0.5 };
        let levels = vec![level.clone(), level];
        let prepared = PreparedMesh::with_surface(mesh(), surface(3), levels.clone()).unwrap();
        assert_eq!((prepared.mesh(), prepared.levels()), (&mesh(), levels.as_slice()));
        assert_eq!((prepared.surface(), prepared.index_count()), (Some(&surface(3)), 9));
        assert_eq!(PreparedMesh::new(mesh()).unwrap().surface(), None);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let empty = Mesh { indices: Vec::new(), ..mesh() };
        let outside = Mesh { indices: vec![0, 1, 3], ..mesh() };
        for broken in [empty, outside] {
            let error = PreparedMesh::new(broken).unwrap_err().to_string();
            assert!(error.contains("triangle"), "{error}");
        }
        assert!(PreparedMesh::with_surface(mesh(), surface(2), Vec::new()).is_err());
        let broken = LodLevel { indices: vec![0, 1, 9], error_m: 0.5 };
        assert!(PreparedMesh::with_surface(mesh(), surface(3), vec![broken]).is_err());
    }
}
