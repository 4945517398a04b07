//! A renderer in a window. At rest it creates no Vulkan object and allocates no memory. Switches at
//! run time leave the image right, without waits and leaks.

use std::ffi::CStr;

use cull::Strategy;
use gpu::{PresentMode, Readback, SwapchainOptions};
use render::{FrameRequest, Renderer, RendererOptions};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::Driver;
use tests::counting::allocations;
use tests::fault_injection::{CALLS_THAT_MAKE, CALLS_THAT_SHOW, FaultInjection, calls};
use tests::window_fixture::{Random, WindowStage};
use tests::x11_window::{Library, X11Window};
use tests::xvfb::Xvfb;

const SIZE: [u32; 2] = [160, 90];
const MODES: [(Driver, &[PresentMode]); 2] = [
    (Driver::Lavapipe, &PresentMode::ALL),
    (Driver::SwiftShader, &[PresentMode::Fifo, PresentMode::Mailbox]),
];

/// Returns the number of created objects, without command buffer recordings and without descriptor
/// sets from the pool of a slot: both begin again with every frame.
pub fn made() -> usize {
    const EVERY_FRAME: [&CStr; 4] = [
        c"vkBeginCommandBuffer",
        c"vkEndCommandBuffer",
        c"vkResetCommandPool",
        c"vkAllocateDescriptorSets",
    ];
    let all = CALLS_THAT_MAKE.iter().chain(CALLS_THAT_SHOW);
    all.filter(|call| !EVERY_FRAME.contains(call)).map(|call| calls(call)).sum()
}

/// Returns false for methods of the literature that always wait or are not exact, and for the ideal
/// yardstick.
fn is_ours(strategy: &Strategy) -> bool {
    !strategy.is_blocking() && ![methods::IDEAL, methods::NEXT_FRAME].contains(strategy)
}

#[test]
fn a_frame_loop_at_rest_makes_nothing_and_allocates_nothing() {
    let server = Xvfb::start();
    let GeneratedScene { scene, routes } = city(300, 1).unwrap();
    let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(0);
    let mut allocating = Vec::new();
    for (driver, _) in MODES {
        for strategy in methods::strategies().into_iter().filter(is_ours) {
            let window = X11Window::open(&server, Library::Xcb, SIZE);
            let stage = WindowStage::with_entry(FaultInjection::default().entry(), driver, window);
            let options =
                RendererOptions { methods: methods::all(), size: SIZE, ..Default::default() };
            let mut renderer = Renderer::new(&stage.device, &scene, &options).unwrap();
            renderer.supports(strategy).unwrap();
            let mut view = renderer.new_view().unwrap();
            let mut swapchain = stage.swapchain(&SwapchainOptions::default());
            let mut after_a_while = (0, 0);
            let mut allocated = Vec::with_capacity(200);
            for frame in 0..200 {
                let before = allocations();
                let request = FrameRequest::new(strategy, camera);
                renderer.render(&mut view, request).unwrap();
                view.drain_stats();
                let shown = renderer.present(&mut swapchain, SIZE).unwrap();
                allocated.push(allocations() - before);
                assert!(shown.presented().is_some());
                if frame == 100 {
                    after_a_while = (made(), stage.device.wait_counts().other);
                }
            }
            assert_eq!(made(), after_a_while.0, "{driver:?} {strategy}: objects were made");
            let late: u64 = allocated[100..].iter().sum();
            if late > 0 {
                allocating.push(format!("{driver:?} {strategy}: {late} in 100 frames"));
            }
            drop((swapchain, view, renderer));
            stage.end();
        }
    }
    assert!(allocating.is_empty(), "{allocating:#?}");
}

#[test]
fn a_thousand_switches_leave_the_image_and_keep_nothing() {
    let server = Xvfb::start();
    let GeneratedScene { scene, routes } = city(300, 1).unwrap();
    let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(0);
    for (driver, modes) in MODES {
        let window = X11Window::open(&server, Library::Xcb, SIZE);
        let stage = WindowStage::with_entry(FaultInjection::default().entry(), driver, window);
        let options = RendererOptions { methods: methods::all(), size: SIZE, ..Default::default() };
        let mut renderer = Renderer::new(&stage.device, &scene, &options).unwrap();
        let strategies = methods::strategies().into_iter().filter(is_ours);
        let strategies: Vec<_> = strategies.filter(|s| renderer.supports(*s).is_ok()).collect();
        let mut view = renderer.new_view().unwrap();
        let mut swapchain = stage.swapchain(&SwapchainOptions::default());
        let image = Readback::new(&stage.device, SIZE).unwrap();
        let mut random = Random::new(11);
        let mut strategy = Strategy::FRUSTUM;
        let mut expected = Vec::new();
        let mut halfway = (0, 0);
        let mut most_retired = 0;
        for switch in 0..1000_u32 {
            match switch % 3 {
                0 => strategy = strategies[random.below(strategies.len() as u32) as usize],
                1 => {
                    let count = 1 + random.below(4) as usize;
                    renderer.set_frames_in_flight(count).unwrap();
                    swapchain.set_frames_in_flight(count).unwrap();
                }
                _ => swapchain.set_mode(modes[random.below(modes.len() as u32) as usize]),
            }
            let waits = stage.device.wait_counts().other;
            let is_looked_at = switch % 25 == 0;
            let wanted = is_looked_at.then_some(&image);
            let request = FrameRequest { image: wanted, ..FrameRequest::new(strategy, camera) };
            renderer.render(&mut view, request).unwrap();
            let shown = renderer.present(&mut swapchain, SIZE).unwrap();
            assert!(shown.presented().is_some(), "{driver:?} {switch}: {shown:?}");
            most_retired = most_retired.max(stage.device.retired());
            assert_eq!(stage.device.wait_counts().other, waits, "a switch waits for nothing");
            if is_looked_at {
                stage.device.wait_idle().unwrap();
                let found = image.rgba8().unwrap().to_vec();
                if expected.is_empty() {
                    expected = found;
                } else {
                    assert!(found == expected, "{driver:?} {switch} {strategy}: another image");
                }
            }
            if switch == 500 {
                halfway = (stage.device.memory_use().block_bytes, most_retired);
            }
        }
        stage.device.wait_idle().unwrap();
        let memory = stage.device.memory_use().block_bytes;
        // The strategies used memory in turn, so its layout may differ slightly.
        assert!(memory <= halfway.0 + (8 << 20), "{driver:?}: {memory} bytes, {}", halfway.0);
        assert!(most_retired <= 2 * halfway.1, "{driver:?}: {most_retired}, {}", halfway.1);
        drop((swapchain, image, view, renderer));
        stage.end();
    }
}
