//! Windows that change a thousand times, in every way that a user can change them.

use gpu::{Acquired, PresentMode, PresentResult, PresentSkipped, SwapchainOptions};
use tests::Driver;
use tests::xvfb::Xvfb;

use tests::display::Show;
use tests::window_fixture::{Painter, Random, WindowStage, await_image, show_surely};
use tests::window_matrix::{LASTING_WAYS, WAYS, modes};
use tests::x11_window::{Library, X11Window};

#[test]
fn a_window_survives_a_thousand_changes() {
    let server = Xvfb::start();
    const STEPS: u32 = 1_000;
    const CHECKS: u64 = 25;
    for (which, &(driver, library)) in LASTING_WAYS.iter().enumerate() {
        let mut size = [320, 200];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let mut random = Random::new(7 + which as u64);
        let modes = modes(driver);
        let mut show = Show::new(&stage, &window, modes[which % modes.len()], size);
        let mut resizes = 0;
        let mut is_mapped = true;
        for step in 0..STEPS {
            let before = size;
            match random.below(20) {
                0 => window.place(random.below(900) as i32 - 100, random.below(700) as i32 - 100),
                1 => {
                    is_mapped = !is_mapped;
                    if is_mapped { window.show() } else { window.hide() }
                }
                kind => {
                    resizes += 1;
                    size = match kind {
                        2 => [1, 1],
                        3 => [1, 1 + random.below(300)],
                        4 => [1 + random.below(300), 1],
                        _ => [1 + random.below(400), 1 + random.below(300)],
                    };
                    window.resize(size);
                }
            }
            show.size = size;
            // Events are late, so the caller sometimes uses an old size.
            show.frame(step, if random.below(4) == 0 { before } else { size });
            if step % (STEPS / CHECKS as u32) == 0 {
                show.check(step);
                is_mapped = true;
            }
        }
        assert!(resizes > 800 && show.presented > 500, "{resizes}, {}", show.presented);
        // At most one swapchain per change: nothing is recreated without a reason.
        assert!(show.swapchain.replaced() <= resizes, "{}", show.swapchain.replaced());
        // At rest nothing is created.
        let replaced = show.swapchain.replaced();
        for seed in 0..20 {
            show.frame(seed, size);
        }
        assert!(show.swapchain.replaced() <= replaced + 1);
        // The compared images were drained. Nothing else waited for the GPU.
        assert_eq!(stage.device.wait_counts().other, CHECKS);
        drop(show);
        stage.end();
    }
}

#[test]
fn an_image_that_is_not_shown_is_what_the_next_frame_gets() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let size = [64, 64];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let mut painter = Painter::new(&stage.device, size);
        let expected = painter.expected(3);
        let mut swapchain = stage.swapchain(&SwapchainOptions::default());
        for _ in 0..20 {
            drop(swapchain.acquire(size).unwrap());
        }
        show_surely(&mut swapchain, &painter.target, size);
        await_image(&expected, || window.pixels(size));
        assert_eq!(swapchain.replaced(), 0, "{driver:?}");
        // The same holds when the window is destroyed with an acquired image.
        drop(swapchain.acquire(size).unwrap());
        drop((swapchain, painter));
        stage.end();
    }
}

#[test]
fn what_is_let_go_is_not_used_again_before_its_time() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        let size = [64, 64];
        let window = X11Window::open(&server, library, size);
        let stage = WindowStage::new(driver, window.clone());
        let mut painter = Painter::new(&stage.device, size);
        let expected = painter.expected(3);
        let mut swapchain = stage.swapchain(&SwapchainOptions::default());
        show_surely(&mut swapchain, &painter.target, size);
        for mode in [PresentMode::Mailbox, PresentMode::Fifo] {
            // The GPU is held back, and with it the wait for the given-up image.
            let gate = gpu::Timeline::new(&stage.device, "gate").unwrap();
            let mut ring = gpu::FrameRing::new(&stage.device, 1).unwrap();
            drop(swapchain.acquire(size).unwrap());
            ring.begin().unwrap().submit(Some(gate.at(gpu::Tick(1)))).unwrap();
            swapchain.set_mode(mode);
            let image = match swapchain.acquire(size).unwrap() {
                Acquired::Image(image) => image,
                Acquired::Not(other) => panic!("{driver:?}: {other:?}"),
            };
            // A present must not depend on a semaphore that is still to be signalled.
            gate.signal(gpu::Tick(1)).unwrap();
            assert!(image.show(&painter.target).unwrap().presented().is_some());
            await_image(&expected, || window.pixels(size));
        }
        drop((swapchain, painter));
        stage.end();
    }
}

#[test]
fn a_window_that_is_destroyed_says_so_and_takes_nothing_with_it() {
    let server = Xvfb::start();
    for (driver, library) in WAYS {
        for &mode in modes(driver) {
            let size = [200, 100];
            let window = X11Window::open(&server, library, size);
            let stage = WindowStage::new(driver, window.clone());
            let mut show = Show::new(&stage, &window, mode, size);
            for seed in 0..5 {
                show.frame(seed, size);
            }
            window.destroy();
            let mut outcomes = Vec::new();
            for seed in 0..8 {
                show.painter.paint(seed, None);
                match show.swapchain.show(&show.painter.target, size).unwrap() {
                    PresentResult::Presented(_) => {}
                    PresentResult::Not(outcome) => outcomes.push(outcome),
                }
            }
            assert_eq!(
                outcomes.last(),
                Some(&PresentSkipped::WindowGone),
                "{driver:?} {library:?} {mode}"
            );
            assert!(
                outcomes
                    .iter()
                    .all(|o| matches!(o, PresentSkipped::OutOfDate | PresentSkipped::WindowGone))
            );
            let Show { painter, swapchain, .. } = show;
            drop((painter, swapchain));
            // The device goes on, in another window.
            let other = X11Window::open(&server, library, size);
            let surface = gpu::Surface::new(&stage.instance, other.clone()).unwrap();
            let mut painter = Painter::new(&stage.device, size);
            let expected = painter.expected(1);
            let options = SwapchainOptions { mode, ..Default::default() };
            let mut swapchain = gpu::Swapchain::new(&stage.device, &surface, &options).unwrap();
            show_surely(&mut swapchain, &painter.target, size);
            await_image(&expected, || other.pixels(size));
            drop((swapchain, painter, surface));
            stage.end();
        }
    }
}

#[test]
fn a_server_that_ends_is_a_window_that_is_gone() {
    // SwiftShader assumes that its server answers. Xlib itself ends the program.
    for mode in PresentMode::ALL {
        let mut server = Xvfb::start();
        let size = [200, 100];
        let window = X11Window::open(&server, Library::Xcb, size);
        let stage = WindowStage::new(Driver::Lavapipe, window.clone());
        let mut painter = Painter::new(&stage.device, size);
        let mut swapchain = stage.swapchain(&SwapchainOptions { mode, ..Default::default() });
        painter.paint(1, None);
        show_surely(&mut swapchain, &painter.target, size);
        server.end();
        let outcomes: Vec<_> =
            (0..6).map(|_| swapchain.show(&painter.target, size).unwrap()).collect();
        assert_eq!(
            outcomes.last(),
            Some(&PresentResult::Not(PresentSkipped::WindowGone)),
            "{mode}: {outcomes:?}"
        );
        drop((swapchain, painter));
        stage.end();
    }
}
