//! Every error of a driver about a window is named, and the loop goes on as long as the window
//! exists.
// A separate program, since SwiftShader keeps shared memory of every swapchain until its program
// ends, and the system has 4096 pieces.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod endings;
mod situations;

use std::ffi::CStr;

use gpu::raw_window_handle::{DisplayHandle, HandleError, HasDisplayHandle};
use gpu::vk::Result as Code;
use gpu::{
    Error, OptionalFeature, PresentResult, PresentSkipped, Surface, Swapchain, SwapchainOptions,
    WindowSystem,
};
use tests::xvfb::Xvfb;
use tests::{Driver, instance, instance_for};

use tests::fault_injection::{
    CALL_THAT_ASKS_A_WINDOW, CALLS_THAT_OPEN_WINDOWS, CALLS_THAT_SHOW, Fault, FaultInjection, calls,
};
use tests::window_fixture::{Painter, WindowStage, await_image, show_surely};
use tests::x11_window::{Library, X11Window};

const SIZE: [u32; 2] = [96, 64];
const ACQUIRE: &CStr = c"vkAcquireNextImageKHR";
const PRESENT: &CStr = c"vkQueuePresentKHR";

/// A window on a lying machine.
struct Liar {
    stage: WindowStage,
    window: std::sync::Arc<X11Window>,
    painter: Painter,
    swapchain: Swapchain,
    frame: u32,
}

impl Liar {
    /// Opens a window and shows a few frames without lies.
    fn new(server: &Xvfb, driver: Driver, faults: FaultInjection) -> Self {
        let mut liar = Self::without_frames(server, driver, faults);
        for _ in 0..4 {
            assert!(liar.show().presented().is_some());
        }
        liar
    }

    /// Opens a window that has shown nothing yet.
    fn without_frames(server: &Xvfb, driver: Driver, faults: FaultInjection) -> Self {
        let window = X11Window::open(server, Library::Xcb, SIZE);
        let stage = WindowStage::with_entry(faults.entry(), driver, window.clone());
        let painter = Painter::new(&stage.device, SIZE);
        let swapchain = stage.swapchain(&SwapchainOptions::default());
        Self { stage, window, painter, swapchain, frame: 0 }
    }

    fn try_show(&mut self) -> Result<PresentResult, Error> {
        self.frame += 1;
        self.painter.paint(self.frame, None);
        self.swapchain.show(&self.painter.target, SIZE)
    }

    fn show(&mut self) -> PresentResult {
        self.try_show().unwrap()
    }

    /// Stops the lies, and checks that the right image is shown and that everything ends in
    /// order.
    fn end(mut self) {
        FaultInjection::default().install();
        let expected = self.painter.expected(77);
        show_surely(&mut self.swapchain, &self.painter.target, SIZE);
        await_image(&expected, || self.window.pixels(SIZE));
        self.close();
    }

    fn close(self) {
        let Self { stage, painter, swapchain, .. } = self;
        drop((painter, swapchain));
        stage.end();
    }
}

fn failing(call: &'static CStr, fails: std::ops::Range<usize>, code: Code) -> FaultInjection {
    FaultInjection { faults: vec![Fault { call, fails, code }], ..FaultInjection::default() }
}

#[test]
fn what_happens_to_a_window_has_a_name_and_is_got_over() {
    let server = Xvfb::start();
    let lost = Code::ERROR_SURFACE_LOST_KHR;
    let outdated = Code::ERROR_OUT_OF_DATE_KHR;
    for driver in Driver::ALL {
        for (call, times, code, expected) in [
            // The swapchain is recreated, and the frame tried again immediately.
            (ACQUIRE, 1, outdated, None),
            (ACQUIRE, 2, outdated, Some(PresentSkipped::OutOfDate)),
            (ACQUIRE, 1, Code::TIMEOUT, Some(PresentSkipped::Hidden)),
            (ACQUIRE, 1, Code::NOT_READY, Some(PresentSkipped::Hidden)),
            (ACQUIRE, 1, lost, Some(PresentSkipped::SurfaceLost)),
            (ACQUIRE, 1, Code::SUBOPTIMAL_KHR, None),
            (PRESENT, 1, outdated, Some(PresentSkipped::OutOfDate)),
            (PRESENT, 1, lost, Some(PresentSkipped::SurfaceLost)),
            (PRESENT, 1, Code::SUBOPTIMAL_KHR, None),
        ] {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            failing(call, 0..times, code).install();
            let outcome = liar.show();
            let named = match outcome {
                PresentResult::Presented(_) => None,
                PresentResult::Not(not_shown) => Some(not_shown),
            };
            assert_eq!(named, expected, "{driver:?}: {code:?} from {call:?}");
            liar.end();
        }
    }
}

#[test]
fn a_driver_that_always_has_a_better_idea_makes_nothing_anew() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for call in [ACQUIRE, PRESENT] {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            failing(call, 0..usize::MAX, Code::SUBOPTIMAL_KHR).install();
            for _ in 0..50 {
                assert!(liar.show().presented().is_some());
            }
            assert_eq!(liar.swapchain.replaced(), 0, "{driver:?}");
            liar.end();
        }
    }
}

#[test]
fn a_window_that_is_minimised_waits_until_it_is_not_whatever_the_driver_says() {
    let server = Xvfb::start();
    let codes = [
        // The frame is tried again immediately.
        (ACQUIRE, Code::ERROR_OUT_OF_DATE_KHR, PresentSkipped::NoArea),
        (ACQUIRE, Code::ERROR_SURFACE_LOST_KHR, PresentSkipped::SurfaceLost),
        (PRESENT, Code::ERROR_OUT_OF_DATE_KHR, PresentSkipped::OutOfDate),
        (PRESENT, Code::ERROR_SURFACE_LOST_KHR, PresentSkipped::SurfaceLost),
    ];
    for driver in Driver::ALL {
        for (call, code, first) in codes {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            FaultInjection { is_minimised: true, ..failing(call, 0..1, code) }.install();
            let named = |outcome: &PresentResult| match outcome {
                PresentResult::Presented(_) => None,
                PresentResult::Not(not_shown) => Some(*not_shown),
            };
            let outcomes = [(); 6].map(|()| named(&liar.show()));
            let mut expected = [Some(PresentSkipped::NoArea); 6];
            expected[0] = Some(first);
            assert_eq!(outcomes, expected, "{driver:?}, {call:?}, {code:?}");
            assert_eq!(calls(c"vkCreateSwapchainKHR"), 0, "{driver:?}, {call:?}, {code:?}");
            liar.end();
        }
    }
}

#[test]
fn a_surface_that_is_lost_again_at_once_is_a_window_that_is_gone() {
    let server = Xvfb::start();
    let mut liar = Liar::new(&server, Driver::Lavapipe, FaultInjection::default());
    failing(ACQUIRE, 0..usize::MAX, Code::ERROR_SURFACE_LOST_KHR).install();
    let outcomes: Vec<_> = (0..4).map(|_| liar.show()).collect();
    assert_eq!(outcomes[0], PresentResult::Not(PresentSkipped::SurfaceLost));
    assert!(
        outcomes[1..].iter().all(|o| *o == PresentResult::Not(PresentSkipped::WindowGone)),
        "{outcomes:?}"
    );
    liar.close();
}

/// Checks the end of a window as Mesa 25.0 reports it: no memory for a surface.
#[test]
fn a_lost_surface_that_no_other_replaces_is_a_window_that_is_gone() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let mut liar = Liar::new(&server, driver, FaultInjection::default());
        let lost = Fault { call: ACQUIRE, fails: 0..1, code: Code::ERROR_SURFACE_LOST_KHR };
        let refused = Fault {
            call: CALLS_THAT_OPEN_WINDOWS[0],
            fails: 0..1,
            code: Code::ERROR_OUT_OF_HOST_MEMORY,
        };
        FaultInjection { faults: vec![lost, refused], ..FaultInjection::default() }.install();
        let mut outcomes = Vec::new();
        let logged = situations::warnings(|| outcomes.extend((0..2).map(|_| liar.show())));
        assert_eq!(outcomes, [PresentResult::Not(PresentSkipped::WindowGone); 2], "{driver:?}");
        assert!(logged.contains("vkCreateXcbSurfaceKHR"), "{logged}");
        liar.close();
    }
}

#[test]
fn a_lost_device_has_a_name_wherever_it_is_found_out() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        for call in [ACQUIRE, PRESENT, c"vkGetPhysicalDeviceSurfaceCapabilitiesKHR"] {
            let mut liar = Liar::new(&server, driver, FaultInjection::default());
            let faults = failing(call, 0..usize::MAX, Code::ERROR_DEVICE_LOST);
            faults.install();
            // Makes the swapchain query the state of the window.
            liar.swapchain.set_mode(gpu::PresentMode::Mailbox);
            assert_eq!(
                liar.show(),
                PresentResult::Not(PresentSkipped::DeviceLost),
                "{driver:?}, {call:?}"
            );
            liar.close();
        }
        let mut liar = Liar::new(&server, driver, FaultInjection::default());
        liar.painter.paint(1, None);
        failing(c"vkQueueSubmit2", 0..usize::MAX, Code::ERROR_DEVICE_LOST).install();
        let shown = liar.swapchain.show(&liar.painter.target, SIZE).unwrap();
        assert_eq!(shown, PresentResult::Not(PresentSkipped::DeviceLost));
        FaultInjection::default().install();
        liar.end();
    }
}

#[test]
fn a_call_that_fails_is_named_and_the_next_frames_are_shown() {
    let server = Xvfb::start();
    let mut list = vec![ACQUIRE, PRESENT, c"vkCreateSemaphore", c"vkQueueSubmit2"];
    list.push(c"vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    list.extend(CALLS_THAT_SHOW);
    for driver in Driver::ALL {
        for &call in &list {
            for number in 0..3 {
                let mut liar = Liar::new(&server, driver, FaultInjection::default());
                failing(call, number..number + 1, Code::ERROR_OUT_OF_HOST_MEMORY).install();
                let mut errors = Vec::new();
                let mut shown = 0;
                for frame in 0..6 {
                    // Each time the window is recreated.
                    let size = [SIZE[0] + frame, SIZE[1]];
                    liar.window.resize(size);
                    liar.frame += 1;
                    if call != c"vkQueueSubmit2" {
                        liar.painter.paint(frame, None);
                    }
                    match liar.swapchain.show(&liar.painter.target, size) {
                        Ok(PresentResult::Presented(_)) => shown += 1,
                        Ok(PresentResult::Not(PresentSkipped::OutOfDate)) => {}
                        Ok(other) => panic!("{driver:?}, {call:?}: {other:?}"),
                        Err(error) => errors.push(error.to_string()),
                    }
                }
                let is_called = calls(call) > number;
                assert!(is_called || call == c"vkCreateFence", "{call:?} is never called");
                assert_eq!(errors.len(), usize::from(is_called), "{call:?} {number}: {errors:?}");
                assert!(shown >= 3, "{driver:?}, {call:?}, {number}: {shown} shown, {errors:?}");
                for error in errors {
                    assert!(error.contains(call.to_str().unwrap()), "{error}");
                    assert!(error.contains("out of memory"), "{error}");
                }
                liar.window.resize(SIZE);
                liar.end();
            }
        }
    }
}

#[test]
fn without_present_fences_old_swapchains_end_all_the_same() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let faults = FaultInjection { is_fenceless: true, ..FaultInjection::default() };
        let mut liar = Liar::new(&server, driver, faults);
        assert!(!liar.stage.device.capabilities().has(OptionalFeature::PresentFences));
        let mut most = 0;
        for step in 0..200 {
            let size = [SIZE[0] + step % 50, SIZE[1]];
            // Sometimes a few frames of one size, then many sizes in a row.
            if step % 40 > 20 {
                liar.window.resize(size);
            }
            liar.painter.paint(step, None);
            let _any = liar.swapchain.show(&liar.painter.target, size).unwrap();
            most = most.max(liar.swapchain.retiring());
        }
        assert!(most > 1, "a proof is waited for");
        liar.window.resize(SIZE);
        for _ in 0..12 {
            liar.show();
        }
        assert_eq!(liar.swapchain.retiring(), 0, "{driver:?}: the proof has come");
        liar.end();
    }
}

#[test]
fn present_fences_are_used_where_there_are_any() {
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let liar = Liar::new(&server, driver, FaultInjection::default());
        let has_fences = liar.stage.device.capabilities().has(OptionalFeature::PresentFences);
        // Newer versions of Mesa have them, too.
        if driver == Driver::SwiftShader {
            assert!(has_fences);
        } else if liar.stage.device.adapter().driver.contains("Mesa 22.3") {
            assert!(!has_fences);
        }
        assert_eq!(calls(c"vkCreateFence") > 0, has_fences);
        liar.end();
    }
}

#[test]
fn nothing_shows_a_window_and_every_device_says_why() {
    let server = Xvfb::start();
    let window = X11Window::open(&server, Library::Xcb, SIZE);
    let system = WindowSystem::of(&window).unwrap();
    let faults = FaultInjection { is_blind: true, ..FaultInjection::default() };
    let instance = instance_for(faults.entry(), Some(system));
    let surface = Surface::new(&instance, window).unwrap();
    for wanted in [None, Some("llvmpipe"), Some("swiftshader")] {
        let error = instance.pick_adapter_for(&surface, wanted).unwrap_err();
        assert!(matches!(error, Error::CannotPresent(_)), "{error}");
        let text = error.to_string();
        assert!(text.contains("has no queue that can show frames in this window"), "{text}");
        assert!(text.contains("draw without a window"), "{text}");
    }
    FaultInjection::default().install();
    let best = instance.pick_adapter_for(&surface, None).unwrap();
    assert!(best.capabilities.has(OptionalFeature::Swapchain));
    let error = instance.pick_adapter_for(&surface, Some("voodoo")).unwrap_err();
    assert!(matches!(error, Error::UnknownDevice { .. }), "{error}");
}

#[test]
fn a_device_whose_driver_fails_for_a_window_is_left_out() {
    let server = Xvfb::start();
    let window = X11Window::open(&server, Library::Xcb, SIZE);
    let system = WindowSystem::of(&window).unwrap();
    let instance = instance_for(FaultInjection::default().entry(), Some(system));
    let surface = Surface::new(&instance, window).unwrap();
    let first = instance.adapters().unwrap().swap_remove(0).name;
    let call = CALL_THAT_ASKS_A_WINDOW;
    let fails = |fails| FaultInjection {
        faults: vec![Fault { call, fails, code: Code::ERROR_OUT_OF_HOST_MEMORY }],
        ..FaultInjection::default()
    };
    fails(0..1).install();
    assert_ne!(instance.pick_adapter_for(&surface, None).unwrap().name, first);
    fails(0..usize::MAX).install();
    let error = instance.pick_adapter_for(&surface, None).unwrap_err();
    assert!(matches!(error, Error::Vulkan { .. }), "{error}");
}

/// A display that is gone.
struct NoDisplay;

impl HasDisplayHandle for NoDisplay {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        Err(HandleError::Unavailable)
    }
}

#[test]
fn no_display_and_no_windows_say_so() {
    let error = WindowSystem::of(&NoDisplay).unwrap_err().to_string();
    assert!(error.contains("no display") && error.contains("draw without a window"), "{error}");
    // An instance without windows is not affected.
    let server = Xvfb::start();
    let window = X11Window::open(&server, Library::Xcb, SIZE);
    let instance = instance();
    let error = Surface::new(&instance, window).err().expect("an error").to_string();
    assert!(error.contains("InstanceOptions::windows"), "{error}");
    let adapter = instance.pick_adapter(None).unwrap();
    let windowed =
        [OptionalFeature::Swapchain, OptionalFeature::PresentFences, OptionalFeature::PresentWait];
    assert!(windowed.into_iter().all(|optional| !adapter.capabilities.has(optional)));
}
