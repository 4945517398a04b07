//! A program with a window, which changes its size.

use std::sync::Arc;

use cull::Strategy;
use gpu::{
    Device, PresentResult, PresentSkipped, Readback, Surface, Swapchain, SwapchainOptions, Window,
    WindowSystem,
};
use render::{FrameRequest, Renderer};
use tests::wayland_window::WaylandWindow;
use tests::x11_window::{Library, X11Window};

use super::{Display, Outcome, Program, SIZE, Stage, device_options};

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

    /// Shows frames in a window, and returns the last image.
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
            let size = [SIZE[0] + 8 * (number / 2), SIZE[1]];
            opened.take(size);
            let request = FrameRequest {
                image: Some(&image),
                ..FrameRequest::new(Strategy::ANTUMBRA, *camera)
            };
            renderer.render(&mut view, request)?;
            match renderer.present(&mut swapchain, size)? {
                PresentResult::Not(PresentSkipped::DeviceLost) => {
                    return Err("the device is lost: ERROR_DEVICE_LOST while presenting".into());
                }
                PresentResult::Presented(_) | PresentResult::Not(_) => {}
            }
        }
        renderer.wait_idle(&mut view)?;
        Ok(image.rgba8()?.to_vec())
    }
}
