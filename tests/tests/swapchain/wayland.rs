//! Images in windows of a Wayland compositor without a screen, under validation.

use std::time::{Duration, Instant};

use gpu::{Device, PresentMode, PresentResult, PresentSkipped, Swapchain, SwapchainOptions};
use tests::Driver;
use tests::wayland_window::WaylandWindow;
use tests::weston::Weston;
use tests::window_fixture::{Painter, Random, WindowStage};

const SIZE: [u32; 2] = [320, 200];
const BOUND: Duration = Duration::from_millis(100);
/// The longest time of a call in a frame loop: a few bounds, on any machine.
const A_WHILE: Duration = Duration::from_secs(2);

fn options(mode: PresentMode) -> SwapchainOptions {
    SwapchainOptions { mode, acquire_bound: BOUND, ..Default::default() }
}

#[test]
fn a_window_on_wayland_takes_images_of_every_size_in_every_mode() {
    let compositor = Weston::start();
    let window = WaylandWindow::open(&compositor);
    let stage = WindowStage::new(Driver::Lavapipe, window.clone());
    let offered = stage.surface.present_modes(&stage.device).unwrap();
    assert!(offered.contains(&PresentMode::Mailbox) && offered.contains(&PresentMode::Fifo));
    for mode in PresentMode::ALL {
        // A visible window gets its turn even on a busy machine.
        let options = SwapchainOptions { acquire_bound: 10 * A_WHILE, ..options(mode) };
        let mut swapchain = stage.swapchain(&options);
        let mut painter = Painter::new(&stage.device, SIZE);
        let mut random = Random::new(5);
        let mut size = SIZE;
        let mut sizes = 0;
        for frame in 0..60 {
            window.answer();
            // Only the caller knows that the window has another size.
            if frame % 3 == 0 {
                let next = [1 + random.below(400), 1 + random.below(300)];
                sizes += u64::from(next != size);
                size = next;
            }
            painter.paint(frame, None);
            let shown = swapchain.show(&painter.target, size).unwrap();
            let PresentResult::Presented(presented) = shown else { panic!("{mode}: {shown:?}") };
            assert_eq!((presented.size, presented.id.0), (size, u64::from(frame) + 1));
        }
        assert_eq!(swapchain.mode(), mode.nearest(&offered));
        assert_eq!(
            (swapchain.replaced(), swapchain.show(&painter.target, [0, 9]).unwrap()),
            (sizes - 1, PresentResult::Not(PresentSkipped::NoArea),)
        );
        // A window of Mesa 25.0 has one chain: the first frame of the next one finds the window
        // out of date as long as this one is only retired.
        drop(swapchain);
        stage.device.wait_idle().unwrap();
    }
    stage.end();
}

/// Runs a frame loop to a window that takes no images. Returns the result of each frame.
fn run_loop(
    window: &WaylandWindow,
    device: &Device,
    painter: &mut Painter,
    swapchain: &mut Swapchain,
    frames: u32,
) -> Vec<PresentResult> {
    let mut outcomes = Vec::new();
    let drains = device.wait_counts().other;
    for frame in 0..frames {
        window.answer();
        let began = Instant::now();
        if swapchain.is_ready().unwrap() {
            painter.paint(frame, None);
            outcomes.push(swapchain.show(&painter.target, SIZE).unwrap());
        } else {
            let outcome = swapchain.show(&painter.target, SIZE).unwrap();
            // A visible window may take the image before only now: Mesa 25.0 is late with the
            // first.
            let is_hidden = outcome == PresentResult::Not(PresentSkipped::Hidden);
            assert!(is_hidden || outcome.presented().is_some(), "{outcome:?}");
            outcomes.push(outcome);
        }
        assert!(began.elapsed() < A_WHILE, "frame {frame} took {:?}", began.elapsed());
    }
    assert_eq!(device.wait_counts().other, drains);
    outcomes
}

#[test]
fn a_window_that_nobody_sees_holds_nothing_up() {
    for mode in [PresentMode::Fifo, PresentMode::Mailbox] {
        let mut compositor = Weston::start();
        let window = WaylandWindow::open_hidden(&compositor);
        let stage = WindowStage::new(Driver::Lavapipe, window.clone());
        let mut painter = Painter::new(&stage.device, SIZE);
        let mut swapchain = stage.swapchain(&options(mode));
        let outcomes = run_loop(&window, &stage.device, &mut painter, &mut swapchain, 12);
        let is_hidden =
            |outcome: &PresentResult| *outcome == PresentResult::Not(PresentSkipped::Hidden);
        if mode == PresentMode::Fifo {
            assert!(outcomes[4..].iter().all(is_hidden), "{outcomes:?}");
            assert!(!swapchain.is_ready().unwrap());
        } else {
            let named = |o: &PresentResult| is_hidden(o) || o.presented().is_some();
            assert!(outcomes.iter().all(named), "{outcomes:?}");
        }
        // The window is lost with its compositor.
        compositor.end();
        let gone = (0..20).map(|_| swapchain.show(&painter.target, SIZE).unwrap()).last();
        assert_eq!(gone, Some(PresentResult::Not(PresentSkipped::WindowGone)), "{mode}");
        drop((swapchain, painter));
        stage.end();
    }
}

#[test]
fn a_window_may_be_closed_while_it_holds_a_image_back() {
    let mut compositor = Weston::start();
    let window = WaylandWindow::open_hidden(&compositor);
    let stage = WindowStage::new(Driver::Lavapipe, window.clone());
    let mut painter = Painter::new(&stage.device, SIZE);
    let mut swapchain = stage.swapchain(&options(PresentMode::Fifo));
    run_loop(&window, &stage.device, &mut painter, &mut swapchain, 6);
    assert!(!swapchain.is_ready().unwrap(), "an image is held back");
    let began = Instant::now();
    drop((swapchain, painter));
    assert!(began.elapsed() < A_WHILE, "closing took {:?}", began.elapsed());
    // The window's last objects are freed when the compositor releases the image, and not before.
    let held = stage.surface.holders();
    compositor.end();
    while stage.surface.holders() >= held {
        assert!(began.elapsed() < 10 * A_WHILE, "the window is never let go");
        std::thread::sleep(Duration::from_millis(5));
        stage.device.wait_idle().unwrap();
    }
    stage.end();
}

#[test]
fn a_compositor_that_stands_still_is_a_window_that_is_hidden_for_a_while() {
    for mode in [PresentMode::Fifo, PresentMode::Mailbox] {
        let compositor = Weston::start();
        let window = WaylandWindow::open(&compositor);
        let stage = WindowStage::new(Driver::Lavapipe, window.clone());
        let mut painter = Painter::new(&stage.device, SIZE);
        let mut swapchain = stage.swapchain(&options(mode));
        run_loop(&window, &stage.device, &mut painter, &mut swapchain, 10);
        compositor.freeze();
        let frozen = run_loop(&window, &stage.device, &mut painter, &mut swapchain, 12);
        assert!(
            frozen[8..].iter().all(|o| *o == PresentResult::Not(PresentSkipped::Hidden)),
            "{mode} {frozen:?}"
        );
        compositor.thaw();
        let thawed = run_loop(&window, &stage.device, &mut painter, &mut swapchain, 30);
        assert!(thawed[20..].iter().all(|o| o.presented().is_some()), "{mode}: {thawed:?}");
        drop((swapchain, painter));
        stage.end();
    }
}
