//! Several views of one scene in one frame: each has its own eye, its own history and its own part of
//! the picture.
//!
//! Views share the scene, the hierarchy and the submit, and no answers. What one eye of a stereo pair
//! found hidden the other may see past an edge, so an answer of the one is never exact for the other;
//! and as a guess it would cost a test all the same, since what is hidden is tested in every frame.

use std::time::Instant;

use cull::{Camera, Strategy, View};
use gpu::{Device, Frame, Readback, Target, Tick, Timeline};

use crate::dialogue_frame::{DialogueFrame, DialogueRequest};
use crate::error::Error;
use crate::flat_overlay::FlatOverlay;
use crate::frame_passes::FrameIo;
use crate::frame_times;
use crate::passes::{ComputeTest, CountPass};
use crate::pick::record_outline;
use crate::pyramid_frame::{Lists, PyramidFrame, PyramidRequest};
use crate::renderer::{FrameReport, Renderer};
use crate::shader_set::ShaderSet;
use crate::view_state::{RendererId, ViewState};
use crate::visible_set::{VISIBLE_SET, VisibleSet};

/// A part of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// Its upper left corner (pixels from that of the picture).
    pub origin: [u32; 2],
    /// Its width and height (pixels).
    pub size: [u32; 2],
}

impl Area {
    /// All of a picture of `size` pixels.
    pub fn whole(size: [u32; 2]) -> Self {
        Self { origin: [0, 0], size }
    }

    /// Whether it is at least a pixel, and within a picture of `size` pixels.
    pub fn fits(&self, size: [u32; 2]) -> bool {
        let fits = |side: usize| {
            let end = u64::from(self.origin[side]) + u64::from(self.size[side]);
            self.size[side] > 0 && end <= u64::from(size[side])
        };
        fits(0) && fits(1)
    }

    /// Where a view is drawn.
    pub fn of(view: &View) -> Self {
        Self { origin: view.origin, size: view.size }
    }

    /// Parts of equal width side by side, from the left, that cover a picture of `size` pixels: they
    /// differ by a pixel where it cannot be divided. Parts that get no pixel have a width of 0.
    pub fn side_by_side(size: [u32; 2], count: u32) -> impl Iterator<Item = Self> {
        let [width, height] = size;
        let edge =
            move |part: u32| (u64::from(width) * u64::from(part) / u64::from(count.max(1))) as u32;
        (0..count).map(move |part| Self {
            origin: [edge(part), 0],
            size: [edge(part + 1) - edge(part), height],
        })
    }
}

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
        if eyes.is_empty() {
            return Err(Error::NoView);
        }
        self.supports(request.strategy)?;
        for eye in eyes.iter_mut() {
            self.check_view(eye.history)?;
            self.check_area(eye.area)?;
            self.check_visible(request.strategy, eye.visible)?;
            eye.history.follow_ring(self)?;
        }
        for picture in request.picture.into_iter().chain(scene_picture) {
            self.check_picture(picture)?;
        }
        if let Some((timeline, _)) = request.after {
            self.device.check(timeline, "a renderer (`Renderer`)")?;
        }
        let began = Instant::now();
        self.prepare(request.strategy)?;
        self.prepare_counts(eyes)?;
        let outlined = self.outlined_bounds();
        let mut frame = self.frames.begin()?;
        self.pass_times.clear();
        self.pass_times.extend_from_slice(frame.pass_times());
        if let Some(time) = frame.last_time() {
            self.frame_times.take(time);
        }

        let (hierarchy, passes) = (&self.hierarchy, &mut self.passes);
        passes.bring(&mut frame, hierarchy, &self.scatter)?;
        // What explanations draw beside the plan says nothing about prices.
        let is_timed = request.strategy.is_governed()
            && self.learns
            && self.explainer.is_none()
            && eyes.iter().all(|eye| eye.history.is_governed())
            && eyes.iter().any(|eye| frame_times::is_turn(eye.history.culler.frame()));
        if is_timed {
            frame.begin_timing();
        }
        let mut report = FrameReport::default();
        for ViewTarget { history, camera, visible, area } in eyes.iter_mut() {
            let view = &view_in(&self.device, camera, *area);
            history.ingest(self.device.completed()?, hierarchy, &passes.geometry);
            report.blended += passes.gather_blended(&mut frame, view, request.strategy)?;
            if let (Strategy::Pyramid, Some(pyramid)) = (request.strategy, &self.pyramid) {
                let request = PyramidRequest { hierarchy, view };
                pyramid.record(&mut frame, history, passes, &request)?;
                passes.count_samples(&mut frame, history, hierarchy, view)?;
                continue;
            }
            if let (true, Some(dialogue)) = (request.strategy.is_dialogue(), &self.dialogue) {
                let ViewsRequest { strategy, after, .. } = *request;
                let request = DialogueRequest { hierarchy, strategy, view, after };
                let stats = dialogue.record(&mut frame, history, passes, &request)?;
                passes.count_samples(&mut frame, history, hierarchy, view)?;
                report.tests += stats.boxes;
                report.queries += stats.boxes + stats.own_draws;
                continue;
            }
            match (request.strategy, *visible) {
                (Strategy::Ideal, Some(visible)) => history.decide_known(hierarchy, visible),
                (strategy, _) => {
                    let geometry = &passes.geometry;
                    history.decide(hierarchy, geometry, strategy, view, self.query_budget);
                }
            }
            if passes.compute_test.is_none() && !history.questions.compute_tags.is_empty() {
                let size = passes.target.size();
                passes.compute_test = Some(ComputeTest::new(&self.device, &self.shaders, size)?);
            }
            let io = FrameIo::write(&mut frame, history, passes)?;
            passes.record(frame.commands(), history, view, &io);
            passes.count_samples(&mut frame, history, hierarchy, view)?;
        }

        if let Some(picture) = scene_picture {
            let target = &mut passes.target;
            frame.commands().pass("copy picture", |commands| target.copy_to(commands, picture));
        }
        let overlay_began = Instant::now();
        if let (Some(explainer), Some(eye)) = (&self.explainer, eyes.first()) {
            let view = view_in(&self.device, &eye.camera, eye.area);
            explainer.record(&mut frame, passes, hierarchy, (eye.history, &view))?;
        }
        if let (Some(bounds), Some(overlay), Some(eye)) = (outlined, &self.birds_eye, eyes.first())
        {
            let view = view_in(&self.device, &eye.camera, eye.area);
            record_outline(&mut frame, passes, overlay, (bounds, &view))?;
        }
        let (target, overlay) = (&mut passes.target, self.flat_overlay.as_mut());
        finish_picture(&mut frame, target, overlay, request.picture)?;
        report.overlay_cpu = overlay_began.elapsed();

        let waited = frame.waited();
        report.waits = frame.waits();
        let tick = frame.submit(request.after)?;
        report.tick = tick;
        self.submitted();
        let views = eyes.len();
        for ViewTarget { history, .. } in eyes.iter_mut() {
            if is_timed {
                history.sent.submitted(tick, &history.plan, views);
            }
            history.submitted(tick, &self.passes.geometry);
            report.add(history);
        }
        // What they learn is for the next frame.
        self.frame_times.tell(eyes);
        report.cpu = began.elapsed().saturating_sub(waited + report.overlay_cpu);
        Ok(report)
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

    /// Makes what only some strategies need, for the first frame that does.
    fn prepare(&mut self, strategy: Strategy) -> Result<(), Error> {
        if strategy == Strategy::Pyramid && self.pyramid.is_none() {
            self.pyramid = Some(self.pyramid_frame(&self.shaders)?);
        }
        if strategy.is_dialogue() && self.dialogue.is_none() {
            let options = self.dialogue_options;
            self.dialogue = Some(DialogueFrame::new(&self.device, &self.shaders, options)?);
        }
        Ok(())
    }

    pub(crate) fn pyramid_frame(&self, shaders: &ShaderSet) -> Result<PyramidFrame, Error> {
        let lists = self.passes.shading.as_ref().map_or(Lists::One, |_| Lists::Both);
        PyramidFrame::new(&self.device, shaders, &self.hierarchy, self.size(), lists)
    }

    /// Makes what counting needs, for the first frame that counts.
    fn prepare_counts(&mut self, eyes: &[ViewTarget<'_>]) -> Result<(), Error> {
        let is_watching = |eye: &ViewTarget<'_>| eye.history.counts.is_watching();
        if self.passes.counts.is_none() && eyes.iter().any(is_watching) {
            self.passes.counts = Some(CountPass::new(&self.device, &self.shaders)?);
        }
        Ok(())
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

pub(crate) fn view_in(device: &Device, camera: &Camera, area: Area) -> View {
    let bits = device.adapter().limits.sub_pixel_precision_bits;
    View { origin: area.origin, ..View::new(camera, area.size, bits) }
}

impl FrameReport {
    /// Adds what a view did.
    fn add(&mut self, history: &ViewState) {
        let plan = history.plan();
        let predicated = plan.tests.iter().filter(|test| test.leaves.count > 0);
        self.tests += plan.tests.len() as u32;
        self.queries += plan.query_count() as u32;
        self.predicated_draws += predicated.count() as u32;
        self.plan += plan.stats;
        // Views that are drawn together learn the same.
        self.corrections = self.corrections.or(history.corrections());
        // No age is less than any, so the larger of two is the older one that there is.
        self.oldest_answer_frames = self.oldest_answer_frames.max(history.answer_ages().max());
        let youngest = self.youngest_answer_frames.into_iter().chain(history.answer_ages().min());
        self.youngest_answer_frames = youngest.min();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_side_by_side_cover_the_picture() {
        for width in 0..20 {
            for count in 1..5 {
                let areas: Vec<Area> = Area::side_by_side([width, 7], count).collect();
                let mut next = 0;
                for area in &areas {
                    assert_eq!((area.origin, area.size[1]), ([next, 0], 7));
                    assert!(area.size[0].abs_diff(width / count) <= 1);
                    next += area.size[0];
                }
                assert_eq!((areas.len() as u32, next), (count, width));
            }
        }
        let whole = Area { origin: [0, 0], size: [9, 4] };
        assert!(Area::side_by_side([9, 4], 1).eq([whole]));
    }
}
