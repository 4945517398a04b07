//! A window of a test that shows an image after every change.

use gpu::{PresentMode, PresentResult, PresentSkipped, Swapchain, SwapchainOptions};

use crate::window_fixture::{Painter, WindowStage, await_image, show_surely};
use crate::x11_window::X11Window;

/// The most swapchains that wait to be destroyed: eight that wait for a proof that they are unused,
/// and one that is being replaced.
const MOST_RETIRING: usize = 9;

/// A window that shows an image after every change.
pub struct Show<'a> {
    /// The window's device.
    pub stage: &'a WindowStage,
    /// The window that shows the images.
    pub window: &'a X11Window,
    /// The source of images.
    pub painter: Painter,
    /// The swapchain under test.
    pub swapchain: Swapchain,
    /// The window's size in pixels.
    pub size: [u32; 2],
    /// Frames that were not presented because the swapchain was out of date.
    pub out_of_date: u32,
    /// Frames that were presented.
    pub presented: u32,
}

impl<'a> Show<'a> {
    /// Creates a swapchain with a present mode for a window of `size` pixels.
    pub fn new(
        stage: &'a WindowStage,
        window: &'a X11Window,
        mode: PresentMode,
        size: [u32; 2],
    ) -> Self {
        let options = SwapchainOptions { mode, ..Default::default() };
        Self {
            stage,
            window,
            painter: Painter::new(&stage.device, [64, 48]),
            swapchain: stage.swapchain(&options),
            size,
            out_of_date: 0,
            presented: 0,
        }
    }

    /// Draws a frame of any size, for a window that the caller believes to have `believed` pixels.
    pub fn frame(&mut self, seed: u32, believed: [u32; 2]) {
        self.painter.paint(seed, None);
        match self.swapchain.show(&self.painter.target, believed).unwrap() {
            PresentResult::Presented(_) => self.presented += 1,
            PresentResult::Not(PresentSkipped::OutOfDate) => self.out_of_date += 1,
            PresentResult::Not(other) => panic!("{other:?}"),
        }
        assert!(self.swapchain.retiring() <= MOST_RETIRING, "{}", self.swapchain.retiring());
        // Retired swapchains, and the objects of a few frames, wait for a tick.
        assert!(self.stage.device.retired() < 40, "{}", self.stage.device.retired());
    }

    /// Checks that the window shows exactly the image that was drawn for its size.
    pub fn check(&mut self, seed: u32) {
        self.window.show();
        self.window.place(0, 0);
        let mut painter = Painter::new(&self.stage.device, self.size);
        let expected = painter.expected(seed);
        let presented = show_surely(&mut self.swapchain, &painter.target, self.size);
        assert_eq!(presented.size, self.size);
        await_image(&expected, || self.window.pixels(self.size));
    }
}
