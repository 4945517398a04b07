//! A renderer that draws, and the promise that it goes on after a change that failed.

use std::error::Error;

use cull::{Camera, Strategy};
use gpu::{Device, Readback, vk};
use render::{FrameRequest, RenderView, Renderer, RendererOptions};
use scene::Scene;
use tests::every_call;

use super::{Outcome, SIZE};

/// A renderer with a view and an image.
pub(super) struct Running {
    pub(super) renderer: Renderer,
    view: RenderView,
    pub(super) image: Readback,
}

impl Running {
    /// Creates a renderer of a scene.
    ///
    /// # Errors
    /// A call that failed.
    pub(super) fn new(
        device: &Device,
        scene: &Scene,
        options: &RendererOptions,
    ) -> Result<Self, Box<dyn Error>> {
        let renderer = Renderer::new(device, scene, options)?;
        let view = renderer.new_view()?;
        Ok(Self { renderer, view, image: Readback::new(device, SIZE)? })
    }

    /// Draws cameras with these strategies in turn, and returns the last image.
    pub(super) fn draw(&mut self, cameras: &[Camera], strategies: &[Strategy]) -> Outcome {
        for (camera, strategy) in cameras.iter().zip(strategies.iter().cycle()) {
            let image = Some(&self.image);
            let request = FrameRequest { image, ..FrameRequest::new(*strategy, *camera) };
            self.renderer.render(&mut self.view, request)?;
        }
        self.renderer.wait_idle(&mut self.view)?;
        Ok(self.image.rgba8()?.to_vec())
    }

    /// Changes what is drawn, and draws it. A change that fails leaves everything as it was: the
    /// next image is `before`, bit for bit, unless its own calls fail.
    pub(super) fn change(
        &mut self,
        camera: Camera,
        before: &[u8],
        change: impl FnOnce(&mut Renderer) -> Result<(), Box<dyn Error>>,
    ) -> Outcome {
        match change(&mut self.renderer) {
            Ok(()) => self.draw(&[camera], &[Strategy::ANTUMBRA]),
            Err(error) => Err(self.still_shows(camera, before, error)),
        }
    }

    /// Checks that the renderer draws what it drew before something else failed, and returns the
    /// error of that.
    pub(super) fn still_shows(
        &mut self,
        camera: Camera,
        before: &[u8],
        error: Box<dyn Error>,
    ) -> Box<dyn Error> {
        let fired = every_call::fired();
        let is_lost = fired.iter().any(|(_, code)| *code == vk::Result::ERROR_DEVICE_LOST);
        match self.draw(&[camera], &[Strategy::ANTUMBRA]) {
            Ok(image) => assert!(image == before, "another image after: {error}"),
            Err(_) if is_lost || every_call::fired().len() > fired.len() => {}
            Err(next) => panic!("no image after: {error}: {next}"),
        }
        error
    }
}
