//! Section planes in a frame: the inputs of passes that are cut, and the caps of objects that are
//! cut open.

use cull::{CullView, Hierarchy};
use gpu::{BufferSlice, Commands, Frame};

use crate::error::Error;
use crate::passes::{CapIo, CapKind};
use crate::scene_renderer::SceneRenderer;

impl SceneRenderer {
    /// Begins a frame in which objects are drawn.
    pub(crate) fn begin_section(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
    ) -> Result<(), Error> {
        self.section.begin_frame(frame, &self.gpu_scene.geometry, hierarchy)
    }

    /// Begins a view of the current frame, and the draws of its objects.
    pub(crate) fn begin_section_view(
        &mut self,
        frame: &mut Frame<'_>,
        hierarchy: &Hierarchy,
        view: &CullView,
    ) -> Result<(), Error> {
        self.section.begin_view(frame, &self.gpu_scene.geometry, hierarchy, view)
    }

    /// Draws the caps of the current view, if it has any, in a rendering before all others, so that
    /// they hide objects from the first test on.
    pub(crate) fn record_caps(&mut self, commands: &Commands, view: &CullView) {
        if self.section.uploaded_caps.is_none() {
            return;
        }
        self.target.prepare(commands);
        let target = self.image_target(view, self.sky());
        let target = if self.pipelines.shading.is_some() { target.depth_only() } else { target };
        commands.pass("draw caps", |commands| {
            commands.rendering(target, |commands| self.draw_caps(commands, view));
        });
    }

    /// Draws the caps of the current view to the current attachments, before its objects.
    pub(crate) fn draw_caps(&self, commands: &Commands, view: &CullView) {
        let kind = match self.pipelines.shading {
            Some(_) => CapKind::Depth,
            None => CapKind::Whole,
        };
        self.draw_caps_of(commands, view, kind, None);
    }

    /// Adds the colour to caps in scenes with surfaces, against the finished depth.
    pub(crate) fn colour_caps(&self, commands: &Commands, view: &CullView) {
        self.draw_caps_of(commands, view, CapKind::Colour, None);
    }

    /// Records the leaves of caps that own a pixel of the finished depth.
    pub(crate) fn note_caps(&self, commands: &Commands, view: &CullView, seen: BufferSlice) {
        self.draw_caps_of(commands, view, CapKind::Seen, Some(seen));
    }

    /// Records the nearest of the caps that own a pixel of the image, in a rendering that is
    /// clipped to that pixel.
    pub(crate) fn point_at_caps(
        &self,
        commands: &Commands,
        view: &CullView,
        pixel: [u32; 2],
        pointed: BufferSlice,
    ) {
        if self.section.uploaded_caps.is_some() {
            let [x, y] = [0, 1].map(|axis: usize| view.origin[axis] + pixel[axis]);
            commands.clear_stencil([x, y], [1, 1]);
            self.draw_caps_over(commands, view, CapKind::Pointed, Some(pointed));
        }
    }

    fn draw_caps_of(
        &self,
        commands: &Commands,
        view: &CullView,
        kind: CapKind,
        notes: Option<BufferSlice>,
    ) {
        if self.section.uploaded_caps.is_some() {
            commands.clear_stencil(view.origin, view.size);
            self.draw_caps_over(commands, view, kind, notes);
        }
    }

    /// Draws caps; the stencil must be 0.
    fn draw_caps_over(
        &self,
        commands: &Commands,
        view: &CullView,
        kind: CapKind,
        notes: Option<BufferSlice>,
    ) {
        let Some(rows) = self.section.uploaded_caps else { return };
        let Some(pass) = self.pipelines.caps.get() else { return };
        let io = CapIo { opaque: self.opaque_io(), rows, draws: &self.section.cap_draws, notes };
        pass.draw(commands, &io, view, kind);
    }
}
