//! The pages of images: texture arrays with one size, encoding and sampler. They are few enough for
//! any device to bind them all at once.

use std::collections::{HashMap, HashSet};

use scene::limits::MAX_LAYERS;
use scene::{Encoding, ImageId, Sampler, Surfaces, Texels, Texture, TextureId};

use crate::resources::spare_capacity::TextureCapacity;
use crate::shading::surfaces::blocks::{PageBlocks, SampledBlocks};
use crate::shading::surfaces::page_groups::{Group, joined, most_texels};
use crate::shading::surfaces::texture_slots::TexturePlace;

/// Images of one size, encoding and sampler.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Size of each layer in pixels.
    pub size: [u32; 2],
    /// The encoding of the bytes.
    pub encoding: Encoding,
    /// The sampler that all layers share.
    pub sampler: Sampler,
    /// The image on each layer, resampled if its size differs.
    pub layers: Vec<ImageId>,
    /// The number of additional layers for textures that are added later.
    pub spare: u32,
    /// The compressed blocks of its only image, if the GPU samples them without unpacking.
    pub(crate) blocks: Option<PageBlocks>,
}

/// The place of each texture of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PagePlan {
    /// The pages, at most [`MAX_PAGES`](scene::limits::MAX_PAGES).
    pub pages: Vec<Page>,
    /// The page and the layer of each texture; `None` if its image does not exist.
    pub places: Vec<Option<(usize, u32)>>,
    /// The number of images that are resampled to the size of their page.
    pub resampled: usize,
    /// The number of resampled images that lose sharpness, since the device or the memory cannot
    /// hold larger ones.
    pub shrunk: usize,
    /// The number of images of compressed blocks that are unpacked.
    pub unpacked: usize,
    /// The number of textures that are sampled by another sampler than their own.
    pub resampled_by_others: usize,
    /// True if each page is the image of one texture, which shaders index by the page's number.
    pub are_own: bool,
}

/// Returns the bit of [`Features`](super::materials::Features) for textures with separate images:
/// pipelines distinguish colours from numbers.
pub(super) fn bit_of(encoding: Encoding) -> u32 {
    match encoding {
        Encoding::Srgb => 1,
        Encoding::Linear => 2,
    }
}

/// The properties that textures on one page share.
type Key = ([u32; 2], Encoding, Sampler);

impl PagePlan {
    /// Plans pages for the textures of `surfaces` that materials and lights use. Images on the
    /// device have at most `max_side` pixels per side and `max_layers` layers. Textures with the
    /// same image and sampler share a layer. Images that are too large for the device are halved
    /// until they fit.
    ///
    /// If there would be more than `max_pages` pages, the two pages that cost least to join are
    /// joined, repeatedly. Pages with the same sampler and aspect are joined first, so that images
    /// are enlarged before any is shrunk; then pages with the same wrapping. Samplers are given up
    /// last, encodings never. If there are very many pages, pages of similar sizes are joined
    /// first.
    ///
    /// All pages together take at most twice the memory of their images (unpacked), or
    /// [`SMALL_PAGES_BYTES`](super::page_groups::SMALL_PAGES_BYTES) if that is more. An image that
    /// is sampled both as colours and as numbers counts twice.
    #[must_use]
    pub fn new(surfaces: &Surfaces, max_side: u32, max_layers: u32, max_pages: usize) -> Self {
        let max_layers = max_layers.clamp(1, MAX_LAYERS);
        let used = used_textures(surfaces);
        let size_of = |texture: &Texture| {
            let image = surfaces.images.get(texture.image.0 as usize)?;
            Some(fitting(image.size, max_side.max(1)))
        };
        let mut groups: Vec<Group> = Vec::new();
        let mut of_key: HashMap<Key, usize> = HashMap::new();
        let mut known: HashSet<(usize, ImageId)> = HashSet::new();
        let textures = (0..).map(TextureId).zip(&surfaces.textures);
        let numbers: Vec<Option<usize>> = textures
            .map(|(id, texture)| {
                let size = size_of(texture).filter(|_| used.contains(&id))?;
                let Texture { encoding, sampler, image } = *texture;
                let next = groups.len();
                let number = *of_key.entry((size, encoding, sampler)).or_insert(next);
                if number == next {
                    let images = Vec::new();
                    let members = vec![number];
                    groups.push(Group { size, encoding, sampler, images, members });
                }
                if known.insert((number, image)) {
                    groups.get_mut(number)?.images.push(image);
                }
                Some(number)
            })
            .collect();
        let most_texels = most_texels(&groups);
        let groups = joined(groups, max_layers, max_pages, most_texels);
        let mut plan = Self::default();
        let mut page_groups: HashMap<usize, usize> = HashMap::new();
        let mut layers: HashMap<(usize, ImageId), (usize, u32)> = HashMap::new();
        for (page_group, group) in groups.iter().enumerate() {
            let first = plan.add(group, max_layers);
            page_groups.extend(group.members.iter().map(|member| (*member, page_group)));
            let place = |place: u32| (first + (place / max_layers) as usize, place % max_layers);
            layers.extend(
                (0..).zip(&group.images).map(|(layer, image)| ((page_group, *image), place(layer))),
            );
        }
        plan.places = surfaces
            .textures
            .iter()
            .zip(numbers)
            .map(|(texture, number)| {
                let page_group = *page_groups.get(&number?)?;
                let is_others = groups.get(page_group)?.sampler != texture.sampler;
                plan.resampled_by_others += usize::from(is_others);
                layers.get(&(page_group, texture.image)).copied()
            })
            .collect();
        plan.count_resampled(surfaces);
        plan
    }

    /// Plans an image for each texture of `surfaces` that materials and lights use, in its own
    /// size; an image with more than `max_side` pixels per side is halved until it fits. Textures
    /// with the same image, encoding and sampler share one. Compressed blocks that `sampled`
    /// contains are not unpacked.
    pub(crate) fn of_images(surfaces: &Surfaces, max_side: u32, sampled: SampledBlocks) -> Self {
        let used = used_textures(surfaces);
        let mut plan = Self { are_own: true, ..Self::default() };
        let mut known: HashMap<Texture, usize> = HashMap::new();
        for (id, texture) in (0..).map(TextureId).zip(&surfaces.textures) {
            let image = surfaces.images.get(texture.image.0 as usize);
            let place = image.filter(|_| used.contains(&id)).map(|image| {
                let next = plan.pages.len();
                let page = *known.entry(*texture).or_insert(next);
                if page == next {
                    let Texture { image: layer, encoding, sampler } = *texture;
                    let blocks = sampled.of_image(image, encoding, sampler, max_side);
                    let size = match blocks {
                        Some(blocks) => image.level_size(blocks.first_level),
                        None => fitting(image.size, max_side.max(1)),
                    };
                    let layers = vec![layer];
                    plan.pages.push(Page { size, encoding, sampler, layers, spare: 0, blocks });
                }
                (page, 0)
            });
            plan.places.push(place);
        }
        plan.count_resampled(surfaces);
        plan
    }

    /// Returns the place of each texture of `surfaces`, which this plan was made for.
    pub(crate) fn texture_places(&self, surfaces: &Surfaces) -> Vec<Option<TexturePlace>> {
        let place = |((page, layer), texture): ((usize, u32), &Texture)| {
            let encoding = self.pages.get(page)?.encoding;
            let bit = if self.are_own { bit_of(encoding) } else { 1 << page };
            let image = surfaces.images.get(texture.image.0 as usize)?;
            Some(TexturePlace { page, layer, bit, has_two_channels: image.has_two_channels() })
        };
        let textures = self.places.iter().zip(&surfaces.textures);
        textures.map(|(there, texture)| place(((*there)?, texture))).collect()
    }

    /// Returns the bits of [`Features`](super::materials::Features) for all present and later
    /// textures of an encoding.
    pub(crate) fn bits_of(&self, encoding: Encoding) -> u32 {
        if self.are_own {
            return bit_of(encoding);
        }
        let pages = self.pages.iter().enumerate().filter(|(_, page)| page.encoding == encoding);
        pages.fold(0, |bits, (page, _)| bits | 1 << page)
    }

    /// Adds a page for each kind of textures that may be added later.
    pub(crate) fn add_room(&mut self, rooms: &[TextureCapacity]) {
        let page = |room: &TextureCapacity| {
            let TextureCapacity { size, encoding, sampler, layers } = *room;
            Page { size, encoding, sampler, layers: Vec::new(), spare: layers, blocks: None }
        };
        self.pages.extend(rooms.iter().map(page));
    }

    fn count_resampled(&mut self, surfaces: &Surfaces) {
        let layers =
            self.pages.iter().flat_map(|page| page.layers.iter().map(move |layer| (page, layer)));
        for (page, image) in layers {
            let Some(image) = surfaces.images.get(image.0 as usize) else { continue };
            self.resampled += usize::from(image.size != page.size);
            let is_smaller = (0..2).any(|side| page.size[side] < image.size[side]);
            self.shrunk += usize::from(is_smaller);
            let is_unpacked =
                page.blocks.is_none() && matches!(image.texels, Texels::Blocks { .. });
            self.unpacked += usize::from(is_unpacked);
        }
    }

    /// Adds the pages of a group and returns the first.
    fn add(&mut self, group: &Group, max_layers: u32) -> usize {
        let first = self.pages.len();
        let Group { size, encoding, sampler, .. } = *group;
        self.pages.extend(group.images.chunks(max_layers as usize).map(|layers| Page {
            size,
            encoding,
            sampler,
            layers: layers.to_vec(),
            spare: 0,
            blocks: None,
        }));
        first
    }
}

/// Returns a size halved until each side is at most `max_side`.
fn fitting(mut size: [u32; 2], max_side: u32) -> [u32; 2] {
    while size.iter().any(|side| *side > max_side) {
        size = size.map(|side| (side / 2).max(1));
    }
    size
}

/// Returns the textures that materials or lights use.
fn used_textures(surfaces: &Surfaces) -> HashSet<TextureId> {
    let of_material = |material: &scene::Material| {
        [
            material.base_colour_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emission_texture,
        ]
    };
    let uses = surfaces.materials.iter().flat_map(of_material).flatten();
    let pictures = surfaces.lights.iter().filter_map(|light| light.cookie);
    let pictures = pictures.map(|picture| picture.texture);
    uses.map(|texture_use| texture_use.texture).chain(pictures).collect()
}
