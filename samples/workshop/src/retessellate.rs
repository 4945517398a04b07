//! Tessellates curved parts on the GPU, at the levels of an image.

use antumbra::Camera;
use antumbra::gpu::Device;
use antumbra::render::{Error, ShaderSet, TessellationPath, Tessellator};
use antumbra::scene::{Mesh, PreparedMesh, Scene, TessellationLevels, TessellationView};

use crate::document::{CurvedPart, Document};
use crate::viewport::ModelViewport;

/// The curved parts of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tessellated {
    /// The number of their triangles.
    pub triangles: u64,
    /// The method by which they were computed.
    pub path: TessellationPath,
}

/// The tessellation of curved parts. The first use compiles its pipeline.
#[derive(Default)]
pub struct CurvedParts {
    tessellator: Option<Tessellator>,
}

impl CurvedParts {
    /// Tessellates the curved parts of a document, in the document and on the GPU. `None` if it has
    /// none. Draws frames while the GPU is at work.
    ///
    /// # Errors
    /// No room, not enough memory, a lost device.
    pub fn tessellate(
        &mut self,
        viewport: &mut ModelViewport,
        document: &mut Document,
        camera: &Camera,
        piece_px: f32,
    ) -> Result<Option<Tessellated>, Error> {
        let mut triangles = None;
        let view = viewport.view_of(camera);
        for index in 0..document.curved.len() {
            let CurvedPart { curved, levels } = &document.curved[index];
            let id = curved.mesh;
            let shown = document.objects().find(|object| {
                let object = document.scene.objects.get(object.0 as usize);
                object.is_some_and(|object| object.mesh == id)
            });
            let Some(object) = shown else { continue };
            let wanted = TessellationView::new(&view, &document.transform(object), piece_px);
            let levels = TessellationLevels::new(&curved.surface, &wanted, levels.as_ref());
            let Some(old) = document.mesh(object) else { continue };
            let name = old.name.clone();
            let colour = old.vertices.first().map_or(u32::MAX, |vertex| vertex.colour);
            let tessellator = self.tessellator(viewport.device())?;
            tessellator.request(&curved.surface, &levels, &name, colour)?;
            let mesh = await_surface(tessellator, viewport, camera)?;
            *triangles.get_or_insert(0) += mesh.triangles();
            let mesh = prepared(&document.scene, id.0 as usize, mesh)?;
            viewport.set_mesh(document, id, mesh.clone())?;
            document.set_mesh(id, mesh);
            document.curved[index].levels = Some(levels);
        }
        let path = self.tessellator.as_ref().map(Tessellator::path);
        Ok(triangles.zip(path).map(|(triangles, path)| Tessellated { triangles, path }))
    }

    /// Returns the tessellator, which the first call creates.
    fn tessellator(&mut self, device: &Device) -> Result<&mut Tessellator, Error> {
        let tessellator = match self.tessellator.take() {
            Some(tessellator) => tessellator,
            None => Tessellator::new(device, &ShaderSet::embedded()?)?,
        };
        Ok(self.tessellator.insert(tessellator))
    }
}

/// Draws frames until the surface is available.
fn await_surface(
    tessellator: &mut Tessellator,
    viewport: &mut ModelViewport,
    camera: &Camera,
) -> Result<Mesh, Error> {
    loop {
        if let Some(mesh) = tessellator.finished()? {
            return Ok(mesh);
        }
        viewport.draw(camera, None)?;
    }
}

/// Returns a mesh with the material of the mesh that it replaces.
fn prepared(scene: &Scene, index: usize, mesh: Mesh) -> Result<PreparedMesh, Error> {
    let material = scene.surfaces.as_ref().and_then(|surfaces| surfaces.meshes.get(index));
    let with_surface = Scene::single(mesh).with_surfaces();
    let mut surfaces = with_surface.surfaces.unwrap_or_default();
    let mut meshes = with_surface.meshes;
    let mut surface = surfaces.meshes.swap_remove(0);
    if let Some(old) = material {
        surface.material = old.material;
    }
    Ok(PreparedMesh::with_surface(meshes.swap_remove(0), surface, Vec::new())?)
}
