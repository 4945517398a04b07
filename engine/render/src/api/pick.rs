//! Finds the object that owns a pixel, without a wait: a frame of that one pixel is drawn, and read
//! when it is over.

use cull::{Camera, FrameId, LeafExplanation, LeafIndex, LeafRange, ObjectId, Outcome, View};
use glam::Vec2;
use gpu::{Optional, Tick};

use crate::debug::pick::Pick;
use crate::error::Error;
use crate::renderer::Renderer;
use crate::view_state::ViewState;

impl Renderer {
    /// Begins to find the object of the scene, as it was drawn last, that owns the pixel at `pixel`
    /// (from the upper left) of an image seen from `camera`. All objects count, also those that
    /// culling left out; transparent ones do not. Submits a frame of one pixel with all objects
    /// whose boxes lie along its ray: only their triangles decide which is hit. Present the image
    /// before or after the next.
    ///
    /// On a device whose fragment shaders cannot write to buffers, the object with the nearest box
    /// is returned.
    ///
    /// # Errors
    /// No memory; a failed call.
    pub fn pick(&mut self, camera: &Camera, pixel: [u32; 2]) -> Result<Pick, Error> {
        let view = self.view_of(camera);
        let ndc = middle_of(pixel, view.size);
        let origin = view.rays.point(ndc, 0.0);
        let ray = view.rays.along(ndc);
        let objects = self.hierarchy.leaf_objects();
        let met = self.hierarchy.leaves_along(origin, ray).into_iter();
        let met = met.filter_map(|(_, leaf)| Some((leaf, *objects.get(leaf.0 as usize)?)));
        let candidates: Vec<(LeafIndex, ObjectId)> = met.collect();
        let can_test = self.device.capabilities().has(Optional::FragmentStores);
        let tick = match can_test && !candidates.is_empty() {
            true => self.submit_pick(&view, pixel, &candidates)?,
            false => None,
        };
        Ok(Pick { tick, candidates, renderer: self.id })
    }

    fn submit_pick(
        &mut self,
        view: &View,
        pixel: [u32; 2],
        candidates: &[(LeafIndex, ObjectId)],
    ) -> Result<Option<Tick>, Error> {
        let bits = self.device.adapter().limits.sub_pixel_precision_bits;
        let leaves: Vec<LeafIndex> = candidates.iter().map(|(leaf, _)| *leaf).collect();
        self.submit_seen(&view.of_pixel(pixel, bits), &leaves).map(Some)
    }

    /// Returns the object that was found; `Some(None)` if there is none, `None` while that is not
    /// known. It is never known if a newer pick, or [`Renderer::visible_set`], replaced it before.
    ///
    /// # Errors
    /// A pick of another renderer; a lost device.
    pub fn picked(&self, pick: &Pick) -> Result<Option<Option<ObjectId>>, Error> {
        self.check_renderer(pick.renderer, "a pick (`Pick`)")?;
        let first = pick.candidates.first().map(|(_, object)| *object);
        let (Some(tick), Some(seen)) = (pick.tick, &self.seen_leaves) else {
            return Ok(Some(first));
        };
        if !seen.is_newest(tick) || self.device.completed()? < tick {
            return Ok(None);
        }
        let mut candidates = pick.candidates.iter();
        let owner = candidates.find(|(leaf, _)| seen.is_seen(*leaf));
        Ok(Some(owner.map(|(_, object)| *object)))
    }

    /// Explains the decision to draw an object or not in the newest frame of `state`, seen from
    /// `view`, with the outcome by the newest answers and their frame. `None` if there is no such
    /// object, or the view is of another renderer.
    pub fn explain_object(
        &self,
        state: &ViewState,
        view: &View,
        object: ObjectId,
    ) -> Option<(LeafExplanation, Option<(FrameId, Outcome)>)> {
        self.check_view(state).ok()?;
        let plan = state.plan();
        let explained = state.visibility.culler().explain(&self.hierarchy, view, plan, object)?;
        let answers = state.visibility.newest_answers();
        let outcome = explained.outcome(&self.hierarchy, answers);
        Some((explained, answers.first().map(|answer| answer.tag.frame).zip(outcome)))
    }

    /// Returns the number of triangles of an object, in the form in which it is drawn; 0 for a
    /// foreign one.
    pub fn triangles_of(&self, object: ObjectId) -> u64 {
        let leaf = self.hierarchy.leaf_of(object);
        leaf.map_or(0, |first| self.executor.leaves.count(LeafRange { first, count: 1 }).triangles)
    }

    /// Outlines the box of an object in every image from now on, seen through everything; of
    /// several views, in the first.
    ///
    /// # Errors
    /// A shader that does not compile, a failed call.
    pub fn outline(&mut self, object: Option<ObjectId>) -> Result<(), Error> {
        self.passes.pipelines.overlay.prepare(&self.device, &self.shaders)?;
        self.outlined = object;
        Ok(())
    }
}

/// Returns the middle of a pixel in normalised device coordinates.
fn middle_of(pixel: [u32; 2], size: [u32; 2]) -> Vec2 {
    let [x, y] = [0, 1].map(|axis| (pixel[axis] as f32 + 0.5) / size[axis].max(1) as f32);
    Vec2::new(x, y) * 2.0 - 1.0
}
