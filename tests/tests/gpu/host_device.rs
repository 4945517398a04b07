//! The engine on the device of a host, which is made from the engine's requirements alone.

use std::ffi::CString;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cull::Strategy;
use gpu::{
    Buffer, Capabilities, Device, Error, Features, FrameRing, HostDevice, HostQueueLock,
    MemoryKind, Optional, Purpose, Readback, Required, Timeline, vk,
};
use render::{Costs, FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::host_device::Host;
use tests::host_memory::HostMemory;
use tests::machine::{Fault, Machine, calls};
use tests::walk::SceneKind;
use tests::{Driver, open};

const FRAMES: u32 = 6;

/// Draws frames of a city with several strategies, and returns their images.
fn images(device: &Device) -> Result<Vec<Vec<u8>>, render::Error> {
    let GeneratedScene { scene, routes } = SceneKind::City.build(400);
    let path = CameraPath::new(PathKind::Street, &routes).unwrap();
    let options = RendererOptions {
        methods: methods::all(),
        size: [96, 64],
        costs: Costs::Ignored,
        ..Default::default()
    };
    let mut renderer = Renderer::new(device, &scene, &options)?;
    let image = Readback::new(device, renderer.size())?;
    let mut images = Vec::new();
    for strategy in [Strategy::ANTUMBRA, methods::PYRAMID, Strategy::FRUSTUM] {
        let mut view = renderer.new_view()?;
        for frame in 0..FRAMES {
            let request = FrameRequest::new(strategy, path.camera(frame));
            renderer.render(&mut view, &FrameRequest { image: Some(&image), ..request })?;
            renderer.drain(&mut view)?;
            images.push(image.rgba8()?.to_vec());
        }
    }
    Ok(images)
}

/// A lock of a host that counts, and sees if two use the queue at once.
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
    for driver in Driver::ALL {
        let (_instance, own) = open(driver);
        let expected = images(&own).unwrap();
        assert!(expected.windows(2).any(|pair| pair[0] != pair[1]), "images of nothing");
        let host = Host::new(driver, Purpose::Renderer);
        let lock = Arc::new(CountedLock::default());
        let device = host.adopt(Some(host.share_queue(Arc::clone(&lock) as _)));
        assert_eq!(device.capabilities(), own.capabilities());
        assert!(images(&device).unwrap() == expected, "other images on {driver:?}");
        // Each submit held the lock: the device's ticks are their number.
        assert_eq!(lock.uses.load(Ordering::Relaxed), device.submitted().0);
        drop(device);
        // Nothing of the host is gone.
        host.run_once(&*lock, |_| {});
        host.finish();
    }
}

#[test]
fn the_queue_of_a_host_is_used_by_one_at_a_time() {
    for driver in Driver::ALL {
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

#[test]
fn all_memory_of_the_cpu_comes_from_the_host_and_goes_back() {
    for driver in Driver::ALL {
        let memory: &'static HostMemory = Box::leak(Box::default());
        let host = Host::new(driver, Purpose::Renderer);
        let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
        let allocation_callbacks = Some(memory.callbacks());
        let description = HostDevice { allocation_callbacks, queue, ..host.describe() };
        let device = host.try_adopt(description).unwrap();
        images(&device).unwrap();
        assert!(memory.made() > 100, "{memory:?}");
        drop(device);
        assert_eq!(memory.live(), 0, "of {} blocks", memory.made());
        host.finish();
    }
}

#[test]
fn the_pipeline_cache_of_a_host_is_used_and_left_to_it() {
    let (entry, purpose) = (Machine::default().entry(), Purpose::Renderer);
    let host = Host::through(entry, Driver::Lavapipe, purpose, &[], Features::default());
    let cache = host.create_pipeline_cache();
    let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
    let description = HostDevice { pipeline_cache: Some(cache), queue, ..host.describe() };
    images(&host.try_adopt(description).unwrap()).unwrap();
    assert_eq!(calls(c"vkCreatePipelineCache"), 1, "the engine made one of its own");
    // The layer would tell if it was gone already.
    host.destroy_pipeline_cache(cache);
    host.finish();
}

#[test]
fn what_is_required_and_not_on_is_refused_by_its_name() {
    let host = Host::new(Driver::Lavapipe, Purpose::Renderer);
    for purpose in [Purpose::Executor, Purpose::Renderer] {
        let refusal = |change: &dyn Fn(&mut HostDevice)| {
            let mut description = host.describe();
            if purpose == Purpose::Renderer {
                description.queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
            }
            change(&mut description);
            host.try_adopt(description).err().map(|error| error.to_string())
        };
        assert_eq!(refusal(&|_| {}), None);
        let mut named = 0;
        for required in Required::ALL {
            let said = refusal(&|description| match required {
                Required::Vulkan13 => description.api_version = vk::API_VERSION_1_2,
                Required::GraphicsQueue => description.queue_family = u32::MAX,
                feature => {
                    description.features = description.features.without(feature.features());
                }
            });
            let is_feature = required != Required::Depth32;
            let expected = required.is_for(purpose) && is_feature;
            assert_eq!(said.is_some(), expected, "{required:?} for {purpose:?}: {said:?}");
            if let Some(said) = said {
                assert!(said.contains(&format!("lacks {}", required.name())), "{said}");
                named += 1;
            }
        }
        assert_eq!(named, if purpose == Purpose::Renderer { 7 } else { 6 });
    }
    host.finish();
}

#[test]
fn what_is_optional_and_not_on_is_done_without() {
    for driver in Driver::ALL {
        let expected = images(&open(driver).1).unwrap();
        let all = Optional::ALL.map(Optional::features);
        let features = all.into_iter().fold(Features::default(), Features::union);
        let names: Vec<_> = Optional::ALL.map(Optional::extensions).concat().concat();
        let host = Host::without(driver, Purpose::Renderer, &names, features);
        let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
        let features = host.needs.features().without(features);
        let extensions = Vec::<CString>::new();
        let description = HostDevice { queue, features, extensions, ..host.describe() };
        let device = host.try_adopt(description).unwrap();
        assert_eq!(device.capabilities().optional, [Optional::Timestamps]);
        assert!(images(&device).unwrap() == expected, "other images on {driver:?}");
        drop(device);
        host.finish();
    }
}

#[test]
fn an_executor_asks_for_less() {
    let host = Host::new(Driver::Lavapipe, Purpose::Executor);
    let (features, names) = (host.needs.features(), host.needs.extensions());
    assert!(!features.timeline_semaphore && !features.sampler_anisotropy);
    assert_eq!(names, [c"VK_EXT_conditional_rendering"]);
    let device = host.adopt(None);
    let Capabilities { optional, .. } = device.capabilities();
    assert!(optional.iter().all(|what| what.is_for(Purpose::Executor)), "{optional:?}");
    drop(device);
    // A renderer would need more.
    let queue = Some(host.share_queue(Arc::new(Mutex::new(()))));
    let refused = host.try_adopt(HostDevice { queue, ..host.describe() });
    let refused = refused.err().expect("an error").to_string();
    assert!(refused.contains("lacks timelineSemaphore"), "{refused}");
    host.finish();
}

#[test]
fn a_device_without_a_queue_submits_nothing_and_frees_what_frames_are_over() {
    for driver in Driver::ALL {
        let host = Host::new(driver, Purpose::Executor);
        let device = host.adopt(None);
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let errors = [
            FrameRing::new(&device, 2).unwrap().begin().err(),
            device.run_once("nothing", |_| {}).err(),
            device.drain().err(),
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
    // A thing of one handle is none of the other's, though the device is the same.
    let timeline = Timeline::new(&devices[0], "timeline").unwrap();
    let error = devices[1].check(&timeline, "a frame").unwrap_err();
    assert!(matches!(error, Error::Foreign { .. }), "{error}");
    drop((timeline, devices));
    hosts.into_iter().for_each(Host::finish);
}

#[test]
fn frames_wait_for_a_timeline_of_the_host_and_signal_one_that_it_can_read() {
    for driver in Driver::ALL {
        let host = Host::new(driver, Purpose::Renderer);
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
        let raw = host.create_timeline();
        let timeline = host.lend_timeline(&device, raw);
        let mut ring = FrameRing::new(&device, 2).unwrap();
        let tick = ring.begin().unwrap().submit(Some((&timeline, gpu::Tick(7)))).unwrap();
        let ticks = device.timeline_semaphore().unwrap();
        assert!(host.value_of(ticks) < tick.0);
        host.signal(raw, 7);
        device.drain().unwrap();
        assert_eq!(host.value_of(ticks), tick.0);
        drop((timeline, ring, device));
        host.destroy_timeline(raw);
        host.finish();
    }
}

#[test]
fn the_loss_of_a_hosts_device_is_an_error_with_its_name() {
    let error_on = |machine: Machine| {
        let (entry, purpose) = (machine.entry(), Purpose::Renderer);
        let host = Host::through(entry, Driver::Lavapipe, purpose, &[], Features::default());
        let device = host.adopt(Some(host.share_queue(Arc::new(Mutex::new(())))));
        let drawn = images(&device).err();
        // The loss is a lie: its work goes on, which that of a lost device would not.
        host.wait_idle();
        drop(device);
        Machine::default().install();
        host.finish();
        drawn
    };
    let fault = |call, number: usize| Machine {
        faults: vec![Fault {
            call,
            fails: number..usize::MAX,
            code: vk::Result::ERROR_DEVICE_LOST,
        }],
        ..Machine::default()
    };
    assert!(error_on(Machine::default()).is_none());
    for call in [c"vkQueueSubmit2", c"vkWaitSemaphores", c"vkGetSemaphoreCounterValue"] {
        let error = error_on(fault(call, 3)).expect("an error");
        let render::Error::Gpu(error) = error else { panic!("{error}") };
        assert!(error.is_device_lost(), "{error}");
        assert!(error.to_string().contains(call.to_str().unwrap()), "{error}");
    }
}
