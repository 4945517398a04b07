//! The last frame of a walk, with its image and statistics.

use gpu::Readback;

use crate::error::Error;
use crate::last_frame::LastFrame;
use crate::render_view::RenderView;
use crate::renderer::Renderer;
use crate::rgba_image::RgbaImage;
use crate::views::finish_image;

impl Renderer {
    /// Waits until every frame is over. Returns the statistics and the image of the newest frame,
    /// which must show the view. With several views, finish a view before another one is rendered.
    /// Do not use it in a frame loop: it counts as a blocking wait.
    ///
    /// # Errors
    /// [`gpu::Error::NoImage`] before the first frame and after a frame that failed;
    /// [`Error::NotNewest`] if the newest frame shows other views or a snapshot; a view of
    /// another renderer, no memory, a lost device, or a frame that takes too long.
    pub fn finish(&mut self, state: &mut RenderView) -> Result<LastFrame, Error> {
        self.check_view(state)?;
        self.passes.target.finished()?;
        if self.shown_tick != state.shown_tick {
            return Err(Error::NotNewest);
        }
        let size = self.size();
        let image = Readback::new(&self.device, size)?;
        let mut frame = self.frames.begin()?;
        finish_image(&mut frame, &mut self.passes, None, Some(&image))?;
        let tick = frame.submit(None)?;
        self.submitted(tick);
        self.wait_idle(state)?;
        let stats = state.newest_stats();
        let in_frustum = state.seen_from.as_ref();
        let in_frustum =
            in_frustum.map_or(0, |view| self.scene.hierarchy().objects_in_frustum(view));
        let pixels = image.rgba8()?.to_vec();
        Ok(LastFrame {
            drawn: stats.map_or(0, |stats| stats.draws),
            triangles: stats.map_or(0, |stats| stats.triangles),
            in_frustum: u64::from(in_frustum),
            image: RgbaImage { size, pixels },
        })
    }
}
