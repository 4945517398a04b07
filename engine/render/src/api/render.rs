//! Frames: one or several views of a scene, drawn and submitted together.

use std::time::{Duration, Instant};

use cull::{Aabb, CullView, QueryShares, Strategy};
use gpu::{Frame, PassTime, Readback, SampleCount};
use occlusion::{CulledScene, FrameTimes, Method, MethodRequest, Rect};
use scene::LensFlare;

use crate::attachment_schedule::{AttachmentSchedule, ColourEnd, ViewScopes};
use crate::debug::debug_overlay::DebugOverlay;
use crate::debug::outline::record_outline;
use crate::debug::pointer::record_pointer;
use crate::debug::sample_counts::count_samples;
use crate::debug::visible_set::{VISIBLE_SET, VisibleSet};
use crate::edges::{EdgeMode, record_edges, record_outlines};
use crate::error::{Error, FOREIGN_VIEW};
use crate::flares::record_flares;
use crate::render_view::{RenderView, RendererId};
use crate::renderer::Renderer;
use crate::resources::skinned_meshes::PoseUploads;
use crate::scene_renderer::SceneRenderer;
use crate::shading::fragments::Fragments;
use crate::shadows::MapUses;
use crate::view_pass::ViewPass;
use crate::views::{
    FrameReport, FrameRequest, ViewRequest, Viewpoint, ViewsRequest, finish_image, finish_scene,
};

impl Renderer {
    /// Renders one frame and submits it: a camera with the default strategy, or a [`FrameRequest`].
    /// Waits only for the frame that used this slot N frames ago, unless the strategy blocks
    /// ([`Strategy::is_blocking`]).
    ///
    /// # Errors
    /// The errors of [`Renderer::render_views`].
    pub fn render<'a>(
        &mut self,
        state: &mut RenderView,
        request: impl Into<FrameRequest<'a>>,
    ) -> Result<FrameReport, Error> {
        let rect = Rect::whole(self.size());
        let FrameRequest { strategy, viewpoint, visible, image, scene_image, overlay, after } =
            request.into();
        let target = ViewRequest { state, viewpoint, visible, rect };
        let request = ViewsRequest { strategy, image, overlay, after };
        self.render_targets(&mut [target], &request, scene_image)
    }

    /// Renders one frame of several views, one after the other, and submits them together. Waits
    /// only for the frame that used this slot N frames ago.
    ///
    /// # Errors
    /// [`Error::NoView`] without a view, since such a frame would leave its image as it is. A
    /// strategy that the device does not support; an area that is not in the image; an image of
    /// another size; a view or visible set of another renderer; an image or timeline of another
    /// device; [`Error::CullView`] and [`Error::StandardDepth`] for a matrix;
    /// [`Error::NoVisibleSet`], [`Error::OldVisibleSet`]; no memory, even for a frame without tests
    /// ([`Strategy::FRUSTUM`]), which is drawn if there is none for them; a lost device, a frame
    /// that takes too long.
    pub fn render_views(
        &mut self,
        targets: &mut [ViewRequest<'_>],
        request: &ViewsRequest<'_>,
    ) -> Result<FrameReport, Error> {
        self.render_targets(targets, request, None)
    }

    /// Renders a frame like [`Renderer::render_targets`], with the memory that is there.
    pub(crate) fn render_tested(
        &mut self,
        targets: &mut [ViewRequest<'_>],
        request: &ViewsRequest<'_>,
        scene_image: Option<&Readback>,
    ) -> Result<FrameReport, Error> {
        let method = self.check_frame(targets, request, scene_image)?;
        let request = &ViewsRequest { strategy: self.usable(request.strategy), ..*request };
        let began = Instant::now();
        self.prepare(method, targets)?;
        let is_timed = self.is_timed(request.strategy, targets);
        let outlined = self.outlined_bounds();
        let views = self.take_views(targets)?;
        let uploads = self.pose_uploads(&views, targets);
        let map_uses = self.map_uses();
        let after_views = self.overlay_scopes(targets, scene_image);
        let Self { frames, scene, passes, methods, flares, .. } = self;

        let mut frame = frames.begin()?;
        note_times(&frame, &mut self.pass_times, &mut self.frame_times);
        passes.begin_section(&mut frame, scene.hierarchy())?;
        passes.upload_changes(&mut frame, scene, uploads, &views, map_uses)?;
        if is_timed {
            frame.begin_timing();
        }
        let mut report = FrameReport::default();
        let method = &mut methods[method];
        plan_views(
            &mut self.query_shares,
            self.options.query_budget,
            &mut **method,
            scene,
            targets,
            &views,
            request,
        )?;
        for (number, (ViewRequest { state, visible, .. }, view)) in
            (0..).zip(targets.iter_mut().zip(&views))
        {
            let strategy = request.strategy;
            let mut view_pass = ViewPass { passes, frame: &mut frame, scene, view };
            report.transparent += begin_view(&mut view_pass, number, strategy)?;
            begin_scopes(passes, state, flares, number, after_views);
            let wanted = method_request(*visible, view, request);
            let visibility = &mut state.visibility;
            let stats = method.record(&mut frame, visibility, scene, passes, &wanted)?;
            report.tests += stats.tests;
            report.queries += stats.queries;
            state.seen_from = Some(*view);
            let mut view_pass = ViewPass { passes, frame: &mut frame, scene, view };
            finish_view(&mut view_pass, flares, state)?;
        }
        finish_scene(&mut frame, passes, scene_image)?;
        let debug_overlay = self.debug_overlay;
        let overlays = Overlays { debug_overlay, outlined, scopes: after_views };
        let first = targets.first();
        report.overlay_cpu = overlays.record(&mut frame, passes, scene, first, request)?;
        passes.read_back(frame.commands());
        let waited = frame.waited();
        report.waits = frame.waits();
        report.tick = frame.submit(request.after)?;
        request.overlay.inspect(|overlay| overlay.submitted());
        self.views = views;
        self.submitted(report.tick);
        self.shown_tick = Some(report.tick);
        self.note_submitted(targets, is_timed, &mut report);
        report.cpu = began.elapsed().saturating_sub(waited + report.overlay_cpu);
        Ok(report)
    }

    /// Returns the renderings of a frame after the renderings of its views. With several samples
    /// per pixel, the last rendering averages them if it covers the whole image and nothing reads
    /// the image before.
    fn overlay_scopes(
        &self,
        targets: &[ViewRequest<'_>],
        scene_image: Option<&Readback>,
    ) -> ViewScopes {
        let has_debug = !self.debug_overlay.is_empty();
        let has_layers = self.debug_overlay.has_depth_complexity;
        let overlays = [
            (AttachmentSchedule::Layers, has_layers),
            (AttachmentSchedule::DepthComplexity, has_layers),
            (AttachmentSchedule::DebugLines, has_debug),
            (AttachmentSchedule::ViewFromAbove, has_debug),
            (AttachmentSchedule::Outline, self.outlined_bounds().is_some()),
        ];
        let colour = match (self.options.samples, targets, scene_image) {
            (SampleCount::One, ..) => ColourEnd::Read,
            (_, [_], None) if !has_debug => ColourEnd::Averaged,
            _ => ColourEnd::Read,
        };
        ViewScopes::ending(colour).and(overlays)
    }

    /// Returns the views of a frame, in memory that is kept from frame to frame.
    fn take_views(&mut self, targets: &[ViewRequest<'_>]) -> Result<Vec<CullView>, Error> {
        let mut views = std::mem::take(&mut self.views);
        views.clear();
        let section = self.passes.section.planes;
        for target in targets {
            views.push(CullView { section, ..target.view(&self.device)? });
        }
        Ok(views)
    }

    /// Refuses a frame that cannot be drawn. Returns the index of the method that draws it.
    fn check_frame(
        &self,
        targets: &mut [ViewRequest<'_>],
        request: &ViewsRequest<'_>,
        scene_image: Option<&Readback>,
    ) -> Result<usize, Error> {
        if targets.is_empty() {
            return Err(Error::NoView);
        }
        let method = self.method(request.strategy)?;
        for target in targets.iter_mut() {
            self.check_renderer(target.state.renderer, FOREIGN_VIEW)?;
            self.check_area(target.rect)?;
            self.check_visible(request.strategy, target.visible)?;
            if target.state.generation != self.generation {
                target.state.follow_device(self.generation, self.new_visibility()?);
            }
            target.state.follow_frames_in_flight(&self.scene)?;
        }
        for image in request.image.into_iter().chain(scene_image) {
            self.check_image(image)?;
        }
        if let Some(after) = request.after {
            self.device.check(after.timeline, "a renderer (`Renderer`)")?;
        }
        Ok(method)
    }

    /// Returns true if cost models learn from the time of the next frame. They do not if the debug
    /// overlay or edges are drawn, since these are not part of a plan.
    fn is_timed(&self, strategy: Strategy, targets: &[ViewRequest<'_>]) -> bool {
        let views = targets.iter().map(|target| &target.state.visibility);
        let is_alone = self.debug_overlay.is_empty() && !self.passes.edges.has_draws();
        is_alone && self.frame_times.is_due(strategy, views)
    }

    /// Notes in the views that their frame was submitted, and adds their plans to the report.
    fn note_submitted(
        &mut self,
        targets: &mut [ViewRequest<'_>],
        is_timed: bool,
        report: &mut FrameReport,
    ) {
        report.add_skinned(self.passes.gpu_scene.skinned());
        report.shadows = self.passes.shadows.stats();
        report.fragments = self.fragment_counts();
        let timed_views = is_timed.then_some(targets.len());
        for ViewRequest { state, .. } in targets.iter_mut() {
            state.submitted(report.tick, &self.scene, timed_views);
            report.add(state);
        }
        // Cost models use these times from the next frame on.
        self.frame_times.teach(targets);
    }

    /// Returns the readers of shadow maps. The debug overlay may draw the scene from another place.
    /// With several samples, a surface is shaded in the middle of a pixel, where the depth is not
    /// known.
    fn map_uses(&self) -> MapUses {
        if self.debug_overlay.is_empty() && self.options.samples == SampleCount::One {
            MapUses::ShadedView
        } else {
            MapUses::Anywhere
        }
    }

    /// Returns the poses to upload for a frame of these views.
    fn pose_uploads<'a>(
        &self,
        views: &'a [CullView],
        targets: &[ViewRequest<'_>],
    ) -> PoseUploads<'a> {
        // The debug overlay may draw the scene from another place, and watched objects are drawn
        // even if they are hidden.
        let draws_hidden = |target: &ViewRequest<'_>| target.state.counts.is_watching();
        let draws_all = !self.debug_overlay.is_empty() || self.passes.edges.has_draws();
        if draws_all || targets.iter().any(draws_hidden) {
            PoseUploads::All
        } else {
            PoseUploads::Seen(views)
        }
    }

    /// Refuses a set of another renderer, and a frame of the ideal without a set of the present
    /// scene.
    fn check_visible(&self, strategy: Strategy, visible: Option<&VisibleSet>) -> Result<(), Error> {
        visible.map_or(Ok(()), |visible| self.check_renderer(visible.renderer(), VISIBLE_SET))?;
        match visible {
            _ if !strategy.needs_still_scene() => Ok(()),
            None => Err(Error::NoVisibleSet(strategy)),
            Some(visible) if !visible.is_of(self.revision) => Err(Error::OldVisibleSet),
            Some(_) => Ok(()),
        }
    }

    /// Creates the objects that only some methods and frames need, before the first such frame.
    fn prepare(&mut self, method: usize, targets: &[ViewRequest<'_>]) -> Result<(), Error> {
        let Self { device, scene, passes, methods, shaders, .. } = self;
        let is_watching = |target: &ViewRequest<'_>| target.state.counts.is_watching();
        if targets.iter().any(is_watching) {
            passes.pipelines.count.prepare(device, shaders)?;
        }
        if targets.iter().any(|target| target.state.pointer.is_pointing()) {
            passes.pipelines.pointer.prepare(device, shaders)?;
        }
        Ok(methods[method].prepare(scene, passes, shaders)?)
    }

    /// Returns the view from `viewpoint` in a part of this renderer's image.
    ///
    /// # Errors
    /// [`Error::InvalidView`] for numbers that are not finite and for an empty area; a matrix that
    /// is not a projection, or whose depth is not reversed.
    pub fn view_in(&self, viewpoint: impl Into<Viewpoint>, area: Rect) -> Result<CullView, Error> {
        let view = viewpoint.into().view(&self.device, area)?;
        Ok(CullView { section: self.passes.section.planes, ..view })
    }

    /// Refuses a view of another renderer, and a view whose rings lie on a lost device.
    pub(crate) fn check_view(&self, state: &RenderView) -> Result<(), Error> {
        self.check_renderer(state.renderer, FOREIGN_VIEW)?;
        if state.generation == self.generation { Ok(()) } else { Err(Error::ViewOfLostDevice) }
    }

    /// Refuses an object of another renderer.
    pub(crate) fn check_renderer(
        &self,
        maker: RendererId,
        thing: &'static str,
    ) -> Result<(), Error> {
        if maker == self.id { Ok(()) } else { Err(Error::ForeignRenderer { thing }) }
    }

    /// Refuses an image of another device or size.
    pub(crate) fn check_image(&self, image: &Readback) -> Result<(), Error> {
        self.device.check(image, "a renderer (`Renderer`)")?;
        let wanted = image.size();
        let drawn = self.size();
        if wanted == drawn { Ok(()) } else { Err(Error::ImageSize { wanted, drawn }) }
    }

    pub(crate) fn check_area(&self, area: Rect) -> Result<(), Error> {
        let image = self.size();
        if area.fits(image) { Ok(()) } else { Err(Error::Rect { area, image }) }
    }
}

/// Reads the available results, and plans the views of a frame.
fn plan_views(
    shares: &mut QueryShares,
    query_budget: usize,
    method: &mut dyn Method,
    scene: &CulledScene,
    targets: &mut [ViewRequest<'_>],
    views: &[CullView],
    request: &ViewsRequest<'_>,
) -> Result<(), Error> {
    let completed = scene.device().completed()?;
    let queries = |target: &ViewRequest<'_>| target.state.plan().query_count();
    shares.plan_views(query_budget, targets, queries, |number, target, share| {
        let ViewRequest { state, visible, .. } = target;
        state.collect(completed, scene);
        let wanted = method_request(*visible, &views[number], request);
        method.plan(&mut state.visibility, scene, &wanted, share);
    });
    Ok(())
}

/// Uploads what the shading of a view draws besides objects; the view is given by its index in the
/// frame. Returns the number of transparent objects in its frustum.
fn begin_view(
    view_pass: &mut ViewPass<'_, '_>,
    number: u32,
    strategy: Strategy,
) -> Result<u32, Error> {
    let ViewPass { passes, frame, scene, view } = view_pass;
    let SceneRenderer { gpu_scene, pipelines, shadows, .. } = &mut **passes;
    let geometry = &gpu_scene.geometry;
    shadows.begin_view(frame, number, view, geometry, scene.hierarchy(), pipelines)?;
    passes.begin_section_view(frame, scene.hierarchy(), view)?;
    passes.record_caps(frame.commands(), view);
    passes.gpu_scene.gather_transparent(frame, scene, view, strategy)
}

/// Notes the renderings of a view, by its index in the frame. Overlays follow the renderings of the
/// first view.
fn begin_scopes(
    passes: &mut SceneRenderer,
    state: &RenderView,
    flares: &[LensFlare],
    number: u32,
    after_views: ViewScopes,
) {
    let has_flares = !flares.is_empty();
    let shades = passes.pipelines.shading.is_some();
    let has_transparent = passes
        .gpu_scene
        .transparent
        .as_ref()
        .is_some_and(|transparent| !transparent.list().is_empty());
    let has_fragments = passes.gpu_scene.fragments().and_then(Fragments::io).is_some();
    let mode = passes.edges.options.mode;
    let later = if number == 0 { after_views } else { ViewScopes::default() };
    passes.scopes = Some(later.and([
        (AttachmentSchedule::LastRound, true),
        (AttachmentSchedule::CasterTests, shades),
        (AttachmentSchedule::Shade, shades),
        (AttachmentSchedule::Fragments, shades && has_transparent && has_fragments),
        (AttachmentSchedule::Transparent, shades && has_transparent),
        (AttachmentSchedule::SampleCounts, state.counts.is_watching()),
        (AttachmentSchedule::Pointer, state.pointer.is_pointing()),
        (AttachmentSchedule::FlareTransmittance, has_flares),
        (AttachmentSchedule::FlareCounts, has_flares),
        (AttachmentSchedule::Flares, has_flares),
        (AttachmentSchedule::Edges, mode != EdgeMode::Off && !mode.is_on_paper()),
        (AttachmentSchedule::EdgesOnPaper, mode.is_on_paper()),
        (AttachmentSchedule::StencilOutlines, !passes.edges.outlines.is_empty()),
    ]));
}

/// Records the end of a view, after everything of its frame is drawn: counts, flares, edges and
/// outlines.
fn finish_view(
    view_pass: &mut ViewPass<'_, '_>,
    flares: &[LensFlare],
    state: &mut RenderView,
) -> Result<(), Error> {
    let RenderView { counts, pointer, flares: flare_counts, visibility, .. } = state;
    count_samples(view_pass, counts, visibility)?;
    record_pointer(view_pass, pointer, visibility)?;
    record_flares(view_pass, flares, flare_counts, visibility)?;
    record_edges(view_pass)?;
    record_outlines(view_pass)
}

/// Returns the request for one view of a frame.
fn method_request<'a>(
    visible: Option<&'a VisibleSet>,
    view: &'a CullView,
    &ViewsRequest { strategy, after, .. }: &ViewsRequest<'a>,
) -> MethodRequest<'a> {
    let visible = visible.map_or::<&[_], _>(&[], VisibleSet::leaves);
    MethodRequest { strategy, view, visible, after }
}

/// The overlays over the scene.
struct Overlays {
    debug_overlay: DebugOverlay,
    /// The box that is outlined.
    outlined: Option<Aabb>,
    /// The renderings of all overlays.
    scopes: ViewScopes,
}

impl Overlays {
    /// Draws the overlays over the first view, and copies the image if that is requested. Returns
    /// the CPU time of this call.
    fn record(
        self,
        frame: &mut Frame<'_>,
        passes: &mut SceneRenderer,
        scene: &CulledScene,
        target: Option<&ViewRequest<'_>>,
        request: &ViewsRequest<'_>,
    ) -> Result<Duration, Error> {
        let began = Instant::now();
        passes.scopes = Some(self.scopes);
        if let Some(target) = target {
            let view = CullView { section: passes.section.planes, ..target.view(&passes.device)? };
            if !self.debug_overlay.is_empty() {
                passes.begin_section_view(frame, scene.hierarchy(), &view)?;
            }
            let state = &*target.state;
            let mut view_pass = ViewPass { passes, frame, scene, view: &view };
            self.debug_overlay.record(&mut view_pass, state)?;
            if let Some(bounds) = self.outlined {
                record_outline(&mut view_pass, bounds)?;
            }
        }
        finish_image(frame, passes, request.overlay, request.image)?;
        passes.scopes = None;
        Ok(began.elapsed())
    }
}

/// Notes the times of frames that are over, which are known when a slot is used again.
fn note_times(frame: &Frame<'_>, passes: &mut Vec<PassTime>, frames: &mut FrameTimes) {
    passes.clear();
    passes.extend_from_slice(frame.pass_times());
    if let Some(time) = frame.last_time() {
        frames.take(time);
    }
}
