//! The parts of every test of a window: a device that can present to it, and images to show.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::{Driver, instance_for};
use gpu::{
    Device, DeviceOptions, FrameRing, Instance, PresentResult, Readback, Surface, Swapchain,
    SwapchainOptions, Target, Window, WindowSystem,
};

/// A window's device. Drop all objects of the device before [`WindowStage::end`].
pub struct WindowStage {
    /// The instance, with validation.
    pub instance: Instance,
    /// The window's surface.
    pub surface: Surface,
    /// A device that presents to it.
    pub device: Device,
}

impl WindowStage {
    /// Opens the driver's device for a window.
    pub fn new(driver: Driver, window: Arc<dyn Window>) -> Self {
        Self::with_entry(gpu::load_entry().unwrap(), driver, window)
    }

    /// Opens the driver's device for a window through a loader of the test.
    pub fn with_entry(entry: gpu::Entry, driver: Driver, window: Arc<dyn Window>) -> Self {
        let instance = instance_for(entry, Some(WindowSystem::of(&window).unwrap()));
        let surface = Surface::new(&instance, window).unwrap();
        let adapter = instance.pick_adapter_for(&surface, Some(driver.device_name()));
        let adapter = adapter.unwrap_or_else(|error| {
            panic!("{error}\nRun `ci/setup --tests` and `. ci/env` first: this needs {driver:?}.")
        });
        let options = DeviceOptions { wait_bound: Duration::from_secs(20), ..Default::default() };
        let device = Device::new(&instance, &adapter, &options).unwrap();
        Self { instance, surface, device }
    }

    /// Creates a swapchain of the window.
    pub fn swapchain(&self, options: &SwapchainOptions) -> Swapchain {
        Swapchain::new(&self.device, &self.surface, options).unwrap()
    }

    /// Destroys everything. Checks that the layers reported nothing, leaks included.
    pub fn end(self) {
        let Self { instance, surface, device } = self;
        let log = instance.validation_log().clone();
        drop((surface, device));
        drop(instance);
        assert_eq!(log.drain(), []);
    }
}

/// A source of images of tiles in different colours.
pub struct Painter {
    device: Device,
    ring: FrameRing,
    /// The target of the last image.
    pub target: Target,
}

const TILES: u32 = 12;

impl Painter {
    /// Creates a painter of images of `size` pixels.
    pub fn new(device: &Device, size: [u32; 2]) -> Self {
        let ring = FrameRing::new(device, 2).unwrap();
        let target = Target::new(device, size, "image").unwrap();
        Self { device: device.clone(), ring, target }
    }

    /// Paints a different image for every seed, and copies it if there is a readback.
    pub fn paint(&mut self, seed: u32, copy: Option<&Readback>) {
        let frame = self.ring.begin().unwrap();
        let commands = frame.commands();
        let [width, height] = self.target.size();
        for tile in 0..TILES * TILES {
            self.target.prepare(commands);
            let x = tile % TILES;
            let y = tile / TILES;
            let origin = [x * width / TILES, y * height / TILES];
            let size = [(x + 1) * width / TILES - origin[0], (y + 1) * height / TILES - origin[1]];
            if size.contains(&0) {
                continue;
            }
            let channel = |prime: u32| (((tile + seed) * prime) % 256) as f32 / 255.0;
            let colour = [channel(37), channel(101), channel(211), 1.0];
            let part = self.target.render_target(Some(colour)).within(origin, size);
            commands.rendering(part, |_| {});
        }
        if let Some(copy) = copy {
            self.target.copy_to(commands, copy);
        }
        frame.submit(None).unwrap();
        self.target.submitted();
    }

    /// Returns the pixels of a seed's image.
    pub fn expected(&mut self, seed: u32) -> Vec<[u8; 3]> {
        let copy = Readback::new(&self.device, self.target.size()).unwrap();
        self.paint(seed, Some(&copy));
        self.device.wait_idle().unwrap();
        copy.rgba8().unwrap().chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }
}

/// Shows the image until it is presented. The window must not change meanwhile.
pub fn show_surely(swapchain: &mut Swapchain, target: &Target, size: [u32; 2]) -> gpu::Presented {
    let mut others = Vec::new();
    for _ in 0..20 {
        match swapchain.show(target, size).unwrap() {
            PresentResult::Presented(presented) => return presented,
            PresentResult::Not(other) => others.push(other),
        }
    }
    panic!("not shown: {others:?}")
}

/// Waits until `look` returns the expected pixels, since presents may end at any time.
pub fn await_image(expected: &[[u8; 3]], look: impl Fn() -> Vec<[u8; 3]>) {
    let began = Instant::now();
    loop {
        let found = look();
        if found == expected {
            return;
        }
        let wrong = found.iter().zip(expected).filter(|(a, b)| a != b).count();
        let first = found.iter().zip(expected).find(|(a, b)| a != b);
        assert!(
            began.elapsed() < Duration::from_secs(5),
            "{wrong} of {} pixels are wrong, the first is {first:?}",
            expected.len()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A pseudorandom sequence, the same each time (SplitMix64, Steele, Lea, Flood 2014).
pub struct Random(u64);

impl Random {
    /// Starts the sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next number below `end`, which is not 0.
    pub fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % u64::from(end)) as u32
    }

    /// Returns the next number from 0 to 1.
    pub fn part(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 24) as f32
    }

    /// Returns the next number between two others.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.part()
    }
}
