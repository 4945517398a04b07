//! The places of textures that are added later, on pages that are kept for them.

use scene::{PreparedTexture, TextureId};

use crate::error::Error;
use crate::resource_errors::TextureError;
use crate::resources::spare_capacity::{SpareRanges, TextureCapacity};

/// The place of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TexturePlace {
    /// The page, or the number of a separate image.
    pub(crate) page: usize,
    pub(crate) layer: u32,
    /// The bit of [`Features`](super::materials::Features) that pipelines must be compiled with.
    pub(crate) bit: u32,
    /// True if its image has only red and green: z of a normal map is computed from them.
    pub(crate) has_two_channels: bool,
}

/// A page for textures of one size, encoding and sampler.
#[derive(Clone, Debug)]
struct SparePage {
    room: TextureCapacity,
    page: usize,
    layers: SpareRanges,
}

/// The pages that are kept for added textures, and the textures on them.
#[derive(Clone, Debug)]
pub(crate) struct TextureSlots {
    pages: Vec<SparePage>,
    ids: SpareRanges,
    /// The number of the scene's textures. Added textures have greater ids.
    of_scene: u32,
    /// The places of added textures.
    places: Vec<Option<TexturePlace>>,
}

impl TextureSlots {
    /// Keeps the pages from `first_page` on, and the ids after the ids of the scene's textures.
    pub(crate) fn new(of_scene: u32, first_page: usize, rooms: &[TextureCapacity]) -> Self {
        let page = |(page, room): (usize, &TextureCapacity)| SparePage {
            room: *room,
            page,
            layers: SpareRanges::behind("textures of this kind", 0, room.layers),
        };
        let all = rooms.iter().fold(0_u32, |all, room| all.saturating_add(room.layers));
        Self {
            pages: (first_page..).zip(rooms).map(page).collect(),
            ids: SpareRanges::behind("textures", of_scene, all),
            of_scene,
            places: vec![None; all as usize],
        }
    }

    /// Refuses a texture that cannot be added for a reason other than lack of room.
    pub(crate) fn check(&self, texture: &PreparedTexture) -> Result<(), TextureError> {
        if self.pages.iter().any(|page| page.room.takes(texture)) {
            return Ok(());
        }
        Err(TextureError::NoRoomForKind)
    }

    /// Takes a place for a texture that was checked.
    pub(crate) fn add(
        &mut self,
        texture: &PreparedTexture,
    ) -> Result<(TextureId, TexturePlace), Error> {
        let mut full =
            Error::CapacityExceeded { what: "textures of this kind", wanted: 1, left: 0 };
        for SparePage { page, layers, .. } in
            self.pages.iter_mut().filter(|page| page.room.takes(texture))
        {
            match layers.take(1) {
                Ok(layer) => {
                    let id = self.ids.take(1)?.start;
                    let place = TexturePlace {
                        page: *page,
                        layer: layer.start,
                        bit: 1 << *page,
                        has_two_channels: texture.image().has_two_channels(),
                    };
                    if let Some(there) = self.places.get_mut((id - self.of_scene) as usize) {
                        *there = Some(place);
                    }
                    return Ok((TextureId(id), place));
                }
                Err(error) => full = error,
            }
        }
        Err(full)
    }

    /// Takes over from `lost`, textures of the same scene, which places are taken. The pages may
    /// follow another number of pages of the scene, since a device with less memory has smaller
    /// textures, and so fewer sizes.
    pub(crate) fn restore(&mut self, lost: &Self) {
        let page_of = |old: usize| {
            let number = lost.pages.iter().position(|page| page.page == old);
            number.and_then(|number| self.pages.get(number)).map(|page| page.page)
        };
        let moved = |place: &TexturePlace| {
            let page = page_of(place.page)?;
            Some(TexturePlace { page, bit: 1 << page, ..*place })
        };
        self.places = lost.places.iter().map(|place| place.as_ref().and_then(moved)).collect();
        self.ids.clone_from(&lost.ids);
        for (page, lost) in self.pages.iter_mut().zip(&lost.pages) {
            page.layers.clone_from(&lost.layers);
        }
    }

    /// Returns the place of an added texture.
    pub(crate) fn place(&self, texture: TextureId) -> Option<TexturePlace> {
        removable(texture, self.of_scene, &self.places).ok()
    }

    /// Refuses to remove a texture that was not added later or does not exist. Materials are not
    /// checked.
    pub(crate) fn check_removal(&self, texture: TextureId) -> Result<(), TextureError> {
        removable(texture, self.of_scene, &self.places).map(drop)
    }

    /// Frees the place of a texture that no material uses.
    pub(crate) fn remove(&mut self, texture: TextureId) {
        let number = texture.0.checked_sub(self.of_scene);
        let place = number.and_then(|number| self.places.get_mut(number as usize));
        let Some(TexturePlace { page, layer, .. }) = place.and_then(Option::take) else { return };
        self.ids.free(texture.0..texture.0 + 1);
        if let Some(page) = self.pages.iter_mut().find(|known| known.page == page) {
            page.layers.free(layer..layer + 1);
        }
    }
}

/// Returns the place of an added texture, or the reason why it cannot be removed.
pub(super) fn removable(
    texture: TextureId,
    of_scene: u32,
    places: &[Option<TexturePlace>],
) -> Result<TexturePlace, TextureError> {
    let Some(number) = texture.0.checked_sub(of_scene) else {
        return Err(TextureError::Permanent);
    };
    let place = places.get(number as usize).copied().flatten();
    place.ok_or(TextureError::UnknownTexture)
}
