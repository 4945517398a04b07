//! Textures that come and go while the renderer runs.

use scene::{PreparedTexture, TextureId};

use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::limits;

impl Renderer {
    /// Adds textures, and returns their ids in the same order: all of them, or none. Materials that
    /// are [added](Renderer::add_materials) can use them at once. An id may have belonged to a
    /// texture that was removed. Where textures lie on [pages], there must be room for their size,
    /// encoding and sampler ([`SpareCapacity::textures`](crate::SpareCapacity::textures)); images
    /// of their own take none.
    ///
    /// Nothing waits: each frame copies some rows of what was added first
    /// ([`RendererOptions::upload_bytes_per_frame`]), and makes the mip maps of what is whole.
    /// Meshes that were added later arrive later, so that none is drawn without its textures. Where
    /// the device cannot make mip maps, this call does; it also unpacks compressed blocks that the
    /// device, or a page, does not take.
    ///
    /// [pages]: crate::surfaces::TextureStorage::ArrayPacked
    /// [`RendererOptions::upload_bytes_per_frame`]: crate::RendererOptions::upload_bytes_per_frame
    ///
    /// # Errors
    /// [`Error::Texture`] for a scene without surfaces or a texture that no room is kept for, or
    /// beyond the device's size; [`Error::CapacityExceeded`]; no memory for images of their own, or
    /// for unpacking.
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
        for ((id, place), texture) in added.iter().zip(textures) {
            let texture = surfaces.textures.ready(texture);
            let levels = surfaces.levels_by_cpu(*place, &texture);
            geometry.uploads.push_texture(*id, texture, *place, levels);
        }
        Ok(added.into_iter().map(|(id, _)| id).collect())
    }

    /// Removes textures: all of them, or none. Frames on their way still show them; their room is
    /// free at once on pages, and once those frames are over where textures have an image each.
    ///
    /// # Errors
    /// [`Error::Texture`] for one that is not there or named twice, that a material uses, or that
    /// the renderer began with.
    pub fn remove_textures(&mut self, textures: &[TextureId]) -> Result<(), Error> {
        let geometry = &mut self.passes.gpu_scene.geometry;
        let Some(surfaces) = &mut geometry.surfaces else {
            return refused(textures.len()).map(drop);
        };
        for (index, texture) in textures.iter().enumerate() {
            let is_new = !textures[..index].contains(texture);
            let checked = surfaces.check_texture_removal(*texture);
            let checked = checked.and(if is_new { Ok(()) } else { Err("it is named twice") });
            checked.map_err(|reason| Error::Texture { index, reason })?;
        }
        for texture in textures {
            geometry.uploads.cancel_texture(*texture);
            surfaces.remove_texture(*texture);
        }
        Ok(())
    }
}

/// Refuses the first of some textures; none are no mistake.
fn refused(count: usize) -> Result<Vec<TextureId>, Error> {
    let reason = "the scene has no surfaces";
    if count == 0 { Ok(Vec::new()) } else { Err(Error::Texture { index: 0, reason }) }
}
