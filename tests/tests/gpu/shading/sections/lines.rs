//! Edges of objects that section planes cut: the edges are cut at the same places.

use cull::{SectionMode, SectionPlanes, Strategy};
use glam::Vec3;
use render::{EdgeMode, EdgeOptions, RendererOptions};
use tests::run_on_all;
use tests::section::{CutScene, Solid, front, plane, scene_of};

const SIDE: u32 = 64;

/// Returns the pixels with a line, in rows of the image.
fn lines(shown: &mut CutScene, strategy: Strategy) -> Vec<bool> {
    let pixels = shown.pixels(front(0.32), strategy);
    pixels.iter().map(|[red, green, blue]| red.max(green).max(blue) < &128).collect()
}

#[test]
fn the_edges_of_what_is_left_show_and_those_of_what_is_cut_away_do_not() {
    run_on_all(|device| {
        let scene = scene_of(&[(Solid::cube(0.2), [1.0, 0.0, 0.0], Vec3::ZERO)]);
        let options = RendererOptions { size: [SIDE; 2], ..RendererOptions::default() };
        let mut shown = CutScene::new(device, &scene, options);
        let drawn = EdgeOptions { mode: EdgeMode::HiddenDashed, ..EdgeOptions::default() };
        shown.renderer.set_edges(drawn).unwrap();
        let whole = lines(&mut shown, Strategy::ANTUMBRA);
        let count = |lines: &[bool]| lines.iter().filter(|line| **line).count();
        // Four sides of forty pixels, two pixels wide.
        assert!((250..400).contains(&count(&whole)), "{}", count(&whole));
        // The front is cut away, but the back has the same outline, seen along its normal.
        let behind = plane([0.0, 0.0, -1.0], 0.05);
        let section = SectionPlanes::new(&[behind], SectionMode::Intersection).unwrap();
        shown.renderer.set_section(section).unwrap();
        let cut = lines(&mut shown, Strategy::ANTUMBRA);
        assert!((200..400).contains(&count(&cut)), "{} of {}", count(&cut), count(&whole));
        assert!(cut == lines(&mut shown, Strategy::FRUSTUM), "every strategy draws the same");
        // The upper half and its lines are cut away.
        let below = plane([0.0, -1.0, 0.0], 0.0);
        let section = SectionPlanes::new(&[below], SectionMode::Intersection).unwrap();
        shown.renderer.set_section(section).unwrap();
        let half = lines(&mut shown, Strategy::ANTUMBRA);
        let (upper, lower) = half.split_at((SIDE * SIDE / 2) as usize);
        assert!(count(&upper[..upper.len() - 2 * SIDE as usize]) == 0, "{}", count(upper));
        assert!(count(lower) > 100, "{}", count(lower));
    });
}
