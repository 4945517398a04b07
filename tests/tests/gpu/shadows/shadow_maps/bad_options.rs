//! Impossible options and lights: the error is a sentence, and nothing has changed.

use cull::Strategy;
use glam::Vec3;
use render::{Error, LightShadow, Renderer, RendererOptions};
use scene::{LightId, LightKind, PunctualLight, Scene};
use shadows::{ShadowFilter, ShadowOptions};
use tests::{Driver, run, run_on_all, shadow_scene, shapes};

use super::{image, renderer, shadows};

#[test]
fn impossible_options_are_refused_and_change_nothing() {
    run(Driver::Lavapipe, |device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let mut renderer = renderer(device, &scene, shadows());
        let mut view = renderer.new_view().unwrap();
        let before = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        let largest = device.adapter().limits.max_image_dimension2_d;
        for bad in [
            ShadowOptions { cascades: 0, ..shadows() },
            ShadowOptions { distance_m: Some(0.0), ..shadows() },
            ShadowOptions { distance_m: Some(f32::NAN), ..shadows() },
            ShadowOptions { penumbra_m: f32::NAN, ..shadows() },
            ShadowOptions { sun_side: 0, ..shadows() },
            ShadowOptions { point_side: 100, ..shadows() },
            ShadowOptions { layers_max: 0, ..shadows() },
            ShadowOptions { layers_max: u32::MAX, ..shadows() },
            ShadowOptions { sun_side: largest.next_power_of_two() * 2, ..shadows() },
        ] {
            let error = renderer.set_shadows(bad).expect_err("refused").to_string();
            assert!(error.len() > 20 && !error.contains("panicked"), "{error}");
        }
        let width = |penumbra_m| Some(LightShadow { is_cast: true, penumbra_m });
        assert!(renderer.set_light_shadow(LightId(99), width(0.1)).is_err());
        assert!(renderer.set_light_shadow(LightId(0), width(f32::NAN)).is_err());
        assert!(renderer.set_light_shadow(LightId(0), width(-1.0)).is_err());
        assert!(renderer.set_light_shadow(LightId(0), width(1.0e30)).is_err());
        assert_eq!(*renderer.shadows(), shadows());
        let after = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        assert!(before == after, "a refused option changed the image");
    });
}

#[test]
fn scenes_without_surfaces_have_no_shadows_and_say_so() {
    run_on_all(|device| {
        let scene = shapes::box_scene(&shadow_scene::boxes());
        let options = RendererOptions { shadows: shadows(), ..RendererOptions::default() };
        let made = Renderer::new(device, &scene, &options).map(drop);
        assert!(matches!(made, Err(Error::NoSurfacesForShadows)));
        let mut plain = Renderer::new(device, &scene, &RendererOptions::default()).unwrap();
        assert!(matches!(plain.set_shadows(shadows()), Err(Error::NoSurfacesForShadows)));
    });
}

/// Returns the yard under impossible lights, with valid ones up to `count` lights in total.
pub fn badly_lit(count: usize) -> Scene {
    let [sun, spot, point] = shadow_scene::lights();
    let mut lights = vec![
        PunctualLight { range_m: Some(0.0), ..point },
        PunctualLight { range_m: Some(f32::NAN), ..point },
        PunctualLight { position: Vec3::NAN, ..point },
        PunctualLight { direction: Vec3::ZERO, ..sun },
        PunctualLight { direction: Vec3::ZERO, ..spot },
        PunctualLight { kind: LightKind::Spot { inner_rad: 0.0, outer_rad: 0.0 }, ..spot },
        PunctualLight { intensity: f32::INFINITY, ..spot },
    ];
    lights.resize_with(count.max(lights.len()), || PunctualLight {
        intensity: 0.01,
        position: shadow_scene::GROUND.max,
        range_m: Some(2.0),
        ..point
    });
    shadow_scene::scene(&shadow_scene::boxes(), &lights)
}

#[test]
fn impossible_lights_and_ten_thousand_of_them_do_no_harm() {
    run_on_all(|device| {
        for count in [0, 10_000] {
            let scene = badly_lit(count);
            let mut renderer = renderer(device, &scene, shadows());
            let mut view = renderer.new_view().unwrap();
            for _ in 0..2 {
                image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
            }
            // One of the seven is a spot without a width, which is dark but not a mistake.
            let degraded = renderer.degradations();
            assert_eq!(degraded.broken_lights, 6);
            assert!(degraded.texts().iter().any(|text| text.starts_with("6 lights have")));
            let broken = PunctualLight { range_m: Some(f32::NAN), ..shadow_scene::lights()[2] };
            renderer.set_light(LightId(0), broken).unwrap();
            assert_eq!(renderer.degradations().broken_lights, 6, "another number, as broken");
            renderer.set_light(LightId(0), shadow_scene::lights()[2]).unwrap();
            assert_eq!(renderer.degradations().broken_lights, 5);
        }
    });
}

#[test]
fn lights_without_a_shadow_shine_through() {
    run_on_all(|device| {
        let scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
        let single = ShadowOptions { filter: ShadowFilter::Single, ..shadows() };
        let mut renderer = renderer(device, &scene, single);
        let mut view = renderer.new_view().unwrap();
        let shadowed = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        let none = Some(LightShadow { is_cast: false, penumbra_m: 0.0 });
        for light in 0..3 {
            renderer.set_light_shadow(LightId(light), none).unwrap();
        }
        // Each slot held other shadows before.
        let mut lit = Vec::new();
        for _ in 0..2 * renderer.frames_in_flight() {
            lit = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
            // The sum of a light and a share of it may be rounded differently in its last bit.
            let is_darker =
                |(lit, shadowed): &(&u8, &u8)| u16::from(**lit) + 1 < u16::from(**shadowed);
            let darker = lit.iter().zip(&shadowed).filter(is_darker).count();
            assert_eq!(darker, 0, "without shadows nothing is darker");
        }
        renderer.set_shadows(ShadowOptions::default()).unwrap();
        let off = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        assert!(lit == off && lit != shadowed, "without shadows all is as if there were no maps");
        renderer.set_shadows(single).unwrap();
        for light in 0..3 {
            renderer.set_light_shadow(LightId(light), None).unwrap();
        }
        let again = image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera());
        assert!(again == shadowed, "shadows came back");
    });
}
