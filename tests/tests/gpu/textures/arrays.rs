//! Arrays and their mip maps: made by the device and by the CPU, filled in pieces and on another
//! thread.

use gpu::{Error, FrameRing, MipGeneration, TextureArray, TextureArrayInfo, TextureUploads, vk};
use render::surfaces::SurfaceOptions;
use scene::{Encoding, Filter, Sampler};
use tests::run_on_all;

use super::{SHARP, SIDE, draw_with, image, one, scene_of, texture, unlit, whole};

const INFO: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "test",
    size: [5, 3],
    layers: 2,
    format: vk::Format::R8G8B8A8_SRGB,
    wrap: [vk::SamplerAddressMode::REPEAT; 2],
    magnified: vk::Filter::LINEAR,
    minified: vk::Filter::LINEAR,
    between_levels: Some(vk::SamplerMipmapMode::LINEAR),
    anisotropy: 1.0,
    mip_making: MipGeneration::Blits,
};

#[test]
fn what_is_made_smaller_is_the_mean_of_its_light() {
    run_on_all(|device| {
        let sampler =
            Sampler { minified: Filter::Linear, between_levels: Some(Filter::Linear), ..SHARP };
        // A quarter is white: from the second level on there is only the mean.
        let spots =
            |x: u32, y: u32| [if x % 2 + y % 2 == 0 { 255 } else { 0 }; 4].map(|part| part.max(1));
        for (encoding, mean) in [(Encoding::Srgb, 137.0), (Encoding::Linear, 137.0)] {
            for mip_making in [MipGeneration::Blits, MipGeneration::Cpu] {
                for anisotropy in [None, Some(8.0)] {
                    let surfaces =
                        one(image([64, 64], spots), texture(0, encoding, sampler), unlit());
                    let options = SurfaceOptions { anisotropy, mip_making, ..Default::default() };
                    // Eight by eight texels a pixel.
                    let scene = scene_of(vec![whole([[0.0; 2], [8.0; 2]], |_| {})], surfaces);
                    for pixel in draw_with(device, &scene, &options) {
                        for channel in &pixel[..3] {
                            let difference = (f64::from(*channel) - mean).abs();
                            assert!(difference <= 2.0, "{encoding:?} {mip_making:?}: {pixel:?}");
                        }
                    }
                }
            }
        }
    });
}

#[test]
fn both_ways_make_the_same_levels_of_odd_sizes() {
    run_on_all(|device| {
        let sampler =
            Sampler { minified: Filter::Linear, between_levels: Some(Filter::Linear), ..SHARP };
        let soft = |x: u32, y: u32| [(x * 3) as u8, (y * 4) as u8, 128, 255];
        let drawn = [MipGeneration::Blits, MipGeneration::Cpu].map(|mip_making| {
            let surfaces =
                one(image([80, 48], soft), texture(0, Encoding::Linear, sampler), unlit());
            let options = SurfaceOptions { mip_making, ..Default::default() };
            draw_with(
                device,
                &scene_of(vec![whole([[0.0; 2], [4.0; 2]], |_| {})], surfaces),
                &options,
            )
        });
        let worst = drawn[0].iter().flatten().zip(drawn[1].iter().flatten());
        let worst = worst.map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(4), "{worst:?}");
        assert_eq!(drawn[0].len(), (SIDE * SIDE) as usize);
    });
}

#[test]
fn layers_come_in_pieces_and_what_is_no_piece_is_refused() {
    run_on_all(|device| {
        for mip_making in [MipGeneration::Blits, MipGeneration::Cpu] {
            let info = TextureArrayInfo { mip_making, ..INFO };
            let mut array = TextureArray::new(device, &info).unwrap();
            let mut uploads = TextureUploads::new(device).unwrap();
            uploads.write_rows(&mut array, 1, &[7; 20]).unwrap();
            for (layer, bytes) in [(1, 60), (1, 0), (1, 19), (2, 20)] {
                let refused = uploads.write_rows(&mut array, layer, &vec![0; bytes]);
                assert!(matches!(refused, Err(Error::WrongCommands(_))), "{layer} {bytes}");
            }
            uploads.write_rows(&mut array, 1, &[7; 40]).unwrap();
            assert!(!array.is_filled());
            assert!(uploads.write(&mut array, 0, &[0; 40]).is_err());
            uploads.write(&mut array, 0, &[9; 60]).unwrap();
            assert!(array.is_filled());
        }
    });
}

#[test]
fn arrays_beyond_the_device_are_refused_with_its_limits() {
    run_on_all(|device| {
        let limits = device.adapter().limits;
        let wide = limits.max_image_dimension2_d + 1;
        for (size, layers, limit) in [
            ([wide, 1], 1, limits.max_image_dimension2_d),
            ([1, wide], 1, limits.max_image_dimension2_d),
            ([1, 1], limits.max_image_array_layers + 1, limits.max_image_array_layers),
            ([0, 1], 1, limits.max_image_dimension2_d),
            ([1, 1], 0, limits.max_image_array_layers),
        ] {
            let error = TextureArray::new(device, &TextureArrayInfo { size, layers, ..INFO })
                .err()
                .unwrap();
            assert!(error.to_string().contains(&limit.to_string()), "{error}");
        }
        let info = TextureArrayInfo { format: vk::Format::R8_UNORM, ..INFO };
        assert!(TextureArray::new(device, &info).is_err());
    });
}

#[test]
fn arrays_are_filled_on_another_thread_while_frames_run() {
    run_on_all(|device| {
        let (sent, loaded) = std::sync::mpsc::channel();
        let mut ring = FrameRing::new(device, 2).unwrap();
        let mut frames = 0;
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let mut uploads = TextureUploads::new(device).unwrap();
                for _ in 0..20 {
                    let info = TextureArrayInfo { size: [64, 64], layers: 1, ..INFO };
                    let mut array = TextureArray::new(device, &info).unwrap();
                    for rows in 0..4 {
                        uploads.write_rows(&mut array, 0, &vec![rows; 64 * 16 * 4]).unwrap();
                    }
                    assert!(array.is_filled());
                }
                sent.send(()).unwrap();
            });
            while loaded.try_recv().is_err() {
                ring.begin().unwrap().submit(None).unwrap();
                frames += 1;
            }
        });
        assert!(frames > 0);
    });
}
