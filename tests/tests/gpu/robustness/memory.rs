//! Devices with too little memory: another block, host memory, smaller textures, and at last an
//! error that says what was needed and what there is.

use ash::vk;
use cull::{Camera, Strategy};
use glam::{Affine2, Affine3A, Quat, Vec3, vec3};
use gpu::{Buffer, Device, DeviceOptions, Instance, MemoryKind, Readback};
use render::{CostModel, Error, FrameRequest, RenderView, Renderer, RendererOptions};
use scene::{
    Encoding, Image, ImageId, Material, MeshId, Object, Sampler, Scene, Texture, TextureId,
    TextureUse,
};
use tests::captured_log::CapturedLog;
use tests::fault_injection::{Fault, FaultInjection, HOST_ALLOCATIONS, calls, most_allocated};
use tests::shapes::coloured_cubes;
use tests::{Driver, instance_with};
use tracing_subscriber::prelude::*;

const SIZE: [u32; 2] = [160, 100];
const ALLOCATE: &std::ffi::CStr = c"vkAllocateMemory";
const MIB: u64 = 1 << 20;
/// The number of textures.
const TEXTURES: u32 = 6;

/// Returns boxes before and behind walls, with a texture of `side` texels per side for each colour.
fn scene(side: u32) -> Scene {
    let object = |mesh: u32, low: Vec3, size: Vec3| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low),
        tint: u32::MAX,
    };
    let mut objects = Vec::new();
    for wall in 0..4_u32 {
        let z = -5.0 - 3.0 * wall as f32;
        objects.push(object(wall % TEXTURES, vec3(-3.0, -2.0, z), vec3(5.0, 3.0, 0.3)));
        let boxes = (0..12).map(|number| {
            let low = vec3(number as f32 - 6.0, -0.6, z + 1.4);
            object((number + wall) % TEXTURES, low, Vec3::splat(0.8))
        });
        objects.extend(boxes);
    }
    let mut scene = coloured_cubes(TEXTURES, objects);
    let surfaces = scene.surfaces.as_mut().unwrap();
    for (mesh, surface) in scene.meshes.iter().zip(&mut surfaces.meshes) {
        for (vertex, surface) in mesh.vertices.iter().zip(&mut surface.vertices) {
            let [x, y, z] = vertex.position;
            surface.uv = [[x + z, y + 0.5 * z]; 2];
        }
    }
    let image = |number: u32| {
        let texel = |at: u32| {
            let x = (at % side) * 64 / side;
            let y = (at / side) * 64 / side;
            [(x * 3 + number * 11) as u8, (y * 3) as u8, (number * 40) as u8, 255]
        };
        let rgba8 = (0..side * side).flat_map(texel).collect();
        Image::of_rgba8(format!("gradient {number}"), [side; 2], rgba8)
    };
    surfaces.images = (0..TEXTURES).map(image).collect();
    let sampler = Sampler::default();
    let textures = (0..TEXTURES).map(ImageId);
    surfaces.textures =
        textures.map(|image| Texture { image, encoding: Encoding::Srgb, sampler }).collect();
    for (texture, material) in (0..).map(TextureId).zip(&mut surfaces.materials) {
        let transform = Affine2::IDENTITY;
        let used = Some(TextureUse { texture, uv_set: 0, transform });
        *material = Material { base_colour_texture: used, is_unlit: true, ..Material::default() };
    }
    scene
}

fn camera(frame: u32) -> Camera {
    let position = vec3(0.3 * frame as f32 - 0.5, 0.3, 0.0);
    Camera::look_at(position, position - Vec3::Z)
}

/// A renderer with a view and an image.
struct Shown {
    renderer: Renderer,
    view: RenderView,
    image: Readback,
}

impl Shown {
    fn new(device: &Device, scene: &Scene) -> Result<Self, Error> {
        let options =
            RendererOptions { size: SIZE, cost_model: CostModel::Off, ..Default::default() };
        let renderer = Renderer::new(device, scene, &options)?;
        let view = renderer.new_view()?;
        Ok(Self { view, image: Readback::new(device, SIZE)?, renderer })
    }

    /// Draws some frames, and returns the last image.
    fn image(&mut self) -> Result<Vec<u8>, Error> {
        for frame in 0..4 {
            let request = FrameRequest {
                image: Some(&self.image),
                ..FrameRequest::new(Strategy::ANTUMBRA, camera(frame))
            };
            self.renderer.render(&mut self.view, request)?;
        }
        self.renderer.wait_idle(&mut self.view)?;
        Ok(self.image.rgba8()?.to_vec())
    }
}

/// A machine with faults.
struct Machine(Instance);

impl Machine {
    fn new() -> Self {
        Self(instance_with(FaultInjection::default().entry()))
    }

    fn device(&self, memory_budget_bytes: Option<u64>) -> Device {
        let adapter = self.0.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
        let options = DeviceOptions { memory_budget_bytes, ..Default::default() };
        Device::new(&self.0, &adapter, &options).unwrap()
    }

    /// Returns the image of a scene on a new device with a budget.
    fn drawn(&self, scene: &Scene, budget: Option<u64>) -> Result<Vec<u8>, Error> {
        Shown::new(&self.device(budget), scene)?.image()
    }

    fn finish(self) {
        let log = self.0.validation_log().clone();
        drop(self.0);
        assert_eq!(log.drain(), []);
    }
}

/// Returns what `run` returns, and what it logs.
fn logged<T>(run: impl FnOnce() -> T) -> (T, String) {
    let log = CapturedLog::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt().with_ansi(false);
    let logging = subscriber.with_writer(move || writer.clone()).set_default();
    let result = run();
    drop(logging);
    (result, log.take())
}

/// Returns the mean difference of the bytes of two images.
fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

#[test]
fn a_block_that_fails_once_or_twice_changes_no_image() {
    let machine = Machine::new();
    let scene = scene(64);
    FaultInjection::default().install();
    let expected = machine.drawn(&scene, None).unwrap();
    let count = calls(ALLOCATE);
    for number in 0..count {
        for times in 1..=2 {
            for code in
                [vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, vk::Result::ERROR_OUT_OF_HOST_MEMORY]
            {
                let fault = Fault { call: ALLOCATE, fails: number..number + times, code };
                let place = format!("{fault:?}");
                FaultInjection { faults: vec![fault], ..Default::default() }.install();
                let image = machine.drawn(&scene, None);
                assert!(image.unwrap() == expected, "{place}");
                assert!(calls(ALLOCATE) > count, "{place}");
            }
        }
    }
    machine.finish();
}

#[test]
fn buffers_move_to_host_memory_with_a_single_warning() {
    let machine = Machine::new();
    let scene = scene(64);
    FaultInjection::default().install();
    let expected = machine.drawn(&scene, None).unwrap();
    let mut moved = 0;
    for kib in (256..=1024).step_by(128) {
        let device_bytes = Some(kib << 10);
        FaultInjection { has_host_memory: true, device_bytes, ..FaultInjection::default() }
            .install();
        let (image, log) = logged(|| machine.drawn(&scene, None));
        let warnings = log.matches("it lies in host memory").count();
        assert!(warnings <= 1, "{log}");
        match image {
            Ok(image) => {
                assert!(image == expected, "{kib} KiB");
                assert!(calls(HOST_ALLOCATIONS) > 0, "mapped memory has no room");
                moved += warnings;
            }
            // Images must lie on the device.
            Err(error) => assert!(error.to_string().contains("MiB are left"), "{error}"),
        }
        if warnings > 0 {
            let words = ["ERROR_OUT_OF_DEVICE_MEMORY", "MiB are in use"];
            assert!(words.iter().all(|words| log.contains(words)), "{log}");
        }
    }
    assert!(moved > 0);
    machine.finish();
}

#[test]
fn a_budget_is_kept_and_textures_become_smaller_before_a_scene_is_refused() {
    let machine = Machine::new();
    let scene = scene(1024);
    FaultInjection::default().install();
    let expected = machine.drawn(&scene, None).unwrap();
    let mut found = [0; 3];
    for mib in [1, 2, 3, 5, 8, 12, 20, 32, 50, 80, 200] {
        most_allocated();
        let (image, log) = logged(|| machine.drawn(&scene, Some(mib * MIB)));
        let most = most_allocated();
        assert!(most <= mib * MIB, "{most} bytes with a budget of {mib} MiB");
        let is_reduced = log.contains("no memory for textures in full size");
        match image {
            Ok(image) if is_reduced => {
                let difference = mean_difference(&image, &expected);
                assert!(difference < 3.0, "{mib} MiB: {difference}");
                found[1] += 1;
            }
            Ok(image) => {
                assert!(image == expected, "{mib} MiB");
                found[0] += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains(&format!("a budget of {mib} MiB")), "{text}");
                assert!(text.contains("raise `DeviceOptions::memory_budget_bytes`"), "{text}");
                found[2] += 1;
            }
        }
    }
    assert!(found.iter().all(|count| *count > 0), "{found:?}");
    machine.finish();
}

#[test]
fn textures_become_smaller_when_memory_is_short_without_a_budget() {
    let machine = Machine::new();
    let scene = scene(1024);
    FaultInjection::default().install();
    let expected = machine.drawn(&scene, None).unwrap();
    FaultInjection { device_bytes: Some(24 * MIB), ..FaultInjection::default() }.install();
    let (shown, log) = logged(|| {
        let mut shown = Shown::new(&machine.device(None), &scene).unwrap();
        let image = shown.image().unwrap();
        (image, shown.renderer.degradations())
    });
    let (image, degradations) = shown;
    assert!(mean_difference(&image, &expected) < 3.0);
    assert_eq!(degradations.shrunk_images, TEXTURES as usize);
    assert!(degradations.texts()[0].contains("has no memory for them"));
    let text =
        "they have at most 512 texels per side instead of 1024, and take 8 MiB instead of 32";
    assert_eq!(log.matches(text).count(), 1, "{log}");
    machine.finish();
}

#[test]
fn a_refused_scene_leaves_the_running_one_as_it_is() {
    let machine = Machine::new();
    FaultInjection::default().install();
    let device = machine.device(Some(48 * MIB));
    let mut running = Shown::new(&device, &scene(128)).unwrap();
    let image = running.image().unwrap();
    let used_bytes = device.memory_use().used_bytes;
    // 60 bytes per vertex.
    let mut large = scene(256);
    let mesh = &mut large.meshes[0];
    mesh.vertices = mesh.vertices.iter().copied().cycle().take(1_000_000).collect();
    let surface = &mut large.surfaces.as_mut().unwrap().meshes[0];
    surface.vertices = surface.vertices.iter().copied().cycle().take(1_000_000).collect();
    let refused = Shown::new(&device, &large).err().unwrap();
    let Error::SceneMemory { needed_mib, left_mib, texture_side, .. } = &refused else {
        panic!("{refused}")
    };
    assert!((58..64).contains(needed_mib), "{refused}");
    assert!((30..48).contains(left_mib), "{refused}");
    assert_eq!(*texture_side, 64, "{refused}");
    let text = refused.to_string();
    assert!(text.contains("of a budget of 48 MiB") && text.contains("MiB are left"), "{text}");
    assert!(running.image().unwrap() == image);
    device.wait_idle().unwrap();
    assert_eq!(device.memory_use().used_bytes, used_bytes);
    // A scene that fits can be loaded now.
    assert!(Shown::new(&device, &scene(128)).unwrap().image().unwrap() == image);
    drop(running);
    drop(device);
    machine.finish();
}

/// Takes all memory of a device but a piece. Returns it in buffers.
fn fill(device: &Device, left_kib: u64) -> Vec<Buffer> {
    let buffer = |kib: u64| {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        Buffer::new(device, "filler", kib << 10, usage, MemoryKind::Upload)
    };
    let left = buffer(left_kib).unwrap();
    let mut taken = Vec::new();
    for kib in [1024, 256, 64, 16, 4, 1] {
        while let Ok(buffer) = buffer(kib) {
            taken.push(buffer);
        }
    }
    drop(left);
    device.wait_idle().unwrap();
    taken
}

#[test]
fn a_frame_without_memory_for_its_tests_is_drawn_without_them() {
    let machine = Machine::new();
    let scene = scene(64);
    FaultInjection::default().install();
    let expected = machine.drawn(&scene, None).unwrap();
    let mut untested = 0;
    for left_kib in [8, 16, 24, 32, 48, 64, 96, 128, 256] {
        // Textures are copied through 8 MiB.
        let device = machine.device(Some(20 * MIB));
        let mut shown = Shown::new(&device, &scene).unwrap();
        let filler = fill(&device, left_kib);
        let (image, log) = logged(|| shown.image());
        match image {
            Ok(image) => {
                assert!(image == expected, "{left_kib} KiB");
                untested += log.matches("no memory for the tests of a frame").count();
            }
            Err(error) => assert!(error.to_string().contains("memory"), "{error}"),
        }
        drop(filler);
        device.wait_idle().unwrap();
        assert!(shown.image().unwrap() == expected, "{left_kib} KiB");
    }
    assert!(untested > 0);
    machine.finish();
}
