//! Hosts with many pipelines. Objects have several draws of several instances in 1, 16 and 256
//! buckets. Images are compared with images of all draws, while many objects are added, removed and
//! moved at once.

mod boxes;
mod growth;
mod host;
mod mistakes;

use boxes::Part;
use cull::{Aabb, Camera, ObjectId, Projection, Strategy};
use glam::{Vec3, vec3};
use gpu::{Device, OptionalFeature, Predicates, PredicationMode};
use host::{Host, Recorder};
use occlusion::{DriverAssumption, DriverQuirks};
use tests::run_on_all;
use tests::walk::images_that_differ;
use tests::window_fixture::Random;

/// Returns the parts of an object: boxes around `middle`, some of which share a bucket.
fn parts(random: &mut Random, middle: Vec3, buckets: u32) -> Vec<Part> {
    let count = [1, 1, 2, 5][random.below(4) as usize];
    let draw = |random: &mut Random| {
        let bucket = random.below(buckets);
        // Several instances of one draw.
        let count = 1 + random.below(3);
        let instance = |random: &mut Random| {
            let at = |random: &mut Random| random.between(-0.4, 0.4);
            let low = middle + vec3(at(random), at(random), at(random));
            Aabb::new(low, low + random.between(0.1, 0.5))
        };
        Part { bucket, boxes: (0..count).map(|_| instance(random)).collect() }
    };
    (0..count).map(|_| draw(random)).collect()
}

/// Returns a place behind the wall. A few places are beside the wall and show.
fn behind(random: &mut Random) -> Vec3 {
    vec3(random.between(-8.0, 8.0), random.between(-4.0, 4.0), random.between(-20.0, -8.0))
}

/// Returns the wall, with one draw in the first bucket and one in the last.
fn wall(buckets: u32) -> Vec<Part> {
    let half = |bucket, low: f32, high: f32| {
        let bounds = Aabb::new(vec3(low, -3.0, -6.0), vec3(high, 3.0, -5.5));
        Part { bucket, boxes: vec![bounds] }
    };
    vec![half(0, -4.0, 0.0), half(buckets - 1, 0.0, 4.0)]
}

/// Changes many objects at once, differently in each frame. The wall is removed and added, too.
fn change(host: &mut Host, random: &mut Random, frame: u32, buckets: u32) {
    let some = |host: &Host, random: &mut Random, count: usize| -> Vec<ObjectId> {
        let all: Vec<ObjectId> = host.objects().filter(|id| *id != host.wall).collect();
        let first = random.below(all.len() as u32) as usize;
        all.iter().cycle().skip(first).take(count.min(all.len())).copied().collect()
    };
    match frame % 6 {
        1 => {
            let things = (0..60).map(|_| {
                let middle = behind(random);
                parts(random, middle, buckets)
            });
            let things: Vec<Vec<Part>> = things.collect();
            host.add(things);
        }
        2 => {
            let gone = some(host, random, 50);
            host.remove(&gone);
        }
        3 => {
            let by = vec3(random.between(-2.0, 2.0), random.between(-1.0, 1.0), 0.0);
            let moved = some(host, random, 80);
            host.move_by(&moved, by);
        }
        4 => {
            for object in some(host, random, 40) {
                let middle = behind(random);
                let parts = parts(random, middle, buckets);
                host.replace(object, parts);
            }
        }
        5 if frame % 12 == 5 => {
            host.remove(&[host.wall]);
        }
        5 => host.wall = host.add(vec![wall(buckets)])[0],
        _ => {}
    }
}

/// Returns a host with a wall, and with objects and panes behind it.
fn furnished(
    device: &Device,
    buckets: u32,
    predication: PredicationMode,
    recorder: Recorder,
    random: &mut Random,
) -> Host {
    furnish(Host::new(device, buckets, predication, recorder), buckets, random)
}

/// Adds a wall, objects and panes to a host.
fn furnish(mut host: Host, buckets: u32, random: &mut Random) -> Host {
    let things = |random: &mut Random, count: usize| -> Vec<Vec<Part>> {
        let thing = |random: &mut Random| {
            let middle = behind(random);
            parts(random, middle, buckets)
        };
        (0..count).map(|_| thing(random)).collect()
    };
    let first = things(random, 110);
    host.wall = host.add(vec![wall(buckets)])[0];
    host.add(first);
    host.add_glass(things(random, 30));
    host
}

/// Returns a camera beside the wall, on a side from -1 to 1, that looks along it.
fn camera(side: f32, along: f32) -> Camera {
    let eye = vec3(side * 7.0 + along, 0.0, 3.0);
    let projection = Projection::perspective(0.9);
    Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, projection, near: 0.1 }
}

/// Draws frames while the eye jumps from side to side, and compares each with all draws.
fn compare(
    device: &Device,
    buckets: u32,
    predication: PredicationMode,
    recorder: Recorder,
    strategy: Strategy,
) {
    const FRAMES: u32 = 15;
    let mut random = Random::new(u64::from(buckets) + 7);
    let mut host = furnished(device, buckets, predication, recorder, &mut random);
    for frame in 0..FRAMES {
        change(&mut host, &mut random, frame, buckets);
        let side = (frame / 5 % 3) as f32 - 1.0;
        host.draw(strategy, &camera(side, frame as f32 * 0.05));
    }
    device.wait_idle().unwrap();
    let what = format!("{strategy}, {buckets} buckets, {}, {recorder:?}", predication.name());
    for (frame, [culled, all]) in host.images.iter().enumerate() {
        assert_eq!(images_that_differ(culled, all), 0, "frame {frame} of {what}");
    }
    let listed = host.listed();
    let (drawn, there) = host.fewest_and_all();
    assert!(drawn > 0 && drawn < there / 2, "{drawn} of {there} draws, {what}");
    let has_counts = device.capabilities().has(OptionalFeature::DrawIndirectCount);
    let are_listed = recorder == Recorder::Host && has_counts;
    assert_eq!(listed > 0, are_listed, "{what}");
    assert!(listed < u64::from(FRAMES) * there / 3, "{listed} of {there} draws, {what}");
}

fn executors(device: &Device) -> Vec<PredicationMode> {
    let all = PredicationMode::ALL;
    all.into_iter()
        .filter(|predication| Predicates::linked(device, Some(*predication), 1, 1).is_ok())
        .collect()
}

#[test]
fn objects_of_any_draws_in_any_buckets_look_like_all_draws_while_they_change() {
    run_on_all(|device| {
        let executors = executors(device);
        for buckets in [1, 16, 256] {
            compare(device, buckets, executors[0], Recorder::Engine, Strategy::ANTUMBRA);
        }
        for predication in &executors[1..] {
            compare(device, 16, *predication, Recorder::Engine, Strategy::ANTUMBRA);
        }
        // The plain strategy already uses flags.
        for strategy in [Strategy::ANTUMBRA_QUERIES, Strategy::ANTUMBRA_COMPUTE] {
            let last = executors[executors.len() - 1];
            compare(device, 16, last, Recorder::Engine, strategy);
        }
    });
}

#[test]
fn transparent_objects_are_drawn_untested_where_flags_are_distrusted() {
    run_on_all(|device| {
        let mut random = Random::new(7);
        let buckets = 3;

        let quirks = DriverQuirks::new(&[DriverAssumption::FlagWrites]);
        let mut host = furnish(
            Host::with_quirks(
                device,
                buckets,
                PredicationMode::Instances,
                Recorder::Engine,
                quirks,
            ),
            buckets,
            &mut random,
        );
        for frame in 0..6 {
            host.draw(Strategy::ANTUMBRA, &camera(frame as f32 / 5.0 - 0.5, 0.0));
        }
        device.wait_idle().unwrap();
        for (frame, [culled, all]) in host.images.iter().enumerate() {
            assert_eq!(images_that_differ(culled, all), 0, "frame {frame}");
        }
    });
}

#[test]
fn draws_that_a_host_records_from_lists_look_like_all_draws() {
    run_on_all(|device| {
        let executors = executors(device);
        let first = executors[0];
        let last = executors[executors.len() - 1];
        for (buckets, predication, strategy) in [
            (1, first, Strategy::ANTUMBRA),
            (16, last, Strategy::ANTUMBRA_QUERIES),
            (16, last, Strategy::ANTUMBRA_COMPUTE),
            (256, last, Strategy::ANTUMBRA),
        ] {
            compare(device, buckets, predication, Recorder::Host, strategy);
        }
    });
}

#[test]
fn a_host_that_draws_depth_first_shades_what_shows_and_nothing_else() {
    run_on_all(|device| {
        let executors = executors(device);
        let first = executors[0];
        let last = executors[executors.len() - 1];
        for (buckets, predication, strategy) in [
            (1, first, Strategy::ANTUMBRA),
            (16, last, Strategy::ANTUMBRA),
            (16, first, Strategy::ANTUMBRA_QUERIES),
        ] {
            compare(device, buckets, predication, Recorder::EngineDepthFirst, strategy);
        }
    });
}

#[test]
fn a_host_that_draws_visible_objects_alone_is_right_again_when_all_stands_still() {
    run_on_all(|device| {
        let mut random = Random::new(11);
        let predication = executors(device)[0];
        let mut host = furnished(device, 16, predication, Recorder::HostLate, &mut random);
        for frame in 0..24 {
            let side = if frame < 12 { -1.0 } else { 1.0 };
            host.draw(Strategy::ANTUMBRA, &camera(side, 0.0));
        }
        device.wait_idle().unwrap();
        let wrong = host.images.iter().map(|[culled, all]| images_that_differ(culled, all));
        let wrong: Vec<_> = wrong.collect();
        assert!(wrong[12] > 0, "nothing came into view: {wrong:?}");
        assert_eq!([wrong[11], wrong[23]], [0, 0], "{wrong:?}");
    });
}
