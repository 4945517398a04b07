//! The edges of surfaces with several samples per pixel: shading must not extrapolate beyond them.

use std::ops::ControlFlow;

use glam::{Affine3A, vec3};
use gpu::{Device, SampleCount};
use import::LoadOptions;
use scene::{Alpha, Image, Object, Scene};
use tests::run_on_all;
use tests::single_frame::first_image;

use super::{check_exact, options};

const SIZE: [u32; 2] = [320, 240];

/// Nine turned squares, seen from the front. Each shows the green half of a picture whose other
/// half is red, up to the edge. A pixel whose middle lies outside a square must not be shaded in
/// red.
const SQUARES: &[u8] = include_bytes!("fringe.glb");

fn squares() -> (Scene, cull::Camera) {
    let go_on = &mut |_| ControlFlow::Continue(());
    let imported =
        import::load_bytes(SQUARES.to_vec(), None, &LoadOptions::default(), go_on).unwrap();
    let camera = imported.default_camera(SIZE);
    let mut scene = imported.scene;
    scene.light.sky = [0.0; 3];
    (scene, camera)
}

/// Returns the number of pixels with some red, and the number of purely green pixels.
fn red_and_green(
    device: &Device,
    scene: &Scene,
    camera: cull::Camera,
    samples: SampleCount,
) -> [usize; 2] {
    let image = first_image(device, scene, &options(SIZE, samples), camera);
    let red = image.chunks_exact(4).filter(|pixel| pixel[0] > 90).count();
    let green = image.chunks_exact(4).filter(|pixel| pixel[0] <= 90 && pixel[1] > 90).count();
    [red, green]
}

#[test]
fn the_neighbour_in_an_atlas_is_not_seen_at_edges() {
    run_on_all(|device| {
        let (scene, camera) = squares();
        for samples in [SampleCount::One, SampleCount::Four] {
            let [red, green] = red_and_green(device, &scene, camera, samples);
            assert!(red == 0 && green > 5000, "{samples:?}: {red} red pixels, {green} green ones");
        }
        check_exact(device, &scene, &[camera], &options(SIZE, SampleCount::Four));
    });
}

/// Checks holes behind other draws. On some drivers, earlier draws decide which samples of a pixel
/// a centroid covers, and holes must not depend on it.
#[test]
fn holes_are_exact_before_and_behind_each_other() {
    run_on_all(|device| {
        let (mut scene, camera) = squares();
        let surfaces = scene.surfaces.as_mut().unwrap();
        let alpha = |place: u32| {
            let is_hole = (place % 512 / 16 + place / 512 / 16).is_multiple_of(2);
            if is_hole { 0 } else { 255 }
        };
        let rgba8 = (0..512 * 512).flat_map(|place| [90, 200, 90, alpha(place)]).collect();
        surfaces.images[0] = Image::of_rgba8("holes", [512; 2], rgba8);
        surfaces.materials[0].base_colour_texture = surfaces.materials[0].emission_texture;
        surfaces.materials[0].alpha = Alpha::Mask { cutoff: 0.5 };
        let behind = |steps: u8, object: &Object| {
            let offset = vec3(0.13, 0.07, -0.2) * f32::from(steps);
            Object { transform: Affine3A::from_translation(offset) * object.transform, ..*object }
        };
        let objects = std::mem::take(&mut scene.objects);
        scene.objects = (0..4)
            .flat_map(|steps| objects.iter().map(move |object| behind(steps, object)))
            .collect();
        let beside = cull::Camera { eye: camera.eye + vec3(0.4, 0.2, 0.0), ..camera };
        check_exact(device, &scene, &[camera, beside], &options(SIZE, SampleCount::Four));
    });
}
