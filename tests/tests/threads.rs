//! The engine starts no threads. A separate process compares its threads before and after frames of
//! a host; threads of the drivers do not count.
#![forbid(unsafe_code)]
#![cfg(feature = "shader-compiler")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use cull::Strategy;
use gpu::{FrameRing, Purpose};
use tests::Driver;
use tests::host_commands::{HostCommands, Runs, record_frame};
use tests::host_device::Host;
use tests::host_scene::{BoxOptions, ComparedScene, IN_FLIGHT};
use tests::host_walk::{boxes, camera};

/// Returns the names of all threads of the process, sorted.
fn threads() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let name = |task: std::io::Result<std::fs::DirEntry>| {
        std::fs::read_to_string(task.unwrap().path().join("comm")).unwrap_or_default()
    };
    let mut names: Vec<String> = tasks.map(name).collect();
    names.sort();
    names
}

#[test]
fn a_host_that_draws_has_the_threads_that_it_had_before() {
    for driver in Driver::ALL {
        let host = Host::new(driver, Purpose::Executor);
        let lock = std::sync::Mutex::new(());
        // Starts the threads that a driver starts with its first submit.
        host.run_once(&lock, |_| {});
        let before = threads();
        let device = host.adopt(None);
        let mut scene = ComparedScene::new(&host, &device, &BoxOptions::default());
        scene.add(&boxes()[..200]).unwrap();
        let mut commands = HostCommands::new(&host, IN_FLIGHT);
        let mut ring = FrameRing::new(&device, IN_FLIGHT).unwrap();
        for frame in 0..8 {
            let (buffer, numbers) = commands.begin();
            let (tick, slot) = record_frame(&mut ring, buffer, numbers, |recorded| {
                let cameras = [camera(frame)];
                let recorded = scene.record(recorded, &cameras, Strategy::ANTUMBRA).unwrap();
                let slot = recorded.slot();
                (recorded, slot)
            });
            scene.ended(tick, slot, Runs::Never);
            commands.end(Runs::Once).unwrap();
            assert_eq!(threads(), before, "{driver:?}, frame {frame}");
        }
        host.say_all_is_over(&device);
        scene.destroy();
        commands.destroy();
        drop((ring, device));
        assert_eq!(threads(), before, "{driver:?}, at the end");
        host.finish();
    }
}
