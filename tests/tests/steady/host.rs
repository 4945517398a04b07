//! A host with the executor in its command buffers. At rest and while boxes move, a frame creates
//! no Vulkan object and allocates no memory.

use cull::{DrawPhases, Strategy};
use glam::Vec3;
use gpu::{Features, FrameRing, Purpose};
use tests::Driver;
use tests::counting::allocations;
use tests::fault_injection::{CALLS_THAT_MAKE, FaultInjection, calls};
use tests::host_commands::{HostCommands, Runs, record_frame};
use tests::host_device::Host;
use tests::host_scene::{BoxOptions, ComparedScene, IN_FLIGHT};
use tests::host_walk::{boxes, camera};

/// The number of frames until all memory has its final size.
const BEFORE: u64 = 40;

#[test]
fn a_host_at_rest_makes_nothing_and_allocates_nothing() {
    let strategies = [
        Strategy::FRUSTUM,
        Strategy::ANTUMBRA,
        Strategy::ANTUMBRA_QUERIES,
        Strategy::ANTUMBRA_FLAGS,
        Strategy::ANTUMBRA_COMPUTE,
    ];
    let mut found = Vec::new();
    for driver in Driver::ALL {
        for strategy in strategies {
            for (moves, draw_phases) in [
                (Moves::Never, DrawPhases::PerRound),
                (Moves::InEachFrame, DrawPhases::PerRound),
                (Moves::InEachFrame, DrawPhases::Two),
            ] {
                let options = BoxOptions { views: 2, draw_phases, ..Default::default() };
                let (made, allocated) = made_and_allocated(driver, strategy, moves, &options);
                if (made, allocated) != (0, 0) {
                    found.push(format!(
                        "{driver:?} {strategy} {moves:?} {draw_phases:?}: {made} made, \
                         {allocated} allocated"
                    ));
                }
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// The moves of some boxes, there and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moves {
    Never,
    InEachFrame,
}

/// Returns the numbers of created Vulkan objects and of allocations by the engine, in frames of a
/// host that has drawn for a while.
fn made_and_allocated(
    driver: Driver,
    strategy: Strategy,
    moves: Moves,
    options: &BoxOptions,
) -> (usize, u64) {
    let entry = FaultInjection::default().entry();
    let purpose = Purpose::Executor;
    let host = Host::through(entry, driver, purpose, &[], Features::default());
    let device = host.adopt(None);
    let mut scene = ComparedScene::new(&host, &device, options);
    let objects = scene.add(&boxes()[..400]).unwrap();
    let mut commands = HostCommands::new(&host, IN_FLIGHT);
    let mut ring = FrameRing::new(&device, IN_FLIGHT).unwrap();
    let made = || -> usize {
        // The descriptor sets of a frame come from the pool of its slot.
        let all = CALLS_THAT_MAKE.iter().filter(|call| **call != c"vkAllocateDescriptorSets");
        all.map(|call| calls(call)).sum()
    };
    let mut late_made = 0;
    let mut late_allocated = 0;
    for frame in 0..2 * BEFORE {
        let (buffer, numbers) = commands.begin();
        if moves == Moves::InEachFrame {
            let by = if frame % 2 == 0 { 0.25 } else { -0.25 };
            scene.move_by(&objects[100..120], Vec3::Y * by);
        }
        let before = (made(), allocations());
        let (tick, slot) = record_frame(&mut ring, buffer, numbers, |recorded| {
            let recorded = scene.record(recorded, &[camera(8), camera(14)], strategy).unwrap();
            let slot = recorded.slot();
            (recorded, slot)
        });
        // Nothing is compared here.
        scene.ended(tick, slot, Runs::Never);
        if frame >= BEFORE {
            late_made += made() - before.0;
            late_allocated += allocations() - before.1;
        }
        commands.end(Runs::Once).unwrap();
        scene.fewest_draws();
    }
    host.say_all_is_over(&device);
    scene.destroy();
    commands.destroy();
    drop((ring, device));
    host.finish();
    (late_made, late_allocated)
}
