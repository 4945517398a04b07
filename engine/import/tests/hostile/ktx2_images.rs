//! Tests of images of compressed blocks and of pixels in KTX2 files.

use antumbra_import::{Cause, ImportError, Limits, LoadOptions, decode_image, read};
use gltf_files::files::GltfFile;
use gltf_files::ktx2_files::Ktx2File;
use ktx2::dfd::DataFormatFlags;
use ktx2::{Format, SupercompressionScheme};
use scene::{AstcBlock, BlockFormat, Image, Texels};
use serde_json::json;

use gltf_files::mutations::SplitMix;

const FORMATS: [([Format; 2], BlockFormat); 7] = [
    ([Format::BC1_RGB_UNORM_BLOCK, Format::BC1_RGB_SRGB_BLOCK], BlockFormat::Bc1),
    ([Format::BC1_RGBA_UNORM_BLOCK, Format::BC1_RGBA_SRGB_BLOCK], BlockFormat::Bc1Alpha),
    ([Format::BC2_UNORM_BLOCK, Format::BC2_SRGB_BLOCK], BlockFormat::Bc2),
    ([Format::BC3_UNORM_BLOCK, Format::BC3_SRGB_BLOCK], BlockFormat::Bc3),
    ([Format::BC4_UNORM_BLOCK; 2], BlockFormat::Bc4),
    ([Format::BC5_UNORM_BLOCK; 2], BlockFormat::Bc5),
    ([Format::BC7_UNORM_BLOCK, Format::BC7_SRGB_BLOCK], BlockFormat::Bc7),
];

/// Returns mip maps whose bytes all differ from their neighbours.
fn levels(format: BlockFormat, size: [u32; 2], count: u32) -> Vec<Vec<u8>> {
    let bytes = |level: u32| {
        format.bytes(size.map(|side| (side >> level).max(1))).expect("a size") as usize
    };
    let byte = |level: u32, at: usize| (at * 37 + at / 256 + level as usize * 91) as u8;
    (0..count).map(|level| (0..bytes(level)).map(|at| byte(level, at)).collect()).collect()
}

/// Returns an image of 20 x 12 texels with all of its mip maps.
pub(crate) fn file() -> Ktx2File {
    Ktx2File::new(Format::BC7_SRGB_BLOCK, [20, 12], &levels(BlockFormat::Bc7, [20, 12], 5))
}

fn decode(file: &Ktx2File) -> Result<Image, ImportError> {
    decode_image("brick", &file.bytes(), &Limits::default())
}

#[test]
fn blocks_of_all_formats_are_taken_as_they_are() {
    let size = [37, 18];
    let astc = (0..14).map(|place| {
        let first = Format::ASTC_4x4_UNORM_BLOCK.value() + 2 * place;
        let formats = [first, first + 1].map(|value| Format::new(value).unwrap());
        let block = AstcBlock::of_place(place).unwrap();
        let [width, height] = block.size();
        let name = format!("ASTC_{width}x{height}_UNORM_BLOCK");
        assert_eq!(format!("{:?}", formats[0]), name);
        (formats, BlockFormat::Astc(block))
    });
    for (formats, expected) in FORMATS.into_iter().chain(astc) {
        for (format, count) in [(formats[0], 1), (formats[1], 6), (formats[0], 3)] {
            let levels = levels(expected, size, count);
            let file = Ktx2File::new(format, size, &levels);
            for file in [file.clone(), file.packed()] {
                let image = decode(&file).unwrap();
                assert_eq!((image.name.as_str(), image.size), ("brick", size));
                assert_eq!(image.check(), Ok(()));
                let blocks = Texels::Blocks { format: expected, levels: levels.clone() };
                assert!(image.texels == blocks, "{format:?}");
            }
        }
    }
}

#[test]
fn pixels_of_one_to_four_bytes_are_spread_to_four() {
    let size = [5, 3];
    for (channels, formats) in [
        (1, [Format::R8_UNORM, Format::R8_SRGB]),
        (2, [Format::R8G8_UNORM, Format::R8G8_SRGB]),
        (3, [Format::R8G8B8_UNORM, Format::R8G8B8_SRGB]),
        (4, [Format::R8G8B8A8_UNORM, Format::R8G8B8A8_SRGB]),
    ] {
        let level = |texels: usize| (0..texels * channels).map(|at| at as u8 + 1).collect();
        let levels: [Vec<u8>; 3] = [level(15), level(2), level(1)];
        let spread = levels[0].chunks(channels).flat_map(|pixel| {
            let lacking = [0, 0, 0, 255];
            [pixel, &lacking[channels..]].concat()
        });
        let expected = Texels::Rgba8(spread.collect());
        for format in formats {
            for count in [1, 3] {
                let file = Ktx2File::new(format, size, &levels[..count]);
                for file in [file.clone(), file.packed()] {
                    let image = decode(&file).unwrap_or_else(|error| panic!("{format:?}: {error}"));
                    assert_eq!((image.size, image.check()), (size, Ok(())));
                    assert!(image.texels == expected, "{format:?}");
                }
            }
        }
    }
}

#[test]
fn limits_hold_for_pixels_too_and_wrong_sizes_are_named() {
    let file = Ktx2File::new(Format::R8_UNORM, [64, 64], &[vec![7; 64 * 64]]);
    let of = |file: &Ktx2File, limits: &Limits| decode_image("grey", &file.bytes(), limits);
    // Four bytes per pixel, whatever the file has.
    let exact = Limits { image_bytes: 4 * 64 * 64, ..Limits::default() };
    assert!(of(&file, &exact).is_ok());
    let less = Limits { image_bytes: 4 * 64 * 64 - 1, ..Limits::default() };
    assert_eq!(of(&file, &less).unwrap_err().cause, Cause::TooLarge);
    let scratch = Limits { image_scratch_bytes: 64 * 64, ..Limits::default() };
    assert_eq!(of(&file, &scratch).unwrap_err().cause, Cause::TooLarge, "they are there twice");
    let mut short = file.clone();
    short.header.pixel_height = 65;
    let error = of(&short, &Limits::default()).unwrap_err().to_string();
    assert!(error.contains("mip map 0 of a KTX2 image is not of 4160 bytes"), "{error}");
    let mut huge = file.clone();
    (huge.header.pixel_width, huge.header.pixel_height) = (u32::MAX, u32::MAX);
    assert_eq!(of(&huge, &Limits::default()).unwrap_err().cause, Cause::TooLarge);
    let mut more = file;
    more.levels[0].0 = vec![7; 1 << 20];
    assert_eq!(of(&more.packed(), &Limits::default()).unwrap_err().cause, Cause::Damaged);
}

/// Returns a frame of Zstandard with a window, one raw block, and a checksum. Without a window, the
/// window is the content, whose size the header states.
fn frame(window: Option<u8>, content: &[u8], checksum: u32) -> Vec<u8> {
    let (descriptor, size) = match window {
        Some(window) => (0b100, window),
        None => (0b10_0100, content.len() as u8),
    };
    let head = [0x28, 0xB5, 0x2F, 0xFD, descriptor, size];
    let block = (content.len() as u32) << 3 | 1;
    let parts = [&head, &block.to_le_bytes()[..3], content, &checksum.to_le_bytes()];
    parts.concat()
}

#[test]
fn windows_of_zstandard_are_those_of_its_levels_and_within_the_limits() {
    let content = levels(BlockFormat::Bc1, [8, 4], 1).remove(0);
    let file = |window: Option<u8>, checksum: u32| {
        let mut file =
            Ktx2File::new(Format::BC1_RGB_UNORM_BLOCK, [8, 4], std::slice::from_ref(&content));
        file.header.supercompression_scheme = Some(SupercompressionScheme::Zstandard);
        file.levels[0].0 = frame(window, &content, checksum);
        file.bytes()
    };
    // The lower half of the XXH64 of these sixteen bytes, which the format uses.
    let right = 0xF741_36E7;
    let decode = |window, checksum, image_scratch_bytes| {
        let limits = Limits { image_scratch_bytes, ..Limits::default() };
        decode_image("brick", &file(window, checksum), &limits)
    };
    // 1 KiB, 448 KiB, 8 MiB of level 19, 128 MiB of level 22, and the content.
    let windows = [(0, 1 << 10), (8 << 3 | 6, 448 << 10), (13 << 3, 8 << 20), (17 << 3, 128 << 20)];
    let windows = windows.map(|(window, bytes)| (Some(window), bytes));
    for (window, bytes) in windows.into_iter().chain([(None, content.len() as u64)]) {
        let scratch = file(window, right).len() as u64 + 3 * bytes;
        let image = decode(window, right, scratch).unwrap();
        assert!(matches!(image.texels, Texels::Blocks { levels, .. } if levels[0] == content));
        let error = decode(window, right, scratch - 1).unwrap_err();
        assert_eq!(error.cause, Cause::TooLarge, "{error}");
    }
    let error = decode(Some(31 << 3), right, 2 << 30).unwrap_err();
    assert_eq!(error.cause, Cause::TooLarge, "{error}");
    let error = decode(Some(0), right ^ 1, 2 << 30).unwrap_err();
    assert!(error.to_string().contains("checksum"), "{error}");
}

#[test]
fn a_description_of_many_blocks_is_refused_before_it_is_read() {
    let mut bytes = file().bytes();
    let at = bytes.len() as u32;
    let mut description = (4 + 9 * 100_000_u32).to_le_bytes().to_vec();
    description.extend([1, 0, 1, 0, 2, 0, 9, 0, 0].repeat(100_000));
    bytes[48..52].copy_from_slice(&at.to_le_bytes());
    bytes[52..56].copy_from_slice(&(description.len() as u32).to_le_bytes());
    bytes.extend(description);
    bytes.push(0);
    let error = decode_image("brick", &bytes, &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("several blocks"), "{error}");
}

#[test]
fn a_file_without_a_number_of_mip_maps_has_one() {
    let mut file = Ktx2File::new(Format::BC1_RGB_SRGB_BLOCK, [8, 8], &[vec![1; 32]]);
    file.header.level_count = 0;
    let texels = decode(&file).unwrap().texels;
    assert!(matches!(texels, Texels::Blocks { levels, .. } if levels == [vec![1; 32]]));
}

type Change = fn(&mut Ktx2File);

/// Changes of a file, words of the expected reason, and the cause.
const REFUSED: &[(Change, &str, Cause)] = &[
    (|f| f.header.format = None, "Basis Universal", Cause::Unsupported),
    (|f| f.header.format = Some(Format::BC6H_UFLOAT_BLOCK), "BC6H_UFLOAT", Cause::Unsupported),
    (|f| f.header.format = Some(Format::BC5_SNORM_BLOCK), "BC5_SNORM", Cause::Unsupported),
    (|f| f.header.format = Some(Format::R16G16B16A16_SFLOAT), "R16G16B16A16", Cause::Unsupported),
    (|f| f.header.format = Some(Format::R8G8B8A8_SNORM), "R8G8B8A8_SNORM", Cause::Unsupported),
    (|f| f.header.format = Some(Format::R8G8B8A8_SRGB), "mip map 0", Cause::Damaged),
    (|f| f.header.format = Format::new(185), "185", Cause::Unsupported),
    (|f| f.header.pixel_width = 0, "cannot be read", Cause::Damaged),
    (|f| f.header.pixel_height = 0, "line", Cause::Unsupported),
    (|f| f.header.pixel_depth = 1, "depths", Cause::Unsupported),
    (|f| f.header.layer_count = 2, "layers", Cause::Unsupported),
    (|f| f.header.face_count = 6, "faces", Cause::Unsupported),
    (|f| f.header.face_count = 0, "cannot be read", Cause::Damaged),
    (|f| f.header.level_count = u32::MAX, "cannot be read", Cause::Damaged),
    (
        |f| f.levels.extend([(vec![0; 16], 16), (vec![0; 16], 16)]),
        "more mip maps",
        Cause::Malformed,
    ),
    (|f| f.header.pixel_width = 24, "mip map 0", Cause::Damaged),
    (|f| f.header.pixel_width = 16_385, "16385", Cause::TooLarge),
    (|f| f.header.pixel_height = u32::MAX, "4294967295", Cause::TooLarge),
    (|f| f.levels[2].0.push(0), "mip map 2", Cause::Damaged),
    (|f| f.levels[4].0.clear(), "mip map 4", Cause::Damaged),
    (|f| f.values.push(("KTXorientation", b"ru\0")), "from the top", Cause::Unsupported),
    (|f| f.values.push(("KTXswizzle", b"rrrg\0")), "swapped", Cause::Unsupported),
    (
        |f| f.description.flags |= DataFormatFlags::ALPHA_PREMULTIPLIED,
        "multiplied by alpha",
        Cause::Unsupported,
    ),
    (
        |f| f.header.supercompression_scheme = Some(SupercompressionScheme::ZLIB),
        "Zstandard",
        Cause::Unsupported,
    ),
    (
        |f| f.header.supercompression_scheme = Some(SupercompressionScheme::Zstandard),
        "mip map 0",
        Cause::Damaged,
    ),
    (|f| cut_packed(f, 0), "mip map 0", Cause::Damaged),
    (|f| cut_packed(f, 3), "mip map 3", Cause::Damaged),
    (|f| pack_more(f), "mip map 1", Cause::Damaged),
];

fn cut_packed(file: &mut Ktx2File, level: usize) {
    *file = file.clone().packed();
    let bytes = &mut file.levels[level].0;
    bytes.truncate(bytes.len() / 2);
}

/// Packs a mip map that is a thousand times as large as stated.
fn pack_more(file: &mut Ktx2File) {
    file.levels[1].0 = vec![0; 100_000];
    *file = file.clone().packed();
}

#[test]
fn what_is_not_supported_or_broken_is_refused_by_name() {
    for (number, (change, words, cause)) in REFUSED.iter().enumerate() {
        let mut file = file();
        file.header.level_count = 5;
        change(&mut file);
        if file.levels.len() > 5 {
            file.header.level_count = file.levels.len() as u32;
        }
        let error = decode(&file).expect_err(words);
        let text = error.to_string();
        assert!(text.starts_with("brick: image: ") && text.contains(words), "{number}: {text}");
        assert_eq!(error.cause, *cause, "{number}: {text}");
    }
}

#[test]
fn limits_hold_for_blocks_too() {
    let refused = |limits: &Limits| {
        let error = decode_image("brick", &file().packed().bytes(), limits).unwrap_err();
        assert_eq!(error.cause, Cause::TooLarge, "{error}");
        error.to_string()
    };
    // Four bytes per texel, since a device may not support blocks.
    let bytes = 4 * 20 * 12;
    let exact = Limits { image_bytes: bytes, ..Limits::default() };
    assert!(decode_image("brick", &file().packed().bytes(), &exact).is_ok());
    assert!(refused(&Limits { image_bytes: bytes - 1, ..exact }).contains("bytes of it"));
    refused(&Limits { image_side: 19, ..Limits::default() });
}

#[test]
fn arbitrary_bytes_give_an_image_or_an_error() {
    let mut random = SplitMix(2);
    let mut below = |end: usize| random.below(end);
    let values = |mut file: Ktx2File| {
        file.values = vec![("KTXorientation", b"rd\0"), ("KTXwriter", b"a test")];
        file.bytes()
    };
    let pixels = Ktx2File::new(Format::R8G8B8_SRGB, [20, 12], &[vec![9; 720], vec![9; 180]]);
    let whole = [file(), file().packed(), pixels.clone(), pixels.packed()].map(values);
    assert!(whole.iter().all(|bytes| decode_image("", bytes, &Limits::default()).is_ok()));
    for round in 0..20_000 {
        let mut bytes = whole[round % 4].clone();
        for _ in 0..1 + below(4) {
            let at = below(bytes.len());
            bytes[at] = [0, 1, 0xFF, bytes[at] ^ 1 << below(8)][below(4)];
        }
        if round % 5 == 0 {
            bytes.truncate(below(bytes.len()));
        }
        if let Ok(image) = decode_image("", &bytes, &Limits::default()) {
            assert_eq!(image.check(), Ok(()), "round {round}");
        }
    }
}

#[test]
fn images_of_a_gltf_file_may_be_blocks() {
    let mut scene = GltfFile::triangle();
    let view = scene.view(&file().packed().bytes());
    scene.set("/images", json!([{ "bufferView": view, "mimeType": "image/ktx2" }]));
    scene.show_images(1);
    let source = read(scene.glb(), None, &LoadOptions::default()).unwrap();
    assert_eq!(source.notes, []);
    let image = source.images[0].as_ref().unwrap();
    assert!(matches!(image.texels, Texels::Blocks { format: BlockFormat::Bc7, .. }));
}

#[test]
fn images_of_pixels_are_decoded_alone_too() {
    let image = image::RgbaImage::from_pixel(3, 2, image::Rgba([1, 2, 3, 4]));
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let decoded = decode_image("three", png.get_ref(), &Limits::default()).unwrap();
    assert_eq!(decoded, Image::of_rgba8("three", [3, 2], [1, 2, 3, 4].repeat(6)));
    let error = decode_image("three", b"nonsense", &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("not a PNG, JPEG, WebP or KTX2"), "{error}");
}
