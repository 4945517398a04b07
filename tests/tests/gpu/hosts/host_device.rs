//! The engine on the device of a host, which is created from nothing but the engine's requirements.

mod requirements;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cull::Strategy;
use gpu::{
    Buffer, Device, DynamicTexture, Error, Features, FrameRing, HostDevice, HostQueueLock,
    MemoryKind, MipGeneration, Purpose, Readback, TextureArray, TextureArrayInfo, Timeline, vk,
};
use render::{CostModel, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::fault_injection::{Fault, FaultInjection, calls};
use tests::host_device::Host;
use tests::host_memory::HostMemory;
use tests::walk::SceneKind;
use tests::{Driver, drivers, open};

const FRAMES: u32 = 6;

/// Returns a renderer of a city, and a path through it.
fn city(device: &Device) -> Result<(Renderer, CameraPath), render::Error> {
    let GeneratedScene { scene, routes } = SceneKind::City.build(400);
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options = RendererOptions {
        methods: methods::all(),
        size: [96, 64],
        cost_model: CostModel::Off,
        ..Default::default()
    };
    Ok((Renderer::new(device, &scene, &options)?, path))
}

/// Draws frames of a city with several strategies, and returns their images.
fn images(device: &Device) -> Result<Vec<Vec<u8>>, render::Error> {
    let (mut renderer, path) = city(device)?;
    let image = Readback::new(device, renderer.size())?;
    let mut images = Vec::new();
    for strategy in [Strategy::ANTUMBRA, methods::HZB, Strategy::FRUSTUM] {
        let mut view = renderer.new_view()?;
        for frame in 0..FRAMES {
            let request = FrameRequest::new(strategy, path.camera(frame));
            renderer.render(&mut view, FrameRequest { image: Some(&image), ..request })?;
            renderer.wait_idle(&mut view)?;
            images.push(image.rgba8()?.to_vec());
        }
    }
    Ok(images)
}

/// A lock of a host that counts its uses and detects simultaneous uses of the queue.
#[derive(Default)]
struct CountedLock {
    queue: Mutex<()>,
    is_used: AtomicBool,
    uses: AtomicU64,
}

impl HostQueueLock for CountedLock {
    fn locked(&self, bound: Duration, submit: &mut dyn FnMut()) {
        self.queue.locked(bound, &mut || {
            assert!(!self.is_used.swap(true, Ordering::SeqCst), "two users at once");
            submit();
            self.uses.fetch_add(1, Ordering::Relaxed);
            self.is_used.store(false, Ordering::SeqCst);
        });
    }
}

#[test]
fn a_renderer_draws_the_same_images_on_a_hosts_device() {
    for driver in drivers() {
        let (_instance, own) = open(driver);
        let expected = images(&own).unwrap();
        assert!(expected.windows(2).any(|pair| pair[0] != pair[1]), "images of nothing");
        let host = Host::new(driver, Purpose::Renderer);
        let lock = Arc::new(CountedLock::default());
        let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
        assert_eq!(device.capabilities(), own.capabilities());
        assert!(images(&device).unwrap() == expected, "other images on {driver:?}");
        // Each submit held the lock: the number of submits is the device's newest tick.
        assert_eq!(lock.uses.load(Ordering::Relaxed), device.submitted().0);
        drop(device);
        // Objects of the host still exist.
        host.run_once(&*lock, |_| {});
        host.finish();
    }
}

#[test]
fn the_queue_of_a_host_is_used_by_one_at_a_time() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let lock = Arc::new(CountedLock::default());
        let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
        let ends = AtomicBool::new(false);
        let submitted = std::thread::scope(|scope| {
            let of_host = scope.spawn(|| {
                let mut submits = 0;
                while !ends.load(Ordering::Relaxed) {
                    host.run_once(&*lock, |_| {});
                    submits += 1;
                }
                submits
            });
            images(&device).unwrap();
            ends.store(true, Ordering::Relaxed);
            of_host.join().unwrap()
        });
        assert!(submitted > 0);
        let uses = lock.uses.load(Ordering::Relaxed);
        assert_eq!(uses, device.submitted().0 + submitted);
        drop(device);
        host.finish();
    }
}

const ARRAY: TextureArrayInfo<'_> = TextureArrayInfo {
    name: "array",
    size: [4; 2],
    layers: 2,
    format: vk::Format::R8G8B8A8_UNORM,
    wrap: [vk::SamplerAddressMode::REPEAT; 2],
    magnified: vk::Filter::LINEAR,
    minified: vk::Filter::LINEAR,
    between_levels: None,
    anisotropy: 1.0,
    mip_making: MipGeneration::Cpu,
};

#[test]
fn all_memory_of_the_cpu_comes_from_the_host_and_goes_back() {
    for driver in drivers() {
        let memory: &'static HostMemory = Box::leak(Box::default());
        let host = Host::new(driver, Purpose::Renderer);
        let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
        let allocation_callbacks = Some(memory.callbacks());
        let description = HostDevice { allocation_callbacks, queue, ..host.describe() };
        let device = host.try_adopt(description).unwrap();
        images(&device).unwrap();
        let texture = DynamicTexture::new(&device, [4; 2], "texture").unwrap();
        let array = TextureArray::new(&device, &ARRAY).unwrap();
        let timeline = Timeline::new(&device, "timeline").unwrap();
        assert!(memory.made() > 100, "{memory:?}");
        drop((texture, array, timeline, device));
        assert_eq!(memory.live(), 0, "of {} blocks", memory.made());
        host.finish();
    }
}

#[test]
fn the_pipeline_cache_of_a_host_is_used_and_left_to_it() {
    let entry = FaultInjection::default().entry();
    let purpose = Purpose::Renderer;
    let host = Host::through(entry, Driver::Lavapipe, purpose, &[], Features::default());
    let cache = host.create_pipeline_cache();
    let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
    let description = HostDevice { pipeline_cache: Some(cache), queue, ..host.describe() };
    images(&host.try_adopt(description).unwrap()).unwrap();
    assert_eq!(calls(c"vkCreatePipelineCache"), 1, "the engine made one of its own");
    // The layer would report an object that no longer exists.
    host.destroy_pipeline_cache(cache);
    host.finish();
}

#[test]
fn a_device_without_a_queue_submits_nothing_and_frees_what_frames_are_over() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Executor);
        let device = host.adopt(None);
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let errors = [
            FrameRing::new(&device, 2).unwrap().begin().err(),
            device.run_once("nothing", |_| {}).err(),
            device.wait_idle().err(),
            Timeline::new(&device, "timeline").err(),
            device.timeline_semaphore().err(),
        ];
        for error in errors {
            let error = error.expect("an error");
            assert!(matches!(error, Error::NoQueue { .. }), "{error}");
        }
        let before = device.retired();
        drop(Buffer::new(&device, "dropped", 64, usage, MemoryKind::Device).unwrap());
        assert_eq!(device.retired(), before + 1);
        host.say_all_is_over(&device);
        assert_eq!(device.retired(), 0);
        drop(device);
        host.finish();
    }
}

#[test]
fn what_a_frame_of_the_host_may_use_is_not_freed_with_the_device() {
    let lock = Mutex::new(());
    for driver in drivers() {
        for is_finished in [true, false] {
            let memory: &'static HostMemory = Box::leak(Box::default());
            let host = Host::new(driver, Purpose::Executor);
            let allocation_callbacks = Some(memory.callbacks());
            let description = HostDevice { allocation_callbacks, ..host.describe() };
            let device = host.try_adopt(description).unwrap();
            let mut ring = FrameRing::new(&device, 2).unwrap();
            host.run_frame(&lock, &mut ring, 5);
            host.run_frame(&lock, &mut ring, 6);
            drop(ring);
            if is_finished {
                host.say_all_is_over(&device);
            }
            drop(device);
            assert_eq!(memory.live() == 0, is_finished, "{memory:?} on {driver:?}");
            if is_finished {
                host.finish();
            } else {
                // The remaining objects of the engine would outlive their device.
                std::mem::forget(host);
            }
        }
    }
}

#[test]
fn a_device_with_a_queue_knows_by_itself_what_is_over() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
    let error = host.say_finished(&device).expect_err("an error");
    assert!(matches!(error, Error::HasQueue), "{error}");
    drop(device);
    host.finish();
}

#[test]
fn two_hosts_and_two_handles_of_one_device_live_side_by_side() {
    let hosts = Driver::ALL.map(|driver| Host::new(driver, Purpose::Renderer));
    let lock = Arc::new(CountedLock::default());
    let adopt = |host: &Host| host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
    let [first, second] = &hosts;
    let devices = [adopt(first), adopt(first), adopt(second)];
    let [one, again, other] = devices.each_ref().map(|device| images(device).unwrap());
    assert!(one == again && one.len() == other.len());
    // An object of one `Device` does not belong to the other, although the Vulkan device is the
    // same.
    let timeline = Timeline::new(&devices[0], "timeline").unwrap();
    let error = devices[1].check(&timeline, "a frame").unwrap_err();
    assert!(matches!(error, Error::Foreign { .. }), "{error}");
    drop((timeline, devices));
    hosts.into_iter().for_each(Host::finish);
}

#[test]
fn frames_wait_for_a_timeline_of_the_host_and_signal_one_that_it_can_read() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
        let raw = host.create_timeline();
        let timeline = host.lend_timeline(&device, raw);
        let mut ring = FrameRing::new(&device, 2).unwrap();
        let tick = ring.begin().unwrap().submit(Some(timeline.at(gpu::Tick(7)))).unwrap();
        let ticks = device.timeline_semaphore().unwrap();
        assert!(host.value_of(ticks) < tick.0);
        host.signal(raw, 7);
        device.wait_idle().unwrap();
        assert_eq!(host.value_of(ticks), tick.0);
        drop((timeline, ring, device));
        host.destroy_timeline(raw);
        host.finish();
    }
}

#[test]
fn the_loss_of_a_hosts_device_is_an_error_with_its_name() {
    let error_on = |faults: FaultInjection| {
        let entry = faults.entry();
        let purpose = Purpose::Renderer;
        let host = Host::through(entry, Driver::Lavapipe, purpose, &[], Features::default());
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
        let drawn = images(&device).err();
        // The loss is simulated: work on the device goes on, unlike on a lost device.
        host.wait_idle();
        drop(device);
        FaultInjection::default().install();
        host.finish();
        drawn
    };
    let fault = |call, number: usize| FaultInjection {
        faults: vec![Fault {
            call,
            fails: number..usize::MAX,
            code: vk::Result::ERROR_DEVICE_LOST,
        }],
        ..FaultInjection::default()
    };
    assert!(error_on(FaultInjection::default()).is_none());
    for call in [c"vkQueueSubmit2", c"vkWaitSemaphores", c"vkGetSemaphoreCounterValue"] {
        let error = error_on(fault(call, 3)).expect("an error");
        let render::Error::Gpu(error) = error else { panic!("{error}") };
        assert!(error.is_device_lost(), "{error}");
        assert!(error.to_string().contains(call.to_str().unwrap()), "{error}");
    }
}

#[test]
fn a_host_reads_the_finished_image_by_commands_of_its_own() {
    for driver in drivers() {
        let host = Host::new(driver, Purpose::Renderer);
        let lock = Arc::new(Mutex::new(()));
        let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
        let (mut renderer, path) = city(&device).unwrap();
        let early = renderer.finished_image().expect_err("an error");
        assert!(matches!(early, render::Error::Gpu(Error::NoImage)), "{early}");
        let mut view = renderer.new_view().unwrap();
        let image = Readback::new(&device, renderer.size()).unwrap();
        let mut states = Vec::new();
        for frame in 0..FRAMES {
            // If the engine copies the image too, the frame leaves the image in another state.
            let is_copied = frame % 2 == 0;
            let request = FrameRequest {
                image: is_copied.then_some(&image),
                ..FrameRequest::new(Strategy::ANTUMBRA, path.camera(frame / 2))
            };
            let report = renderer.render(&mut view, request).unwrap();
            let finished = renderer.finished_image().unwrap();
            assert_eq!((finished.tick, finished.size), (report.tick, renderer.size()));
            states.push(finished.state);
            let copied = host.copy(&*lock, &finished);
            // The copy came after the frame on the same queue, so the frame is over.
            assert!(host.value_of(finished.timeline) >= finished.tick.0);
            assert!(copied == *image.rgba8().unwrap(), "frame {frame} on {driver:?}");
        }
        assert!(states[0] != states[1] && states[0] == states[2]);
        drop((renderer, view, image, device));
        host.finish();
    }
}

/// A check that types are usable on several threads as documented.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    const fn is_send<T: Send>() {}
    is_send_and_sync::<Device>();
    is_send_and_sync::<gpu::Instance>();
    is_send_and_sync::<gpu::Adapter>();
    is_send_and_sync::<gpu::Requirements>();
    is_send_and_sync::<Timeline>();
    is_send_and_sync::<Buffer>();
    is_send_and_sync::<Readback>();
    is_send_and_sync::<gpu::TextureUploads>();
    is_send_and_sync::<gpu::GraphicsPipeline>();
    is_send::<FrameRing>();
    is_send::<gpu::Target>();
    is_send::<gpu::Predicates>();
    is_send::<Renderer>();
    is_send::<render::RenderView>();
    is_send_and_sync::<cull::Hierarchy>();
    is_send_and_sync::<cull::Culler>();
    is_send::<occlusion::CulledScene>();
    is_send::<occlusion::LeafTable>();
    is_send::<occlusion::OcclusionState>();
    is_send::<occlusion::TransparentList>();
};
