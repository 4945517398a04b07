//! The transition between cascades of a sun: neighbouring pixels do not differ more than with
//! either cascade alone. Beyond the last cascade, shadows fade.

use cull::{Aabb, Camera, Strategy};
use glam::{Affine3A, Vec3, vec3};
use gpu::Device;
use scene::Scene;
use shadows::{ShadowFilter, ShadowOptions};
use tests::{run_on_all, shadow_scene};

use super::{SIZE, image, renderer, shadows};

/// Returns posts all over the ground, whose shadows merge in coarse maps.
fn posts() -> Scene {
    let mut boxes = vec![shadow_scene::GROUND];
    for post in 0..400 {
        let [x, z] = [post % 20, post / 20].map(|place| place as f32 * 1.1 - 10.5);
        boxes.push(Aabb::new(vec3(x, 0.0, z), vec3(x + 0.3, 1.6, z + 0.3)));
    }
    shadow_scene::scene(&boxes, &shadow_scene::lights()[..1])
}

/// Returns the linear red of each pixel, 0 to 255.
fn light(device: &Device, scene: &Scene, shadows: ShadowOptions) -> Vec<f32> {
    let mut renderer = renderer(device, scene, shadows);
    let mut view = renderer.new_view().unwrap();
    let linear = |code: u8| (f32::from(code) / 255.0).powf(2.2) * 255.0;
    let pixels = image(&mut renderer, &mut view, Strategy::FRUSTUM, shadow_scene::camera());
    pixels.chunks_exact(4).map(|pixel| linear(pixel[0])).collect()
}

/// Returns the largest difference of neighbouring pixels in an image beyond their difference in the
/// other images. Pixels that differ without shadows do not count.
fn excess(image: &[f32], others: &[&[f32]], bare: &[f32]) -> f32 {
    let [width, height] = SIZE.map(|side| side as usize);
    let pairs = (0..width * height).flat_map(|at| {
        let right = (at % width + 1 < width).then_some((at, at + 1));
        right.into_iter().chain((at + width < width * height).then_some((at, at + width)))
    });
    let step = |image: &[f32], (a, b): (usize, usize)| (image[a] - image[b]).abs();
    let smooth = pairs.filter(|pair| step(bare, *pair) < 2.0);
    let over = smooth.map(|pair| {
        let allowed = others.iter().map(|other| step(other, pair)).fold(0.0, f32::max);
        step(image, pair) - allowed
    });
    over.fold(0.0, f32::max)
}

/// Draws a scene in another, larger unit. Without a given distance, shadows of the sun reach as far
/// as the scene.
#[test]
fn a_scene_in_units_of_ten_kilometres_has_the_shadows_of_one_in_metres() {
    run_on_all(|device| {
        let unit_m = 16_384.0;
        let posts = posts();
        let mut large = posts.clone();
        for object in &mut large.objects {
            object.transform = Affine3A::from_scale(Vec3::splat(unit_m)) * object.transform;
        }
        let dark = |scene: &Scene, unit_m: f32| {
            let camera = shadow_scene::camera();
            let camera = Camera { eye: camera.eye * unit_m, near: 0.1 * unit_m, ..camera };
            let draw = |options| {
                let mut renderer = renderer(device, scene, options);
                let mut view = renderer.new_view().unwrap();
                image(&mut renderer, &mut view, Strategy::FRUSTUM, camera)
            };
            let lit = draw(ShadowOptions::default());
            let options = ShadowOptions { distance_m: None, sun_side: 1024, ..shadows() };
            let shadowed = draw(options);
            lit.iter()
                .zip(&shadowed)
                .filter(|(lit, shadowed)| lit.saturating_sub(**shadowed) > 24)
                .count()
        };
        let small = dark(&posts, 1.0);
        let large = dark(&large, unit_m);
        assert!(small > 300 && large.abs_diff(small) * 4 < small, "{large} of {small}");
    });
}

#[test]
fn cascades_blend_into_each_other_and_into_full_light() {
    run_on_all(|device| {
        let scene = posts();
        let coarse = ShadowOptions { sun_side: 64, filter: ShadowFilter::Single, ..shadows() };
        let of = |cascades, distance_m, cascade_blend| {
            let options =
                ShadowOptions { cascades, distance_m: Some(distance_m), cascade_blend, ..coarse };
            light(device, &scene, options)
        };
        let bare = light(device, &scene, ShadowOptions::default());
        let near = of(1, 6.0, 0.0);
        let far = of(1, 18.0, 0.0);
        let hard = of(2, 18.0, 0.0);
        let soft = of(2, 18.0, 0.4);
        let parts = [&near[..], &far[..]];
        let [hard, soft] = [hard, soft].map(|both| excess(&both, &parts, &bare));
        assert!(hard > 35.0 && soft < 0.6 * hard, "{hard} {soft}");
        // The last cascade fades: light is only added, and in some places partly.
        let fading = of(1, 6.0, 0.4);
        let mut faded = 0;
        for ((near, fading), bare) in near.iter().zip(&fading).zip(&bare) {
            assert!(*fading >= near - 1.0 && *fading <= bare + 1.0, "{near} {fading} {bare}");
            faded += u32::from(*fading > near + 15.0 && *fading < bare - 15.0);
        }
        assert!(faded > 10, "{faded}");
    });
}
