//! Textures that are added and removed while the renderer runs.

use scene::{PreparedTexture, TextureId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resource_errors::TextureError;
use crate::resources::limits;

impl Renderer {
    /// Adds textures, all or none, and returns their ids in the same order. Materials that are
    /// [added](Renderer::add_materials) can use them at once. An id may have belonged to a texture
    /// that was removed. If textures lie on [pages], there must be room for their size, encoding
    /// and sampler ([`SpareCapacity::textures`](crate::SpareCapacity::textures)); textures with
    /// images of their own need no such room.
    ///
    /// Nothing waits: each frame copies a number of rows
    /// ([`RendererOptions::upload_bytes_per_frame`]), in the order in which things were added, and
    /// creates the mip maps of complete textures. Meshes that were added later arrive later, so a
    /// mesh is never drawn without its textures. If the device cannot create mip maps, this call
    /// does; it also unpacks compressed blocks that the device, or a page, does not support.
    ///
    /// [pages]: crate::surfaces::TextureStorage::ArrayPacked
    /// [`RendererOptions::upload_bytes_per_frame`]: crate::RendererOptions::upload_bytes_per_frame
    ///
    /// [`Error::Texture`] for a scene without surfaces, and for a texture that no room is kept for
    /// or that is larger than the device supports; [`Error::CapacityExceeded`]; no memory for
    /// images of their own, or for unpacking.
    pub fn add_textures(
        &mut self,
        textures: Vec<PreparedTexture>,
    ) -> Result<Vec<TextureId>, Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        let Some(surfaces) = &mut geometry.surfaces else {
            return refused(textures.len());
        };
        for (index, texture) in textures.iter().enumerate() {
            let checked = surfaces.textures.check(texture);
            checked.map_err(|reason| Error::Texture { index, reason })?;
        }
        for texture in textures.iter().filter(|texture| surfaces.textures.unpacks(texture)) {
            limits::check_unpacking(texture.image().size)?;
        }
        let mut added = Vec::with_capacity(textures.len());
        for texture in &textures {
            match surfaces.add_texture(texture) {
                Ok(taken) => added.push(taken),
                Err(error) => {
                    added.into_iter().for_each(|(id, _)| surfaces.remove_texture(id));
                    return Err(error);
                }
            }
        }
        self.has_other_content = true;
        for ((id, place), texture) in added.iter().zip(textures) {
            if let Some(kept) = &mut self.kept {
                kept.textures.insert(*id, texture.clone());
            }
            let texture = surfaces.textures.ready(texture);
            let levels = surfaces.levels_by_cpu(*place, &texture);
            geometry.uploads.push_texture(*id, texture, *place, levels);
        }
        Ok(added.into_iter().map(|(id, _)| id).collect())
    }

    /// Removes textures, all or none. Frames in flight still show them. Their room is free at once
    /// on pages; images of their own are freed once these frames are over.
    ///
    /// # Errors
    /// [`Error::Texture`] for a texture that does not exist, is named twice, is used by a material,
    /// or that the renderer began with.
    pub fn remove_textures(&mut self, textures: &[TextureId]) -> Result<(), Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        let Some(surfaces) = &mut geometry.surfaces else {
            return refused(textures.len()).map(drop);
        };
        for (index, texture) in textures.iter().enumerate() {
            let is_new = !textures[..index].contains(texture);
            let checked = surfaces.check_texture_removal(*texture);
            let checked = checked.and(if is_new { Ok(()) } else { Err(TextureError::NamedTwice) });
            checked.map_err(|reason| Error::Texture { index, reason })?;
        }
        for texture in textures {
            geometry.uploads.cancel_texture(*texture);
            surfaces.remove_texture(*texture);
            if let Some(kept) = &mut self.kept {
                kept.textures.remove(texture);
            }
        }
        Ok(())
    }
}

/// Refuses the first of some textures. An empty list is not an error.
fn refused(count: usize) -> Result<Vec<TextureId>, Error> {
    let reason = TextureError::NoSurfaces;
    if count == 0 { Ok(Vec::new()) } else { Err(Error::Texture { index: 0, reason }) }
}
