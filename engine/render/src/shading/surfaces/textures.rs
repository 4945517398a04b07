//! The textures of a renderer on the GPU: on pages, or with separate images.

use gpu::{Device, SampledArrays, TextureArray};
use scene::limits::MAX_PAGES;
use scene::{PreparedTexture, Surfaces, Texels, TextureId};

use crate::error::Error;
use crate::resource_errors::TextureError;
use crate::shading::surfaces::bindless_textures::BindlessTextures;
use crate::shading::surfaces::blocks::SampledBlocks;
use crate::shading::surfaces::page_upload::{Sampling, plan, upload_all_pages};
use crate::shading::surfaces::pages::PagePlan;
use crate::shading::surfaces::surface_options::SurfaceOptions;
use crate::shading::surfaces::texture_slots::{TexturePlace, TextureSlots};
use crate::shading::surfaces::texture_storage::TextureStorage;

/// All textures that materials and lights use or may use.
pub(crate) enum SurfaceTextures {
    Pages { arrays: Vec<TextureArray>, slots: TextureSlots },
    Images(Box<BindlessTextures>),
}

impl SurfaceTextures {
    /// Uploads the textures of `surfaces`. Returns them with the plan of their places. Waits for
    /// copies. Fails for separate images on a device that cannot index them.
    pub(crate) fn new(
        device: &Device,
        surfaces: &Surfaces,
        options: &SurfaceOptions,
    ) -> Result<(Self, PagePlan), Error> {
        let sampling = Sampling::of(device, options);
        let plan = plan_of(device, surfaces, options, options.max_texture_side)?;
        if plan.are_own {
            let cancellation = &options.cancellation;
            let images = BindlessTextures::new(device, surfaces, sampling, &plan, cancellation)?;
            return Ok((Self::Images(Box::new(images)), plan));
        }
        let rooms = &options.spare.textures;
        let arrays = upload_all_pages(device, surfaces, &plan, sampling, &options.cancellation)?;
        let first_page = plan.pages.len().saturating_sub(rooms.len());
        let slots = TextureSlots::new(surfaces.textures.len() as u32, first_page, rooms);
        Ok((Self::Pages { arrays, slots }, plan))
    }

    /// Returns the size of the textures of `surfaces` if none has more than `max_side` texels per
    /// side; 0 if they cannot be planned.
    pub(crate) fn size_bytes(
        device: &Device,
        surfaces: &Surfaces,
        options: &SurfaceOptions,
        max_side: u32,
    ) -> u64 {
        let plan = plan_of(device, surfaces, options, max_side);
        plan.map_or(0, |plan| Sampling::of(device, options).size_bytes(&plan))
    }

    pub(crate) fn storage(&self) -> TextureStorage {
        match self {
            Self::Pages { .. } => TextureStorage::ArrayPacked,
            Self::Images(_) => TextureStorage::Bindless,
        }
    }

    /// Returns the array that contains a texture.
    pub(crate) fn array(&self, place: TexturePlace) -> Option<&TextureArray> {
        match self {
            Self::Pages { arrays, .. } => arrays.get(place.page),
            Self::Images(images) => images.image(place),
        }
    }

    /// Calls `bind` with the arrays for passes: all pages that shaders declare, with the first in
    /// place of missing ones; or the table of all images.
    pub(crate) fn bound(&self, bind: impl FnOnce(SampledArrays<'_>)) {
        match self {
            Self::Images(images) => bind(SampledArrays::Table(images.table())),
            Self::Pages { arrays, .. } => {
                let Some(first) = arrays.first() else { return bind(SampledArrays::NONE) };
                let page = |page| arrays.get(page).unwrap_or(first);
                bind(SampledArrays::Few(&std::array::from_fn::<_, MAX_PAGES, _>(page)));
            }
        }
    }

    /// Returns true if a texture has compressed blocks that must be unpacked.
    pub(crate) fn unpacks(&self, texture: &PreparedTexture) -> bool {
        let takes_blocks = match self {
            Self::Pages { .. } => false,
            Self::Images(images) => images.takes_blocks(texture),
        };
        matches!(texture.image().texels, Texels::Blocks { .. }) && !takes_blocks
    }

    /// Returns a texture in the form to upload.
    pub(crate) fn ready(&self, texture: PreparedTexture) -> PreparedTexture {
        if self.unpacks(&texture) { texture.unpacked() } else { texture }
    }

    /// Refuses a texture that cannot be added for a reason other than lack of room.
    pub(crate) fn check(&self, texture: &PreparedTexture) -> Result<(), TextureError> {
        match self {
            Self::Pages { slots, .. } => slots.check(texture),
            Self::Images(images) => images.check(texture),
        }
    }

    /// Takes a place for a texture that was checked.
    pub(crate) fn add(
        &mut self,
        texture: &PreparedTexture,
    ) -> Result<(TextureId, TexturePlace), Error> {
        match self {
            Self::Pages { slots, .. } => slots.add(texture),
            Self::Images(images) => images.add(texture),
        }
    }

    /// Takes over from `lost`, textures of the same scene in the same storage, which places are
    /// taken. Separate images are created again by [`SurfaceTextures::place_again`].
    pub(crate) fn restore(&mut self, lost: &Self) {
        match (self, lost) {
            (Self::Pages { slots, .. }, Self::Pages { slots: lost, .. }) => slots.restore(lost),
            (Self::Images(images), Self::Images(lost)) => images.restore(lost),
            (Self::Pages { .. }, Self::Images(_)) | (Self::Images(_), Self::Pages { .. }) => {}
        }
    }

    /// Returns the place of a texture that was added before the device was lost: its old place on
    /// a page, or that of a new image.
    pub(crate) fn place_again(
        &mut self,
        id: TextureId,
        texture: &PreparedTexture,
    ) -> Result<Option<TexturePlace>, Error> {
        match self {
            Self::Pages { slots, .. } => Ok(slots.place(id)),
            Self::Images(images) => images.place_again(id, texture).map(Some),
        }
    }

    /// Refuses to remove a texture that was not added later or does not exist. Materials are not
    /// checked.
    pub(crate) fn check_removal(&self, texture: TextureId) -> Result<(), TextureError> {
        match self {
            Self::Pages { slots, .. } => slots.check_removal(texture),
            Self::Images(images) => images.check_removal(texture),
        }
    }

    /// Frees the place of a texture that no material uses.
    pub(crate) fn remove(&mut self, texture: TextureId) {
        match self {
            Self::Pages { slots, .. } => slots.remove(texture),
            Self::Images(images) => images.remove(texture),
        }
    }
}

/// Plans the places of the textures of `surfaces` in the requested or best storage. No texture has
/// more than `max_side` texels per side.
fn plan_of(
    device: &Device,
    surfaces: &Surfaces,
    options: &SurfaceOptions,
    max_side: u32,
) -> Result<PagePlan, Error> {
    let storage = options.textures.unwrap_or_else(|| {
        TextureStorage::best(
            BindlessTextures::count(device, surfaces),
            BindlessTextures::most(device),
        )
    });
    if storage == TextureStorage::Bindless {
        let max_side = max_side.min(device.adapter().limits.max_image_dimension2_d);
        return Ok(PagePlan::of_images(surfaces, max_side, SampledBlocks::of(device)));
    }
    plan(device, surfaces, &options.spare.textures, max_side)
}
