//! Tests of the sets of lights: they are valid, at the right places, and reproducible.

use glam::Vec3;
use scene::{LightKind, Mesh, PunctualLight, Scene};

use super::super::city;
use super::super::field;
use super::super::path::{CameraPath, PathKind};
use super::*;

fn eyes(routes: &super::super::routes::Routes) -> Vec<Vec3> {
    let path = CameraPath::new(PathKind::Street, routes).unwrap();
    (0..120).map(|frame| path.camera(frame).eye).collect()
}

fn lights(scene: &Scene) -> &[PunctualLight] {
    &scene.surfaces.as_ref().unwrap().lights
}

fn of_kind(scene: &Scene, is_kind: impl Fn(&LightKind) -> bool) -> Vec<PunctualLight> {
    lights(scene).iter().filter(|light| is_kind(&light.kind)).copied().collect()
}

#[test]
fn names_are_read_and_written() {
    for name in ["sun", "torches", "1", "8", "64"] {
        assert_eq!(name.parse::<LightSet>().unwrap().to_string(), name);
    }
    for name in ["", "0", "65", "-1", "10000", "1.5", "NaN", "moon", "Sun"] {
        let refused = name.parse::<LightSet>().unwrap_err().to_string();
        assert!(refused.contains(&format!("'{name}'")) && refused.contains("1 to 64"), "{refused}");
    }
}

#[test]
fn a_number_of_lamps_is_lit_and_the_nearest_are_the_first() {
    let city = city(2_000, 5).unwrap();
    let eyes = eyes(&city.routes);
    let lit = |lamps| LightSet::Lamps(lamps).light(city.scene.clone(), &eyes).unwrap();
    let is_spot = |kind: &LightKind| matches!(kind, LightKind::Spot { .. });
    let all = of_kind(&lit(64), is_spot);
    for lamps in [1, 8, 16, 32, 64] {
        let scene = lit(lamps);
        assert_eq!(scene.validate(), Ok(()));
        assert_eq!(scene, lit(lamps), "the same each time");
        let spots = of_kind(&scene, is_spot);
        assert_eq!(spots, all[..lamps as usize]);
        assert_eq!(scene.objects.len(), city.scene.objects.len());
        let is_lit = |mesh: &Mesh| mesh.name == "street lamp, lit";
        let lit = scene.objects.iter().filter(|object| scene.mesh_of(object).is_some_and(is_lit));
        assert_eq!(lit.count(), lamps as usize, "their globes glow");
    }
    assert!(all[0].position.distance(eyes[0]) < 40.0, "the first is where the walk begins");
    for light in &all {
        assert!((light.direction.length() - 1.0).abs() < 1e-5 && light.direction.y < -0.9);
        assert!(light.range_m.is_some_and(|range_m| range_m > light.position.y));
        let around = |object: &&scene::Object| {
            let bounds = city.scene.bounds_of(object).unwrap();
            bounds.distance_squared(light.position) == 0.0
        };
        let holders = city.scene.objects.iter().filter(around).count();
        assert!(holders <= 1, "at most its own lamp's box is around it");
    }
}

#[test]
fn torches_are_points_and_the_sun_is_alone() {
    let city = city(500, 2).unwrap();
    let torches = LightSet::Torches.light(city.scene.clone(), &[]).unwrap();
    assert_eq!(torches.validate(), Ok(()));
    assert_eq!(of_kind(&torches, |kind| *kind == LightKind::Point).len(), 32);
    let sun = LightSet::Sun(Hour::AFTERNOON).light(city.scene.clone(), &[]).unwrap();
    assert_eq!(sun.validate(), Ok(()));
    assert_eq!(lights(&sun), [sun_light(&Hour::AFTERNOON.light()).unwrap()]);
    let dawn = LightSet::Sun("6".parse().unwrap()).light(city.scene, &[]).unwrap();
    assert!(lights(&dawn).iter().all(|light| light.intensity < 0.1), "it is at the horizon");
}

#[test]
fn scenes_with_too_few_lamps_are_refused() {
    let few = city(5, 1).unwrap().scene;
    for set in [LightSet::Torches, LightSet::Lamps(1)] {
        let refused = set.light(few.clone(), &[]).unwrap_err();
        assert_eq!(refused, GeneratorError::TooFewLamps { asked: 1, found: 0 });
    }
    let field = field(3_000, 1).unwrap();
    let refused = LightSet::Lamps(64).light(city(60, 1).unwrap().scene, &[]).unwrap_err();
    assert!(matches!(refused, GeneratorError::TooFewLamps { asked: 64, .. }));
    assert!(LightSet::Lamps(8).light(field.scene, &eyes(&field.routes)).is_ok());
}

#[test]
fn lights_of_a_scene_of_its_own_stay_by_their_kind() {
    let own = LightSet::Lamps(2).light(city(300, 1).unwrap().scene, &[]).unwrap();
    let torches = LightSet::Torches.light(own.clone(), &[]).unwrap();
    let sun = LightSet::Sun(Hour::AFTERNOON).light(own.clone(), &[]).unwrap();
    for (lit, keeps_sun) in [(&torches, false), (&sun, true)] {
        assert_eq!(lights(lit).len(), lights(&own).len());
        for (light, before) in lights(lit).iter().zip(lights(&own)) {
            let expected = if is_sun(before) == keeps_sun { before.intensity } else { 0.0 };
            assert_eq!((light.kind, light.intensity), (before.kind, expected));
        }
    }
    let mut dark = own.clone();
    dark.surfaces.as_mut().unwrap().lights.retain(|light| !is_sun(light));
    let lit = LightSet::Sun(Hour::AFTERNOON).light(dark, &[]).unwrap();
    assert_eq!(lights(&lit).last().copied(), sun_light(&Hour::AFTERNOON.light()));
    let sunny = LightSet::Sun(Hour::AFTERNOON).light(city(9, 1).unwrap().scene, &[]).unwrap();
    assert_eq!(LightSet::Torches.light(sunny, &[]), Err(GeneratorError::NoTorches));
}

#[test]
fn some_windows_glow_and_others_do_not() {
    let scene = LightSet::Lamps(1).light(city(300, 1).unwrap().scene, &[]).unwrap();
    let surfaces = scene.surfaces.as_ref().unwrap();
    let glow = surfaces.materials.iter().position(|material| material.name == GLOW_NAME).unwrap();
    let glowing = surfaces.meshes.iter().filter(|mesh| mesh.material.0 as usize == glow);
    let mut lit = 0;
    let mut dark = 0;
    for mesh in glowing {
        for vertex in &mesh.vertices {
            if vertex.uv[0][0] > 0.25 { lit += 1 } else { dark += 1 }
        }
    }
    assert!(lit > 100 && dark > lit, "{lit} and {dark} vertices");
}

#[test]
fn lamps_are_on_at_night_and_the_sun_follows_the_hour() {
    let city = city(500, 1).unwrap();
    let (scene, mut daylight) = Daylight::new(city.scene, &[], 16).unwrap();
    assert_eq!(scene.validate(), Ok(()));
    assert_eq!((daylight.lamps.len(), lights(&scene).len()), (16, 17));
    for (change, light) in daylight.lights().iter().zip(lights(&scene)) {
        assert_eq!(change.to, *light, "it begins at night");
    }
    daylight.hour = Hour::AFTERNOON;
    let by_day = daylight.lights();
    assert_eq!(by_day.len(), 17);
    assert_eq!(by_day[0].to, sun_light(&Hour::AFTERNOON.light()).unwrap());
    assert!(by_day[1..].iter().all(|lamp| lamp.to.intensity == 0.0));
    assert_eq!(daylight.material().unwrap().1.emission, [0.0; 3]);
    daylight.hour = "6".parse().unwrap();
    assert_eq!(daylight.lights().len(), 17, "the sun stays a light when it is dark");
    let (bare, daylight) = Daylight::new(field(1, 1).unwrap().scene, &[], 16).unwrap();
    assert_eq!((bare.validate(), daylight.lamps.len()), (Ok(()), 0));
}
