//! Levels of detail, chosen for a few objects per frame.

use cull::{Camera, DetailPolicy, View};

use crate::renderer::Renderer;

impl Renderer {
    /// Lets objects take the levels of detail ([`Surfaces::levels`](scene::Surfaces::levels)) whose
    /// errors are too small to be seen by any of the `cameras`; returns the number of objects that
    /// took another. To be called once per frame, before it: each call looks at no more than 2,048
    /// objects, in turn, so that larger scenes follow the camera some frames late.
    ///
    /// Visibility plays no part in it, so that frames are the same under every strategy. An error
    /// of 0 pixels restores the finest levels.
    pub fn choose_detail(&mut self, cameras: &[Camera], policy: &DetailPolicy) -> u32 {
        let views: Vec<View> = cameras.iter().map(|camera| self.view_of(camera)).collect();
        let geometry = &mut self.passes.geometry;
        if !geometry.lods.are_any() {
            return 0;
        }
        let mut changed = 0;
        for object in geometry.lods.next_batch(self.hierarchy.leaf_objects().len()) {
            let (Some(node), Some(leaf)) =
                (self.hierarchy.node_of(object), self.hierarchy.leaf_of(object))
            else {
                continue;
            };
            let bounds = self.hierarchy.bounds(node);
            let of_view = |view: &View| view.pixels_per_metre(&bounds);
            let pixels_per_metre = views.iter().map(of_view).fold(0.0, f32::max);
            if geometry.select_lod(object, pixels_per_metre, policy) {
                self.executor.leaves.mark_dirty(leaf, geometry.draw_of(object));
                changed += 1;
            }
        }
        if changed > 0 {
            self.revision.advance();
        }
        changed
    }
}
