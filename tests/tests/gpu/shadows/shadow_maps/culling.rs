//! Culling of casters: images equal those with all casters in all maps, bit for bit, although most
//! casters are left out. The eye and the lights move through a town.

use std::f32::consts::TAU;

use cull::{Aabb, Camera, Projection, Strategy};
use glam::{Quat, Vec3, vec3};
use render::{DebugOverlay, RenderView, Renderer};
use scene::{LightId, PunctualLight, Scene};
use shadows::{CasterCulling, ShadowCaching, ShadowFilter, ShadowOptions, ShadowStats};
use tests::{Driver, run, run_on_all, shadow_scene};

use super::{image, renderer, shadows};

/// Blocks along each side of the town.
const BLOCKS: i32 = 5;

/// Returns the boxes of a town: the ground, blocks of houses, and boxes and poles in the streets.
fn boxes() -> Vec<Aabb> {
    let mut boxes = vec![Aabb::new(vec3(-40.0, -0.5, -40.0), vec3(40.0, 0.0, 40.0))];
    for block in 0..BLOCKS * BLOCKS {
        let [x, z] = [block % BLOCKS, block / BLOCKS].map(|place| place as f32 * 12.0 - 28.0);
        let height = 4.0 + (block * 7 % 5) as f32 * 2.0;
        boxes.push(Aabb::new(vec3(x, 0.0, z), vec3(x + 7.0, height, z + 7.0)));
        for prop in 0..6 {
            let along = prop as f32 * 1.9 + (block % 3) as f32 * 0.3;
            let low = vec3(x + 8.0 + (prop % 3) as f32, 0.0, z + along);
            boxes.push(Aabb::new(low, low + vec3(0.4, 0.5 + prop as f32 * 0.3, 0.4)));
        }
    }
    boxes
}

/// Returns a low sun, a spot light and lamps. The light of one lamp is not visible from any path.
fn lights(frame: u32) -> Vec<PunctualLight> {
    let [sun, spot, point] = shadow_scene::lights();
    let angle = frame as f32 * 0.02;
    let sway = vec3(angle.sin(), 0.0, angle.cos());
    let turned = Quat::from_rotation_y(angle * 0.1);
    vec![
        PunctualLight { direction: turned * vec3(-0.6, -0.5, -0.3).normalize(), ..sun },
        PunctualLight { position: vec3(-8.0, 7.0, 4.0) + sway, ..spot },
        PunctualLight { position: vec3(-8.0, 2.4, 9.0) + sway * 0.3, ..point },
        PunctualLight { position: vec3(29.0, 2.0, -26.0) + sway * 0.2, ..point },
    ]
}

/// Returns the town.
pub fn scene() -> Scene {
    shadow_scene::scene(&boxes(), &lights(0))
}

/// Returns the camera at street level, which walks, looks around, and stands at the end.
fn camera(frame: u32) -> Camera {
    let walked = frame.min(60) as f32;
    let angle = TAU * (0.6 + 0.12 * (walked * 0.07).sin());
    Camera {
        eye: vec3(-19.0 + walked * 0.3, 1.7, 10.0 - walked * 0.02),
        forward: vec3(angle.cos(), -0.1, angle.sin()),
        up: Vec3::Y,
        projection: Projection::perspective(1.1),
        near: 0.1,
    }
}

/// A renderer and its view of the town.
pub struct Side(Renderer, RenderView);

impl Side {
    /// Creates a renderer of the town with these shadows.
    pub fn new(device: &gpu::Device, scene: &Scene, options: ShadowOptions) -> Self {
        Self::of(renderer(device, scene, options))
    }

    /// Creates a town from its renderer, with a new view.
    pub fn of(renderer: Renderer) -> Self {
        let view = renderer.new_view().unwrap();
        Self(renderer, view)
    }

    /// Draws a frame of the walk.
    pub fn draw(&mut self, frame: u32, strategy: Strategy) -> Vec<u8> {
        for (number, light) in (0..).zip(lights(frame.min(70))) {
            self.0.set_light(LightId(number), light).unwrap();
        }
        image(&mut self.0, &mut self.1, strategy, camera(frame))
    }

    /// Returns the counts of the newest frame.
    pub fn stats(&self) -> ShadowStats {
        self.0.shadow_stats()
    }
}

fn options(caching: ShadowCaching, culling: CasterCulling) -> ShadowOptions {
    ShadowOptions { caching, culling, ..shadows() }
}

/// Draws frames of a town with and without culled casters. Returns the triangles of casters in
/// both.
fn compare(device: &gpu::Device, frames: u32, filter: ShadowFilter) -> [u64; 2] {
    use CasterCulling::{Culled, Unculled};
    use ShadowCaching::{Cached, Uncached};
    let scene = scene();
    let mut sides =
        [(Uncached, Unculled), (Uncached, Culled), (Cached, Culled)].map(|(caching, culling)| {
            let options = ShadowOptions { filter, ..options(caching, culling) };
            Side::new(device, &scene, options)
        });
    let mut triangles = [0; 2];
    let mut culled_faces = 0;
    for frame in (0..frames).step_by(2) {
        let [expected, uncached, cached] =
            sides.each_mut().map(|side| side.draw(frame, Strategy::ANTUMBRA));
        for (name, found) in [("uncached", &uncached), ("cached", &cached)] {
            let wrong = tests::walk::pixels_that_differ(&expected, found);
            assert_eq!(wrong, 0, "{filter:?}: pixels of frame {frame}, {name}");
        }
        let [all, culled, cached] = sides.each_ref().map(Side::stats);
        assert_eq!((all.culled_faces, culled.culled_faces), (0, culled.faces));
        culled_faces += cached.culled_faces;
        triangles[0] += all.triangles;
        triangles[1] += culled.triangles + culled.revealed_triangles;
        if frame > 75 {
            assert_eq!(cached.drawn_faces, 0, "frame {frame}: nothing moves any more");
        }
    }
    assert!(culled_faces > frames / 4, "moving lights are not culled in cached maps");
    triangles
}

#[test]
fn lavapipe_images_are_those_with_all_casters() {
    run(Driver::Lavapipe, |device| {
        let [all, culled] = compare(device, 90, ShadowFilter::Adaptive);
        println!("{culled} triangles of {all}");
        assert!(culled * 2 < all, "{culled} triangles of {all}");
        for filter in ShadowFilter::ALL {
            compare(device, 12, filter);
        }
    });
}

#[test]
fn swiftshader_images_are_those_with_all_casters() {
    run(Driver::SwiftShader, |device| {
        compare(device, 14, ShadowFilter::Adaptive);
    });
}

#[test]
fn every_strategy_draws_with_the_same_casters() {
    run(Driver::Lavapipe, |device| {
        let scene = scene();
        let mut afresh =
            Side::new(device, &scene, options(ShadowCaching::Uncached, CasterCulling::Unculled));
        let expected: Vec<_> = (0..4).map(|index| afresh.draw(index, Strategy::FRUSTUM)).collect();
        let strategies = [
            Strategy::FRUSTUM,
            Strategy::ANTUMBRA_QUERIES,
            Strategy::ANTUMBRA_COMPUTE,
            methods::CHC,
            methods::HZB,
        ];
        for strategy in strategies {
            let culled = options(ShadowCaching::Uncached, CasterCulling::Culled);
            let mut side = Side::new(device, &scene, culled);
            for (frame, expected) in (0..).zip(&expected) {
                let found = side.draw(frame, strategy);
                let wrong = tests::walk::pixels_that_differ(expected, &found);
                assert_eq!(wrong, 0, "{strategy}: pixels of frame {frame}");
            }
        }
    });
}

#[test]
fn what_looks_from_elsewhere_sees_all_casters() {
    run(Driver::Lavapipe, |device| {
        let culled = options(ShadowCaching::Uncached, CasterCulling::Culled);
        let mut side = Side::new(device, &scene(), culled);
        side.draw(0, Strategy::ANTUMBRA);
        assert!(side.stats().culled_faces > 0);
        let boxes = DebugOverlay { has_boxes: true, ..DebugOverlay::default() };
        side.0.set_debug_overlay(boxes).unwrap();
        side.draw(1, Strategy::ANTUMBRA);
        assert_eq!(side.stats().culled_faces, 0);
    });
}

#[test]
fn a_light_that_shines_on_nothing_visible_costs_one_test_and_no_triangle() {
    run_on_all(|device| {
        let [.., hidden] = lights(0)[..] else { panic!("no light") };
        let scene = shadow_scene::scene(&boxes(), &[hidden]);
        let culled = options(ShadowCaching::Uncached, CasterCulling::Culled);
        let mut renderer = renderer(device, &scene, culled);
        let mut view = renderer.new_view().unwrap();
        let away = Camera { forward: vec3(-1.0, 0.2, 0.0), ..camera(0) };
        let mut draw = |camera| {
            // The counts of a frame are read two frames later.
            for _ in 0..3 {
                image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            }
            renderer.shadow_stats()
        };
        let stats = draw(camera(0));
        assert!(stats.casters > 10 && stats.culled_faces == 6, "{stats:?}");
        assert_eq!((stats.tests, stats.triangles, stats.revealed_triangles), (1, 0, 0));
        let stats = draw(away);
        assert_eq!((stats.tests, stats.triangles, stats.revealed_triangles), (1, 0, 0));
        // The eye is in the light of the lamp.
        let stats = draw(Camera { eye: hidden.position + 0.5, ..camera(0) });
        assert_eq!((stats.tests, stats.revealed_triangles), (0, 0));
        assert!(stats.triangles > 100, "{stats:?}");
    });
}
