//! Tests of the page of each image, without a device.

use glam::Affine2;
use scene::limits::MAX_PAGES;
use scene::{
    Encoding, Filter, Image, ImageId, Material, Sampler, Surfaces, Texture, TextureId, TextureUse,
    Wrap,
};

use super::pages::PagePlan;

/// Returns surfaces with an image of each size, and textures that are all used.
fn surfaces(sizes: &[[u32; 2]], textures: &[(u32, Encoding, Sampler)]) -> Surfaces {
    let image = |size: &[u32; 2]| Image::of_rgba8("", *size, Vec::new());
    let texture = |(image, encoding, sampler): &(u32, Encoding, Sampler)| Texture {
        image: ImageId(*image),
        encoding: *encoding,
        sampler: *sampler,
    };
    let material = |texture| Material {
        base_colour_texture: Some(TextureUse {
            texture: TextureId(texture),
            uv_set: 0,
            transform: Affine2::IDENTITY,
        }),
        ..Material::default()
    };
    Surfaces {
        images: sizes.iter().map(image).collect(),
        textures: textures.iter().map(texture).collect(),
        materials: (0..textures.len() as u32).map(material).collect(),
        ..Surfaces::default()
    }
}

fn clamped() -> Sampler {
    Sampler { wrap: [Wrap::Clamp; 2], ..Sampler::default() }
}

/// Returns all different samplers, 27 for each pair of filters.
fn samplers() -> Vec<Sampler> {
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let filters = [Filter::Nearest, Filter::Linear];
    let mut all = Vec::new();
    for across in wraps {
        for down in wraps {
            for magnified in filters {
                all.push(Sampler { wrap: [across, down], magnified, ..Sampler::default() });
            }
        }
    }
    all
}

/// Checks that every place holds the texture's own image.
fn assert_sound(plan: &PagePlan, surfaces: &Surfaces, max_layers: u32) {
    assert!(plan.pages.len() <= MAX_PAGES, "{}", plan.pages.len());
    for (texture, place) in surfaces.textures.iter().zip(&plan.places) {
        let (page, layer) = place.unwrap();
        let page = &plan.pages[page];
        assert_eq!(page.layers[layer as usize], texture.image);
        assert_eq!(page.encoding, texture.encoding);
        assert!(page.layers.len() <= max_layers as usize);
    }
}

#[test]
fn what_is_alike_shares_a_page_and_equal_images_a_layer() {
    let plain = Sampler::default();
    let srgb = Encoding::Srgb;
    let linear = Encoding::Linear;
    let surfaces = surfaces(
        &[[8, 8], [8, 8], [4, 8]],
        &[
            (0, srgb, plain),
            (1, srgb, plain),
            (0, srgb, plain),
            (2, srgb, plain),
            (0, linear, plain),
            (1, srgb, clamped()),
        ],
    );
    let plan = PagePlan::new(&surfaces, 4096, 256, MAX_PAGES);
    let places: Vec<_> = plan.places.iter().map(|place| place.unwrap()).collect();
    assert_eq!(places, [(0, 0), (0, 1), (0, 0), (1, 0), (2, 0), (3, 0)]);
    assert_eq!((plan.pages.len(), plan.resampled, plan.resampled_by_others), (4, 0, 0));
    assert_sound(&plan, &surfaces, 256);
}

#[test]
fn what_nobody_uses_or_has_takes_no_place() {
    let texture = (0, Encoding::Srgb, Sampler::default());
    let mut surfaces =
        surfaces(&[[8, 8]], &[texture, (7, Encoding::Srgb, Sampler::default()), texture]);
    surfaces.materials.truncate(2);
    surfaces.textures[2].encoding = Encoding::Linear;
    let plan = PagePlan::new(&surfaces, 4096, 256, MAX_PAGES);
    assert_eq!(plan.places, [Some((0, 0)), None, None]);
    assert_eq!(plan.pages.len(), 1);
    assert_eq!(PagePlan::new(&Surfaces::default(), 4096, 256, MAX_PAGES), PagePlan::default());
}

#[test]
fn more_images_than_layers_go_on_with_the_next_page() {
    let sizes = vec![[2, 2]; 10];
    let textures: Vec<_> =
        (0..10).map(|image| (image, Encoding::Srgb, Sampler::default())).collect();
    let surfaces = surfaces(&sizes, &textures);
    let plan = PagePlan::new(&surfaces, 4096, 4, MAX_PAGES);
    assert_eq!(plan.pages.iter().map(|page| page.layers.len()).collect::<Vec<_>>(), [4, 4, 2]);
    assert_sound(&plan, &surfaces, 4);
}

#[test]
fn images_beyond_the_device_are_halved() {
    let surfaces = surfaces(&[[60_000, 100]], &[(0, Encoding::Srgb, Sampler::default())]);
    let plan = PagePlan::new(&surfaces, 16_384, 256, MAX_PAGES);
    assert_eq!((plan.pages[0].size, plan.resampled), ([15_000, 25], 1));
}

#[test]
fn too_many_sizes_are_made_larger_first() {
    let sizes: Vec<_> = (1..=20).map(|size| [size * 16, size * 16]).collect();
    let textures: Vec<_> =
        (0..20).map(|image| (image, Encoding::Srgb, Sampler::default())).collect();
    let surfaces = surfaces(&sizes, &textures);
    let plan = PagePlan::new(&surfaces, 4096, 256, MAX_PAGES);
    assert_sound(&plan, &surfaces, 256);
    assert_eq!((plan.pages.len(), plan.resampled_by_others), (MAX_PAGES, 0));
    assert!(plan.resampled >= 8);
    for page in &plan.pages {
        for image in &page.layers {
            assert!(sizes[image.0 as usize][0] <= page.size[0], "nothing lost a pixel");
        }
    }
}

#[test]
fn samplers_are_given_up_last_and_encodings_never() {
    let mut textures = Vec::new();
    for sampler in samplers() {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            textures.push((0, encoding, sampler));
        }
    }
    let surfaces = surfaces(&[[64, 64]], &textures);
    let plan = PagePlan::new(&surfaces, 4096, 256, MAX_PAGES);
    assert_sound(&plan, &surfaces, 256);
    assert!(plan.resampled_by_others > 0);
    // Six of the nine wrappings are left for each encoding; none is lost without need.
    let kept = surfaces.textures.iter().zip(&plan.places).filter(|(texture, place)| {
        plan.pages[place.unwrap().0].sampler.wrap == texture.sampler.wrap
    });
    assert!(kept.count() >= 24, "wrapping is kept before filters are");
}
