//! Tests of the lights that reach each object, without a device.

use cull::{Aabb, Hierarchy};
use glam::{Vec3, vec3};
use scene::limits::{MAX_DIRECTIONAL_LIGHTS, MAX_LIGHTS_PER_OBJECT};
use scene::{LightId, LightKind, PunctualLight, Surfaces};

use super::light_lists::LightLists;
use super::lights::{LightTable, dark_light, reach_m};
use crate::resources::spare_capacity::SpareCapacity;

fn bulb(position: Vec3, candela: f32, range_m: Option<f32>) -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0, 0.5, 0.25],
        intensity: candela,
        range_m,
        position,
        direction: Vec3::NEG_Z,
        cookie: None,
    }
}

fn sun(lux: f32) -> PunctualLight {
    PunctualLight { kind: LightKind::Directional, ..bulb(Vec3::ZERO, lux, None) }
}

/// Returns boxes of a metre in a grid of three metres.
fn boxes() -> Vec<Aabb> {
    let corner = |number: u32| vec3((number % 10) as f32, (number / 10 % 10) as f32, 0.0) * 3.0;
    (0..100).map(corner).map(|corner| Aabb::new(corner, corner + 1.0)).collect()
}

fn table(lights: Vec<PunctualLight>) -> LightTable {
    LightTable::new(&Surfaces { lights, ..Surfaces::default() }, &SpareCapacity::default())
}

/// Returns the lights that reach a box, found by testing all of them.
fn plain(lights: &[PunctualLight], bounds: &Aabb) -> Vec<u32> {
    let mut found: Vec<(f32, u32)> = (0..)
        .zip(lights)
        .filter(|(_, light)| bounds.distance_squared(light.position).sqrt() <= reach_m(light))
        .map(|(place, light)| {
            (light.intensity / bounds.distance_squared(light.position).max(1e-4), place)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    found.truncate(MAX_LIGHTS_PER_OBJECT);
    found.into_iter().map(|(_, place)| place).collect()
}

fn lights() -> Vec<PunctualLight> {
    let place = |number: u32| {
        vec3((number * 7 % 30) as f32, (number * 11 % 29) as f32, (number % 3) as f32)
    };
    (0..60)
        .map(|number| {
            bulb(place(number), 1.0 + (number % 9) as f32, Some(4.0 + (number % 5) as f32))
        })
        .collect()
}

#[test]
fn lists_hold_the_strongest_lights_that_reach_a_box() {
    let boxes = boxes();
    let lights = lights();
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let mut lists = LightLists::new(&table(lights.clone()), boxes.len());
    lists.fill(&hierarchy, 0);
    lists.submitted();
    let mut longest = 0;
    for (slot, bounds) in (0..).zip(&boxes) {
        let expected = plain(&lights, bounds);
        longest = longest.max(expected.len());
        assert_eq!(lists.entries(slot), expected, "{slot}");
        assert_eq!(lists.count(slot) as usize, expected.len());
    }
    assert!(longest > 3);
    assert!(lists.dirty().is_empty(), "what is uploaded whole is not stale");
}

#[test]
fn no_list_is_longer_than_it_may_be() {
    let lights: Vec<_> = (0..40).map(|number| bulb(Vec3::ZERO, number as f32, Some(9.0))).collect();
    let boxes = [Aabb::new(Vec3::splat(1.0), Vec3::splat(2.0))];
    let mut lists = LightLists::new(&table(lights), 1);
    lists.fill(&Hierarchy::build(&boxes).unwrap(), 0);
    lists.submitted();
    let strongest: Vec<u32> = (24..40).rev().collect();
    assert_eq!(lists.entries(0), strongest);
    assert_eq!(lists.crowded(), 1);
}

#[test]
fn what_moves_finds_its_lights_again() {
    let mut boxes = boxes();
    let lights = lights();
    let mut lists = LightLists::new(&table(lights.clone()), boxes.len());
    lists.fill(&Hierarchy::build(&boxes).unwrap(), 0);
    lists.submitted();
    for moved in [3_usize, 50, 51] {
        boxes[moved] = Aabb::new(vec3(11.0, 12.0, 0.0), vec3(14.0, 13.0, 1.0));
        assert!(lists.find(moved as u32, &boxes[moved]));
        assert!(!lists.find(moved as u32, &boxes[moved]), "the same again");
        assert_eq!(lists.entries(moved as u32), plain(&lights, &boxes[moved]));
    }
    assert_eq!(lists.dirty(), [3, 50, 51]);
    lists.submitted();
    assert!(lists.dirty().is_empty());
    assert!(!lists.find(1000, &boxes[0]), "there is no such slot");
}

#[test]
fn a_light_that_moves_is_found_around_both_its_places() {
    let boxes = boxes();
    let mut lights = lights();
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let mut lists = LightLists::new(&table(lights.clone()), boxes.len());
    lists.fill(&hierarchy, 0);
    lists.submitted();
    for (moved, to) in [
        (5, bulb(vec3(20.0, 20.0, 0.0), 50.0, Some(6.0))),
        (6, bulb(vec3(2.0, 2.0, 0.0), 0.0, Some(6.0))),
        (6, bulb(vec3(2.0, 2.0, 0.0), 3.0, None)),
        (7, bulb(Vec3::NAN, 3.0, None)),
    ] {
        lights[moved] = to;
        for (centre, radius_m) in lists.replace(moved, Some(moved as u32), &to) {
            lists.doubt(&hierarchy, 0, centre, radius_m);
        }
        let doubtful = lists.take_doubtful();
        assert!(doubtful.len() < 80, "not all objects are asked: {}", doubtful.len());
        for object in doubtful {
            lists.find(object, &boxes[object as usize]);
        }
        for (slot, bounds) in (0..).zip(&boxes) {
            let shining: Vec<_> = lights
                .iter()
                .map(|light| {
                    // A dark or broken light reaches nothing.
                    let is_dark = light.intensity == 0.0 || light.position.is_nan();
                    if is_dark { bulb(Vec3::splat(1e9), 1.0, Some(1e-3)) } else { *light }
                })
                .collect();
            assert_eq!(lists.entries(slot), plain(&shining, bounds), "{slot}");
        }
    }
}

#[test]
fn lights_without_range_reach_until_they_are_dark() {
    let light = bulb(Vec3::ZERO, 10.0, None);
    let reach = reach_m(&light);
    let white = 10.0 / (reach * reach) / std::f32::consts::PI;
    assert!((white * 256.0 - 1.0).abs() < 1e-3, "{white}");
    assert_eq!(reach_m(&bulb(Vec3::ZERO, 10.0, Some(3.0))), 3.0);
}

#[test]
fn the_strongest_suns_come_first_in_the_table() {
    let strengths = [1.0, 5.0, f32::NAN, 3.0, 4.0, 2.0];
    let mut lights: Vec<_> = strengths.into_iter().map(sun).collect();
    lights.insert(2, bulb(Vec3::ZERO, 1.0, None));
    let table = table(lights);
    assert_eq!(table.directional as usize, MAX_DIRECTIONAL_LIGHTS);
    let places = [None, Some(0), Some(4), None, Some(2), Some(1), Some(3)];
    assert_eq!(table.places, places);
    assert_eq!(table.entries(|_| None).len(), 5);
    assert_eq!(
        LightTable::new(&Surfaces::default(), &SpareCapacity::default()).entries(|_| None).len(),
        1,
        "something can be bound"
    );
}

#[test]
fn room_lies_behind_the_lights_of_the_scene_and_is_used_again() {
    let lights = vec![bulb(Vec3::X, 2.0, None), sun(1.0)];
    let spare = SpareCapacity { lights: 2, directional_lights: 1, ..Default::default() };
    let mut table = LightTable::new(&Surfaces { lights, ..Surfaces::default() }, &spare);
    assert_eq!((table.directional, table.dark_suns, table.entries(|_| None).len()), (2, 0, 5));
    assert!(table.get(LightId(1)).is_some() && table.get(LightId(2)).is_none());
    assert_eq!([LightKind::Point, LightKind::Directional].map(|kind| table.room(kind)), [2, 1]);
    assert_eq!(table.take(LightKind::Directional), Some(LightId(2)));
    assert_eq!(table.take(LightKind::Directional), None);
    let taken = [(); 3].map(|()| table.take(LightKind::Point));
    assert_eq!(taken, [Some(LightId(3)), Some(LightId(4)), None]);
    table.free(LightId(0));
    assert!(table.get(LightId(0)).is_none());
    assert_eq!(table.take(LightKind::Directional), None, "a sun has a place of its own");
    assert_eq!(table.take(LightKind::Point), Some(LightId(0)));
}

#[test]
fn a_sun_that_did_not_shine_leaves_no_room() {
    let mut table = table((0..5).map(|number| sun(5.0 - number as f32)).collect());
    for number in [4, 0] {
        table.lights[number] = dark_light(LightKind::Directional);
        table.free(LightId(number as u32));
    }
    assert_eq!(table.take(LightKind::Directional), Some(LightId(0)));
    assert_eq!(table.take(LightKind::Directional), None);
}
