//! Levels of detail, chosen for a few objects per frame.

use cull::{Camera, CullView, DetailPolicy};

use crate::debug::settled_counts::SettledCounts;
use crate::error::{Error, FOREIGN_VIEW};
use crate::render_view::RenderView;
use crate::renderer::Renderer;

/// A view, and the counts of the samples visible in it.
type SeenView<'a> = (CullView, Option<&'a SettledCounts>);

/// A view that levels of detail are chosen for.
#[derive(Clone, Copy)]
pub struct DetailView<'a> {
    /// The camera of the next frame.
    pub camera: Camera,
    /// The view, with the counts of its frames.
    pub state: &'a RenderView,
}

impl Renderer {
    /// Chooses levels of detail ([`Surfaces::levels`](scene::Surfaces::levels)) for objects: levels
    /// whose errors are too small to be seen by any of the `cameras`. Returns the number of objects
    /// whose level changed. Call it once before each frame: a call visits at most 2,048 objects, in
    /// turn, so larger scenes follow the camera some frames late.
    ///
    /// Visibility is not considered, so frames are the same under every strategy;
    /// [`Renderer::choose_detail_seen`] considers the visible samples. An error of 0 pixels
    /// restores the finest levels.
    pub fn choose_detail(&mut self, cameras: &[Camera], policy: &DetailPolicy) -> u32 {
        let views = cameras.iter().map(|camera| (self.view_of(camera), None));
        let views: Vec<SeenView<'_>> = views.collect();
        self.choose_levels(&views, policy)
    }

    /// Chooses levels of detail as [`Renderer::choose_detail`] does, but objects with few visible
    /// samples may take coarser levels than their distance allows, as [`DetailPolicy::by_samples`]
    /// says. With several samples per pixel, all samples of a pixel together count as one. Samples
    /// are known for objects that a view [watches](RenderView::watch): the samples of their boxes,
    /// which do not depend on the level. For other objects, and for boxes that contain the eye,
    /// only the distance decides. If several views see an object, it takes the finest of their
    /// levels.
    ///
    /// With N frames in flight, counts are N + 1 frames old: an object that comes out from behind a
    /// wall gets finer with this delay. [`RenderView::reset`] forgets the counts. They are
    /// counts of the finished depth, and a count is not used before this age even if it arrives
    /// earlier, so frames are the same under every exact strategy and on a GPU of any speed.
    ///
    /// # Errors
    /// [`Error::ForeignRenderer`] for a view of another renderer. Nothing has changed then.
    pub fn choose_detail_seen(
        &mut self,
        views: &[DetailView<'_>],
        policy: &DetailPolicy,
    ) -> Result<u32, Error> {
        for view in views {
            self.check_renderer(view.state.renderer, FOREIGN_VIEW)?;
        }
        let seen = views
            .iter()
            .map(|view| (self.view_of(&view.camera), Some(view.state.counts.settled())));
        let seen: Vec<SeenView<'_>> = seen.collect();
        Ok(self.choose_levels(&seen, policy))
    }

    fn choose_levels(&mut self, views: &[SeenView<'_>], policy: &DetailPolicy) -> u32 {
        let samples_per_pixel = self.options.samples.count();
        let geometry = &mut self.passes.gpu_scene.geometry;
        if !geometry.lods.are_any() {
            return 0;
        }
        let mut changed = 0;
        for object in geometry.lods.next_batch(self.scene.hierarchy().leaf_objects().len()) {
            let (Some(node), Some(leaf)) =
                (self.scene.hierarchy().node_of(object), self.scene.hierarchy().leaf_of(object))
            else {
                continue;
            };
            let bounds = self.scene.hierarchy().bounds(node);
            let of_view = |(view, counts): &SeenView<'_>| {
                let visible = counts.and_then(|counts| counts.visible_of(object));
                let visible = visible.map(|samples| samples.div_ceil(samples_per_pixel));
                policy.seen_pixels_per_metre(view.pixels_per_metre(&bounds), visible)
            };
            let pixels_per_metre = views.iter().map(of_view).fold(0.0, f32::max);
            if geometry.select_lod(object, pixels_per_metre, policy) {
                self.scene.parts_mut().leaves.mark_dirty(leaf, geometry.draw_of(object));
                changed += 1;
            }
        }
        if changed > 0 {
            self.revision.advance();
        }
        changed
    }
}
