//! Compares the cache with maps that are drawn afresh. Maps are simulated as the sets of casters
//! that were drawn to them, over a thousand seeded frames. Objects and lights move, rest, appear
//! and vanish.
#![allow(clippy::expect_used, reason = "a test fails by panicking")]

use std::collections::{BTreeSet, HashMap};

use antumbra_shadows::{
    Casters, FaceWork, LightShape, ShadowCache, ShadowCaching, ShadowLight, ShadowLightId,
    ShadowMethod, ShadowOptions, ShadowPlan, ShadowViews, Tile,
};
use cull::{Aabb, BoxChange, Hierarchy, LeafIndex, ObjectId};
use glam::{Vec3, vec3};

/// A small generator of numbers that look random.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        ((self.0 >> 33) % u64::from(end)) as u32
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    fn place(&mut self) -> Aabb {
        let low = vec3(self.unit() * 60.0, self.unit() * 6.0, self.unit() * 60.0);
        Aabb::new(low, low + vec3(0.2, 0.2, 0.2) + 2.0 * self.unit())
    }
}

type Drawn = BTreeSet<(ObjectId, u32)>;

/// The contents of the texels of each tile, as an executor leaves them.
#[derive(Default)]
struct Maps {
    maps: HashMap<Tile, Drawn>,
    resting: HashMap<Tile, Drawn>,
    drawn: u64,
}

/// The existing objects, and how often each has changed.
struct World {
    hierarchy: Hierarchy,
    versions: Vec<u32>,
    changes: Vec<BoxChange>,
}

impl World {
    fn new(random: &mut Random) -> Self {
        let mut boxes: Vec<Aabb> = (0..200).map(|_| random.place()).collect();
        boxes.resize(230, Aabb::EMPTY);
        let hierarchy = Hierarchy::build(&boxes).expect("usable boxes");
        Self { hierarchy, versions: vec![0; boxes.len()], changes: Vec::new() }
    }

    fn bounds(&self, object: ObjectId) -> Aabb {
        self.hierarchy.node_of(object).map_or(Aabb::EMPTY, |node| self.hierarchy.bounds(node))
    }

    fn change(&mut self, object: ObjectId, before: Aabb) {
        let after = self.bounds(object);
        self.versions[object.0 as usize] += 1;
        self.changes.push(BoxChange { object, before, after });
    }

    fn move_to(&mut self, object: ObjectId, to: Aabb) {
        let before = self.bounds(object);
        if !before.is_empty() {
            self.hierarchy.refit([(object, to)]).expect("it is there");
            self.change(object, before);
        }
    }

    /// Makes the changes of one frame: a few objects always move, the others now and then.
    fn step(&mut self, frame: u32, random: &mut Random) {
        self.changes.clear();
        if frame % 100 > 70 {
            return;
        }
        for object in 0..6 {
            let to = random.place();
            self.move_to(ObjectId(object), to);
        }
        if random.below(10) == 0 {
            let object = ObjectId(random.below(200));
            let to = random.place();
            self.move_to(object, to);
        }
        if random.below(20) == 0 {
            let object = ObjectId(random.below(200));
            let before = self.bounds(object);
            if !before.is_empty() {
                self.hierarchy.remove(object).expect("it is there");
                self.change(object, before);
            }
        }
        if random.below(20) == 0
            && let Ok(object) = self.hierarchy.insert(random.place())
        {
            self.change(object, Aabb::EMPTY);
        }
        if random.below(8) == 0 {
            self.hierarchy.rebuild_subtrees(&mut Vec::new());
        }
    }

    fn drawn(&self, leaves: &[LeafIndex]) -> Drawn {
        let object = |leaf: &LeafIndex| self.hierarchy.leaf_objects()[leaf.0 as usize];
        leaves.iter().map(object).map(|leaf| (leaf, self.versions[leaf.0 as usize])).collect()
    }
}

impl Maps {
    /// Executes a plan, and compares every map with one that is drawn afresh.
    fn execute(&mut self, plan: &ShadowPlan, world: &World) {
        for planned in &plan.faces {
            let casters =
                |range: &std::ops::Range<usize>| world.drawn(&plan.casters[range.clone()]);
            let tile = planned.tile;
            match &planned.work {
                FaceWork::Keep => {}
                FaceWork::Cull(_) => unreachable!("nothing may be culled"),
                FaceWork::Draw(all) => {
                    self.maps.insert(tile, casters(all));
                }
                FaceWork::Layered { resting, moving } => {
                    if let Some(resting) = resting {
                        self.resting.insert(tile, casters(resting));
                    }
                    let mut map = self.resting[&tile].clone();
                    map.extend(casters(moving));
                    self.maps.insert(tile, map);
                }
            }
            let mut afresh = Vec::new();
            planned.face.casters(&world.hierarchy, &mut afresh);
            assert_eq!(self.maps[&tile], world.drawn(&afresh), "{:?}", planned.face.id);
        }
        self.drawn += plan.casters.len() as u64;
    }
}

fn lights(frame: u32) -> Vec<ShadowLight> {
    let light = |id, shape| ShadowLight { id: ShadowLightId(id), shape, penumbra_m: 0.3 };
    let towards = vec3(0.3, 0.9, 0.2).normalize();
    let mut lights = vec![light(0, LightShape::Sun { towards })];
    for lamp in 0..5 {
        let position = vec3(10.0 * lamp as f32 + 5.0, 5.0, 30.0);
        let direction = Vec3::NEG_Y;
        let shape = match lamp % 2 {
            0 => LightShape::Point { position, reach_m: 12.0 },
            _ => LightShape::Spot { position, direction, outer_rad: 0.7, reach_m: 15.0 },
        };
        // One light is off for a while, and one moves.
        let moved = position + Vec3::X * (frame / 50) as f32;
        match lamp {
            3 if frame % 120 > 90 => {}
            4 => lights.push(light(5, LightShape::Point { position: moved, reach_m: 8.0 })),
            _ => lights.push(light(1 + lamp, shape)),
        }
    }
    lights
}

fn options(caching: ShadowCaching) -> ShadowOptions {
    let method = ShadowMethod::Maps;
    ShadowOptions {
        method,
        caching,
        cascades: 3,
        distance_m: Some(60.0),
        ..ShadowOptions::default()
    }
}

/// Returns the number of casters drawn over all frames.
fn walk(seed: u64, caching: ShadowCaching, lost_frames: bool) -> u64 {
    let mut random = Random(seed);
    let mut world = World::new(&mut random);
    let mut cache = ShadowCache::new(options(caching));
    let mut plan = ShadowPlan::default();
    let mut maps = Maps::default();
    for frame in 0..1000 {
        world.step(frame, &mut random);
        let eyes = [vec3(20.0 + 0.02 * frame as f32, 1.7, 25.0), vec3(40.0, 3.0, 10.0)];
        let eyes = &eyes[..1 + (frame / 300 % 2) as usize];
        let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&world.changes) };
        let eyes = ShadowViews { eyes, sub_pixel_bits: 8, drawn_share: None };
        cache.plan(&lights(frame), &casters, &eyes, &mut plan);
        if lost_frames && frame % 37 == 5 {
            // This plan is neither drawn nor submitted.
            continue;
        }
        maps.execute(&plan, &world);
        cache.submitted();
    }
    maps.drawn
}

#[test]
fn cached_maps_hold_what_maps_that_are_drawn_afresh_hold() {
    for seed in 1..4 {
        let cached = walk(seed, ShadowCaching::Cached, false);
        let uncached = walk(seed, ShadowCaching::Uncached, false);
        assert!(cached * 5 < uncached, "{cached} draws of {uncached}");
    }
}

#[test]
fn frames_that_are_never_submitted_lose_nothing() {
    walk(9, ShadowCaching::Cached, true);
}

#[test]
fn unknown_changes_draw_everything() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    let mut cache = ShadowCache::new(options(ShadowCaching::Cached));
    let mut plan = ShadowPlan::default();
    let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share: None };
    let mut drawn_faces = |changes| {
        let casters = Casters { hierarchy: &world.hierarchy, changes };
        cache.plan(&lights(0), &casters, &eyes, &mut plan);
        cache.submitted();
        (plan.stats().drawn_faces, plan.stats().faces)
    };
    let (first, faces) = drawn_faces(Some(&[]));
    assert_eq!(first, faces);
    assert_eq!(drawn_faces(Some(&[])), (0, faces));
    assert_eq!(drawn_faces(None), (faces, faces));
}

#[test]
fn lights_beyond_the_room_get_smaller_maps_and_then_none() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    let options = ShadowOptions { layers_max: 1, sun_side: 256, ..options(ShadowCaching::Cached) };
    let mut cache = ShadowCache::new(options);
    let mut plan = ShadowPlan::default();
    let lamps: Vec<ShadowLight> = (0..400)
        .map(|lamp| ShadowLight {
            id: ShadowLightId(lamp),
            shape: LightShape::Point { position: vec3(lamp as f32 % 60.0, 4.0, 9.0), reach_m: 5.0 },
            penumbra_m: 0.1,
        })
        .collect();
    let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&[]) };
    let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share: None };
    cache.plan(&lamps, &casters, &eyes, &mut plan);
    let stats = plan.stats();
    assert_eq!(stats.lights + stats.unshadowed_lights, 400);
    assert!(stats.lights > 0 && stats.unshadowed_lights > 0, "{stats:?}");
    let tiles: BTreeSet<_> =
        plan.faces.iter().map(|face| (face.tile.layer, face.tile.origin)).collect();
    assert_eq!((tiles.len(), plan.layers), (plan.faces.len(), 1));
}

#[test]
fn maps_grow_again_when_there_is_room() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    // The maps of two lamps fill three layers; the maps of the third lamp are smaller, in the
    // fourth layer.
    let options = ShadowOptions { layers_max: 4, sun_side: 512, ..options(ShadowCaching::Cached) };
    let mut cache = ShadowCache::new(options);
    let mut plan = ShadowPlan::default();
    let position = |lamp| vec3(lamp as f32 % 60.0, 4.0, 9.0);
    let lamps: Vec<ShadowLight> = (0..3)
        .map(|lamp| ShadowLight {
            id: ShadowLightId(lamp),
            shape: LightShape::Point { position: position(lamp), reach_m: 5.0 },
            penumbra_m: 0.1,
        })
        .collect();
    let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&[]) };
    let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share: None };
    let mut side_of_last = |lamps: &[ShadowLight]| {
        cache.plan(lamps, &casters, &eyes, &mut plan);
        cache.submitted();
        plan.faces.last().map(|face| face.tile.side)
    };
    assert_eq!(side_of_last(&lamps), Some(128));
    assert_eq!(side_of_last(&lamps), Some(128), "nothing went");
    let alone = &lamps[2..];
    assert_eq!(side_of_last(alone), Some(256));
    cache.limit_layers(0);
    cache.plan(alone, &casters, &eyes, &mut plan);
    assert_eq!((plan.faces.len(), plan.unshadowed_lights), (0, 1), "no room is no shadow");
}

#[test]
fn impossible_lights_have_no_maps() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    let mut cache = ShadowCache::new(options(ShadowCaching::Cached));
    let mut plan = ShadowPlan::default();
    let nowhere = Vec3::splat(f32::NAN);
    let shapes = [
        LightShape::Sun { towards: nowhere },
        LightShape::Sun { towards: Vec3::ZERO },
        LightShape::Point { position: nowhere, reach_m: 5.0 },
        LightShape::Point { position: Vec3::ZERO, reach_m: 0.0 },
        LightShape::Point { position: Vec3::ZERO, reach_m: f32::NAN },
        LightShape::Point { position: Vec3::ZERO, reach_m: f32::INFINITY },
        LightShape::Spot {
            position: Vec3::ZERO,
            direction: Vec3::ZERO,
            outer_rad: 0.5,
            reach_m: 3.0,
        },
        LightShape::Spot { position: Vec3::ZERO, direction: Vec3::X, outer_rad: 0.0, reach_m: 3.0 },
    ];
    let lights: Vec<ShadowLight> = (0..)
        .map(ShadowLightId)
        .zip(shapes)
        .map(|(id, shape)| ShadowLight { id, shape, penumbra_m: 0.1 })
        .collect();
    let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&[]) };
    cache.plan(
        &lights,
        &casters,
        &ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share: None },
        &mut plan,
    );
    assert_eq!((plan.lights.len(), plan.faces.len()), (0, 0));
}

#[test]
fn maps_of_a_light_that_keeps_moving_are_culled_and_whole_once_it_rests() {
    let mut random = Random(5);
    let world = World::new(&mut random);
    let mut cache = ShadowCache::new(options(ShadowCaching::Cached));
    let mut plan = ShadowPlan::default();
    let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&[]) };
    let mut work = |step: u32, drawn_share| {
        let position = vec3(20.0 + step as f32, 4.0, 9.0);
        let shape = LightShape::Point { position, reach_m: 9.0 };
        let lamp = ShadowLight { id: ShadowLightId(0), shape, penumbra_m: 0.1 };
        let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share };
        cache.plan(&[lamp], &casters, &eyes, &mut plan);
        cache.submitted();
        let stats = plan.stats();
        [stats.culled_faces, stats.drawn_faces]
    };
    let all = Some(1.0);
    assert_eq!(work(0, all), [0, 6], "it may rest from now on");
    assert_eq!(work(1, all), [0, 6]);
    assert_eq!(work(2, all), [6, 6], "the second move in a row");
    assert_eq!(work(3, all), [6, 6]);
    assert_eq!(work(4, None), [0, 6], "a frame of two views");
    assert_eq!(work(5, all), [6, 6]);
    assert_eq!(work(5, all), [0, 6], "maps without all casters are not kept");
    assert_eq!(work(5, all), [0, 0]);
    // A third of the casters in each of two frames, then all of them.
    let third = Some(0.33);
    assert_eq!(work(6, third), [6, 6]);
    assert_eq!(work(6, third), [6, 6]);
    assert_eq!(work(6, third), [0, 6]);
    assert_eq!(work(6, third), [0, 0]);
    for step in 7..20 {
        assert_eq!([work(step, third), work(step, third)], [[6, 6]; 2], "it moves in time");
    }
    assert_eq!(work(20, None), [0, 6], "a frame of two views");
    assert_eq!(work(20, third), [0, 0]);
    let culled = (0..99).take_while(|_| work(21, Some(0.0))[0] == 6);
    assert_eq!(culled.count(), 15, "nothing to draw at all");
}

#[test]
fn maps_of_which_all_casters_move_are_culled_in_most_frames() {
    let mut random = Random(5);
    let world = World::new(&mut random);
    let mut cache = ShadowCache::new(options(ShadowCaching::Cached));
    let mut plan = ShadowPlan::default();
    let objects = (0..200).map(ObjectId);
    let moved = objects.map(|object| {
        let bounds = world.bounds(object);
        BoxChange { object, before: bounds, after: bounds }
    });
    let moved: Vec<BoxChange> = moved.collect();
    let mut work = |changes, drawn_share| {
        let shape = LightShape::Point { position: vec3(20.0, 4.0, 9.0), reach_m: 90.0 };
        let lamp = ShadowLight { id: ShadowLightId(0), shape, penumbra_m: 0.1 };
        let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share };
        let casters = Casters { hierarchy: &world.hierarchy, changes: Some(changes) };
        cache.plan(&[lamp], &casters, &eyes, &mut plan);
        cache.submitted();
        let stats = plan.stats();
        [stats.culled_faces, stats.drawn_faces]
    };
    let third = Some(0.33);
    for round in 0..4 {
        let frames = [work(&moved, third), work(&moved, third), work(&moved, third)];
        // A face without casters is kept from the first round on.
        let drawn = if round == 0 { 6 } else { 5 };
        assert_eq!(frames, [[drawn, drawn], [drawn, drawn], [0, drawn]], "round {round}");
    }
    assert_eq!(work(&[], third), [0, 0], "all is there, and nothing moved");
    assert_eq!(work(&moved, None), [0, 5], "a frame of two views");
}

#[test]
fn a_light_without_room_gets_maps_when_another_needs_less() {
    let mut random = Random(3);
    let world = World::new(&mut random);
    let options = ShadowOptions {
        layers_max: 1,
        sun_side: 256,
        spot_side: 512,
        ..options(ShadowCaching::Cached)
    };
    let mut cache = ShadowCache::new(options);
    let mut plan = ShadowPlan::default();
    let casters = Casters { hierarchy: &world.hierarchy, changes: Some(&[]) };
    let eyes = ShadowViews { eyes: &[Vec3::ZERO], sub_pixel_bits: 8, drawn_share: None };
    let position = vec3(20.0, 4.0, 9.0);
    let direction = Vec3::NEG_Y;
    let light = |id, shape| ShadowLight { id: ShadowLightId(id), shape, penumbra_m: 0.1 };
    let spot = |id, outer_rad| {
        light(id, LightShape::Spot { position, direction, outer_rad, reach_m: 5.0 })
    };
    let mut sides = |first: ShadowLight| {
        cache.plan(&[first, spot(1, 0.5)], &casters, &eyes, &mut plan);
        cache.submitted();
        (plan.unshadowed_lights, plan.stats().drawn_faces)
    };
    // One map fills the layer.
    assert_eq!(sides(spot(0, 0.5)), (1, 1));
    assert_eq!(sides(spot(0, 0.5)), (1, 0), "the other does not try again");
    // Six maps of 256 texels do not fit: it has smaller ones, and leaves room.
    assert_eq!(sides(light(0, LightShape::Point { position, reach_m: 5.0 })).0, 1);
    assert_eq!(sides(light(0, LightShape::Point { position, reach_m: 5.0 })).0, 0);
}
