//! Tests of pages for scenes with very many images, sizes and samplers: pages are complete, few
//! enough, and within their limit.

use std::collections::{BTreeSet, HashSet};

use glam::Affine2;
use scene::limits::MAX_PAGES;
use scene::{
    Encoding, Filter, Image, ImageId, Material, Sampler, Surfaces, Texture, TextureId, TextureUse,
    Wrap,
};

use super::page_groups::SMALL_PAGES_BYTES;
use super::pages::PagePlan;

type Look = (u32, Encoding, Sampler);

/// Returns surfaces with an image of each size, and textures that are all used.
fn surfaces(sizes: &[[u32; 2]], textures: &[Look]) -> Surfaces {
    let image = |size: &[u32; 2]| Image::of_rgba8("", *size, Vec::new());
    let texture = |(image, encoding, sampler): &Look| Texture {
        image: ImageId(*image),
        encoding: *encoding,
        sampler: *sampler,
    };
    let base = |texture| TextureUse {
        texture: TextureId(texture),
        uv_set: 0,
        transform: Affine2::IDENTITY,
    };
    let material =
        |texture| Material { base_colour_texture: Some(base(texture)), ..Material::default() };
    Surfaces {
        images: sizes.iter().map(image).collect(),
        textures: textures.iter().map(texture).collect(),
        materials: (0..textures.len() as u32).map(material).collect(),
        ..Surfaces::default()
    }
}

/// Returns a texture for each image.
fn plain(sizes: &[[u32; 2]]) -> Surfaces {
    let look = |image| (image, Encoding::Srgb, Sampler::default());
    surfaces(sizes, &(0..sizes.len() as u32).map(look).collect::<Vec<_>>())
}

/// Returns the bytes of an image with all mip maps.
fn bytes(size: [u32; 2]) -> u64 {
    let [mut width, mut height] = size;
    let mut sum = 0;
    loop {
        sum += 4 * u64::from(width) * u64::from(height);
        if width.max(height) == 1 {
            return sum;
        }
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
}

/// Checks that each texture has its own image, and that pages are few and within their limit.
/// Returns the bytes of the pages.
fn assert_sound(plan: &PagePlan, surfaces: &Surfaces, max_layers: u32) -> u64 {
    assert!(plan.pages.len() <= MAX_PAGES, "{} pages", plan.pages.len());
    let mut own = BTreeSet::new();
    for (texture, place) in surfaces.textures.iter().zip(&plan.places) {
        let (page, layer) = place.unwrap();
        assert_eq!(plan.pages[page].layers[layer as usize], texture.image);
        assert_eq!(plan.pages[page].encoding, texture.encoding);
        own.insert((texture.image, texture.encoding == Encoding::Srgb));
    }
    for page in &plan.pages {
        assert!(page.layers.len() <= max_layers as usize && !page.layers.is_empty());
        assert_eq!(page.layers.iter().collect::<HashSet<_>>().len(), page.layers.len());
        assert!(page.size.iter().all(|side| (1..=16_384).contains(side)));
    }
    let own: u64 = own.iter().map(|(image, _)| bytes(surfaces.images[image.0 as usize].size)).sum();
    let all: u64 = plan.pages.iter().map(|page| bytes(page.size) * page.layers.len() as u64).sum();
    assert!(all <= (2 * own).max(SMALL_PAGES_BYTES), "{all} bytes for {own}");
    all
}

#[test]
fn thousands_of_sizes_lose_nothing_while_they_are_small() {
    let sizes: Vec<_> = (0..3000).map(|number| [1 + number % 64, 1 + number / 64]).collect();
    let surfaces = plain(&sizes);
    let plan = PagePlan::new(&surfaces, 16_384, 2048, MAX_PAGES);
    assert_sound(&plan, &surfaces, 2048);
    assert_eq!(plan.shrunk, 0);
    assert_eq!(plan, PagePlan::new(&surfaces, 16_384, 2048, MAX_PAGES), "the same again");
}

#[test]
fn one_huge_image_does_not_blow_thousands_of_tiny_ones_up() {
    for tiny in [1, 40] {
        let mut sizes = vec![[16_384, 16_384]];
        sizes.extend((0..4000).map(|number| [1 + number % tiny, 1 + number / 7 % tiny]));
        let surfaces = plain(&sizes);
        let plan = PagePlan::new(&surfaces, 16_384, 2048, MAX_PAGES);
        assert_sound(&plan, &surfaces, 2048);
        assert_eq!(plan.shrunk, 0, "the huge one stays as it is: {tiny}");
    }
}

#[test]
fn long_and_high_images_are_not_brought_to_one_that_holds_both() {
    let sizes = (0..13).flat_map(|index| vec![[1 << index, 1 << (12 - index)]; 40]);
    let surfaces = plain(&sizes.chain([[8192, 8192]]).collect::<Vec<_>>());
    let plan = PagePlan::new(&surfaces, 16_384, 2048, MAX_PAGES);
    assert_sound(&plan, &surfaces, 2048);
    let huge = plan.places[520].unwrap().0;
    assert_eq!(plan.pages[huge].size, [8192, 8192]);
    assert!(plan.shrunk <= 160, "{}", plan.shrunk);
}

#[test]
fn an_image_is_not_copied_for_each_of_many_samplers() {
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let looks: Vec<Look> = (0..216)
        .map(|number| {
            let encoding = if number % 2 == 0 { Encoding::Srgb } else { Encoding::Linear };
            let wrap = [wraps[number / 2 % 3], wraps[number / 6 % 3]];
            let filter = |bit: usize| if bit == 0 { Filter::Nearest } else { Filter::Linear };
            let between_levels = [None, Some(Filter::Nearest), Some(Filter::Linear)];
            let sampler = Sampler {
                wrap,
                magnified: filter(number / 18 % 2),
                minified: filter(number / 36 % 2),
                between_levels: between_levels[number / 72],
            };
            (0, encoding, sampler)
        })
        .collect();
    let large = surfaces(&[[16_384, 16_384]], &looks);
    let plan = PagePlan::new(&large, 16_384, 2048, MAX_PAGES);
    assert_eq!(assert_sound(&plan, &large, 2048), 2 * bytes([16_384; 2]));
    let small = surfaces(&[[64, 64]], &looks);
    let plan = PagePlan::new(&small, 16_384, 2048, MAX_PAGES);
    assert_sound(&plan, &small, 2048);
    assert_eq!(plan.pages.len(), MAX_PAGES, "small ones keep as many samplers as they can");
}

#[test]
fn images_of_an_encoding_fill_the_last_layer_of_all_pages() {
    // Two thirds of a page for each of 18 sizes: merging any two of them saves no page.
    let sizes: Vec<_> = (0..18).flat_map(|index| vec![[index + 1, 2 * index + 1]; 40]).collect();
    let surfaces = plain(&sizes);
    assert_sound(&PagePlan::new(&surfaces, 16_384, 60, MAX_PAGES), &surfaces, 60);
    let plan = PagePlan::new(&surfaces, 16_384, 59, MAX_PAGES);
    assert!(plan.pages.len() > MAX_PAGES, "more images than layers is for the caller to refuse");
}

#[test]
fn whatever_there_is_gets_a_page_within_the_bound() {
    for seed in 0..120_u64 {
        let mut state = seed;
        let mut random = move |below: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_889);
            ((state >> 33) as u32) % below
        };
        let count = 1 << (seed % 12);
        let largest = [4, 9, 12, 15][(seed / 12 % 4) as usize];
        let mut side = || (1 << random(largest)) + random(3);
        let sizes: Vec<_> =
            (0..count).map(|_| [side(), side()].map(|number: u32| number.min(16_384))).collect();
        let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
        let samplers = 1 + (seed % 5) as u32 * 2;
        let mut look = |image| {
            let encoding = if random(4) == 0 { Encoding::Linear } else { Encoding::Srgb };
            let kind = random(samplers) as usize;
            let wrap = [wraps[kind % 3], wraps[kind / 3]];
            (image, encoding, Sampler { wrap, ..Sampler::default() })
        };
        let looks: Vec<_> = (0..2 * count).map(|number| look(number % count)).collect();
        let surfaces = surfaces(&sizes, &looks);
        let plan = PagePlan::new(&surfaces, 16_384, 512, MAX_PAGES);
        assert_sound(&plan, &surfaces, 512);
        assert_eq!(plan, PagePlan::new(&surfaces, 16_384, 512, MAX_PAGES), "seed {seed}");
    }
}
