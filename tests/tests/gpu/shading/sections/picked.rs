//! Picks in a scene with section planes: they find the drawn surfaces.

use cull::{Camera, ObjectId, SectionMember, SectionMode, SectionPlanes, Strategy};
use glam::Vec3;
use render::{FrameRequest, RendererOptions};
use tests::run_on_all;
use tests::section::{CutScene, Solid, front, plane, scene_of};

const SIDE: u32 = 64;

/// Returns a thick-walled box around a small solid.
fn hollow() -> Solid {
    let mut outside = Solid::cube(0.2);
    let inside = Solid::cube(0.16);
    outside.triangles.extend(inside.triangles.iter().map(|[a, b, c]| [*a, *c, *b]));
    outside
}

#[test]
fn a_click_finds_what_is_drawn_where_a_box_is_cut_open() {
    run_on_all(|device| {
        let scene = scene_of(&[
            (hollow(), [1.0, 0.0, 0.0], Vec3::ZERO),
            (Solid::cube(0.05), [0.0, 1.0, 0.0], Vec3::ZERO),
            (Solid::cube(0.02), [0.0, 0.0, 1.0], Vec3::new(0.05, 0.05, 0.3)),
        ]);
        let options = RendererOptions { size: [SIDE; 2], ..RendererOptions::default() };
        let mut shown = CutScene::new(device, &scene, options);
        let cuts = [plane([0.0, 0.0, -1.0], 0.04), plane([0.0, -1.0, 0.0], 0.5)];
        let camera = Camera { ..front(0.32) };
        let pick = |shown: &mut CutScene, x: u32, y: u32| {
            shown.view.point_at(Some([x, y])).unwrap();
            let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
            shown.renderer.render(&mut shown.view, request).unwrap();
            shown.renderer.wait_idle(&mut shown.view).unwrap();
            let pointed = shown.view.pointed().expect("it is over");
            pointed.surface.map(|surface| surface.object.0)
        };
        assert_eq!(pick(&mut shown, 32, 32), Some(0), "closed");
        for mode in [SectionMode::Intersection, SectionMode::Union] {
            let number = if mode == SectionMode::Union { 1 } else { 2 };
            let section = SectionPlanes::new(&cuts[..number], mode).unwrap();
            shown.renderer.set_section(section).unwrap();
            assert_eq!(pick(&mut shown, 32, 32), Some(1), "inside, {mode:?}");
            assert_eq!(pick(&mut shown, 32 - 18, 32), Some(0), "the cap, {mode:?}");
            assert_eq!(pick(&mut shown, 42, 22), Some(0), "where one was cut away, {mode:?}");
            assert_eq!(pick(&mut shown, 1, 1), None);
            shown.renderer.set_section_member(ObjectId(2), SectionMember::Whole);
            assert_eq!(pick(&mut shown, 42, 22), Some(2), "an excluded part, {mode:?}");
            shown.renderer.set_section_member(ObjectId(2), SectionMember::Cut);
        }
        // A union of two halves of a corner: a pick finds the visible surface.
        let corner = [plane([-1.0, 0.0, 0.0], 0.0), plane([0.0, 0.0, -1.0], 0.04)];
        let section = SectionPlanes::new(&corner, SectionMode::Union).unwrap();
        shown.renderer.set_section(section).unwrap();
        let pixels = shown.pixels(camera, Strategy::ANTUMBRA);
        for y in (0..SIDE).step_by(7) {
            for x in (0..SIDE).step_by(5) {
                let [red, green, blue] = pixels[(y * SIDE + x) as usize];
                let drawn = match () {
                    () if red > 0 => Some(0),
                    () if green > 0 => Some(1),
                    () if blue > 0 => Some(2),
                    () => None,
                };
                assert_eq!(pick(&mut shown, x, y), drawn, "{x}, {y}");
            }
        }
    });
}
