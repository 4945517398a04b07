//! A program with a window, which changes its size.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cull::Strategy;
use gpu::{
    Device, PresentResult, PresentSkipped, Readback, Surface, Swapchain, SwapchainOptions, Window,
    WindowSystem,
};
use render::{FrameRequest, Renderer};
use tests::wayland_window::WaylandWindow;
use tests::x11_window::{Library, X11Window};

use super::{Display, Outcome, Program, SIZE, Stage, device_options};

/// The frames in which a window must show one, beside those that a fault has taken from it.
const ATTEMPTS: usize = 4;

/// The time in which a presented image must be in its window.
const SHOWN: Duration = Duration::from_secs(2);

/// A window that shows no frame, and the last reason.
#[derive(Clone, Copy, Debug)]
pub struct Unshown(pub PresentSkipped);

impl Error for Unshown {}

impl std::fmt::Display for Unshown {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "no frame is shown: {}", self.0)
    }
}

/// Presents the newest frame until the window shows it.
///
/// # Errors
/// A call that failed, the loss of the device, or the reason why the window shows nothing.
pub(super) fn show_surely(
    renderer: &Renderer,
    swapchain: &mut Swapchain,
    size: [u32; 2],
) -> Result<(), Box<dyn Error>> {
    let mut last = PresentSkipped::Hidden;
    for _ in 0..ATTEMPTS {
        match renderer.present(swapchain, size)? {
            PresentResult::Presented(_) => return Ok(()),
            PresentResult::Not(PresentSkipped::DeviceLost) => {
                return Err(Box::new(Unshown(PresentSkipped::DeviceLost)));
            }
            PresentResult::Not(reason) => last = reason,
        }
    }
    Err(Box::new(Unshown(last)))
}

/// Waits until a window has the pixels of an image of its size.
///
/// # Errors
/// Another image.
pub(super) fn await_shown(window: &X11Window, image: &[u8]) -> Result<(), Box<dyn Error>> {
    let expected: Vec<[u8; 3]> = image
        .as_chunks::<4>()
        .0
        .iter()
        .map(|[red, green, blue, _]| [*red, *green, *blue])
        .collect();
    let began = Instant::now();
    while window.pixels(SIZE) != expected {
        if began.elapsed() > SHOWN {
            return Err("the window has another image than the last one".into());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

/// A window that a test opened.
enum Opened {
    X11(Arc<X11Window>),
    Wayland(Arc<WaylandWindow>),
}

impl Opened {
    fn shared(&self) -> Arc<dyn Window> {
        match self {
            Self::X11(window) => window.clone(),
            Self::Wayland(window) => window.clone(),
        }
    }

    /// Gives the window a size. On Wayland it has that of its images.
    fn take(&self, size: [u32; 2]) {
        match self {
            Self::X11(window) => window.resize(size),
            Self::Wayland(window) => window.answer(),
        }
    }
}

impl Program {
    fn open(&self) -> Result<Opened, &'static str> {
        match self.display.as_ref().ok_or("no server of windows")? {
            Display::X11(server) => Ok(Opened::X11(X11Window::open(server, Library::Xcb, SIZE))),
            Display::Wayland(server) => Ok(Opened::Wayland(WaylandWindow::open(server))),
        }
    }

    /// Shows frames in a window, and returns the last image, which the window has.
    pub(super) fn show_in_window(&self, stage: &Stage) -> Outcome {
        let opened = self.open()?;
        let window = opened.shared();
        let instance = stage.instance(Some(WindowSystem::of(&window)?))?;
        let surface = Surface::new(&instance, window)?;
        let adapter = instance.pick_adapter_for(&surface, Some(stage.driver.device_name()))?;
        let device = Device::new(&instance, &adapter, &device_options())?;
        let mut swapchain = Swapchain::new(&device, &surface, &SwapchainOptions::default())?;
        let mut renderer = Renderer::new(&device, &self.scene, &self.options())?;
        let mut view = renderer.new_view()?;
        let image = Readback::new(&device, SIZE)?;
        for (number, camera) in (0..).zip(&self.cameras) {
            // The window has the size of the images in the end.
            let size = [SIZE[0] + 8 * (number % 2), SIZE[1]];
            opened.take(size);
            let request = FrameRequest {
                image: Some(&image),
                ..FrameRequest::new(Strategy::ANTUMBRA, *camera)
            };
            renderer.render(&mut view, request)?;
            show_surely(&renderer, &mut swapchain, size)?;
        }
        renderer.wait_idle(&mut view)?;
        let pixels = image.rgba8()?.to_vec();
        if let Opened::X11(window) = &opened {
            await_shown(window, &pixels)?;
        }
        Ok(pixels)
    }
}
