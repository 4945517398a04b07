//! A renderer on a device of its own, without a window.

use scene::Scene;

use crate::error::Error;
use crate::renderer::{Renderer, RendererOptions};

/// A renderer in the making, on the best device that there is.
pub struct HeadlessRenderer<'a> {
    scene: &'a Scene,
    options: RendererOptions,
}

impl Renderer {
    /// Begins a renderer of a scene without a window, on a device that it opens itself.
    pub fn headless(scene: &Scene) -> HeadlessRenderer<'_> {
        HeadlessRenderer { scene, options: RendererOptions::default() }
    }
}

impl HeadlessRenderer<'_> {
    /// Draws images of `width` times `height` pixels in place of 1280x720.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.options.size = [width, height];
        self
    }

    /// Takes these options in place of the default ones, the size among them.
    #[must_use]
    pub fn options(mut self, options: RendererOptions) -> Self {
        self.options = options;
        self
    }

    /// Opens the device and uploads the scene.
    ///
    /// # Errors
    /// Those of [`gpu::open`] and of [`Renderer::new`].
    pub fn build(self) -> Result<Renderer, Error> {
        let device = gpu::open()?;
        Renderer::new(&device, self.scene, &self.options)
    }
}
