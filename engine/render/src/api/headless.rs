//! A renderer on a device of its own, without a window.

use scene::Scene;

use crate::error::Error;
use crate::renderer::{Renderer, RendererOptions};

/// A builder of a renderer on the best available device.
pub struct HeadlessRenderer<'a> {
    scene: &'a Scene,
    options: RendererOptions,
}

impl Renderer {
    /// Begins to build a renderer of a scene without a window, on a device that it opens itself.
    pub fn headless(scene: &Scene) -> HeadlessRenderer<'_> {
        HeadlessRenderer { scene, options: RendererOptions::default() }
    }
}

impl HeadlessRenderer<'_> {
    /// Sets the size of images in place of 1280x720.
    #[must_use]
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.options.size = [width, height];
        self
    }

    /// Sets all options, including the size.
    #[must_use]
    pub fn options(mut self, options: RendererOptions) -> Self {
        self.options = options;
        self
    }

    /// Opens the device and uploads the scene.
    ///
    /// # Errors
    /// The errors of [`gpu::open`] and of [`Renderer::new`].
    pub fn build(self) -> Result<Renderer, Error> {
        let device = gpu::open()?;
        Renderer::new(&device, self.scene, &self.options)
    }
}
