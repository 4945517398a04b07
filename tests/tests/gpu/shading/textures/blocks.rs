//! Images of compressed blocks: sampled directly if the device supports their format, otherwise
//! unpacked, with the same texels.

use glam::Vec3;
use gpu::{
    Device, Error, MipGeneration, OptionalFeature, TextureArray, TextureArrayInfo, TextureUploads,
    vk,
};
use scene::{
    Alpha, AstcBlock, BlockFormat, Encoding, Filter, Image, LightKind, Material, PunctualLight,
    Sampler, Surfaces, Texels,
};
use tests::surface_fixture::snorm16;
use tests::{Driver, run, run_on_all};

use super::{SHARP, SIDE, at, draw, one, scene_of, texel_at, texture, unlit, using, whole};

const SIZE: [u32; 2] = [10, 7];
const ONCE: [[f32; 2]; 2] = [[0.0; 2], [1.0; 2]];

fn astc() -> BlockFormat {
    BlockFormat::Astc(AstcBlock::of_size([6, 5]).unwrap())
}

/// Returns a block of one half of BC5 whose eight values lie between its two ends.
fn half(random: &mut impl FnMut() -> u8) -> Vec<u8> {
    let low = 70 + random() % 40;
    let ends = [low + 20 + random() % 40, low];
    ends.into_iter().chain((0..6).map(|_| random())).collect()
}

/// Returns a random block, but never a block whose decoding is undefined.
fn block(format: BlockFormat, random: &mut impl FnMut() -> u8) -> Vec<u8> {
    match format {
        BlockFormat::Bc4 => half(random),
        BlockFormat::Bc5 => [half(random), half(random)].concat(),
        // A block of one colour, since many random bits are not valid ASTC blocks.
        BlockFormat::Astc(_) => {
            let one = [0xFC, 0xFD, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF];
            let colour = [random(), random(), random(), 255].map(|channel| [channel; 2]);
            [one.as_slice(), colour.as_flattened()].concat()
        }
        // The lowest set bit is the number of the mode, and a ninth mode does not exist.
        BlockFormat::Bc7 => (0..16).map(|at| random() | u8::from(at == 0) << 5).collect(),
        _ => (0..format.block_bytes()).map(|_| random()).collect(),
    }
}

/// Returns an image of random blocks without mip maps.
fn blocks(format: BlockFormat, size: [u32; 2], seed: u64) -> Image {
    let mut state = seed * 2 + 1;
    let mut random = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (state >> 56) as u8
    };
    let count = format.bytes(size).unwrap() as u32 / format.block_bytes();
    let level = (0..count).flat_map(|_| block(format, &mut random)).collect();
    let texels = Texels::Blocks { format, levels: vec![level] };
    let image = Image { name: format!("{format:?}"), size, texels };
    assert_eq!(image.check(), Ok(()));
    image
}

/// Returns the encoded byte of a linear value.
fn shown(number: u8) -> u8 {
    let light = f64::from(number) / 255.0;
    let encoded =
        if light > 0.003_130_8 { 1.055 * light.powf(1.0 / 2.4) - 0.055 } else { light * 12.92 };
    (encoded * 255.0).round() as u8
}

#[test]
fn texels_of_blocks_are_those_that_they_unpack_to() {
    use BlockFormat::*;
    run_on_all(|device| {
        for format in [Bc1, Bc1Alpha, Bc2, Bc3, Bc4, Bc5, Bc7, astc()] {
            // BC4 and BC5 hold numbers, and would be unpacked if they were colours.
            let encoding = if format.has_colours() { Encoding::Srgb } else { Encoding::Linear };
            for seed in 0..4 {
                let image = blocks(format, SIZE, seed);
                let rgba8 = image.rgba8().into_owned();
                let material = Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..unlit() };
                let surfaces = one(image, texture(0, encoding, SHARP), material);
                let found = draw(device, &scene_of(vec![whole(ONCE, |_| {})], surfaces));
                let mut hole = None;
                for (pixel, found) in found.into_iter().enumerate() {
                    let uv = at(pixel, ONCE);
                    let [x, y] =
                        std::array::from_fn(|index| texel_at(uv, SIZE[index], SHARP.wrap)[index]);
                    let first = 4 * (y * SIZE[0] + x) as usize;
                    let texel: [u8; 4] = rgba8[first..first + 4].try_into().unwrap();
                    let expected = match encoding {
                        Encoding::Srgb => texel,
                        Encoding::Linear => texel.map(shown),
                    };
                    // Drivers interpolate between the ends of a block with different precision.
                    let is_close = (0..3).all(|index| found[index].abs_diff(expected[index]) <= 2);
                    match texel[3] {
                        132.. => assert!(
                            is_close,
                            "{format:?} at {x}, {y}: {found:?}, {expected:?} expected"
                        ),
                        ..=123 => assert_eq!(found, *hole.get_or_insert(found), "a hole"),
                        _ => {}
                    }
                }
            }
        }
    });
}

/// Returns the largest difference between two images, and the number of differing pixels.
fn difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> (u8, usize) {
    let of = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|index| a[index].abs_diff(b[index])).max();
    let all: Vec<u8> = a.iter().zip(b).filter_map(of).collect();
    let most = all.iter().copied().max().unwrap_or_default();
    (most, all.into_iter().filter(|difference| *difference > 0).count())
}

/// Draws a lit square with a texture of numbers.
fn lit(device: &Device, image: Image, change: impl FnOnce(&mut Material)) -> Vec<[u8; 4]> {
    let mut material = Material { metallic: 0.0, ..Material::default() };
    change(&mut material);
    let mut surfaces = one(image, texture(0, Encoding::Linear, SHARP), material);
    surfaces.lights = vec![PunctualLight {
        kind: LightKind::Directional,
        colour: [1.0; 3],
        intensity: 1.5,
        range_m: None,
        position: Vec3::ZERO,
        direction: Vec3::new(-0.6, -0.48, -0.64),
        cookie: None,
    }];
    let square = whole(ONCE, |vertex| vertex.tangent = snorm16(Vec3::X, 1));
    let mut scene = scene_of(vec![square], surfaces);
    (scene.light.ambient_above, scene.light.ambient_below) = ([0.3; 3], [0.3; 3]);
    draw(device, &scene)
}

#[test]
fn normals_of_two_channels_have_the_third() {
    run_on_all(|device| {
        let image = blocks(BlockFormat::Bc5, SIZE, 7);
        let normal = |texel: [u8; 4]| {
            let [x, y] = [texel[0], texel[1]].map(|part| f32::from(part) / 127.5 - 1.0);
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            [texel[0], texel[1], (z * 127.5 + 127.5).round() as u8, 255]
        };
        let texels =
            image.rgba8().as_chunks::<4>().0.iter().flat_map(|texel| normal(*texel)).collect();
        let three = Image::of_rgba8("three channels", SIZE, texels);
        let [two, three] = [image, three]
            .map(|image| lit(device, image, |material| material.normal_texture = using(0)));
        let (most, count) = difference(&two, &three);
        assert!(most <= 2, "{count} pixels differ, by {most} at most");
        let plain = blocks(BlockFormat::Bc5, SIZE, 7);
        let flat = lit(device, plain, |material| material.occlusion_texture = using(0));
        assert!(difference(&two, &flat).0 > 10, "or there are no normals");
    });
}

#[test]
fn red_alone_is_enough_for_occlusion() {
    run_on_all(|device| {
        let image = blocks(BlockFormat::Bc4, SIZE, 3);
        let [packed, unpacked] = [image.clone(), image.clone().unpacked()]
            .map(|image| lit(device, image, |material| material.occlusion_texture = using(0)));
        assert!(difference(&packed, &unpacked).0 <= 2);
        let plain = lit(device, image, |_| {});
        assert!(difference(&packed, &plain).0 > 20, "or there is no occlusion");
    });
}

/// Returns true if the device samples BC blocks directly.
fn samples_bc(device: &Device) -> bool {
    let has = |optional| device.capabilities().has(optional);
    has(OptionalFeature::DescriptorIndexing) && has(OptionalFeature::BcTextures)
}

/// Returns an image whose mip maps have a colour each.
fn coloured_levels(count: usize) -> (Image, Vec<[u8; 3]>) {
    // A colour of five, six and five bits, as both ends of a block.
    let colours = [[248, 0, 0], [0, 252, 0], [0, 0, 248], [248, 252, 0]];
    let block = |[red, green, blue]: [u8; 3]| {
        let bits = u16::from(red) << 8 | u16::from(green) << 3 | u16::from(blue) >> 3;
        [bits.to_le_bytes(), bits.to_le_bytes(), [0; 2], [0; 2]].concat()
    };
    let size = [64_u32, 32];
    let blocks =
        |level: usize| size.map(|side| (side >> level).max(1).div_ceil(4)).iter().product::<u32>();
    let levels = colours.iter().take(count).enumerate();
    let levels = levels.map(|(level, colour)| block(*colour).repeat(blocks(level) as usize));
    let texels = Texels::Blocks { format: BlockFormat::Bc1, levels: levels.collect() };
    let image = Image { name: "a colour per level".into(), size, texels };
    assert_eq!(image.check(), Ok(()));
    // The colour in eight bits.
    let full = |part: u8| if part == 0 { 0 } else { 255 };
    (image, colours.iter().take(count).map(|colour| colour.map(full)).collect())
}

#[test]
fn the_mip_maps_of_an_image_are_its_own() {
    run(Driver::SwiftShader, |device| assert!(samples_bc(device), "or nothing here is tested"));
    run_on_all(|device| {
        let sampler = Sampler { between_levels: Some(Filter::Nearest), ..SHARP };
        for (count, shift, shown) in [(4, 0, 0), (4, 1, 1), (4, 2, 2), (4, 5, 3), (2, 4, 1)] {
            let (image, colours) = coloured_levels(count);
            // The number of texels per pixel, in both directions, is the width of a texel of the
            // level.
            let [width, height] = image.size.map(|side| (SIDE << shift) as f32 / side as f32);
            let uv = [[0.0; 2], [width, height]];
            let surfaces = one(image, texture(0, Encoding::Srgb, sampler), unlit());
            let found = draw(device, &scene_of(vec![whole(uv, |_| {})], surfaces));
            // Unpacked images have mip maps of the whole image.
            let expected = colours[if samples_bc(device) { shown } else { 0 }];
            for pixel in found {
                assert_eq!(pixel[..3], expected, "{count} levels, {shift}");
            }
        }
    });
}

const INFO: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "blocks",
    size: [13, 9],
    layers: 2,
    format: vk::Format::BC7_SRGB_BLOCK,
    wrap: [vk::SamplerAddressMode::REPEAT; 2],
    magnified: vk::Filter::LINEAR,
    minified: vk::Filter::LINEAR,
    between_levels: Some(vk::SamplerMipmapMode::LINEAR),
    anisotropy: 1.0,
    mip_making: MipGeneration::Given(3),
};

/// Creates an array and writes its layers.
fn written(
    device: &Device,
    info: &TextureArrayInfo<'_>,
    levels: &[Vec<u8>],
) -> Result<bool, Error> {
    let mut array = TextureArray::new(device, info)?;
    let mut uploads = TextureUploads::new(device)?;
    for layer in 0..info.layers {
        uploads.write_levels(&mut array, layer, levels)?;
    }
    Ok(array.is_filled())
}

#[test]
fn arrays_take_the_blocks_that_the_device_has() {
    run_on_all(|device| {
        let has = |optional| device.capabilities().has(optional);
        for (format, block, needed) in [
            (vk::Format::BC1_RGB_SRGB_BLOCK, BlockFormat::Bc1, OptionalFeature::BcTextures),
            (vk::Format::BC5_UNORM_BLOCK, BlockFormat::Bc5, OptionalFeature::BcTextures),
            (vk::Format::BC7_SRGB_BLOCK, BlockFormat::Bc7, OptionalFeature::BcTextures),
            (vk::Format::ASTC_6X5_UNORM_BLOCK, astc(), OptionalFeature::AstcTextures),
        ] {
            let levels: Vec<Vec<u8>> = [[13, 9], [6, 4], [3, 2]]
                .map(|size| vec![0x55; block.bytes(size).unwrap() as usize])
                .to_vec();
            let info = TextureArrayInfo { format, ..INFO };
            let made = written(device, &info, &levels);
            if !has(needed) {
                let error = made.unwrap_err().to_string();
                assert!(error.contains(needed.name()), "{error}");
                continue;
            }
            assert!(made.unwrap(), "{format:?}");
            let wrong = |info: TextureArrayInfo<'_>, levels: &[Vec<u8>]| {
                let made = written(device, &info, levels);
                assert!(matches!(made, Err(Error::WrongCommands(_))), "{made:?}");
            };
            wrong(info, &levels[..2]);
            wrong(info, &[levels[0].clone(), levels[0].clone(), levels[2].clone()]);
            wrong(TextureArrayInfo { mip_making: MipGeneration::Blits, ..info }, &levels);
            wrong(TextureArrayInfo { mip_making: MipGeneration::Cpu, ..info }, &levels);
            let mut array = TextureArray::new(device, &info).unwrap();
            let rows = TextureUploads::new(device).unwrap().write_rows(&mut array, 0, &levels[0]);
            assert!(matches!(rows, Err(Error::WrongCommands(_))), "its mip maps are lost");
            let one_level = TextureArrayInfo { mip_making: MipGeneration::Given(1), ..info };
            assert!(written(device, &one_level, &levels[..1]).unwrap());
        }
        let other = TextureArrayInfo { format: vk::Format::BC6H_UFLOAT_BLOCK, ..INFO };
        let made = TextureArray::new(device, &other).err();
        assert!(matches!(made, Some(Error::WrongCommands(_))), "{made:?}");
    });
}

#[test]
fn all_blocks_of_astc_have_the_size_that_images_say() {
    run_on_all(|device| {
        for place in 0..14 {
            let block = BlockFormat::Astc(AstcBlock::of_place(place).unwrap());
            let format = vk::Format::ASTC_4X4_UNORM_BLOCK.as_raw() + 2 * place as i32;
            // One texel more than a row and a column of blocks: a wrong block size makes three
            // blocks too many or too few.
            let size = block.block_size().map(|side| side + 1);
            let info = TextureArrayInfo {
                size,
                format: vk::Format::from_raw(format),
                mip_making: MipGeneration::Given(1),
                ..INFO
            };
            let level = vec![0x55; block.bytes(size).unwrap() as usize];
            match written(device, &info, &[level]) {
                Ok(is_filled) => assert!(is_filled),
                Err(error) => assert!(matches!(error, Error::Unsupported { .. }), "{error}"),
            }
        }
    });
}

#[test]
fn images_beyond_the_devices_size_begin_with_a_smaller_mip_map() {
    run_on_all(|device| {
        let most = device.adapter().limits.max_image_dimension2_d;
        let format = BlockFormat::Bc1;
        let mut image = blocks(format, [most + 4, 1], 1);
        let smaller = |level| vec![0xAA; format.bytes(image.level_size(level)).unwrap() as usize];
        let smaller: Vec<Vec<u8>> = (1..6).map(smaller).collect();
        let Texels::Blocks { levels, .. } = &mut image.texels else { panic!() };
        levels.extend(smaller);
        let sampler = Sampler::default();
        let scene = scene_of(
            vec![whole(ONCE, |_| {})],
            one(image, texture(0, Encoding::Srgb, sampler), unlit()),
        );
        let options = render::RendererOptions::default();
        let found = render::Renderer::new(device, &scene, &options).unwrap().degradations();
        let unpacked = usize::from(!samples_bc(device));
        assert_eq!((found.shrunk_images, found.unpacked_images), (1, unpacked));
        assert_eq!(found.texts().len(), 1 + unpacked, "{:?}", found.texts());
    });
}

#[test]
fn images_of_surfaces_that_are_not_whole_are_refused() {
    run(Driver::Lavapipe, |device| {
        let mut image = blocks(BlockFormat::Bc7, SIZE, 1);
        let Texels::Blocks { levels, .. } = &mut image.texels else { panic!() };
        levels[0].pop();
        let surfaces = Surfaces {
            images: vec![image],
            ..one(blocks(BlockFormat::Bc7, SIZE, 1), texture(0, Encoding::Srgb, SHARP), unlit())
        };
        let scene = scene_of(vec![whole(ONCE, |_| {})], surfaces);
        let refused = render::Renderer::new(device, &scene, &render::RendererOptions::default());
        let error = refused.err().unwrap().to_string();
        assert!(error.contains("Bc7") && error.contains("10x7"), "{error}");
    });
}
