//! Outlines of objects: around all their pixels, even hidden ones, and never on these pixels.

use cull::{ObjectId, Strategy};
use glam::vec3;
use gpu::{OptionalFeature, SampleCount};
use render::{EdgeMode, ObjectOutline};
use tests::run_on_all;
use tests::shapes::{box_at, box_scene};
use tests::walk::pixels_that_differ;

use super::{SIZE, options, renderer_of, settled, straight};

const GREEN: [u8; 3] = [0, 255, 0];
const BLUE: [u8; 3] = [0, 0, 255];

fn outline(objects: &[u32], colour: [f32; 3]) -> ObjectOutline {
    let objects = objects.iter().copied().map(ObjectId).collect();
    ObjectOutline { objects, colour, width_pixels: 2.0 }
}

#[test]
fn an_outline_goes_around_all_pixels_of_what_is_selected() {
    // 40 by 40 pixels around the middle, behind a wall, and a visible object beside the wall.
    let wall = box_at(vec3(0.0, 0.0, -5.0), vec3(3.0, 2.0, 0.1));
    let hidden = box_at(vec3(0.0, 0.0, -20.0), vec3(1.0, 1.0, 1.0));
    let beside = box_at(vec3(-2.25, 0.0, -3.0), vec3(0.5, 0.5, 0.5));
    run_on_all(|device| {
        let mut renderer =
            renderer_of(device, &box_scene(&[wall, hidden, beside]), SampleCount::One);
        let plain = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        renderer.set_outlined(&[outline(&[], [1.0; 3]), outline(&[77], [1.0; 3])]).unwrap();
        let nothing = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(pixels_that_differ(&plain.0, &nothing.0), 0, "nothing is selected");
        let green = [0.0, 1.0, 0.0];
        let blue = [0.0, 0.0, 1.0];
        renderer.set_outlined(&[outline(&[1], green), outline(&[2], blue)]).unwrap();
        for strategy in [Strategy::FRUSTUM, Strategy::ANTUMBRA] {
            let image = settled(&mut renderer, strategy, straight());
            assert_eq!(image.count(GREEN), 44 * 44 - 40 * 40, "{strategy}");
            assert_eq!(image.count(BLUE), 24 * 24 - 20 * 20, "{strategy}");
            assert_eq!(image.at(SIZE[0] / 2, SIZE[1] / 2), plain.at(SIZE[0] / 2, SIZE[1] / 2));
            let drawn = 44 * 44 - 40 * 40 + 24 * 24 - 20 * 20;
            assert_eq!(pixels_that_differ(&plain.0, &image.0), drawn, "{strategy}");
        }
        // Objects of one outline that overlap have one line around both.
        renderer.set_outlined(&[outline(&[0, 1, 2], green)]).unwrap();
        let image = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(image.count(GREEN), 124 * 84 - 120 * 80);
        renderer.set_outlined(&[]).unwrap();
        let after = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(pixels_that_differ(&plain.0, &after.0), 0);
        let wide = ObjectOutline { width_pixels: 40.0, ..outline(&[1], green) };
        assert!(renderer.set_outlined(&[wide]).is_err());
    });
}

#[test]
fn outlines_lie_over_edges_and_have_samples() {
    let hidden = box_at(vec3(0.0, 0.0, -20.0), vec3(1.0, 1.0, 1.0));
    run_on_all(|device| {
        if !device.capabilities().has(OptionalFeature::SampleDepths) {
            return;
        }
        let mut renderer = renderer_of(device, &box_scene(&[hidden]), SampleCount::Four);
        renderer.set_edges(options(EdgeMode::HiddenDashed)).unwrap();
        renderer.set_outlined(&[outline(&[0], [0.0, 1.0, 0.0])]).unwrap();
        let image = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(image.count(GREEN), 44 * 44 - 40 * 40);
        renderer.resize([80, 60]).unwrap();
        renderer.resize(SIZE).unwrap();
        let image = settled(&mut renderer, Strategy::ANTUMBRA, straight());
        assert_eq!(image.count(GREEN), 44 * 44 - 40 * 40);
    });
}
