//! The view of depth complexity: the number of surfaces that are drawn at each pixel.

use cull::{SectionPlanes, Strategy};
use glam::{Vec3, vec3};
use gpu::{Device, OptionalFeature, SampleCount};
use render::palette::layer_colour;
use render::{DebugOverlay, RendererOptions};
use tests::run_on_all;
use tests::section::{CutScene, Solid, front, plane, planes, scene_of};
use tests::shapes::{box_at, box_scene, square_camera};

const SIDE: u32 = 80;
const QUADS: u32 = 40;
const OVERLAY: DebugOverlay = DebugOverlay {
    has_wireframe: false,
    has_boxes: false,
    has_depth_complexity: true,
    top_down: None,
};

/// Returns half the side of a quad (metres).
fn half_m(number: u32) -> f32 {
    (number + 1) as f32 / QUADS as f32 * 0.9
}

/// Returns a renderer of quads, one behind the other, with the smallest in front.
fn quads(device: &Device, samples: SampleCount) -> CutScene {
    let solids: Vec<_> = (0..QUADS)
        .map(|number| {
            let half_m = half_m(number);
            let corner = |x: f32, y: f32| vec3(x * half_m, y * half_m, 0.0);
            let mut solid = Solid::default();
            solid.push_quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]);
            (solid, [0.5; 3], Vec3::NEG_Z * 0.02 * number as f32)
        })
        .collect();
    let options = RendererOptions { size: [SIDE; 2], samples, ..RendererOptions::default() };
    CutScene::new(device, &scene_of(&solids), options)
}

/// Checks the middle row of an image of quads, which are cut to x above `from_m`. With several
/// samples per pixel, a surface counts if it covers one of them. It counts twice at the diagonal of
/// a quad, which crosses the middle.
fn check_row(shown: &mut CutScene, from_m: f32) {
    let outermost_sample = match shown.renderer.samples() {
        SampleCount::One => 0.0,
        _ => 0.375,
    };
    let pixels = shown.pixels(front(2.0), Strategy::FRUSTUM);
    let mut counted = 0;
    for column in 0..SIDE {
        let x_m = (column as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let nearest_m = x_m.abs() - outermost_sample * 2.0 / SIDE as f32;
        if x_m.abs() < 0.05 {
            continue;
        }
        let is_clear = |at_m: f32| (at_m - nearest_m).abs() > 0.004;
        if !(0..QUADS).all(|number| is_clear(half_m(number))) || (x_m - from_m).abs() < 0.03 {
            continue;
        }
        let all = (0..QUADS).filter(|number| half_m(*number) > nearest_m).count() as u32;
        let surfaces = if x_m > from_m { all } else { 0 };
        let found = pixels[(SIDE / 2 * SIDE + column) as usize];
        assert_eq!(found, layer_colour(surfaces), "{surfaces} surfaces in column {column}");
        counted += u32::from(surfaces > 0);
    }
    assert!(counted > 12, "{counted} columns were counted");
}

#[test]
fn so_many_quads_are_so_many_surfaces_whatever_hides_them() {
    run_on_all(|device| {
        for samples in [SampleCount::One, SampleCount::Four] {
            // Drivers with wrong depths of samples do not average colours either.
            if samples == SampleCount::Four
                && !device.capabilities().has(OptionalFeature::SampleDepths)
            {
                continue;
            }
            let mut shown = quads(device, samples);
            let before = shown.pixels(front(2.0), Strategy::FRUSTUM);
            shown.renderer.set_debug_overlay(OVERLAY).unwrap();
            check_row(&mut shown, -2.0);
            // Parts that planes cut away do not count.
            shown.renderer.set_section(planes(&[plane([1.0, 0.0, 0.0], -0.2)])).unwrap();
            check_row(&mut shown, 0.2);
            shown.renderer.set_section(SectionPlanes::default()).unwrap();
            shown.renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
            assert!(shown.pixels(front(2.0), Strategy::FRUSTUM) == before, "no trace is left");
        }
    });
}

#[test]
fn behind_a_wall_culling_leaves_one_surface() {
    run_on_all(|device| {
        let wall = box_at(vec3(0.0, 0.0, -2.0), vec3(9.0, 9.0, 0.2));
        let behind = (1..=16)
            .map(|number| box_at(vec3(0.0, 0.0, -2.0 - 2.0 * number as f32), Vec3::splat(0.5)));
        let scene = box_scene(&std::iter::once(wall).chain(behind).collect::<Vec<_>>());
        let options = RendererOptions { size: [SIDE; 2], ..RendererOptions::default() };
        let mut shown = CutScene::new(device, &scene, options);
        shown.renderer.set_debug_overlay(OVERLAY).unwrap();
        let mut middle = |strategy| {
            (0..6).for_each(|_| drop(shown.pixels(square_camera(), strategy)));
            shown.pixels(square_camera(), strategy)[(SIDE / 2 * SIDE + SIDE / 2) as usize]
        };
        assert_eq!(middle(Strategy::FRUSTUM), layer_colour(17));
        assert_eq!(middle(Strategy::ANTUMBRA), layer_colour(1));
    });
}
