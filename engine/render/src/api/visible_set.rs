//! The exact set of objects that own a pixel, found in advance with a wait. The frame is drawn by
//! the exact strategy, its objects are drawn again against the finished depth, and the CPU waits
//! for the result.

use cull::{LeafIndex, Rays, Strategy};
use gpu::{Access, MemoryBarrier};
use occlusion::{BucketId, ObjectRenderer, Rect};

use crate::debug::visible_set::{SeenLeaves, VISIBLE_SET, VisibleSet};
use crate::error::{Error, FOREIGN_VIEW};
use crate::passes::SeenIo;
use crate::render_view::RenderView;
use crate::renderer::Renderer;
use crate::views::{ViewRequest, Viewpoint, ViewsRequest};

impl Renderer {
    /// Finds the objects that own a pixel of `area` seen from `viewpoint`. Waits for the GPU twice:
    /// use it for measurements, not in a frame loop. `state` is a view kept for this purpose, so
    /// that its history grows along the path.
    ///
    /// # Errors
    /// A view of another renderer; a matrix that is not a projection; a device whose fragment
    /// shaders cannot write to buffers; no memory; a failed call.
    pub fn visible_set(
        &mut self,
        state: &mut RenderView,
        viewpoint: impl Into<Viewpoint>,
        area: Rect,
    ) -> Result<VisibleSet, Error> {
        self.check_renderer(state.renderer, FOREIGN_VIEW)?;
        let viewpoint = viewpoint.into();
        let target = ViewRequest { state: &mut *state, viewpoint, visible: None, rect: area };
        // The Antumbra strategy may leave out visible objects if there is a threshold, or if no
        // test is exact.
        let is_exact = self.is_exact() && self.supports(Strategy::ANTUMBRA).is_ok();
        let strategy = if is_exact { Strategy::ANTUMBRA } else { Strategy::FRUSTUM };
        let request = ViewsRequest { strategy, image: None, overlay: None, after: None };
        self.render_views(&mut [target], &request)?;
        let view = self.view_in(viewpoint, area)?;
        let snapshot = self.snapshot(state, view)?;
        let drawn = snapshot.drawn.iter();
        let drawn: Vec<LeafIndex> = drawn
            .flat_map(|range| (range.first.0..range.first.0 + range.count).map(LeafIndex))
            .collect();
        self.submit_seen(&snapshot.view, &drawn)?;
        self.device.wait_idle()?;
        let revision = self.revision;
        let Some(seen) = &self.seen_leaves else {
            return Ok(VisibleSet { leaves: Vec::new(), objects: Vec::new(), revision });
        };
        let mut leaves: Vec<LeafIndex> =
            drawn.into_iter().filter(|leaf| seen.is_seen(*leaf)).collect();
        let rays = &snapshot.view.rays;
        leaves.sort_by(|a, b| {
            let near = self.distance_squared(*a, rays);
            let far = self.distance_squared(*b, rays);
            near.total_cmp(&far).then(a.cmp(b))
        });
        let all = self.scene.hierarchy().leaf_objects();
        let objects = leaves.iter().filter_map(|leaf| all.get(leaf.0 as usize)).copied();
        Ok(VisibleSet { objects: objects.collect(), leaves, revision })
    }

    /// Makes a set valid again that was found in the same state of the scene, although the scene
    /// has changed since. The caller guarantees that every object has the place and the form that
    /// it had. Use it for measurements that repeat the same moments.
    ///
    /// # Errors
    /// A set that another renderer found.
    pub fn visible_again(&self, set: &mut VisibleSet) -> Result<(), Error> {
        self.check_renderer(set.renderer(), VISIBLE_SET)?;
        set.leaves.clear();
        set.leaves.extend(
            set.objects.iter().filter_map(|object| self.scene.hierarchy().leaf_of(*object)),
        );
        set.revision = self.revision;
        Ok(())
    }

    /// Returns the squared distance from the eye to the box of a leaf.
    fn distance_squared(&self, leaf: LeafIndex, rays: &Rays) -> f32 {
        let object = self.scene.hierarchy().leaf_objects().get(leaf.0 as usize);
        let node = object.and_then(|object| self.scene.hierarchy().node_of(*object));
        node.map_or(0.0, |node| rays.distance_squared(&self.scene.hierarchy().bounds(node)))
    }

    /// Submits a frame that finds the leaves in `leaves` that own a pixel of `view`.
    pub(crate) fn submit_seen(
        &mut self,
        view: &cull::CullView,
        leaves: &[LeafIndex],
    ) -> Result<(), Error> {
        let passes = &mut self.passes;
        let leaf_table = self.scene.leaves();
        passes.pipelines.seen.prepare(&self.device, &self.shaders)?;
        let seen = match self.seen_leaves.take() {
            Some(seen) => seen,
            None => SeenLeaves::new(&self.device, self.scene.hierarchy().leaf_objects().len())?,
        };
        let seen = self.seen_leaves.insert(seen);
        let mut frame = self.frames.begin()?;
        passes.write_stale(&mut frame)?;
        passes.begin_section(&mut frame, self.scene.hierarchy())?;
        passes.begin_section_view(&mut frame, self.scene.hierarchy(), view)?;
        let draws = frame.uploads().push_iter(leaves.iter().map(|leaf| leaf_table.draw(*leaf)))?;
        let commands = frame.commands();
        let values = seen.values.whole();
        commands.pass("find visible", |commands| {
            let between = MemoryBarrier::between;
            // The previous frame may still copy, if nothing waited for it.
            commands.barrier(between(&[Access::CopyRead, Access::CopyWrite], &[Access::CopyWrite]));
            commands.fill(values, 0);
            commands.barrier(between(&[Access::CopyWrite], &[Access::FragmentWrite]));
            passes.target.prepare(commands);
            let target = passes.image_target(view, passes.sky()).forgotten();
            commands.rendering(target, |commands| {
                passes.draw_caps(commands, view);
                passes.bind(commands, view, BucketId(0));
                if !leaves.is_empty() {
                    commands.draw_indirect(draws);
                }
                let io = SeenIo { opaque: passes.opaque_io(), seen: values };
                if let Some(pass) = passes.pipelines.seen.get().filter(|_| !leaves.is_empty()) {
                    pass.bind(commands, &io, view);
                    commands.draw_indirect(draws);
                }
                passes.note_caps(commands, view, values);
            });
            commands.barrier(between(&[Access::FragmentWrite], &[Access::CopyRead]));
            commands.copy_buffer(values, seen.readback.whole());
            commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
        });
        passes.read_back(commands);
        let tick = frame.submit(None)?;
        passes.stale_submitted(tick);
        Ok(())
    }
}
