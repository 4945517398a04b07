//! A program with a window, which changes its size.

use cull::Strategy;
use gpu::{
    Device, PresentResult, PresentSkipped, Readback, Surface, Swapchain, SwapchainOptions,
    WindowSystem,
};
use render::{FrameRequest, Renderer};
use tests::x11_window::{Library, X11Window};

use super::{Outcome, Program, SIZE, Stage, TestWindow, device_options};

impl Program {
    /// Shows frames in a window, and returns the last image.
    pub(super) fn show_in_window(&self, stage: &Stage) -> Outcome {
        let server = self.server.as_ref().ok_or("a server")?;
        let window: TestWindow = X11Window::open(server, Library::Xcb, SIZE);
        let instance = stage.instance(Some(WindowSystem::of(&window)?))?;
        let surface = Surface::new(&instance, window.clone())?;
        let adapter = instance.pick_adapter_for(&surface, Some(stage.driver.device_name()))?;
        let device = Device::new(&instance, &adapter, &device_options())?;
        let mut swapchain = Swapchain::new(&device, &surface, &SwapchainOptions::default())?;
        let mut renderer = Renderer::new(&device, &self.scene, &self.options())?;
        let mut view = renderer.new_view()?;
        let image = Readback::new(&device, SIZE)?;
        for (number, camera) in (0..).zip(&self.cameras) {
            let size = [SIZE[0] + 8 * (number / 2), SIZE[1]];
            window.resize(size);
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
