//! Tests of light lists in scenes with very many lights: they are the lists found by testing all
//! lights, with limited work and memory.

use cull::{Aabb, Hierarchy};
use glam::{Vec3, vec3};
use scene::limits::MAX_LIGHTS_PER_OBJECT;
use scene::{LightKind, PunctualLight, Surfaces};

use super::light_lists::{LEAST_VISITS, LightLists, MOST_VISITS, VISITS_A_FRAME};
use super::light_tree::{LightTree, Reach};
use super::lights::{LightTable, is_bright, reach_m, strongest_part};
use crate::resources::spare_capacity::SpareCapacity;

/// A generator of numbers in `0.0..1.0` from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn place(&mut self, size: f32) -> Vec3 {
        vec3(self.next(), self.next(), self.next()) * size
    }

    fn chance(&mut self, share: f32) -> bool {
        self.next() < share
    }
}

fn bulb(position: Vec3, candela: f32, range_m: Option<f32>) -> PunctualLight {
    PunctualLight {
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: candela,
        range_m,
        position,
        direction: Vec3::NEG_Z,
        cookie: None,
    }
}

/// Returns a common kind of light, or a degenerate one.
fn any_light(random: &mut Random) -> PunctualLight {
    // Many lights share a position, and many are equally strong.
    let position =
        if random.chance(0.3) { random.place(4.0).round() * 10.0 } else { random.place(60.0) };
    let candela = if random.chance(0.3) { 5.0 } else { random.next() * 2000.0 };
    let range_m = random.chance(0.7).then(|| random.next() * 20.0);
    let light = bulb(position, candela, range_m);
    match (random.next() * 40.0) as u32 {
        0 => PunctualLight { kind: LightKind::Directional, ..light },
        1 => PunctualLight { intensity: 0.0, ..light },
        2 => PunctualLight { position: Vec3::splat(f32::NAN), ..light },
        3 => PunctualLight { intensity: f32::MAX, range_m: None, ..light },
        4 => PunctualLight { position: Vec3::splat(3.0e38), ..light },
        5 => PunctualLight { intensity: 3.0e38, colour: [4.0; 3], ..light },
        _ => light,
    }
}

fn any_box(random: &mut Random) -> Aabb {
    let corner = random.place(60.0);
    let size = if random.chance(0.1) { 40.0 } else { 2.0 };
    Aabb::new(corner, corner + random.place(size))
}

fn table(lights: &[PunctualLight]) -> LightTable {
    LightTable::new(
        &Surfaces { lights: lights.to_vec(), ..Surfaces::default() },
        &SpareCapacity::default(),
    )
}

/// Returns all lights that reach a box, from the strongest on.
fn plain(lights: &[PunctualLight], table: &LightTable, bounds: &Aabb) -> Vec<u32> {
    let mut found: Vec<(f32, u32)> = lights
        .iter()
        .zip(&table.places)
        .filter(|(light, _)| light.kind == LightKind::Point && is_bright(light))
        .filter_map(|(light, place)| {
            let distance_squared = bounds.distance_squared(light.position);
            let reaches = distance_squared <= reach_m(light) * reach_m(light);
            let lux = strongest_part(light) / distance_squared.max(1.0e-4);
            Some((lux, (*place)?)).filter(|_| reaches)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(_, place)| place).collect()
}

fn assert_plain(lists: &LightLists, lights: &[PunctualLight], table: &LightTable, boxes: &[Aabb]) {
    let mut crowded = 0;
    for (slot, bounds) in (0..).zip(boxes) {
        let mut expected = plain(lights, table, bounds);
        crowded += usize::from(expected.len() > MAX_LIGHTS_PER_OBJECT);
        expected.truncate(MAX_LIGHTS_PER_OBJECT);
        assert_eq!(lists.entries(slot), expected, "{slot}");
    }
    assert_eq!(lists.crowded(), crowded);
}

#[test]
fn lists_are_those_found_the_plain_way_whatever_changes() {
    let mut all_crowded = Vec::new();
    for seed in 0..40 {
        let random = &mut Random(seed);
        let light_count = 1 << (seed % 11);
        let box_count = 60;
        let mut lights: Vec<_> = (0..light_count).map(|_| any_light(random)).collect();
        let mut boxes: Vec<_> = (0..box_count).map(|_| any_box(random)).collect();
        let table = table(&lights);
        let mut hierarchy = Hierarchy::build(&boxes).unwrap();
        let mut lists = LightLists::new(&table, boxes.len());
        lists.fill(&hierarchy, 0);
        assert_plain(&lists, &lights, &table, &boxes);
        // In small scenes, more replacements than lights, so that the tree is built again.
        for _ in 0..100 {
            let light = (random.next() * light_count as f32) as usize;
            let now = PunctualLight { kind: lights[light].kind, ..any_light(random) };
            lights[light] = now;
            for (centre, radius_m) in lists.replace(light, table.places[light], &now) {
                lists.doubt(&hierarchy, 0, centre, radius_m);
            }
            let moved = (random.next() * box_count as f32) as usize;
            boxes[moved] = any_box(random);
            hierarchy.refit([(cull::ObjectId(moved as u32), boxes[moved])]).unwrap();
            lists.find(moved as u32, &boxes[moved]);
        }
        for slot in lists.take_doubtful() {
            lists.find(slot, &boxes[slot as usize]);
        }
        assert_plain(&lists, &lights, &table, &boxes);
        all_crowded.push(lists.crowded());
    }
    assert!(all_crowded.contains(&0));
    assert!(all_crowded.iter().any(|crowded| *crowded > 40), "{all_crowded:?}");
}

fn tree(lights: &[PunctualLight]) -> LightTree {
    LightTree::new((0..).zip(lights).map(|(place, light)| Reach::of(light, Some(place))).collect())
}

/// Returns the highest number of nodes that a search visits, over many boxes.
fn most_visits(lights: &[PunctualLight], random: &mut Random) -> usize {
    let tree = tree(lights);
    let visits = |_| tree.strongest(&any_box(random), usize::MAX).visits;
    (0..500).map(visits).max().unwrap()
}

#[test]
fn a_search_asks_few_of_many_lights() {
    let random = &mut Random(7);
    let count = 40_000;
    let lights = |make: &mut dyn FnMut() -> PunctualLight| -> Vec<PunctualLight> {
        (0..count).map(|_| make()).collect()
    };
    let in_one_place = lights(&mut || bulb(Vec3::ONE, 1000.0, None));
    let far_reaching = lights(&mut || bulb(random.place(60.0), 1000.0, None));
    let unequal = lights(&mut || bulb(random.place(60.0), random.next() * 1000.0, None));
    let near = lights(&mut || bulb(random.place(60.0), 10.0, Some(0.5)));
    for (name, lights, most) in [
        ("in one place", in_one_place, 100),
        ("far reaching", far_reaching, 2000),
        ("unequal", unequal, 2000),
        ("near", near, 2000),
    ] {
        let visits = most_visits(&lights, random);
        assert!(visits <= most, "{name}: {visits}");
    }
}

/// Returns lights around a point that end just short of it: a tree of boxes must test nearly all of
/// them.
fn shell(count: usize, random: &mut Random) -> Vec<PunctualLight> {
    let light = |_| {
        let direction = (random.place(2.0) - Vec3::ONE).normalize_or(Vec3::X);
        bulb(direction * 100.0, 10.0, Some(98.999))
    };
    (0..count).map(light).collect()
}

#[test]
fn no_search_and_no_frame_asks_more_than_it_may() {
    let random = &mut Random(11);
    let lights = shell(50_000, random);
    let bounds = Aabb::new(Vec3::splat(-0.5), Vec3::splat(0.5));
    let whole = tree(&lights).strongest(&bounds, usize::MAX);
    assert!(whole.visits > 20_000 && !whole.leaves_out, "or this would prove nothing: {whole:?}");
    let cut = tree(&lights).strongest(&bounds, 1000);
    assert!(cut.visits == 1000 && cut.leaves_out, "it says that it may have missed some");

    let boxes = vec![bounds; 20_000];
    let mut lists = LightLists::new(&table(&lights), boxes.len());
    lists.fill(&Hierarchy::build(&boxes).unwrap(), 0);
    assert!(lists.visits() <= VISITS_A_FRAME + MOST_VISITS + boxes.len() * LEAST_VISITS);
    lists.submitted();
    assert_eq!(lists.visits(), 0, "the next frame has as many again");
}

#[test]
fn many_lights_that_change_are_one_search_an_object_and_frame() {
    let lights: Vec<_> = (0..5000).map(|_| bulb(Vec3::ONE, 1000.0, None)).collect();
    let random = &mut Random(3);
    let boxes: Vec<_> = (0..3000).map(|_| any_box(random)).collect();
    let hierarchy = Hierarchy::build(&boxes).unwrap();
    let mut lists = LightLists::new(&table(&lights), boxes.len());
    lists.fill(&hierarchy, 0);
    lists.submitted();
    assert_eq!(lists.crowded(), boxes.len());
    let mut asked = 0;
    for _ in 0..3 {
        // Simulates changes without frames.
        for (place, light) in (0..).zip(&lights) {
            for (centre, radius_m) in lists.replace(place as usize, Some(place), light) {
                lists.doubt(&hierarchy, 0, centre, radius_m);
            }
        }
        let visits = lists.doubt_visits();
        assert!(visits <= 4 * boxes.len() + 1000 + hierarchy.node_count(), "{visits}");
    }
    for slot in lists.take_doubtful() {
        lists.find(slot, &boxes[slot as usize]);
        asked += 1;
    }
    assert_eq!(asked, boxes.len());
    assert!(lists.visits() <= 100 * boxes.len(), "{}", lists.visits());
}
