//! Which image lies on which page: texture arrays of one size, encoding and sampler, few enough that any
//! device binds them all at once.

use std::collections::HashMap;

use crate::scene::{Encoding, ImageId, Sampler, Surfaces, Texture, TextureId};

/// The most pages of a scene: with room to spare within the 16 samplers that every device has.
pub const MAX_PAGES: usize = 12;

/// The most layers of a page, whatever the device can: a texture's place must fit a word.
pub const MAX_LAYERS: u32 = 2048;

/// Images of one size, encoding and sampler.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Size of each layer in pixels.
    pub size: [u32; 2],
    /// What the bytes mean.
    pub encoding: Encoding,
    /// How it is looked at.
    pub sampler: Sampler,
    /// The image on each layer, resampled where its size is another.
    pub layers: Vec<ImageId>,
}

/// Where each texture of a scene lies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PagePlan {
    /// At most [`MAX_PAGES`].
    pub pages: Vec<Page>,
    /// Page and layer of each texture; `None` for one whose image is not there.
    pub places: Vec<Option<(usize, u32)>>,
    /// Images that are resampled to the size of their page.
    pub resampled: usize,
    /// Textures that are looked at by another sampler than their own.
    pub resampled_by_others: usize,
}

/// What decides which textures can share a page as they are.
type Key = ([u32; 2], Encoding, Sampler);

impl PagePlan {
    /// Plans pages for the textures of `surfaces` that materials use, on a device whose images have at most
    /// `max_side` pixels a side and `max_layers` layers. Textures of the same image and sampler share a
    /// layer. Images beyond the device's size are halved until they fit.
    ///
    /// Where there would be more than [`MAX_PAGES`], the two pages whose union costs least become one:
    /// first those of the same sampler and aspect, so that images are made larger before any is made
    /// smaller; then those of the same wrapping; samplers are given up last, encodings never.
    #[must_use]
    pub fn new(surfaces: &Surfaces, max_side: u32, max_layers: u32) -> Self {
        let max_layers = max_layers.clamp(1, MAX_LAYERS);
        let used = used_textures(surfaces);
        let size_of = |texture: &Texture| {
            let image = surfaces.images.get(texture.image.0 as usize)?;
            Some(fitting(image.size, max_side.max(1)))
        };
        let mut groups: Vec<Group> = Vec::new();
        let mut of_key: HashMap<Key, usize> = HashMap::new();
        for (id, texture) in (0..).map(TextureId).zip(&surfaces.textures) {
            let Some(size) = size_of(texture).filter(|_| used.contains(&id)) else { continue };
            let key = (size, texture.encoding, texture.sampler);
            let group = *of_key.entry(key).or_insert_with(|| {
                groups.push(Group { key, images: Vec::new() });
                groups.len() - 1
            });
            if let Some(group) = groups.get_mut(group)
                && !group.images.contains(&texture.image)
            {
                group.images.push(texture.image);
            }
        }
        // Each key leads to the group it ended up in.
        let mut homes: Vec<(Key, usize)> = of_key.into_iter().collect();
        merge(&mut groups, &mut homes, max_layers);
        let mut plan = Self::default();
        let firsts: Vec<usize> = groups.iter().map(|group| plan.add(group, max_layers)).collect();
        plan.places = surfaces
            .textures
            .iter()
            .zip((0..).map(TextureId))
            .map(|(texture, id)| {
                let size = size_of(texture).filter(|_| used.contains(&id))?;
                let key = (size, texture.encoding, texture.sampler);
                let (_, home) = homes.iter().find(|(known, _)| *known == key)?;
                let group = groups.get(*home)?;
                let place = group.images.iter().position(|image| *image == texture.image)? as u32;
                plan.resampled_by_others += usize::from(group.key.2 != texture.sampler);
                Some((firsts.get(*home)? + (place / max_layers) as usize, place % max_layers))
            })
            .collect();
        let differs = |page: &Page| {
            let other = |image: &&ImageId| {
                surfaces.images.get(image.0 as usize).is_some_and(|image| image.size != page.size)
            };
            page.layers.iter().filter(other).count()
        };
        plan.resampled = plan.pages.iter().map(differs).sum();
        plan
    }

    /// Adds the pages of a group; answers the first.
    fn add(&mut self, group: &Group, max_layers: u32) -> usize {
        let first = self.pages.len();
        let (size, encoding, sampler) = group.key;
        self.pages.extend(group.images.chunks(max_layers as usize).map(|layers| Page {
            size,
            encoding,
            sampler,
            layers: layers.to_vec(),
        }));
        first
    }
}

/// Images that share pages.
struct Group {
    key: Key,
    images: Vec<ImageId>,
}

impl Group {
    fn pages(&self, max_layers: u32) -> usize {
        self.images.len().div_ceil(max_layers as usize)
    }

    fn pixels(&self) -> u64 {
        let [width, height] = self.key.0.map(u64::from);
        width * height * self.images.len() as u64
    }
}

/// Joins groups until their pages are few enough.
fn merge(groups: &mut Vec<Group>, homes: &mut [(Key, usize)], max_layers: u32) {
    while groups.iter().map(|group| group.pages(max_layers)).sum::<usize>() > MAX_PAGES {
        let pairs = (0..groups.len()).flat_map(|from| (0..groups.len()).map(move |to| (from, to)));
        let possible = pairs.filter_map(|(from, to)| {
            let cost = cost_of_joining(groups.get(from)?, groups.get(to)?, max_layers)?;
            (from != to).then_some((cost, from, to))
        });
        // Nothing to join is left where a scene has more images of one kind than all pages hold.
        let Some((_, from, to)) = possible.min() else { return };
        let moved = groups.swap_remove(from);
        let last = groups.len();
        // The last group took the place of the one that was moved.
        let place = |group: usize| if group == last { from } else { group };
        let target = place(to);
        for (_, home) in homes.iter_mut() {
            *home = if *home == from { target } else { place(*home) };
        }
        if let Some(group) = groups.get_mut(target) {
            for image in moved.images {
                if !group.images.contains(&image) {
                    group.images.push(image);
                }
            }
        }
    }
}

/// How bad it is to bring the images of one group to another: first by how they would look, then by
/// the pixels they would have more. `None` where they cannot, or nothing is won.
fn cost_of_joining(from: &Group, to: &Group, max_layers: u32) -> Option<(u8, u64)> {
    let ([from_size, to_size], joined) =
        ([from.key.0, to.key.0], from.images.len() + to.images.len());
    let is_won =
        joined.div_ceil(max_layers as usize) < from.pages(max_layers) + to.pages(max_layers);
    if from.key.1 != to.key.1 || !is_won {
        return None;
    }
    let (own, other) = (from.key.2, to.key.2);
    let is_smaller = (0..2).any(|side| to_size[side] < from_size[side]);
    let [width, height] = to_size.map(u64::from);
    let grown = (width * height * from.images.len() as u64).abs_diff(from.pixels());
    let look = match (own == other, own.wrap == other.wrap, is_smaller) {
        (true, _, false) => 0,
        (true, _, true) => 1,
        (false, true, false) => 2,
        (false, true, true) => 3,
        (false, false, false) => 4,
        (false, false, true) => 5,
    };
    Some((look, grown))
}

/// A size halved until each side is at most `max_side`.
fn fitting(mut size: [u32; 2], max_side: u32) -> [u32; 2] {
    while size.iter().any(|side| *side > max_side) {
        size = size.map(|side| (side / 2).max(1));
    }
    size
}

/// The textures that some material uses, once each.
fn used_textures(surfaces: &Surfaces) -> std::collections::HashSet<TextureId> {
    let of_material = |material: &crate::scene::Material| {
        [
            material.base_colour_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emission_texture,
        ]
    };
    let uses = surfaces.materials.iter().flat_map(of_material).flatten();
    uses.map(|texture_use| texture_use.texture).collect()
}
