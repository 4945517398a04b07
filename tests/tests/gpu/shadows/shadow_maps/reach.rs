//! Culled casters whose shadows reach farthest: receivers in grazing light, whose filters find
//! casters far behind them, and lights without a range.

use cull::{Aabb, Camera, Projection, Strategy};
use glam::{Vec3, vec3};
use scene::{LightKind, PunctualLight};
use shadows::{CasterCulling, ShadowCaching, ShadowFilter, ShadowMethod, ShadowOptions};
use tests::{Driver, run, shadow_scene};

use super::{image, renderer, shadows};

/// Checks that an image is the same with and without culled casters.
fn compare(
    light: PunctualLight,
    boxes: &[Aabb],
    camera: Camera,
    options: ShadowOptions,
    exposure: f32,
) {
    run(Driver::Lavapipe, |device| {
        let scene = shadow_scene::scene(boxes, &[light]);
        let [all, culled] = [CasterCulling::Unculled, CasterCulling::Culled].map(|culling| {
            let options = ShadowOptions { culling, caching: ShadowCaching::Uncached, ..options };
            let mut renderer = renderer(device, &scene, options);
            renderer.set_exposure(exposure);
            let mut view = renderer.new_view().unwrap();
            let frames =
                (0..4).map(|_| image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera));
            frames.last().unwrap()
        });
        let wrong = tests::walk::pixels_that_differ(&all, &culled);
        assert_eq!(wrong, 0, "{options:?} with {light:?}");
    });
}

fn lamp() -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: 12.0,
        range_m: Some(15.0),
        position: vec3(0.0, 2.0, 0.0),
        direction: Vec3::NEG_Y,
        cookie: None,
    }
}

/// Returns enough small boxes for the light to keep a history.
fn fillers(low: Vec3) -> impl Iterator<Item = Aabb> {
    (0..100).map(move |number| {
        let low = low + vec3((number % 10) as f32 * 0.2, (number / 10) as f32 * 0.2, 0.0);
        Aabb::new(low, low + 0.1)
    })
}

#[test]
fn receivers_that_a_lamp_grazes_have_all_of_their_casters() {
    let camera = Camera {
        eye: vec3(1.0, 2.8, 1.5),
        forward: vec3(0.0, -0.86, -1.5).normalize(),
        up: Vec3::Y,
        projection: Projection::perspective(0.5),
        near: 0.1,
    };
    let kind = LightKind::Spot { inner_rad: 0.3, outer_rad: 0.35 };
    let spot = PunctualLight { kind, direction: Vec3::X, ..lamp() };
    for (light, low) in [(lamp(), vec3(-9.0, 1.0, -4.0)), (spot, vec3(12.0, 1.0, -2.0))] {
        for height in [0.04, 0.06, 0.1] {
            // A plate a little below the light, and a caster ten metres away.
            let plate = Aabb::new(vec3(0.7, 1.8, -0.2), vec3(1.3, 2.0 - height, 0.2));
            let caster = Aabb::new(vec3(9.9, 1.7, -0.5), vec3(10.0, 2.6, 0.5));
            let boxes: Vec<_> = fillers(low).chain([plate, caster]).collect();
            for filter in [ShadowFilter::Adaptive, ShadowFilter::Pcf3, ShadowFilter::Pcss64] {
                let options = ShadowOptions { filter, ..shadows() };
                compare(light, &boxes, camera, options, 1.0);
            }
        }
    }
}

#[test]
fn lights_without_a_range_end_where_their_shadows_do() {
    let position = vec3(0.0, 8.0, 0.0);
    let light = PunctualLight { intensity: 1.0, range_m: None, position, ..lamp() };
    let ground = Aabb::new(vec3(-30.0, -0.5, -30.0), vec3(30.0, 0.0, 30.0));
    let caster = Aabb::new(vec3(6.0, 0.0, -0.5), vec3(6.3, 4.5, 0.5));
    let few = vec![ground, caster];
    let many: Vec<_> = few.iter().copied().chain(fillers(vec3(-5.0, 10.0, -1.0))).collect();
    for (boxes, x) in [(&few, 13.0), (&many, 11.5), (&many, 11.0)] {
        let camera = Camera {
            eye: vec3(x, 6.0, 0.0),
            forward: Vec3::NEG_Y,
            up: Vec3::X,
            projection: Projection::perspective(0.8),
            near: 0.1,
        };
        for method in [ShadowMethod::Maps, ShadowMethod::Volumes] {
            let options = ShadowOptions { method, ..shadows() };
            compare(light, boxes, camera, options, 8.0);
        }
    }
}
