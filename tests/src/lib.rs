//! The harness of the GPU tests: a device per test, and a failure on any validation message.
//!
//! A missing driver or layer fails a test, since a test that passes without running proves nothing.
// A harness fails by panicking.
#![allow(clippy::panic, clippy::expect_used, clippy::unwrap_used)]
#![allow(unsafe_code, reason = "a host calls Vulkan itself")]

pub mod box_rays;
pub mod captured_log;
pub mod counting;
pub mod display;
pub mod every_call;
pub mod fault_injection;
pub mod frame_of_file;
pub mod host_commands;
pub mod host_copy;
pub mod host_device;
pub mod host_images;
pub mod host_memory;
pub mod host_overlay;
pub mod host_passes;
#[cfg(feature = "shader-compiler")]
pub mod host_scene;
pub mod host_walk;
mod loader;
pub mod long_run;
#[cfg(feature = "shader-compiler")]
pub mod numbered_boxes;
pub mod projections;
pub mod reference;
pub mod regressions;
pub mod scene_rays;
pub mod section;
pub mod shadow_scene;
pub mod shapes;
pub mod single_frame;
pub mod surface_fixture;
pub mod walk;
pub mod wayland_window;
pub mod weston;
pub mod window_fixture;
pub mod window_matrix;
pub mod x11_screen;
pub mod x11_window;
pub mod xvfb;

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use gpu::{Device, DeviceOptions, Instance, InstanceOptions, Message, OptionalFeature, Validation};

/// A software driver that every machine can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// Mesa's driver, with conditional rendering. Debian 12 has version 22.3; `ci/next` runs a
    /// newer one, with more optional features.
    Lavapipe,
    /// Google's driver, without conditional rendering and draw counts.
    SwiftShader,
}

impl Driver {
    /// Both drivers, in the order in which tests run on them.
    pub const ALL: [Driver; 2] = [Driver::Lavapipe, Driver::SwiftShader];

    /// Returns a part of the name of the driver's device. If the environment variable
    /// `ANTUMBRA_TEST_DEVICE` names a GPU, the GPU replaces lavapipe.
    pub fn device_name(self) -> &'static str {
        static NAMED: OnceLock<Option<String>> = OnceLock::new();
        let named = NAMED.get_or_init(|| std::env::var("ANTUMBRA_TEST_DEVICE").ok());
        match (self, named) {
            (Driver::Lavapipe, Some(name)) => name,
            (Driver::Lavapipe, None) => "llvmpipe",
            (Driver::SwiftShader, _) => "SwiftShader",
        }
    }
}

/// Returns an instance with synchronization validation and a device of `driver`.
pub fn open(driver: Driver) -> (Instance, Device) {
    let instance = instance();
    let adapter = instance.pick_adapter(Some(driver.device_name())).unwrap_or_else(|error| {
        panic!("{error}\nRun `ci/setup --tests` and `. ci/env` first: these tests need {driver:?}.")
    });
    // Short, so that a test ends soon if it fails while it holds the GPU back.
    let options = DeviceOptions { wait_bound: Duration::from_secs(60), ..Default::default() };
    let device = Device::new(&instance, &adapter, &options);
    (instance, device.expect("a device"))
}

/// Waits until no other test of this process has an instance, and blocks them until the calling
/// thread, and with it the test, ends.
///
/// Devices that share nothing still interfere with each other. The validation layer of Debian 12
/// looks devices up in a table that other threads change; the loader does the same with a list
/// (Vulkan-Loader, issue 2018).
pub fn take_turn() {
    static TURN: Mutex<()> = Mutex::new(());
    thread_local! {
        static MINE: MutexGuard<'static, ()> = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    }
    MINE.with(|_| ());
}

/// Returns an instance with synchronization validation.
pub fn instance() -> Instance {
    instance_with(gpu::load_entry().unwrap_or_else(|error| panic!("{error}")))
}

/// Returns an instance with synchronization validation, through an entry of the test.
pub fn instance_with(entry: gpu::Entry) -> Instance {
    instance_for(entry, None)
}

/// Returns an instance with synchronization validation, for windows.
pub fn instance_for(entry: gpu::Entry, windows: Option<gpu::WindowSystem>) -> Instance {
    take_turn();
    let options = InstanceOptions {
        application: "tests".to_owned(),
        validation: Validation::Synchronization,
        windows,
    };
    Instance::new(entry, &options).unwrap_or_else(|error| {
        panic!("{error}\nRun `ci/setup --tests` first: these tests need the validation layer.")
    })
}

/// Runs `test` on `driver`. Returns all messages of the layers, including the destruction.
pub fn messages_of(driver: Driver, test: impl FnOnce(&Device)) -> Vec<Message> {
    let (instance, device) = open(driver);
    test(&device);
    let log = instance.validation_log().clone();
    // Leaks are reported when the device and the instance are destroyed.
    drop(device);
    drop(instance);
    log.drain()
}

/// Runs `test` on `driver`, and fails on any validation message.
pub fn run(driver: Driver, test: impl FnOnce(&Device)) {
    let messages = messages_of(driver, test);
    assert!(messages.is_empty(), "the validation layer said on {driver:?}: {messages:#?}");
}

/// Returns the drivers that the calling test runs on: lavapipe, and for an eighth of the tests
/// SwiftShader, which takes most of the time of both. The name of a test decides, so that a test
/// always has the same drivers. With the environment variable `ANTUMBRA_ALL_DRIVERS` every test has
/// both; `ci/verify` sets it.
pub fn drivers() -> impl Iterator<Item = Driver> {
    let thread = std::thread::current();
    let name = thread.name().expect("libtest names the thread of a test after the test");
    let is_sampled = name.bytes().map(u32::from).sum::<u32>().is_multiple_of(8);
    let has_both = is_sampled || std::env::var_os("ANTUMBRA_ALL_DRIVERS").is_some();
    Driver::ALL.into_iter().take(if has_both { 2 } else { 1 })
}

/// Runs `test` on the [`drivers`] of the calling test.
pub fn run_on_all(test: impl Fn(&Device)) {
    for driver in drivers() {
        run(driver, &test);
    }
}

/// Runs `test` on every driver whose device has `feature`. SwiftShader must have it, so that the
/// test runs everywhere; lavapipe may have it in newer versions, and so may a GPU in its place.
pub fn run_where(feature: OptionalFeature, test: impl Fn(&Device)) {
    for driver in Driver::ALL {
        run(driver, |device| {
            let is_there = device.capabilities().has(feature);
            assert!(is_there || driver != Driver::SwiftShader, "nothing tests {feature:?}");
            if is_there {
                test(device);
            }
        });
    }
}
