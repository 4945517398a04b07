//! Textures with separate images, which shaders index by number.

use gpu::{
    CancellationToken, Device, OptionalFeature, TextureArray, TextureNumber, TextureTable, vk,
};
use scene::limits::MAX_OWN_IMAGES;
use scene::{PreparedTexture, Surfaces, TextureId};

use crate::error::Error;
use crate::resource_errors::TextureError;
use crate::resources::limits;
use crate::resources::spare_capacity::SpareRanges;
use crate::shading::surfaces::blocks::{PageBlocks, SampledBlocks};
use crate::shading::surfaces::page_upload::{Sampling, upload_pages};
use crate::shading::surfaces::pages::{Page, PagePlan, bit_of};
use crate::shading::surfaces::texture_slots::{TexturePlace, removable};

/// The textures of a scene, and textures that are added later.
pub(crate) struct BindlessTextures {
    table: TextureTable,
    sampling: Sampling,
    /// The highest number of pixels per side.
    max_side: u32,
    sampled: SampledBlocks,
    ids: SpareRanges,
    /// The number of the scene's textures. Added textures have greater ids.
    of_scene: u32,
    /// The places of added textures.
    places: Vec<Option<TexturePlace>>,
}

impl BindlessTextures {
    /// Returns the highest number of textures that a device can index; 0 if it does not support
    /// indexing.
    pub(crate) fn most(device: &Device) -> u32 {
        if device.capabilities().has(OptionalFeature::DescriptorIndexing) {
            device.adapter().indexed_textures.min(MAX_OWN_IMAGES)
        } else {
            0
        }
    }

    /// Returns the number of textures that `surfaces` use.
    pub(crate) fn count(device: &Device, surfaces: &Surfaces) -> u64 {
        let max_side = device.adapter().limits.max_image_dimension2_d;
        PagePlan::of_images(surfaces, max_side, SampledBlocks::default()).pages.len() as u64
    }

    /// Uploads the textures that `surfaces` use, by their plan. Waits for copies.
    pub(crate) fn new(
        device: &Device,
        surfaces: &Surfaces,
        sampling: Sampling,
        plan: &PagePlan,
        cancellation: &CancellationToken,
    ) -> Result<Self, Error> {
        let max_side = device.adapter().limits.max_image_dimension2_d;
        let sampled = SampledBlocks::of(device);
        let count = plan.pages.len() as u64;
        let most = device.adapter().indexed_textures.min(MAX_OWN_IMAGES);
        const FEWER: &str = "let materials share textures, or take `TextureStorage::ArrayPacked`";
        limits::check("textures with an image each", count, most.into(), FEWER)?;
        let room = room(device.adapter().kind, count as u32, most);
        let mut table = TextureTable::new(device, "textures", room)?;
        let create = |info: &gpu::TextureArrayInfo<'_>| table.create(info);
        for texture in upload_pages(device, surfaces, plan, sampling, cancellation, create)? {
            table.add(texture)?;
        }
        let of_scene = surfaces.textures.len() as u32;
        let to_come = room.saturating_sub(count as u32);
        let ids = SpareRanges::behind("textures", of_scene, to_come);
        let places = Vec::new();
        Ok(Self { table, sampling, max_side, sampled, ids, of_scene, places })
    }

    /// Returns the table in which draws look up textures.
    pub(crate) fn table(&self) -> &TextureTable {
        &self.table
    }

    pub(crate) fn image(&self, place: TexturePlace) -> Option<&TextureArray> {
        self.table.texture(TextureNumber(place.page as u32))
    }

    /// Refuses a texture that cannot be added for a reason other than lack of room.
    pub(crate) fn check(&self, texture: &PreparedTexture) -> Result<(), TextureError> {
        if texture.image().size.iter().all(|side| (1..=self.max_side).contains(side)) {
            Ok(())
        } else {
            Err(TextureError::Size)
        }
    }

    /// Returns the compressed blocks of a texture, if the GPU samples them without unpacking.
    fn blocks(&self, texture: &PreparedTexture) -> Option<PageBlocks> {
        let encoding = texture.encoding();
        let sampler = texture.sampler();
        self.sampled.of_image(texture.image(), encoding, sampler, self.max_side)
    }

    /// Returns true if the GPU samples the blocks of a texture without unpacking.
    pub(crate) fn takes_blocks(&self, texture: &PreparedTexture) -> bool {
        self.blocks(texture).is_some()
    }

    /// Adds a texture. Its image must be opened before anything samples it.
    pub(crate) fn add(
        &mut self,
        texture: &PreparedTexture,
    ) -> Result<(TextureId, TexturePlace), Error> {
        let id = self.ids.take(1)?;
        match self.place_again(TextureId(id.start), texture) {
            Ok(place) => Ok((TextureId(id.start), place)),
            Err(error) => {
                self.ids.free(id);
                // The numbers of removed textures become free once their frames are over.
                match error {
                    Error::Gpu(gpu::Error::TooLarge { .. }) => {
                        Err(Error::CapacityExceeded { what: "textures", wanted: 1, left: 0 })
                    }
                    other => Err(other),
                }
            }
        }
    }

    /// Creates the image of a texture whose id is taken.
    pub(crate) fn place_again(
        &mut self,
        id: TextureId,
        texture: &PreparedTexture,
    ) -> Result<TexturePlace, Error> {
        let encoding = texture.encoding();
        let sampler = texture.sampler();
        let size = texture.image().size;
        let blocks = self.blocks(texture);
        let page = Page { size, encoding, sampler, layers: Vec::new(), spare: 1, blocks };
        let mut image = self.table.create(&self.sampling.array_info("texture that came", &page))?;
        image.announce();
        let TextureNumber(number) = self.table.add(image)?;
        let bit = bit_of(encoding);
        let has_two_channels = texture.image().has_two_channels();
        let place = TexturePlace { page: number as usize, layer: 0, bit, has_two_channels };
        let there = id.0.saturating_sub(self.of_scene) as usize;
        self.places.resize(self.places.len().max(there + 1), None);
        if let Some(there) = self.places.get_mut(there) {
            *there = Some(place);
        }
        Ok(place)
    }

    /// Takes over from `lost`, textures of the same scene, which ids are taken.
    pub(crate) fn restore(&mut self, lost: &Self) {
        self.ids.clone_from(&lost.ids);
    }

    /// Refuses to remove a texture that was not added later or does not exist. Materials are not
    /// checked.
    pub(crate) fn check_removal(&self, texture: TextureId) -> Result<(), TextureError> {
        removable(texture, self.of_scene, &self.places).map(drop)
    }

    /// Removes a texture that no material uses.
    pub(crate) fn remove(&mut self, texture: TextureId) {
        let number = texture.0.checked_sub(self.of_scene);
        let place = number.and_then(|number| self.places.get_mut(number as usize));
        let Some(TexturePlace { page, .. }) = place.and_then(Option::take) else { return };
        self.ids.free(texture.0..texture.0 + 1);
        self.table.remove(TextureNumber(page as u32));
    }
}

/// Returns the number of textures that a table has room for. A table for `most` textures takes two
/// megabytes of a GPU. Software drivers may visit every entry in each draw, so their tables have
/// room only for the textures of the scene and [`TO_COME_ON_A_CPU`] more.
fn room(kind: vk::PhysicalDeviceType, of_scene: u32, most: u32) -> u32 {
    match kind {
        vk::PhysicalDeviceType::CPU => of_scene.saturating_add(TO_COME_ON_A_CPU).min(most),
        _ => most,
    }
}

/// The number of textures that can be added on a software driver.
const TO_COME_ON_A_CPU: u32 = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tables_that_are_walked_in_each_draw_are_short() {
        let gpu = vk::PhysicalDeviceType::INTEGRATED_GPU;
        let cpu = vk::PhysicalDeviceType::CPU;
        assert_eq!(room(gpu, 5, MAX_OWN_IMAGES), 32_767);
        assert_eq!(room(cpu, 5, MAX_OWN_IMAGES), 1029);
        assert_eq!(room(cpu, 32_700, MAX_OWN_IMAGES), 32_767);
        assert_eq!(room(cpu, u32::MAX, 2000), 2000);
    }
}
