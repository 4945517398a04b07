//! Swapchains and devices that end while something may still use them.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use cull::Strategy;
use gpu::vk::Result as Code;
use gpu::{
    Device, DeviceOptions, PresentResult, PresentSkipped, Surface, Swapchain, SwapchainOptions,
    Tick, Timeline,
};
use raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, WindowHandle,
};
use render::FrameRequest;
use tests::Driver;
use tests::every_call::{self, live_objects};
use tests::fault_injection::{CALLS_THAT_WAIT_FOR_PRESENTS, FaultInjection};
use tests::window_fixture::{Painter, show_surely};
use tests::x11_window::X11Window;
use tests::xvfb::Xvfb;

use crate::situations::{Kept, end, every_call_alone, fail_forever, warnings, windows};
use crate::{Liar, SIZE, failing};

/// The number of replaced swapchains that are kept without a proof that their presents are over.
const KEPT: usize = 8;

/// Installs codes of the first `count` waits and reads of present fences.
fn fail_fences(count: usize, waited: Code, read: Code) {
    let [wait, status] = CALLS_THAT_WAIT_FOR_PRESENTS else { panic!("two calls") };
    let faults =
        [failing(wait, 0..count, waited).faults, failing(status, 0..count, read).faults].concat();
    FaultInjection { faults, ..FaultInjection::default() }.install();
}

/// Shows frames in a window that changes its size with each, by swapchains whose images were never
/// presented: nothing waits for a fence of theirs.
fn show_in_new_sizes(liar: &mut Liar, count: u32) {
    for step in 1..=count {
        let size = [SIZE[0] + step, SIZE[1]];
        liar.window.resize(size);
        liar.painter.paint(step, None);
        show_surely(&mut liar.swapchain, &liar.painter.target, size);
    }
}

#[test]
fn a_retired_swapchain_whose_fence_never_signals_is_destroyed_in_the_end() {
    let server = Xvfb::start();
    let out_of_memory = Code::ERROR_OUT_OF_HOST_MEMORY;
    for (waited, read) in [(Code::TIMEOUT, Code::NOT_READY), (out_of_memory, out_of_memory)] {
        // The other driver has no present fences.
        let mut liar = Liar::new(&server, Driver::SwiftShader, FaultInjection::default());
        fail_fences(usize::MAX, waited, read);
        show_in_new_sizes(&mut liar, 3);
        let held = liar.swapchain.retiring() + 1;
        assert!(held > 3, "nothing waits for a fence");
        let began = Instant::now();
        let logged = warnings(|| liar.close());
        assert_eq!(logged.matches("a present did not end").count(), held, "{logged}");
        // All of them have a second, not each.
        assert!(began.elapsed() < Duration::from_secs(held as u64), "{:?}", began.elapsed());
        FaultInjection::default().install();
    }
    // Other devices of the process are not affected.
    drop(tests::instance());
}

/// Checks that a present has its second again when others have ended since one that did not.
#[test]
fn presents_that_end_again_are_waited_for() {
    let server = Xvfb::start();
    // The other driver has no present fences.
    let mut liar = Liar::new(&server, Driver::SwiftShader, FaultInjection::default());
    let logged = warnings(|| {
        fail_fences(usize::MAX, Code::TIMEOUT, Code::NOT_READY);
        show_in_new_sizes(&mut liar, KEPT as u32 + 2);
        FaultInjection::default().install();
        let size = [SIZE[0] + KEPT as u32 + 2, SIZE[1]];
        for _ in 0..8 {
            show_surely(&mut liar.swapchain, &liar.painter.target, size);
        }
    });
    assert!(logged.contains("a present did not end"), "{logged}");
    fail_fences(3, Code::TIMEOUT, Code::NOT_READY);
    let logged = warnings(|| liar.close());
    assert!(!logged.contains("a present did not end"), "{logged}");
    FaultInjection::default().install();
}

/// A window that owns an object of the device that shows frames in it.
struct OwningWindow {
    window: Arc<X11Window>,
    _object: Timeline,
}

impl HasWindowHandle for OwningWindow {
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        self.window.window_handle()
    }
}

impl HasDisplayHandle for OwningWindow {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        self.window.display_handle()
    }
}

/// Checks that the end of a window, with its last swapchain, may drop objects of the device.
#[test]
fn a_window_may_own_an_object_of_its_device() {
    const BOUND: Duration = Duration::from_secs(60);
    let _alone = every_call_alone();
    every_call::stop();
    let (is_done, done) = channel();
    std::thread::spawn(move || {
        let server = Xvfb::start();
        let (instance, [shown]) = windows(&server);
        let device = shown.open(&instance, Driver::Lavapipe).unwrap();
        let window = OwningWindow {
            window: Arc::clone(&shown.window),
            _object: Timeline::new(&device, "of a window").unwrap(),
        };
        drop(shown);
        let surface = Surface::new(&instance, Arc::new(window)).unwrap();
        let mut swapchain =
            Swapchain::new(&device, &surface, &SwapchainOptions::default()).unwrap();
        let mut painter = Painter::new(&device, SIZE);
        painter.paint(1, None);
        show_surely(&mut swapchain, &painter.target, SIZE);
        drop((swapchain, surface));
        device.wait_idle().unwrap();
        assert_eq!(device.retired(), 0);
        drop((painter, device));
        end(instance);
        is_done.send(()).unwrap();
    });
    done.recv_timeout(BOUND).expect("a window that ends while objects are freed");
}

/// Checks that the newest swapchain is there when the submit behind which the oldest of nine is
/// destroyed, without present fences, fails.
#[test]
fn a_submit_that_fails_behind_an_old_swapchain_loses_none() {
    let _alone = every_call_alone();
    every_call::stop();
    let server = Xvfb::start();
    let before = swapchains();
    for code in [Code::ERROR_DEVICE_LOST, Code::ERROR_OUT_OF_HOST_MEMORY] {
        let (instance, [shown]) = windows(&server);
        let device = shown.open(&instance, Driver::Lavapipe).unwrap();
        let options = SwapchainOptions::default();
        let mut swapchain = Swapchain::new(&device, &shown.surface, &options).unwrap();
        let mut painter = Painter::new(&device, SIZE);
        let mut size = SIZE;
        painter.paint(1, None);
        while swapchain.retiring() < KEPT {
            size[0] += 1;
            shown.window.resize(size);
            show_surely(&mut swapchain, &painter.target, size);
        }
        size[0] += 1;
        shown.window.resize(size);
        fail_forever("vkQueueSubmit2", 0, code);
        let failed = swapchain.show(&painter.target, size);
        every_call::stop();
        if code == Code::ERROR_DEVICE_LOST {
            assert_eq!(failed.unwrap(), PresentResult::Not(PresentSkipped::DeviceLost));
        } else {
            assert!(failed.unwrap_err().to_string().contains("vkQueueSubmit2"));
            show_surely(&mut swapchain, &painter.target, size);
        }
        drop((swapchain, painter, device));
        assert_eq!(swapchains(), before, "{code:?}");
        assert_eq!(Arc::strong_count(&shown.window), 2, "the surface has the window, too");
        drop(shown);
        end(instance);
    }
}

/// Checks that a device that does not finish is left as it is, with all that it may use: a
/// swapchain that was dropped, its surface and its window.
#[test]
fn a_gpu_that_hangs_keeps_the_window_of_its_swapchain() {
    let _alone = every_call_alone();
    every_call::stop();
    let server = Xvfb::start();
    let before = swapchains();
    let (instance, [mut shown]) = windows(&server);
    let log = instance.validation_log().clone();
    const WAIT_BOUND: Duration = Duration::from_secs(5);
    let options = DeviceOptions { wait_bound: WAIT_BOUND, ..Default::default() };
    let driver = Some(Driver::Lavapipe.device_name());
    let adapter = instance.pick_adapter_for(&shown.surface, driver).unwrap();
    let device = Device::new(&instance, &adapter, &options).unwrap();
    let mut kept = Kept::new(&device);
    kept.pixels(0);
    shown.follow(&device);
    shown.present_surely(&kept);
    let gate = Timeline::new(&device, "gate").unwrap();
    let request = FrameRequest::new(Strategy::ANTUMBRA, kept.camera(1));
    let request = FrameRequest { after: Some(gate.at(Tick(1))), ..request };
    kept.renderer.render(&mut kept.view, request).unwrap();
    let window = Arc::clone(&shown.window);
    assert!(matches!(device.wait_idle(), Err(gpu::Error::Timeout { .. })));
    let began = Instant::now();
    let logged = warnings(|| drop((shown, kept, gate, device)));
    assert!(began.elapsed() < WAIT_BOUND, "it is waited for again");
    assert!(logged.contains("the device is left as it is"), "{logged}");
    drop(instance);
    // It never becomes idle, which the next loss of a device would wait for.
    every_call::forget_devices();
    assert_eq!(swapchains(), before + 1);
    assert_eq!(Arc::strong_count(&window), 2, "its surface was destroyed");
    assert_eq!(log.drain(), []);
}

/// Returns the number of swapchains that are alive in this process.
fn swapchains() -> i64 {
    live_objects().get("SwapchainKHR").copied().unwrap_or_default()
}
