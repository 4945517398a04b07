//! Scenes of hosts: several scenes on a device, and several devices. Each frame that runs is
//! compared with brute force, while objects are added and removed. Some frames never run.

use ash::vk;
use cull::{Camera, DrawPhases, ObjectId, Strategy};
use glam::Vec3;
use gpu::{Device, Features, FrameNumbers, FrameRing, PredicationMode, Purpose, Tick};
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::host_commands::{HostCommands, Runs, record_frame};
use tests::host_device::Host;
use tests::host_scene::{BoxOptions, ComparedScene, IN_FLIGHT, RenderingOwner};
use tests::host_walk::{boxes, camera};
use tests::window_fixture::Random;
use tests::{Driver, drivers};

const FRAMES: u64 = 18;

/// Returns the cameras of a frame. The second view is elsewhere on the walk.
fn cameras(frame: u64) -> [Camera; 2] {
    [camera(frame), camera(frame + 9)]
}

/// Adds the wall and a few boxes behind it.
fn fill(scene: &mut ComparedScene<'_>) {
    scene.add(&boxes()[..60]).unwrap();
}

/// Changes many objects at once, different ones in each frame. The wall stays.
fn change(scene: &mut ComparedScene<'_>, random: &mut Random, frame: u64) {
    let all = boxes();
    let some = |scene: &ComparedScene<'_>, random: &mut Random, count: usize| -> Vec<ObjectId> {
        let there: Vec<ObjectId> = scene.objects().filter(|object| object.0 > 0).collect();
        let first = random.below(there.len() as u32) as usize;
        there.iter().cycle().skip(first).take(count.min(there.len())).copied().collect()
    };
    match frame % 4 {
        0 => {
            // New boxes, since two boxes in the same place would have equal depths.
            let first = 60 + frame as usize / 4 * 40;
            scene.add(&all[first..first + 40]).unwrap();
        }
        1 => {
            let gone = some(scene, random, 30);
            scene.remove(&gone);
        }
        _ => {
            // Out of sight and back.
            let moved = some(scene, random, 20);
            let up = if random.below(2) == 0 { 40.0 } else { -40.0 };
            scene.move_by(&moved, Vec3::Y * up);
        }
    }
}

/// Rings of a device whose frames alternate: ring 0 has the even frame numbers, ring 1 the odd
/// ones.
struct Rings([FrameRing; 2]);

impl Rings {
    fn new(device: &Device) -> Self {
        Self([(); 2].map(|()| FrameRing::new(device, IN_FLIGHT).unwrap()))
    }

    /// Compares the previous images of a slot, and records some scenes into a frame of a ring.
    fn draw(
        &mut self,
        ring: usize,
        raw: vk::CommandBuffer,
        numbers: FrameNumbers,
        scenes: &mut [&mut ComparedScene<'_>],
        frame: u64,
        runs: Runs,
    ) {
        let FrameNumbers { current, safe } = numbers;
        let turn = ring as u64;
        let safe = if safe == Tick::ZERO { safe } else { Tick(2 * safe.0 + turn) };
        let numbers = FrameNumbers { current: Tick(2 * current.0 + turn), safe };
        let (tick, slot) = record_frame(&mut self.0[ring], raw, numbers, |mut recorded| {
            for scene in &mut *scenes {
                scene.compare(recorded.slot().0, &format!("frame {}", frame - IN_FLIGHT as u64));
                recorded = scene.record(recorded, &cameras(frame), Strategy::ANTUMBRA).unwrap();
                scene.record_all(&recorded, &cameras(frame));
            }
            let slot = recorded.slot();
            (recorded, slot)
        });
        scenes.iter_mut().for_each(|scene| scene.ended(tick, slot, runs));
    }
}

/// Compares the last images, and destroys a scene. All frames are over.
fn finish(mut scene: ComparedScene<'_>) {
    (0..IN_FLIGHT).for_each(|slot| {
        scene.compare(slot, "the last frames");
    });
    let drawn = scene.fewest_draws().unwrap();
    let all = scene.objects().count() as u64;
    assert!(drawn < all, "{drawn} of {all}");
    scene.destroy();
}

/// Walks while objects are added and removed. Every third frame never runs.
fn walk(driver: Driver, options: &BoxOptions<'_>) {
    let host = Host::new(driver, Purpose::Executor);
    let device = host.adopt(None);
    let mut scene = ComparedScene::new(&host, &device, options);
    let mut commands = HostCommands::new(&host, IN_FLIGHT);
    let mut rings = Rings::new(&device);
    let mut random = Random::new(5);
    fill(&mut scene);
    for frame in 2..2 + FRAMES {
        change(&mut scene, &mut random, frame);
        // Among them the first frame, which uploads everything.
        let runs = if frame % 3 == 2 { Runs::Never } else { Runs::Once };
        let (buffer, numbers) = commands.begin();
        rings.draw(0, buffer, numbers, &mut [&mut scene], frame, runs);
        commands.end(runs).unwrap();
    }
    host.say_all_is_over(&device);
    finish(scene);
    commands.destroy();
    drop((rings, device));
    host.finish();
}

#[test]
fn objects_come_and_go_in_frames_of_which_some_never_run() {
    for driver in drivers() {
        walk(driver, &BoxOptions::default());
        walk(driver, &BoxOptions { views: 2, predication: INSTANCES, ..BoxOptions::default() });
    }
}

#[test]
fn several_views_with_several_samples_in_render_passes_of_the_host_are_exact() {
    for driver in drivers() {
        let samples = vk::SampleCountFlags::TYPE_4;
        let renderings = RenderingOwner::Host;
        walk(driver, &BoxOptions { views: 2, samples, renderings, ..BoxOptions::default() });
    }
}

#[test]
fn several_views_that_a_host_draws_from_lists_are_exact() {
    for driver in drivers() {
        let draw_phases = DrawPhases::Two;
        walk(driver, &BoxOptions { views: 2, draw_phases, ..BoxOptions::default() });
    }
}

/// The frames of two scenes on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sharing {
    /// One frame, which contains the second scene every other time.
    Frame,
    /// One frame per scene, with separate rings, in one command buffer.
    Commands,
    /// One command buffer per scene. The first one always runs.
    Device,
}

/// Draws two scenes on one device. If a frame with the second scene never ran, frames of the first
/// scene do not prove its uploads.
fn two_scenes(driver: Driver, sharing: Sharing) {
    let host = Host::new(driver, Purpose::Executor);
    let device = host.adopt(None);
    let options = BoxOptions::default();
    let [mut one, mut other] = [(); 2].map(|()| ComparedScene::new(&host, &device, &options));
    let mut commands = [(); 2].map(|()| HostCommands::new(&host, IN_FLIGHT));
    let mut rings = Rings::new(&device);
    let mut random = Random::new(9);
    fill(&mut one);
    fill(&mut other);
    for frame in 2..2 + FRAMES {
        change(&mut one, &mut random, frame);
        if frame % 2 == 0 {
            change(&mut other, &mut random, frame / 2);
        }
        let runs = if frame % 4 == 0 { Runs::Never } else { Runs::Once };
        let [first, second] = &mut commands;
        let (buffer, numbers) = first.begin();
        match sharing {
            Sharing::Frame if frame % 2 == 0 => {
                rings.draw(0, buffer, numbers, &mut [&mut one, &mut other], frame, runs);
            }
            Sharing::Frame => rings.draw(0, buffer, numbers, &mut [&mut one], frame, runs),
            Sharing::Commands => {
                rings.draw(0, buffer, numbers, &mut [&mut one], frame, runs);
                rings.draw(1, buffer, numbers, &mut [&mut other], frame, runs);
            }
            Sharing::Device => {
                rings.draw(0, buffer, numbers, &mut [&mut one], frame, Runs::Once);
                let (buffer, numbers) = second.begin();
                rings.draw(1, buffer, numbers, &mut [&mut other], frame, runs);
                second.end(runs).unwrap();
            }
        }
        first.end(if sharing == Sharing::Device { Runs::Once } else { runs }).unwrap();
    }
    host.say_all_is_over(&device);
    [one, other].into_iter().for_each(finish);
    commands.into_iter().for_each(HostCommands::destroy);
    drop((rings, device));
    host.finish();
}

#[test]
fn two_scenes_on_one_device_are_exact() {
    for driver in drivers() {
        for sharing in [Sharing::Frame, Sharing::Commands, Sharing::Device] {
            two_scenes(driver, sharing);
        }
    }
}

#[test]
fn two_devices_and_two_adoptions_of_one_draw_side_by_side() {
    let hosts = Driver::ALL.map(|driver| Host::new(driver, Purpose::Executor));
    let [first, second] = &hosts;
    let sides =
        [(first, first.adopt(None)), (first, first.adopt(None)), (second, second.adopt(None))];
    let mut parts = sides.each_ref().map(|(host, device)| {
        let mut scene = ComparedScene::new(host, device, &BoxOptions::default());
        fill(&mut scene);
        (scene, HostCommands::new(host, IN_FLIGHT), Rings::new(device), Random::new(3))
    });
    for frame in 2..14 {
        for (scene, commands, rings, random) in &mut parts {
            change(scene, random, frame);
            let (buffer, numbers) = commands.begin();
            rings.draw(0, buffer, numbers, &mut [scene], frame, Runs::Once);
            commands.end(Runs::Once).unwrap();
        }
    }
    sides.iter().for_each(|(host, device)| host.say_all_is_over(device));
    for (scene, commands, rings, _) in parts {
        finish(scene);
        commands.destroy();
        drop(rings);
    }
    drop(sides);
    hosts.into_iter().for_each(Host::finish);
}

#[test]
fn after_the_loss_of_a_device_without_a_queue_another_one_draws() {
    for driver in drivers() {
        let fault = Fault {
            call: c"vkQueueSubmit2",
            fails: 5..usize::MAX,
            code: vk::Result::ERROR_DEVICE_LOST,
        };
        for (faults, drawn) in [(vec![fault], 5), (Vec::new(), 12)] {
            let entry = FaultInjection { faults, ..FaultInjection::default() }.entry();
            let host = Host::through(entry, driver, Purpose::Executor, &[], Features::default());
            let device = host.adopt(None);
            let mut scene = ComparedScene::new(&host, &device, &BoxOptions::default());
            let mut commands = HostCommands::new(&host, IN_FLIGHT);
            let mut rings = Rings::new(&device);
            fill(&mut scene);
            let submits = (2..14).map(|frame| {
                let (buffer, numbers) = commands.begin();
                rings.draw(0, buffer, numbers, &mut [&mut scene], frame, Runs::Once);
                commands.end(Runs::Once)
            });
            let told: Vec<_> = submits.take_while(Result::is_ok).collect();
            assert_eq!(told.len(), drawn, "the host is told by its own submit");
            // The loss is simulated: work on the device goes on, unlike on a lost device.
            let waits = calls(c"vkDeviceWaitIdle");
            host.say_all_is_over(&device);
            if drawn == 12 {
                finish(scene);
            } else {
                scene.destroy();
            }
            commands.destroy();
            drop((rings, device));
            assert_eq!(calls(c"vkDeviceWaitIdle"), waits + 1, "the engine waits for nothing");
            FaultInjection::default().install();
            host.finish();
        }
    }
}

const INSTANCES: Option<PredicationMode> = Some(PredicationMode::Instances);
