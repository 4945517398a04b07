//! Hundreds of textures that are added to a running renderer, and the table of their numbers.

use gpu::{MipGeneration, Readback, TextureArrayInfo, TextureTable, TextureUploads, vk};
use render::{FrameRequest, SpareCapacity};
use scene::{BlockFormat, MaterialId, PreparedMesh, PreparedTexture, Texels};

use super::*;

const EACH_FRAME: u32 = 4;
const FRAMES: u32 = 50;

/// Returns a texture whose size and colour depend on its number.
fn texture_of(number: u32) -> PreparedTexture {
    let size = [1 + number % 9, 1 + number / 9 % 14];
    let texel = [(number * 7) as u8, (number * 13) as u8, (number * 29) as u8, 255];
    let name = format!("came {number}");
    let image = match number % 3 {
        2 => {
            let size = [5 * size[0], 3 * size[1]];
            Image { name, size, texels: blocks_of(texel, size) }
        }
        _ => Image::of_rgba8(name, size, texel.repeat((size[0] * size[1]) as usize)),
    };
    PreparedTexture::new(image, Encoding::Srgb, Sampler::default()).unwrap()
}

/// Returns all mip maps of blocks of one colour.
fn blocks_of(colour: [u8; 4], size: [u32; 2]) -> Texels {
    let [red, green, blue, _] = colour;
    let bits = u16::from(red >> 3) << 11 | u16::from(green >> 2) << 5 | u16::from(blue >> 3);
    let block = [bits.to_le_bytes(), bits.to_le_bytes(), [0; 2], [0; 2]].concat();
    let blocks = |level: u32| size.map(|side: u32| (side >> level).max(1).div_ceil(4));
    let level = |level| block.repeat(blocks(level).iter().product::<u32>() as usize);
    let levels = (0..=size[0].max(size[1]).ilog2()).map(level).collect();
    Texels::Blocks { format: BlockFormat::Bc1, levels }
}

fn material_of(texture: TextureId) -> Material {
    Material {
        base_colour_texture: using(texture.0, Affine2::IDENTITY),
        is_unlit: true,
        ..Material::default()
    }
}

fn place(number: u32) -> Vec3 {
    let x = number % 20;
    let y = number / 20;
    vec3(x as f32 * 0.4 - 4.0, y as f32 * 0.4 - 2.0, -6.0)
}

fn spare() -> SpareCapacity {
    let all = EACH_FRAME * FRAMES;
    SpareCapacity {
        meshes: all,
        vertices: 64 * all,
        indices: 64 * all,
        materials: all,
        ..SpareCapacity::default()
    }
}

#[test]
fn hundreds_of_textures_come_while_frames_are_in_flight() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let (scene, _) = one_texture([4, 4]);
        let options = RendererOptions {
            spare: spare(),
            spare_objects: (EACH_FRAME * FRAMES) as usize,
            frames_in_flight: 3,
            upload_bytes_per_frame: 60_000,
            ..options(None)
        };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let camera = cameras(1)[0];
        let image = Readback::new(device, SIZE).unwrap();
        let surface = scene.surfaces.as_ref().unwrap().meshes[0].clone();
        let mut gone = 0;
        let mut shown = Vec::new();
        let waits = device.wait_counts().other;
        for frame in 0..FRAMES {
            let numbers = frame * EACH_FRAME..(frame + 1) * EACH_FRAME;
            let textures = renderer.add_textures(numbers.clone().map(texture_of).collect());
            let textures = textures.unwrap();
            // One of four textures is not used in the end, so that another texture gets its number.
            let (last, kept) = textures.split_last().unwrap();
            let materials: Vec<Material> = kept.iter().map(|kept| material_of(*kept)).collect();
            let materials = renderer.add_materials(&materials).unwrap();
            let mesh = |material: &MaterialId| {
                let surface = scene::SurfaceMesh { material: *material, ..surface.clone() };
                PreparedMesh::with_surface(scene.meshes[0].clone(), surface, Vec::new()).unwrap()
            };
            let meshes = renderer.add_meshes(materials.iter().map(mesh).collect()).unwrap();
            for (number, mesh) in numbers.zip(meshes) {
                let object = object(mesh.0, place(number), Vec3::splat(0.38));
                renderer.update(&[scene::ObjectChange::Add { object }]).unwrap();
                shown.push(number);
            }
            let request = FrameRequest {
                image: Some(&image),
                ..FrameRequest::new(Strategy::ANTUMBRA, camera)
            };
            renderer.render(&mut view, request).unwrap();
            renderer.remove_textures(&[*last]).unwrap();
            gone += 1;
        }
        assert_eq!(device.wait_counts().other, waits, "nothing waits");
        assert_eq!((gone, shown.len() as u32), (FRAMES, (EACH_FRAME - 1) * FRAMES));
        while renderer.is_uploading() {
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
        }
        let request =
            FrameRequest { image: Some(&image), ..FrameRequest::new(Strategy::ANTUMBRA, camera) };
        for _ in 0..4 {
            renderer.render(&mut view, request).unwrap();
        }
        renderer.wait_idle(&mut view).unwrap();
        let streamed = image.rgba8().unwrap().to_vec();
        let fresh = drawn_at_once(device, &scene, &shown, camera);
        assert_eq!(pixels_that_differ(&streamed, &fresh), 0);
        // Most textures are in the image, each in its colour.
        let colour = |number: u32| texture_of(number).image().rgba8()[..4].to_vec();
        let is_shown =
            |number: &&u32| streamed.chunks_exact(4).any(|pixel| pixel == colour(**number));
        let count = shown.iter().filter(is_shown).count();
        assert!(count > 100, "{count} of {} are shown", shown.len());
    });
}

/// Draws the same image by a renderer that is created with everything.
fn drawn_at_once(device: &Device, scene: &Scene, shown: &[u32], camera: Camera) -> Vec<u8> {
    let mut scene = scene.clone();
    let surfaces = scene.surfaces.as_mut().unwrap();
    for number in shown {
        let texture = surfaces.textures.len() as u32;
        let mesh = surfaces.meshes.len() as u32;
        let came = texture_of(*number);
        surfaces.images.push(came.image().clone());
        surfaces.textures.push(Texture {
            image: ImageId(texture),
            encoding: came.encoding(),
            sampler: came.sampler(),
        });
        surfaces.materials.push(material_of(TextureId(texture)));
        let material = MaterialId(surfaces.materials.len() as u32 - 1);
        surfaces.meshes.push(scene::SurfaceMesh { material, ..surfaces.meshes[0].clone() });
        scene.meshes.push(scene.meshes[0].clone());
        scene.objects.push(object(mesh, place(*number), Vec3::splat(0.38)));
    }
    let mut renderer = Renderer::new(device, &scene, &options(None)).unwrap();
    let mut view = renderer.new_view().unwrap();
    let found = frame_loop(&mut renderer, &mut view, Strategy::FRUSTUM, &[camera]);
    found.images[0].rgba8().unwrap().to_vec()
}

const INFO: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "one",
    size: [4, 4],
    layers: 1,
    format: vk::Format::R8G8B8A8_SRGB,
    wrap: [vk::SamplerAddressMode::REPEAT; 2],
    magnified: vk::Filter::LINEAR,
    minified: vk::Filter::LINEAR,
    between_levels: None,
    anisotropy: 1.0,
    mip_making: MipGeneration::Cpu,
};

#[test]
fn a_table_says_when_it_is_full_and_gives_numbers_away_again() {
    run_where(OptionalFeature::DescriptorIndexing, |device| {
        let mut table = TextureTable::new(device, "three", 3).unwrap();
        let numbers: Vec<_> = (0..3)
            .map(|_| {
                let mut texture = table.create(&INFO).unwrap();
                TextureUploads::new(device).unwrap().write(&mut texture, 0, &[9; 64]).unwrap();
                table.add(texture).unwrap()
            })
            .collect();
        let one_more = |table: &mut TextureTable| {
            let texture = table.create(&INFO).unwrap();
            table.add(texture)
        };
        let error = one_more(&mut table).unwrap_err().to_string();
        assert!(error.contains("three") && error.contains('4') && error.contains('3'), "{error}");
        table.remove(numbers[1]);
        assert!(table.texture(numbers[1]).is_none());
        assert!(table.texture(numbers[2]).is_some());
        let mut frames = gpu::FrameRing::new(device, 1).unwrap();
        for _ in 0..3 {
            frames.begin().unwrap().submit(None).unwrap();
        }
        assert_eq!(one_more(&mut table).unwrap(), numbers[1]);
        let (_other_instance, other) = tests::open(Driver::SwiftShader);
        let foreign = TextureTable::new(&other, "other", 3).unwrap().create(&INFO).unwrap();
        let error = table.add(foreign).unwrap_err().to_string();
        assert!(error.contains("TextureTable"), "{error}");
    });
}
