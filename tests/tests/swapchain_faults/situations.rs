//! Situations in which other programs were lost: a device that is lost between two calls of a
//! frame, a recovery that fails, devices and windows that come and go meanwhile.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cull::{Camera, Strategy};
use gpu::vk::Result as Code;
use gpu::{
    Device, DeviceOptions, Error, Instance, PresentMode, PresentResult, PresentSkipped, Readback,
    Surface, Swapchain, SwapchainOptions, WindowSystem,
};
use pacing::{RecoverySchedule, Retry, Time};
use render::{FrameRequest, RenderView, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind};
use tests::captured_log::CapturedLog;
use tests::every_call::{self, Fault, FaultPlan, Lasts};
use tests::fault_injection::FaultInjection;
use tests::walk::SceneKind;
use tests::window_fixture::{await_image, show_surely};
use tests::x11_window::{Library, X11Window};
use tests::xvfb::Xvfb;
use tests::{Driver, instance_for, instance_with};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::prelude::*;

use crate::{ACQUIRE, Liar, PRESENT, SIZE, failing};

/// Waits until no other test of this program uses [`every_call`], whose plan is that of a process.
pub(super) fn every_call_alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes a call fail from its `nth` call on; a lost device by all calls that can report it.
pub(super) fn fail_forever(call: &str, nth: usize, code: Code) {
    let call = every_call::number_of(call).unwrap();
    let first = Fault { call, nth, code, lasts: Lasts::Forever };
    every_call::install(FaultPlan { first: Some(first), second: None });
}

/// A renderer that keeps its scene.
pub(super) struct Kept {
    pub(super) renderer: Renderer,
    pub(super) view: RenderView,
    path: CameraPath,
}

impl Kept {
    pub(super) fn new(device: &Device) -> Self {
        let GeneratedScene { scene, routes } = SceneKind::City.build(80);
        let scene = Arc::new(scene);
        let options = RendererOptions { size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        renderer.keep_scene(scene).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        Self { view: renderer.new_view().unwrap(), renderer, path }
    }

    pub(super) fn camera(&self, frame: u32) -> Camera {
        self.path.camera(frame)
    }

    fn render(&mut self, frame: u32) -> Result<(), render::Error> {
        let request = FrameRequest::new(Strategy::ANTUMBRA, self.camera(frame));
        self.renderer.render(&mut self.view, request).map(|_| ())
    }

    /// Renders a frame and returns its pixels.
    pub(super) fn pixels(&mut self, frame: u32) -> Vec<[u8; 3]> {
        let image = Readback::new(self.renderer.device(), SIZE).unwrap();
        let request = FrameRequest {
            image: Some(&image),
            ..FrameRequest::new(Strategy::ANTUMBRA, self.camera(frame))
        };
        self.renderer.render(&mut self.view, request).unwrap();
        self.renderer.wait_idle(&mut self.view).unwrap();
        let pixels = image.rgba8().unwrap();
        pixels.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }

    /// Renders frames until one reports the loss of the device.
    fn lose(&mut self) {
        let errors = (0..4).filter_map(|frame| self.render(frame).err());
        let lost =
            errors.map(|error| matches!(&error, render::Error::Gpu(e) if e.is_device_lost()));
        assert_eq!(lost.collect::<Vec<_>>().first(), Some(&true));
    }
}

/// A window of a server, and the swapchain of a device.
pub(super) struct Shown {
    pub(super) window: Arc<X11Window>,
    pub(super) surface: Surface,
    pub(super) swapchain: Option<Swapchain>,
}

impl Shown {
    fn new(instance: &Instance, window: Arc<X11Window>) -> Self {
        let surface = Surface::new(instance, Arc::clone(&window) as _).unwrap();
        Self { window, surface, swapchain: None }
    }

    pub(super) fn open(&self, instance: &Instance, driver: Driver) -> Result<Device, Error> {
        let adapter = instance.pick_adapter_for(&self.surface, Some(driver.device_name()))?;
        Device::new(instance, &adapter, &DeviceOptions::default())
    }

    pub(super) fn follow(&mut self, device: &Device) -> &mut Swapchain {
        let swapchain = Swapchain::new(device, &self.surface, &SwapchainOptions::default());
        self.swapchain.insert(swapchain.unwrap())
    }

    fn present(&mut self, kept: &Kept) -> Result<PresentResult, render::Error> {
        kept.renderer.present(self.swapchain.as_mut().unwrap(), SIZE)
    }

    /// Presents the newest frame, a second time if the window has changed.
    pub(super) fn present_surely(&mut self, kept: &Kept) {
        let first = self.present(kept).unwrap();
        if first == PresentResult::Not(PresentSkipped::OutOfDate) {
            let second = self.present(kept).unwrap();
            assert!(second.presented().is_some(), "{second:?}");
        } else {
            assert!(first.presented().is_some(), "{first:?}");
        }
    }
}

/// Starts windows of one server, and an instance that shows frames in them.
pub(super) fn windows<const COUNT: usize>(server: &Xvfb) -> (Instance, [Shown; COUNT]) {
    let windows = [(); COUNT].map(|()| X11Window::open(server, Library::Xcb, SIZE));
    let instance = instance_for(every_call::entry(), Some(WindowSystem::of(&windows[0]).unwrap()));
    let shown = windows.map(|window| Shown::new(&instance, window));
    (instance, shown)
}

/// Ends an instance, and checks that the layers reported nothing, leaks included.
pub(super) fn end(instance: Instance) {
    let log = instance.validation_log().clone();
    drop(instance);
    assert_eq!(log.drain(), []);
}

#[test]
fn a_device_lost_between_acquire_submit_and_present_lets_the_window_go() {
    let _alone = every_call_alone();
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for call in ["vkAcquireNextImageKHR", "vkQueueSubmit2", "vkQueuePresentKHR"] {
            let (instance, [mut shown]) = windows(&server);
            let device = shown.open(&instance, driver).unwrap();
            shown.follow(&device);
            let mut kept = Kept::new(&device);
            drop(device);
            for frame in 0..3 {
                kept.render(frame).unwrap();
                shown.present(&kept).unwrap();
            }
            kept.render(3).unwrap();
            fail_forever(call, 0, Code::ERROR_DEVICE_LOST);
            let outcome = shown.present(&kept).unwrap();
            let lost = PresentResult::Not(PresentSkipped::DeviceLost);
            assert_eq!(outcome, lost, "{driver:?}, {call}");
            // First what the user sees, then what shows it, then what drew it.
            let Shown { window, surface, swapchain } = shown;
            window.destroy();
            drop(swapchain);
            drop(surface);
            drop(kept);
            every_call::stop();
            end(instance);
        }
    }
}

/// Checks that a loss which the repair of a lost surface meets is a value, too: the release of an
/// image that was acquired and not presented needs a submit.
#[test]
fn a_device_lost_while_a_lost_surface_is_given_up_has_the_same_name() {
    let _alone = every_call_alone();
    every_call::stop();
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let (instance, [mut shown]) = windows(&server);
        let device = shown.open(&instance, driver).unwrap();
        shown.follow(&device);
        let mut kept = Kept::new(&device);
        kept.render(0).unwrap();
        shown.present_surely(&kept);
        kept.render(1).unwrap();
        let call = every_call::number_of("vkQueueSubmit2").unwrap();
        let code = Code::ERROR_OUT_OF_HOST_MEMORY;
        let first = Some(Fault { call, nth: 0, code, lasts: Lasts::Once });
        every_call::install(FaultPlan { first, second: None });
        assert!(shown.present(&kept).unwrap_err().to_string().contains("vkQueueSubmit2"));
        shown.window.destroy();
        fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
        let new_size = [SIZE[0] + 1, SIZE[1]];
        let outcome = kept.renderer.present(shown.swapchain.as_mut().unwrap(), new_size).unwrap();
        assert_eq!(outcome, PresentResult::Not(PresentSkipped::DeviceLost), "{driver:?}");
        assert!(device.is_known_lost());
        drop((shown, kept, device));
        every_call::stop();
        end(instance);
    }
}

#[test]
fn a_present_after_a_recovery_and_before_a_frame_is_refused_by_name() {
    let _alone = every_call_alone();
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let (instance, [mut shown]) = windows(&server);
        let device = shown.open(&instance, driver).unwrap();
        shown.follow(&device);
        let mut kept = Kept::new(&device);
        drop(device);
        let expected = kept.pixels(5);
        fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
        kept.lose();
        let device = shown.open(&instance, driver).unwrap();
        kept.renderer.recover(&device).unwrap();
        every_call::stop();
        shown.follow(&device);
        let error = shown.present(&kept).unwrap_err().to_string();
        assert!(error.contains("submit"), "{error}");
        assert!(kept.pixels(5) == expected, "{driver:?}");
        shown.present_surely(&kept);
        await_image(&expected, || shown.window.pixels(SIZE));
        drop((kept, shown, device));
        end(instance);
    }
}

#[test]
fn devices_that_cannot_be_created_are_tried_again_and_nothing_changes_meanwhile() {
    let _alone = every_call_alone();
    for driver in Driver::ALL {
        let instance = instance_with(every_call::entry());
        let name = driver.device_name();
        let open = || {
            let adapter = instance.pick_adapter(Some(name))?;
            Device::new(&instance, &adapter, &DeviceOptions::default())
        };
        let mut kept = Kept::new(&open().unwrap());
        let expected = kept.pixels(5);
        fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
        kept.lose();
        fail_forever("vkCreateDevice", 0, Code::ERROR_INITIALIZATION_FAILED);
        for _ in 0..5 {
            let error = open().err().unwrap().to_string();
            assert!(error.contains("vkCreateDevice"), "{error}");
        }
        // Attempts that fail in the middle: each loses another device.
        for nth in 0..3 {
            every_call::stop();
            let device = open().unwrap();
            fail_forever("vkQueueSubmit2", nth, Code::ERROR_DEVICE_LOST);
            match kept.renderer.recover(&device) {
                Ok(()) => {
                    assert!(nth > 0, "{driver:?}: nothing was submitted");
                    kept.lose();
                }
                Err(render::Error::Gpu(error)) => assert!(error.is_device_lost(), "{error}"),
                Err(error) => panic!("{error}"),
            }
        }
        every_call::stop();
        kept.renderer.recover(&open().unwrap()).unwrap();
        assert!(kept.pixels(5) == expected, "{driver:?}");
        drop(kept);
        end(instance);
    }
}

#[test]
fn five_losses_in_a_minute_change_nothing_and_the_sixth_ends() {
    let _alone = every_call_alone();
    let instance = instance_with(every_call::entry());
    let adapter = instance.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let open = || Device::new(&instance, &adapter, &DeviceOptions::default()).unwrap();
    let mut kept = Kept::new(&open());
    let expected = kept.pixels(5);
    let mut schedule = RecoverySchedule::default();
    let mut now = Time::from_origin(Duration::ZERO);
    let calls = ["vkQueueSubmit2", "vkWaitSemaphores", "vkGetSemaphoreCounterValue"];
    for call in calls.into_iter().cycle().take(5) {
        fail_forever(call, 0, Code::ERROR_DEVICE_LOST);
        kept.lose();
        let Retry::At(time) = schedule.lost(now) else { panic!("it gave up") };
        kept.renderer.recover(&open()).unwrap();
        every_call::stop();
        assert!(kept.pixels(5) == expected, "after a loss by {call}");
        now = time.after(Duration::from_secs(5));
    }
    fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
    kept.lose();
    assert_eq!(schedule.lost(now), Retry::GiveUp);
    drop(kept);
    every_call::stop();
    end(instance);
}

#[test]
fn with_fewer_devices_than_before_a_renderer_continues_on_one_that_is_there() {
    let _alone = every_call_alone();
    let first = instance_with(every_call::entry());
    let adapter = first.pick_adapter(Some(Driver::Lavapipe.device_name())).unwrap();
    let device = Device::new(&first, &adapter, &DeviceOptions::default()).unwrap();
    let mut kept = Kept::new(&device);
    drop(device);
    kept.render(0).unwrap();
    fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
    kept.lose();
    let none = FaultInjection { has_no_devices: true, ..FaultInjection::default() };
    let second = instance_with(none.entry());
    let error = second.pick_adapter(None).err().unwrap();
    assert!(matches!(error, Error::NoDriver(_)), "{error:?}");
    FaultInjection::default().install();
    let adapter = second.pick_adapter(Some(Driver::SwiftShader.device_name())).unwrap();
    let device = Device::new(&second, &adapter, &DeviceOptions::default()).unwrap();
    kept.renderer.recover(&device).unwrap();
    every_call::stop();
    let shown = kept.pixels(5);
    assert!(shown == Kept::new(&device).pixels(5), "another image than that of a new renderer");
    drop((kept, device));
    end(second);
    end(first);
}

#[test]
fn two_windows_get_over_a_loss_during_the_recovery_from_a_loss() {
    let _alone = every_call_alone();
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let (instance, mut both) = windows::<2>(&server);
        let device = both[0].open(&instance, driver).unwrap();
        for shown in &mut both {
            shown.follow(&device).set_mode(PresentMode::Mailbox);
        }
        let mut kept = Kept::new(&device);
        drop(device);
        for frame in 0..3 {
            kept.render(frame).unwrap();
            for shown in &mut both {
                shown.present(&kept).unwrap();
            }
        }
        // The first window shows a frame of the device that the second one finds lost.
        kept.render(3).unwrap();
        both[0].present(&kept).unwrap();
        fail_forever("vkQueuePresentKHR", 0, Code::ERROR_DEVICE_LOST);
        let outcome = both[1].present(&kept).unwrap();
        assert_eq!(outcome, PresentResult::Not(PresentSkipped::DeviceLost), "{driver:?}");
        let device = both[0].open(&instance, driver).unwrap();
        fail_forever("vkQueueSubmit2", 0, Code::ERROR_DEVICE_LOST);
        let error = kept.renderer.recover(&device).unwrap_err();
        assert!(matches!(&error, render::Error::Gpu(e) if e.is_device_lost()), "{error}");
        every_call::stop();
        let device = both[0].open(&instance, driver).unwrap();
        kept.renderer.recover(&device).unwrap();
        let expected = kept.pixels(5);
        // The second window covers the first one.
        for mut shown in both.into_iter().rev() {
            shown.follow(&device);
            shown.present_surely(&kept);
            await_image(&expected, || shown.window.pixels(SIZE));
        }
        drop((kept, device));
        end(instance);
    }
}

#[test]
fn the_first_swapchain_and_the_first_image_may_fail() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for (call, code) in [
            (c"vkCreateSwapchainKHR", Code::ERROR_OUT_OF_DEVICE_MEMORY),
            (c"vkCreateSwapchainKHR", Code::ERROR_INITIALIZATION_FAILED),
            (c"vkCreateSwapchainKHR", Code::ERROR_SURFACE_LOST_KHR),
            (ACQUIRE, Code::ERROR_OUT_OF_DATE_KHR),
            (ACQUIRE, Code::ERROR_SURFACE_LOST_KHR),
        ] {
            // No other swapchain: SwiftShader refuses a second one for a window until the first one
            // is destroyed, which is a thread's work.
            let mut liar = Liar::without_frames(&server, driver, FaultInjection::default());
            failing(call, 0..1, code).install();
            let outcome = liar.try_show();
            match &outcome {
                Ok(PresentResult::Presented(_) | PresentResult::Not(PresentSkipped::OutOfDate)) => {
                    assert_eq!(
                        code,
                        Code::ERROR_OUT_OF_DATE_KHR,
                        "{driver:?} {call:?}: {outcome:?}"
                    );
                }
                Ok(PresentResult::Not(reason)) => {
                    assert_eq!(
                        *reason,
                        PresentSkipped::SurfaceLost,
                        "{driver:?} {call:?} {code:?}"
                    );
                }
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains("vkCreateSwapchainKHR"), "{driver:?}, {code:?}: {text}");
                }
            }
            FaultInjection::default().install();
            show_surely(&mut liar.swapchain, &liar.painter.target, SIZE);
            // A swapchain that was not created is none that was replaced.
            let replaced = u64::from(call == ACQUIRE);
            assert_eq!(liar.swapchain.replaced(), replaced, "{driver:?}, {call:?}, {code:?}");
            liar.end();
        }
    }
}

/// Runs `test` and returns what was logged as a warning or an error meanwhile by this thread.
pub fn warnings(test: impl FnOnce()) -> String {
    let log = CapturedLog::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt().with_ansi(false);
    let subscriber = subscriber.with_writer(move || writer.clone());
    let logged = subscriber.with_max_level(LevelFilter::WARN).set_default();
    test();
    drop(logged);
    log.take()
}

#[test]
fn a_driver_that_never_has_an_image_does_not_fill_the_log() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for code in [Code::NOT_READY, Code::TIMEOUT] {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            failing(ACQUIRE, 0..usize::MAX, code).install();
            let began = Instant::now();
            let logged = warnings(|| {
                for _ in 0..300 {
                    assert_eq!(liar.show(), PresentResult::Not(PresentSkipped::Hidden));
                }
            });
            let lines = logged.lines().count() as u64;
            assert!(lines <= 1 + began.elapsed().as_secs(), "{driver:?}, {code:?}: {logged}");
            liar.end();
        }
    }
}

#[test]
fn a_present_that_finds_the_surface_lost_again_and_again_ends_by_name() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for (call, times) in [(ACQUIRE, 1), (PRESENT, 1), (PRESENT, 3)] {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            failing(call, 0..times, Code::ERROR_SURFACE_LOST_KHR).install();
            let outcomes: Vec<_> = (0..4).map(|_| liar.show()).collect();
            assert_eq!(outcomes[0], PresentResult::Not(PresentSkipped::SurfaceLost), "{driver:?}");
            if times == 1 {
                assert!(outcomes[3].presented().is_some(), "{driver:?}: {outcomes:?}");
                liar.end();
            } else {
                let gone = PresentResult::Not(PresentSkipped::WindowGone);
                assert_eq!(outcomes[1..], [gone; 3], "{driver:?}");
                liar.close();
            }
        }
    }
}
