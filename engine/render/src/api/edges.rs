//! Edges of objects, and outlines.

use crate::edges::{EdgeMode, EdgeOptions, ObjectOutline, check_edges, check_outlines};
use crate::error::Error;
use crate::renderer::Renderer;
use crate::resources::edge_meshes::EdgeMeshes;

impl Renderer {
    /// Returns the options of edges.
    pub fn edges(&self) -> &EdgeOptions {
        &self.passes.edges.options
    }

    /// Draws the edges of objects in every view from now on. The first call with a mode other than
    /// [`EdgeMode::Off`], and a call with another crease angle, find the edges of all meshes and
    /// wait for copies: do not make such calls in every frame. [`EdgeMode::Off`] costs nothing; the
    /// memory of the edges is freed once no object is outlined either.
    ///
    /// The edges of every object around the frustum are drawn, including hidden objects, so the
    /// image is the same under every strategy.
    ///
    /// # Errors
    /// [`Error::Edges`]; meshes beyond the device's limits, a shader that does not compile, no
    /// memory, a failed call. Nothing has changed then.
    pub fn set_edges(&mut self, options: EdgeOptions) -> Result<(), Error> {
        check_edges(&options)?;
        if options.mode != EdgeMode::Off {
            self.passes.pipelines.edges.prepare(&self.device, &self.shaders)?;
            self.find_edges(&options)?;
        }
        self.passes.edges.options = options;
        self.drop_unused_edges();
        Ok(())
    }

    /// Outlines objects in every view from now on. Later outlines lie above earlier ones; an empty
    /// list ends outlining. The first call finds the edges of all meshes, as
    /// [`Renderer::set_edges`] does.
    ///
    /// # Errors
    /// The errors of [`Renderer::set_edges`]; a device that cannot draw to a stencil.
    pub fn set_outlined(&mut self, outlines: &[ObjectOutline]) -> Result<(), Error> {
        check_outlines(outlines)?;
        let outlines: Vec<_> =
            outlines.iter().filter(|outline| !outline.objects.is_empty()).cloned().collect();
        if !outlines.is_empty() {
            self.passes.pipelines.outlines.prepare(&self.device, &self.shaders)?;
            let options = self.passes.edges.options;
            self.find_edges(&options)?;
        }
        self.passes.edges.outlines = outlines;
        self.drop_unused_edges();
        Ok(())
    }

    /// Returns the outlines that have objects.
    pub fn outlined(&self) -> &[ObjectOutline] {
        &self.passes.edges.outlines
    }

    /// Finds the edges of all meshes, unless edges by the same rules are known.
    fn find_edges(&mut self, options: &EdgeOptions) -> Result<(), Error> {
        let passes = &mut self.passes;
        let known = passes.edges.meshes.as_ref();
        if known.is_some_and(|edges| *edges.rules() == options.rules()) {
            return Ok(());
        }
        let edges = EdgeMeshes::new(
            &self.device,
            &passes.gpu_scene.geometry,
            passes.gpu_scene.skinned_meshes.as_ref(),
            self.scene.hierarchy(),
            options.rules(),
        )?;
        passes.edges.meshes = Some(edges);
        Ok(())
    }

    fn drop_unused_edges(&mut self) {
        if !self.passes.edges.has_draws() {
            self.passes.edges.meshes = None;
            self.passes.edges.resized();
        }
    }
}
