//! Levels of detail, chosen for a few objects per frame.

use cull::{Camera, CullView, DetailPolicy};

use crate::debug::settled_counts::SettledCounts;
use crate::error::Error;
use crate::render_view::RenderView;
use crate::renderer::Renderer;

/// A view, and the counts of what it sees.
type SeenView<'a> = (CullView, Option<&'a SettledCounts>);

impl Renderer {
    /// Lets objects take the levels of detail ([`Surfaces::levels`](scene::Surfaces::levels)) whose
    /// errors are too small to be seen by any of the `cameras`; returns the number of objects that
    /// took another. To be called once per frame, before it: each call looks at no more than 2,048
    /// objects, in turn, so that larger scenes follow the camera some frames late.
    ///
    /// Visibility plays no part in it, so that frames are the same under every strategy;
    /// [`Renderer::choose_detail_seen`] lets visible samples play one. An error of 0 pixels
    /// restores the finest levels.
    pub fn choose_detail(&mut self, cameras: &[Camera], policy: &DetailPolicy) -> u32 {
        let views = cameras.iter().map(|camera| (self.view_of(camera), None));
        let views: Vec<SeenView<'_>> = views.collect();
        self.choose_levels(&views, policy)
    }

    /// Does the same as [`Renderer::choose_detail`], and lets objects of which few samples are
    /// visible take coarser levels than their distance allows, as [`DetailPolicy::by_samples`]
    /// says; of several samples per pixel, so many count as one. Samples are known of the objects
    /// that a view [watches](RenderView::watch): those of their boxes, which no level changes. Of
    /// others, and of boxes that the eye is in, the distance alone decides. Where several views see
    /// an object, the finest of their levels is taken.
    ///
    /// Counts are as many frames old as are in flight, and one more: so late does what comes out
    /// from behind a wall get finer. [`RenderView::reset`] forgets them. They are of the finished
    /// depth, and none is used that happens to arrive earlier, so that frames are the same under
    /// every exact strategy, and on a GPU of any speed.
    ///
    /// # Errors
    /// [`Error::ForeignRenderer`] for a view of another renderer. Nothing has changed then.
    pub fn choose_detail_seen(
        &mut self,
        views: &[(Camera, &RenderView)],
        policy: &DetailPolicy,
    ) -> Result<u32, Error> {
        views.iter().try_for_each(|(_, state)| self.check_view(state))?;
        let seen = views
            .iter()
            .map(|(camera, state)| (self.view_of(camera), Some(state.counts.settled())));
        let seen: Vec<SeenView<'_>> = seen.collect();
        Ok(self.choose_levels(&seen, policy))
    }

    fn choose_levels(&mut self, views: &[SeenView<'_>], policy: &DetailPolicy) -> u32 {
        let samples_per_pixel = self.samples.count();
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
