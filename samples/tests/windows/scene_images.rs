//! Images of files that showed errors before: points, lines, transparent parts of one mesh.

use std::fs;

use harness::{Scratch, pixels, program, scene, stderr};

/// Returns the first frame that `viewer` draws of a file.
fn seen(scratch: &Scratch, device: &str, size: &str, file: &[u8]) -> Vec<[u8; 3]> {
    fs::write(scratch.0.join("file.glb"), file).unwrap();
    let arguments = ["file.glb", "--headless", "--frames", "1", "--out", "out", "--hud", "off"];
    let rest = ["--size", size, "--device", device, "--validation", "sync"];
    // Nothing is overwritten.
    let _absent = fs::remove_dir_all(scratch.0.join("out"));
    let viewer = crate::VIEWER;
    let output = program(viewer, &scratch.0, &[&arguments[..], &rest].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    pixels(&scratch.0.join("out/frame_00000.png"))
}

#[test]
fn points_and_lines_are_some_pixels_wide_in_small_and_large_images() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("scene-thin-{device}"));
        for (size, height) in [("256x144", 144.0), ("1280x720", 720.0)] {
            let image = seen(&scratch, device, size, &scene::thin());
            let count = |strong: usize| {
                let is_strong = |pixel: &&[u8; 3]| {
                    let others = (0..3).filter(|part| *part != strong);
                    pixel[strong] > 150 && others.into_iter().all(|other| pixel[other] < 80)
                };
                image.iter().filter(is_strong).count() as f32
            };
            // Four cubes, and four lines of about half of the image's height.
            let points = count(0);
            let lines = count(1);
            let point = (height / 120.0_f32).powi(2);
            assert!(
                points > 4.0 * point * 0.5 && points < 4.0 * point * 3.0,
                "{device}, {size}: {points}"
            );
            let line = height * 0.5 * height / 180.0;
            assert!(
                lines > 4.0 * line * 0.5 && lines < 4.0 * line * 3.0,
                "{device}, {size}: {lines}"
            );
        }
    }
}

#[test]
fn parts_of_one_blended_mesh_are_seen_in_their_order_whatever_that_of_the_file() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("scene-cards-{device}"));
        let [right, wrong] =
            [[1, 0], [0, 1]].map(|order| seen(&scratch, device, "128x72", &scene::cards(order)));
        assert!(right == wrong, "{device}");
        let [red, _, blue] = right[36 * 128 + 64];
        assert!(
            red > blue && blue > 60,
            "{device}: red is before blue, not {:?}",
            right[36 * 128 + 64]
        );
    }
}

/// Returns an image of 64 x 64 pixels, its left half red, its right one blue.
fn halves() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 64, 64);
    encoder.set_color(png::ColorType::Rgb);
    let half = |column: u32| if column < 32 { [255, 0, 0] } else { [0, 0, 255] };
    let pixels: Vec<u8> = (0..64 * 64).flat_map(|place| half(place % 64)).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    file
}

/// Checks that textures have no seams at edges of triangles: derivatives are taken beyond the
/// edges, and no mixture of all texels may be seen there.
#[test]
fn transformed_textures_have_no_seams_where_triangles_meet() {
    for device in ["llvmpipe", "swiftshader"] {
        let scratch = Scratch::new(&format!("scene-seams-{device}"));
        let image = seen(&scratch, device, "320x180", &scene::transformed(&halves()));
        let is_near = |pixel: &[u8; 3], other: [u8; 3]| {
            (0..3).all(|part| pixel[part].abs_diff(other[part]) < 40)
        };
        let count = |other| image.iter().filter(|pixel| is_near(pixel, other)).count();
        let plain = [[255, 0, 0], [0, 0, 255]].map(count);
        assert!(plain.iter().all(|count| *count > 3000), "{device}: {plain:?}");
        // Half of each, as light and as the smallest level of its mip maps has it.
        let mixed = count([188, 0, 188]);
        assert!(mixed < 300, "{device}: {mixed} pixels");
    }
}
