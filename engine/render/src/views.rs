//! Several views of one scene in one frame: each has its own eye, its own history and its own part of
//! the picture.
//!
//! Views share the scene, the hierarchy and the submit, and no answers. What one eye of a stereo pair
//! found hidden the other may see past an edge, so an answer of the one is never exact for the other;
//! and as a guess it would cost a test all the same, since what is hidden is tested in every frame.

use std::time::Instant;

use cull::{Camera, Strategy, View};
use gpu::{Device, Frame, PassTime, Readback, Target, Tick, Timeline};
use occlusion::{Area, FrameTimes, MethodRequest, MethodScene, VisibilityState};

use crate::deformers::Skinned;
use crate::error::Error;
use crate::flat_overlay::FlatOverlay;
use crate::passes::CountPass;
use crate::pick::record_outline;
use crate::renderer::{FrameReport, Renderer};
use crate::view_state::{RendererId, ViewState};
use crate::visible_set::{VISIBLE_SET, VisibleSet};

/// One view of a frame.
pub struct ViewTarget<'a> {
    /// What it saw so far. Every eye needs one of its own, the same in each frame.
    pub history: &'a mut ViewState,
    /// Where it is. Its angle of sight is that of the height of `area`.
    pub camera: Camera,
    /// What owns a pixel, for [`Strategy::Ideal`], which knows nothing else.
    pub visible: Option<&'a VisibleSet>,
    /// Where its image goes: at least a pixel, within the picture. Where areas overlap, later eyes
    /// replace what earlier ones drew.
    pub area: Area,
}

impl AsRef<VisibilityState> for ViewTarget<'_> {
    fn as_ref(&self) -> &VisibilityState {
        &self.history.visibility
    }
}

impl AsMut<VisibilityState> for ViewTarget<'_> {
    fn as_mut(&mut self) -> &mut VisibilityState {
        &mut self.history.visibility
    }
}

/// What is wanted of a frame of several views.
#[derive(Clone, Copy)]
pub struct ViewsRequest<'a> {
    /// Who decides what to draw.
    pub strategy: Strategy,
    /// Where to copy the picture, if it is wanted. What no eye covers holds anything.
    pub picture: Option<&'a Readback>,
    /// The frame starts on the GPU once this tick of a host's timeline is reached.
    pub after: Option<(&'a Timeline, Tick)>,
}

impl Renderer {
    /// Renders one frame of several views, one after the other, and submits them together. Waits for
    /// the frame that used this slot N frames ago, and for nothing else.
    ///
    /// # Errors
    /// [`Error::NoView`] where there is no eye: such a frame would leave its picture as it is. A
    /// strategy that the device has not what it takes for; an area that is not in the picture; a
    /// picture of another size; a view or visible set of another renderer, a picture or timeline of
    /// another device; [`Error::NoVisibleSet`], [`Error::OldVisibleSet`]; no memory, a lost device, a
    /// frame that takes too long.
    pub fn render_views(
        &mut self,
        eyes: &mut [ViewTarget<'_>],
        request: &ViewsRequest<'_>,
    ) -> Result<FrameReport, Error> {
        self.render_eyes(eyes, request, None)
    }

    /// Renders the same, and copies what the scene alone shows to `scene_picture`.
    pub(crate) fn render_eyes(
        &mut self,
        eyes: &mut [ViewTarget<'_>],
        request: &ViewsRequest<'_>,
        scene_picture: Option<&Readback>,
    ) -> Result<FrameReport, Error> {
        let method = self.check_frame(eyes, request, scene_picture)?;
        let began = Instant::now();
        self.prepare(method, eyes)?;
        let is_timed = self.is_timed(request.strategy, eyes);
        let outlined = self.outlined_bounds();
        let Self { device, frames, hierarchy, passes, executor, methods, shaders, .. } = self;

        let mut frame = frames.begin()?;
        note_times(&frame, &mut self.pass_times, &mut self.frame_times);
        let views = eyes.iter().map(|eye| view_in(device, &eye.camera, eye.area));
        let views: Vec<View> = views.collect();
        // An explanation may draw the scene as seen from elsewhere.
        let views = Some(views.as_slice()).filter(|_| self.explainer.is_none());
        let Skinned { poses, vertices } =
            passes.upload_changes(&mut frame, hierarchy, executor, views)?;
        if is_timed {
            frame.begin_timing();
        }
        let mut report =
            FrameReport { poses, skinned_vertices: vertices, ..FrameReport::default() };
        for ViewTarget { history, camera, visible, area } in eyes.iter_mut() {
            let view = &view_in(device, camera, *area);
            history.collect(device.completed()?, hierarchy, &executor.leaves);
            report.blended +=
                passes.gather_blended(&mut frame, executor, view, request.strategy)?;
            let wanted = MethodRequest {
                strategy: request.strategy,
                view,
                visible: visible.map_or(&[], VisibleSet::leaves),
                query_budget: self.query_budget,
                after: request.after,
            };
            let mut scene = MethodScene { device, shaders, hierarchy, executor, objects: passes };
            let state = &mut history.visibility;
            let stats = methods[method].record(&mut frame, state, &mut scene, &wanted)?;
            report.tests += stats.tests;
            report.queries += stats.queries;
            passes.count_samples(&mut frame, executor, history, hierarchy, view)?;
        }
        if let Some(picture) = scene_picture {
            let target = &mut passes.target;
            frame.commands().pass("copy picture", |commands| target.copy_to(commands, picture));
        }
        let overlay_began = Instant::now();
        if let Some(eye) = eyes.first() {
            let view = view_in(device, &eye.camera, eye.area);
            let scene = (&mut *passes, &*executor, &*hierarchy);
            if let Some(explainer) = &self.explainer {
                explainer.record(&mut frame, scene, (eye.history, &view))?;
            }
            if let (Some(bounds), Some(overlay)) = (outlined, &self.birds_eye) {
                record_outline(&mut frame, passes, overlay, (bounds, &view))?;
            }
        }
        let (target, overlay) = (&mut passes.target, self.flat_overlay.as_mut());
        finish_picture(&mut frame, target, overlay, request.picture)?;
        report.overlay_cpu = overlay_began.elapsed();

        let waited = frame.waited();
        report.waits = frame.waits();
        report.tick = frame.submit(request.after)?;
        self.submitted();
        self.note_submitted(eyes, is_timed, &mut report);
        report.cpu = began.elapsed().saturating_sub(waited + report.overlay_cpu);
        Ok(report)
    }

    /// Refuses what cannot be drawn. Returns the number of the method that draws it.
    fn check_frame(
        &self,
        eyes: &mut [ViewTarget<'_>],
        request: &ViewsRequest<'_>,
        scene_picture: Option<&Readback>,
    ) -> Result<usize, Error> {
        if eyes.is_empty() {
            return Err(Error::NoView);
        }
        let method = self.method(request.strategy)?;
        for eye in eyes.iter_mut() {
            self.check_view(eye.history)?;
            self.check_area(eye.area)?;
            self.check_visible(request.strategy, eye.visible)?;
            let (slots, leaves) = (self.frames_in_flight(), &self.executor.leaves);
            eye.history.set_frames_in_flight(slots, &self.hierarchy, leaves)?;
        }
        for picture in request.picture.into_iter().chain(scene_picture) {
            self.check_picture(picture)?;
        }
        if let Some((timeline, _)) = request.after {
            self.device.check(timeline, "a renderer (`Renderer`)")?;
        }
        Ok(method)
    }

    /// Returns true if cost models learn from what the next frame takes. What explanations draw beside a
    /// plan says nothing about prices.
    fn is_timed(&self, strategy: Strategy, eyes: &[ViewTarget<'_>]) -> bool {
        let has_turn = |eye: &ViewTarget<'_>| {
            occlusion::is_timed_after(eye.history.visibility.culler().frame())
        };
        strategy.is_governed()
            && self.learns
            && self.explainer.is_none()
            && eyes.iter().all(|eye| eye.history.visibility.has_cost_model())
            && eyes.iter().any(has_turn)
    }

    /// Notes in the views that their frame is on its way, and in the report what they planned.
    fn note_submitted(
        &mut self,
        eyes: &mut [ViewTarget<'_>],
        is_timed: bool,
        report: &mut FrameReport,
    ) {
        let timed_views = is_timed.then_some(eyes.len());
        for ViewTarget { history, .. } in eyes.iter_mut() {
            history.submitted(report.tick, &self.executor.leaves, timed_views);
            report.add(history);
        }
        // What they learn is for the next frame.
        self.frame_times.teach(eyes);
    }

    /// Refuses a set of another renderer, and an ideal frame without one of the scene as it is now.
    fn check_visible(&self, strategy: Strategy, visible: Option<&VisibleSet>) -> Result<(), Error> {
        visible.map_or(Ok(()), |visible| self.check_renderer(visible.renderer(), VISIBLE_SET))?;
        match visible {
            _ if strategy != Strategy::Ideal => Ok(()),
            None => Err(Error::NoVisibleSet),
            Some(visible) if !visible.is_of(self.edition) => Err(Error::OldVisibleSet),
            Some(_) => Ok(()),
        }
    }

    /// Makes what only some methods and frames need, for the first frame that does.
    fn prepare(&mut self, method: usize, eyes: &[ViewTarget<'_>]) -> Result<(), Error> {
        let Self { device, hierarchy, passes, executor, methods, shaders, .. } = self;
        let is_watching = |eye: &ViewTarget<'_>| eye.history.counts.is_watching();
        if passes.counts.is_none() && eyes.iter().any(is_watching) {
            passes.counts = Some(CountPass::new(device, shaders)?);
        }
        let mut scene = MethodScene { device, shaders, hierarchy, executor, objects: passes };
        Ok(methods[method].prepare(&mut scene)?)
    }

    /// The view of `camera` in a part of this renderer's picture.
    pub fn view_in(&self, camera: &Camera, area: Area) -> View {
        view_in(&self.device, camera, area)
    }

    /// Refuses a view of another renderer.
    pub(crate) fn check_view(&self, history: &ViewState) -> Result<(), Error> {
        self.check_renderer(history.renderer, "a view (`ViewState`)")
    }

    /// Refuses what another renderer made.
    pub(crate) fn check_renderer(
        &self,
        maker: RendererId,
        thing: &'static str,
    ) -> Result<(), Error> {
        if maker == self.id { Ok(()) } else { Err(Error::ForeignRenderer { thing }) }
    }

    /// Refuses a picture of another device or size.
    pub(crate) fn check_picture(&self, picture: &Readback) -> Result<(), Error> {
        self.device.check(picture, "a renderer (`Renderer`)")?;
        let (wanted, drawn) = (picture.size(), self.size());
        if wanted == drawn { Ok(()) } else { Err(Error::PictureSize { wanted, drawn }) }
    }

    pub(crate) fn check_area(&self, area: Area) -> Result<(), Error> {
        let picture = self.size();
        if area.fits(picture) { Ok(()) } else { Err(Error::Area { area, picture }) }
    }
}

/// What comes after the views, whoever decided what they show: what is flat over them, and the copy of
/// the picture for who wants it.
pub(crate) fn finish_picture(
    frame: &mut Frame<'_>,
    target: &mut Target,
    overlay: Option<&mut FlatOverlay>,
    picture: Option<&Readback>,
) -> Result<(), Error> {
    overlay.map_or(Ok(()), |overlay| overlay.record(frame, target))?;
    if let Some(picture) = picture {
        frame.commands().pass("copy picture", |commands| target.copy_to(commands, picture));
    }
    Ok(())
}

/// Takes the times of frames that are over, as they are known when a slot is used again.
fn note_times(frame: &Frame<'_>, passes: &mut Vec<PassTime>, frames: &mut FrameTimes) {
    passes.clear();
    passes.extend_from_slice(frame.pass_times());
    if let Some(time) = frame.last_time() {
        frames.take(time);
    }
}

pub(crate) fn view_in(device: &Device, camera: &Camera, area: Area) -> View {
    let bits = device.adapter().limits.sub_pixel_precision_bits;
    View { origin: area.origin, ..View::new(camera, area.size, bits) }
}

impl FrameReport {
    /// Adds what a view did.
    fn add(&mut self, history: &ViewState) {
        let plan = history.plan();
        let predicated = plan.tests.iter().filter(|test| test.leaves.count > 0);
        self.predicated_draws += predicated.count() as u32;
        self.plan += plan.stats;
        // Views that are drawn together learn the same.
        self.corrections = self.corrections.or(history.corrections());
        // No age is less than any, so the larger of two is the older one that there is.
        self.oldest_answer_frames =
            self.oldest_answer_frames.max(history.visibility.answer_ages().max());
        let youngest =
            self.youngest_answer_frames.into_iter().chain(history.visibility.answer_ages().min());
        self.youngest_answer_frames = youngest.min();
    }
}
