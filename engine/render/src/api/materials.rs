//! Materials that are added and removed while the renderer runs.

use scene::{Material, MaterialId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resource_errors::MaterialError;

impl Renderer {
    /// Adds materials, all or none, and returns their ids in the same order. New meshes can use
    /// them at once; the next frame uploads them. An id may have belonged to a material that was
    /// removed. There must be room ([`RendererOptions::spare`](crate::RendererOptions::spare)).
    ///
    /// The materials can use textures that the renderer began with or that were
    /// [added](Renderer::add_textures).
    ///
    /// # Errors
    /// [`Error::Material`] for a scene without surfaces, and for a material that blends or that has
    /// a number that is not finite or a texture that does not exist; [`Error::CapacityExceeded`].
    pub fn add_materials(&mut self, materials: &[Material]) -> Result<Vec<MaterialId>, Error> {
        let Some(surfaces) = &mut self.passes.gpu_scene.geometry.surfaces else {
            return refused(materials.len());
        };
        for (index, material) in materials.iter().enumerate() {
            let checked = surfaces.check_material(material);
            checked.map_err(|reason| Error::Material { index, reason })?;
        }
        let slots = &mut surfaces.material_slots;
        let mut added = Vec::with_capacity(materials.len());
        for material in materials {
            match slots.add(material) {
                Ok(id) => added.push(id),
                Err(error) => {
                    added.into_iter().for_each(|id| slots.remove(id));
                    return Err(error);
                }
            }
        }
        Ok(added)
    }

    /// Replaces the colours and numbers of a material. The next frame shows them on every mesh that
    /// has the material.
    ///
    /// # Errors
    /// [`Error::Material`] for a material that does not exist; for a material that is not opaque
    /// before and after, since shadows and depth depend on its holes; and as for
    /// [`Renderer::add_materials`]. [`Error::CapacityExceeded`] for its texture transforms. Nothing
    /// has changed then.
    pub fn set_material(&mut self, material: MaterialId, to: &Material) -> Result<(), Error> {
        let refused = |reason| Error::Material { index: material.0 as usize, reason };
        let surfaces = self.passes.gpu_scene.geometry.surfaces.as_mut();
        let surfaces = surfaces.ok_or(refused(MaterialError::NoSurfaces))?;
        surfaces.check_material(to).map_err(refused)?;
        surfaces.material_slots.check_replacement(material, to).map_err(refused)?;
        surfaces.material_slots.replace(material, to)
    }

    /// Removes materials, all or none. Their room is free at once.
    ///
    /// # Errors
    /// [`Error::Material`] for a material that does not exist, is named twice, or is used by a
    /// mesh.
    pub fn remove_materials(&mut self, materials: &[MaterialId]) -> Result<(), Error> {
        let Some(surfaces) = &mut self.passes.gpu_scene.geometry.surfaces else {
            return refused(materials.len()).map(drop);
        };
        let slots = &mut surfaces.material_slots;
        for (index, material) in materials.iter().enumerate() {
            let is_new = !materials[..index].contains(material);
            let checked = slots.check_removal(*material);
            let checked = checked.and(if is_new { Ok(()) } else { Err(MaterialError::NamedTwice) });
            checked.map_err(|reason| Error::Material { index, reason })?;
        }
        materials.iter().for_each(|material| slots.remove(*material));
        Ok(())
    }
}

/// Refuses the first of some materials. An empty list is not an error.
fn refused(count: usize) -> Result<Vec<MaterialId>, Error> {
    let reason = MaterialError::NoSurfaces;
    if count == 0 { Ok(Vec::new()) } else { Err(Error::Material { index: 0, reason }) }
}
