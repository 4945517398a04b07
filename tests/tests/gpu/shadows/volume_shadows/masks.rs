//! The mask of shadow volumes: one bit per pixel for each light that a view shows, in layers.

use cull::{Aabb, Camera, Projection, Strategy};
use glam::{Vec3, vec3};
use scene::{LightKind, PunctualLight};
use shadows::ShadowOptions;
use tests::walk::pixels_that_differ;
use tests::{run_on_all, shadow_scene};

use super::{image, renderer, volumes};

/// The number of plots along a side of the field.
const SIDE: u32 = 7;

/// Returns a field of plots, each with a pillar.
fn field() -> Vec<Aabb> {
    let plot = |number: u32| {
        let low = vec3((number % SIDE) as f32 * 3.0, -0.2, (number / SIDE) as f32 * 3.0);
        let pillar = low + vec3(1.4, 0.2, 1.2);
        [Aabb::new(low, low + vec3(3.0, 0.2, 3.0)), Aabb::new(pillar, pillar + vec3(0.5, 0.6, 0.5))]
    };
    (0..SIDE * SIDE).flat_map(plot).collect()
}

/// Returns a lamp over each plot.
fn lamps() -> Vec<PunctualLight> {
    let lamp = |number: u32| PunctualLight {
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: 6.0,
        range_m: Some(2.6),
        position: vec3((number % SIDE) as f32 * 3.0 + 1.0, 1.0, (number / SIDE) as f32 * 3.0 + 1.0),
        direction: Vec3::NEG_Y,
        cookie: None,
    };
    (0..SIDE * SIDE).map(lamp).collect()
}

fn above() -> Camera {
    let projection = Projection::perspective(1.0);
    Camera {
        eye: vec3(10.5, 19.2, 10.5),
        forward: Vec3::NEG_Y,
        up: Vec3::NEG_Z,
        projection,
        near: 1.0,
    }
}

#[test]
fn more_lights_than_bits_take_another_layer_and_beyond_the_last_shine_through() {
    run_on_all(|device| {
        let draw = |lamps: &[PunctualLight], options: ShadowOptions| {
            let mut renderer = renderer(device, &shadow_scene::scene(&field(), lamps), options);
            let mut view = renderer.new_view().unwrap();
            let image = image(&mut renderer, &mut view, Strategy::ANTUMBRA, above());
            (image, renderer.shadow_stats())
        };
        let lit = draw(&lamps(), ShadowOptions::default()).0;
        let (two_layers, stats) = draw(&lamps(), volumes());
        assert_eq!((stats.lights, stats.unshadowed_lights), (SIDE * SIDE, 0));
        let mut turned = lamps();
        turned.reverse();
        let (other_bits, _) = draw(&turned, volumes());
        // Sums of lights in another order may be rounded differently in their last bit.
        let mut both = two_layers.iter().zip(&other_bits);
        assert!(both.all(|(a, b)| a.abs_diff(*b) <= 1), "all bits are alike");
        let one = ShadowOptions { layers_max: 1, ..volumes() };
        let (one_layer, stats) = draw(&lamps(), one);
        assert_eq!((stats.lights, stats.unshadowed_lights), (32, SIDE * SIDE - 32));
        let row = |image: &[u8], row: usize| {
            // The image shows the whole field, so each row of plots is an equal share of the
            // image's rows.
            let width = super::SIZE[0] as usize;
            let height = super::SIZE[1] as usize;
            let plots = height * row / SIDE as usize..height * (row + 1) / SIDE as usize;
            image[plots.start * width * 4..plots.end * width * 4].to_vec()
        };
        for number in [0, 2] {
            assert!(row(&one_layer, number) == row(&two_layers, number), "row {number}");
            assert!(pixels_that_differ(&row(&lit, number), &row(&two_layers, number)) > 20);
        }
        let last = SIDE as usize - 1;
        let beyond = row(&lit, last).into_iter().zip(row(&one_layer, last));
        assert!(beyond.into_iter().all(|(a, b)| a.abs_diff(b) <= 1), "these shine through");
        assert!(pixels_that_differ(&row(&lit, last), &row(&two_layers, last)) > 20);
    });
}
