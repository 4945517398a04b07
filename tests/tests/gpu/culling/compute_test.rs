//! The compute tester against the rasteriser. It never hides a box that a query on the proxy shows,
//! and hides most of the boxes that the query hides.

use cull::{Aabb, Camera, CullView, Projection, ProjectionKind, Rays};
use glam::{Vec2, Vec3};
use gpu::{
    Access, Buffer, Device, FrameRing, MemoryBarrier, MemoryKind, QueryIndex, QueryRing,
    SampleCount, Target, vk,
};
use occlusion::{ComputeTest, ComputeTestIo, ProxyBox, ProxyIo, ProxyPass, Rect, ShaderSet};
use tests::shapes::{DepthBoxes, box_at};
use tests::window_fixture::Random;
use tests::{Driver, run};

/// Returns a number spread evenly over orders of magnitude.
fn scale(random: &mut Random, low: f32, high: f32) -> f32 {
    low * (high / low).powf(random.part())
}

fn vector(random: &mut Random, low: f32, high: f32) -> Vec3 {
    Vec3::from([(); 3].map(|()| random.between(low, high)))
}

/// Occluders, boxes to test, and the eye.
struct World {
    camera: Camera,
    occluders: Vec<Aabb>,
    tested: Vec<Aabb>,
}

const TESTS: usize = 150;

impl World {
    /// Creates a world around `origin`, since small numbers round differently from large ones.
    fn new(random: &mut Random, origin: Vec3) -> Self {
        let eye = origin + vector(random, -1.0, 1.0);
        let projection = if random.part() < 0.5 {
            Projection::perspective(random.between(0.3, 2.0))
        } else {
            Projection::Orthographic { height: scale(random, 4.0, 60.0), far: 300.0 }
        };
        let camera = Camera {
            eye,
            forward: vector(random, -1.0, 1.0) + Vec3::new(0.0, 0.0, 0.01),
            up: vector(random, -1.0, 1.0),
            projection,
            near: scale(random, 0.01, 0.3),
        };
        let seen = CullView::new(&camera, [64, 64], 8).rays;
        let place = |random: &mut Random, nearest: f32, farthest: f32| {
            let distance = scale(random, nearest, farthest);
            let ndc = Vec2::new(random.between(-0.9, 0.9), random.between(-0.9, 0.9));
            let size = Vec3::splat(seen.down.length() * seen.kind.w(distance));
            (seen.point(ndc, distance), size)
        };
        let occluders = (0..30).map(|_| {
            let (centre, size) = place(random, 3.0, 30.0);
            box_at(centre, size * vector(random, 0.05, 0.5))
        });
        let occluders = occluders.collect();
        let tested = (0..TESTS).map(|number| {
            let (centre, size) = place(random, 5.0, 200.0);
            let largest = [0.02, 0.2, 1.5][number % 3];
            let half = size * vector(random, 0.0, largest);
            // Some are flat.
            box_at(
                centre,
                half * [Vec3::ONE, Vec3::new(1.0, 0.0, 1.0)][usize::from(number % 5 == 0)],
            )
        });
        Self { camera, occluders, tested: tested.collect() }
    }

    /// Returns the same boxes, each behind a smaller copy of its proxy as seen from the eye. The
    /// copy covers the proxy except for less than a pixel, so rounding decides.
    fn close_calls(random: &mut Random, size: [u32; 2], bits: u32) -> Self {
        let world = Self::new(random, Vec3::ZERO);
        let view = CullView::new(&world.camera, size, bits);
        let tested = world.tested.into_iter().step_by(10);
        let mut occluders = Vec::new();
        let mut kept = Vec::new();
        for bounds in tested {
            let Some(proxy) = view.margin.proxy(&bounds) else { continue };
            let Rays { kind, origin, forward, down, .. } = view.rays;
            // Nearer along the rays, and smaller if the rays meet.
            let copy = match kind {
                ProjectionKind::Perspective => {
                    let towards = |point: Vec3| origin + (point - origin) * 0.7;
                    Aabb::new(towards(proxy.min), towards(proxy.max))
                }
                ProjectionKind::Orthographic => {
                    let nearer = forward * (view.rays.distance(&proxy) * 0.3);
                    Aabb::new(proxy.min - nearer, proxy.max - nearer)
                }
            };
            let distance = view.rays.depth_m(copy.centre());
            let pixel = 2.0 * down.length() / size[1] as f32 * kind.w(distance);
            occluders.push(copy.enlarged(random.between(-0.15, 0.15) * pixel));
            kept.push(bounds);
        }
        Self { camera: world.camera, occluders, tested: kept }
    }
}

/// Returns the results of both testers for each box of each world: samples of the query, result of
/// the compute tester.
fn compare(device: &Device, size: [u32; 2], worlds: &[World]) -> Vec<(u32, u32)> {
    compare_in(device, Target::new(device, size, "target").unwrap(), worlds)
}

fn compare_in(device: &Device, mut target: Target, worlds: &[World]) -> Vec<(u32, u32)> {
    let size = target.size();
    let attachments = target.attachments();
    let shaders = ShaderSet::embedded().unwrap();
    let occluder_pass = DepthBoxes::of(device, attachments);
    let proxies = ProxyPass::new(device, &shaders, attachments).unwrap();
    let tester = ComputeTest::sized(device, &shaders, attachments.samples, size).unwrap();
    let mut ring = FrameRing::new(device, 2).unwrap();
    let mut queries = QueryRing::<usize>::new(device, 2, "proxies").unwrap();
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
    let size_bytes = TESTS as u64 * 4;
    let results = Buffer::new(device, "results", size_bytes, storage, MemoryKind::Device).unwrap();
    let to = vk::BufferUsageFlags::TRANSFER_DST;
    let readback =
        Buffer::new(device, "results readback", size_bytes, to, MemoryKind::ReadBack).unwrap();
    let mut said = Vec::new();
    for world in worlds {
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::new(&world.camera, size, bits);
        let enlarged = world.tested.iter().filter_map(|bounds| view.margin.proxy(bounds));
        let tests: Vec<ProxyBox> = enlarged.map(ProxyBox::from).collect();
        let count = tests.len() as u32;
        let tags: Vec<usize> = (0..tests.len()).collect();
        let mut frame = ring.begin().unwrap();
        queries.begin(&mut frame, &tags).unwrap();
        let occluders: Vec<_> = world.occluders.iter().copied().map(ProxyBox::from).collect();
        let occluders = frame.uploads().push(&occluders).unwrap();
        let boxes = frame.uploads().push(&tests).unwrap();
        let commands = frame.commands();
        target.prepare(commands);
        commands.rendering(target.render_target(Some([0.0; 4])), |commands| {
            for index in 0..world.occluders.len() as u32 {
                occluder_pass.draw(commands, occluders, &view, index);
            }
            proxies.bind(commands, &ProxyIo { boxes, flags: None }, &view);
            for test in 0..count {
                queries.scope(commands, QueryIndex(test), |c| proxies.draw(c, test));
            }
        });
        tester.record_grid(commands, &mut target, Rect::of(&view), view.depth);
        // Two parts, like two rounds.
        let half = count / 2;
        for (first, count) in [(0, half), (half, count - half)] {
            let io = ComputeTestIo { boxes, results: results.whole(), first, count };
            tester.record_tests(commands, &io, &view);
        }
        let between = MemoryBarrier::between;
        commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyRead]));
        commands.copy_buffer(results.whole(), readback.whole());
        commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
        queries.resolve(commands, 0..count);
        queries.read_back(commands);
        let tick = frame.submit(None).unwrap();
        queries.submitted(tick);
        device.wait_idle().unwrap();
        let answers = readback.read::<u32>(0..tests.len());
        queries.collect(device.completed().unwrap(), |test, samples| {
            said.push((samples, answers[test]));
        });
    }
    said
}

/// Checks that no visible box was lost. Returns the number of boxes that the query hid, and the
/// number of these that the compute tester showed.
fn judge(said: &[(u32, u32)], what: &str) -> (usize, usize) {
    assert!(said.iter().all(|(_, result)| *result <= 1), "{what}: a result is 0 or 1");
    let lost = said.iter().filter(|(samples, result)| *samples > 0 && *result == 0);
    let lost: Vec<u32> = lost.map(|(samples, _)| *samples).collect();
    assert!(lost.is_empty(), "{what}: {} shown boxes were hidden: {lost:?} samples", lost.len());
    let hidden = said.iter().filter(|(samples, _)| *samples == 0);
    let shown = hidden.clone().filter(|(_, result)| *result != 0).count();
    (hidden.count(), shown)
}

fn worlds(count: u64, origin: Vec3) -> Vec<World> {
    (0..count).map(|seed| World::new(&mut Random::new(seed), origin)).collect()
}

#[test]
fn it_hides_nothing_that_shows_and_shows_little_that_is_hidden() {
    for (driver, count) in [(Driver::Lavapipe, 40), (Driver::SwiftShader, 20)] {
        run(driver, |device| {
            let size = [320, 180];
            let said = compare(device, size, &worlds(count, Vec3::ZERO));
            let (hidden, shown) = judge(&said, &format!("{driver:?}"));
            println!("{driver:?}: {} boxes, {hidden} hidden, {shown} of them shown", said.len());
            assert!(hidden > said.len() / 5 && hidden < said.len() * 4 / 5, "{hidden} hidden");
            assert!(shown * 50 < hidden, "{shown} of {hidden} hidden boxes show");
        });
    }
}

#[test]
fn close_calls_lose_nothing() {
    for (driver, count) in [(Driver::Lavapipe, 120_u64), (Driver::SwiftShader, 120)] {
        run(driver, |device| {
            let size = [320, 180];
            let bits = device.adapter().limits.sub_pixel_precision_bits;
            let world = |seed: u64| World::close_calls(&mut Random::new(1000 + seed), size, bits);
            let said = compare(device, size, &(0..count).map(world).collect::<Vec<_>>());
            let (hidden, shown) = judge(&said, &format!("{driver:?}"));
            println!("{driver:?}: {} boxes, {hidden} hidden, {shown} of them shown", said.len());
            let few = said.iter().filter(|(samples, _)| (1..=8).contains(samples)).count();
            assert!(few > said.len() / 20, "{few} boxes show by a few samples");
            assert!(shown * 2 < hidden, "{shown} of {hidden} hidden boxes show");
        });
    }
}

#[test]
fn odd_sizes_and_far_origins_lose_nothing() {
    for driver in Driver::ALL {
        run(driver, |device| {
            for size in [[1, 1], [8, 8], [333, 7], [9, 65], [641, 363]] {
                let said = compare(device, size, &worlds(3, Vec3::ZERO));
                judge(&said, &format!("{driver:?} {size:?}"));
            }
            let origin = Vec3::new(3000.0, -700.0, 90_000.0);
            let said = compare(device, [320, 180], &worlds(4, origin));
            let (hidden, _) = judge(&said, &format!("{driver:?}, far out"));
            assert!(hidden > 0);
        });
    }
}

/// Fails if tests only looked at the middles of pixels.
#[test]
fn close_calls_lose_nothing_with_four_samples() {
    run(Driver::Lavapipe, |device| {
        let size = [320, 180];
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let world = |seed: u64| World::close_calls(&mut Random::new(1000 + seed), size, bits);
        let worlds: Vec<World> = (0..120).map(world).collect();
        let target = Target::multisampled(device, size, SampleCount::Four, "samples").unwrap();
        let said = compare_in(device, target, &worlds);
        let (hidden, shown) = judge(&said, "four samples");
        println!("{} boxes, {hidden} hidden, {shown} of them shown", said.len());
        let few = said.iter().filter(|(samples, _)| (1..=8).contains(samples)).count();
        assert!(few > said.len() / 40, "{few} boxes show by a few samples");
        assert!(hidden > 0 && shown < hidden, "{shown} of {hidden} hidden boxes show");
    });
}
