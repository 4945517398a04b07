//! The request for a frame, and its report. A frame has one or several views of one scene. Each
//! view has its own eye, its own history and its own part of the image.
//!
//! Views share the scene, the hierarchy and the submit, but not their answers. An object that is
//! hidden from one eye of a stereo pair may be visible to the other past an edge, so an answer of
//! one eye is never exact for the other. As a guess it would save no test, since hidden nodes are
//! tested in every frame.

use std::time::Duration;

use cull::{Camera, Corrections, CullView, DepthConvention, Strategy, ViewProjection};
use gpu::{Device, Frame, Readback, Tick, TimelineWait};
use occlusion::{FrameStats, OcclusionState, Rect};

use crate::debug::visible_set::VisibleSet;
use crate::error::Error;
use crate::host_overlay::{HOST_OVERLAY, HostOverlay};
use crate::render_view::RenderView;
use crate::resources::skinned_meshes::Skinned;
use crate::scene_renderer::SceneRenderer;
use crate::shading::transparency::FragmentCounts;

/// The position and orientation that a view is seen from, and its projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viewpoint {
    /// A camera.
    Camera(Camera),
    /// A host's matrix, including the jitter of the frame. Its depth must be reversed.
    Matrix(ViewProjection),
}

impl From<Camera> for Viewpoint {
    fn from(camera: Camera) -> Self {
        Self::Camera(camera)
    }
}

impl From<&Camera> for Viewpoint {
    fn from(camera: &Camera) -> Self {
        Self::Camera(*camera)
    }
}

impl From<ViewProjection> for Viewpoint {
    fn from(projection: ViewProjection) -> Self {
        Self::Matrix(projection)
    }
}

impl Viewpoint {
    /// Returns the view in a part of the image. Refuses impossible numbers and an empty part.
    pub(crate) fn view(&self, device: &Device, area: Rect) -> Result<CullView, Error> {
        let view = match self {
            Self::Camera(camera) => {
                cull::check_camera(camera, area.size)?;
                view_in(device, camera, area)
            }
            Self::Matrix(projection) => Self::view_of_matrix(device, projection, area)?,
        };
        cull::check_view(&view)?;
        Ok(view)
    }

    fn view_of_matrix(
        device: &Device,
        projection: &ViewProjection,
        area: Rect,
    ) -> Result<CullView, Error> {
        cull::check_view_size(area.size)?;
        if projection.depth != DepthConvention::Reversed {
            return Err(Error::StandardDepth);
        }
        let bits = device.adapter().limits.sub_pixel_precision_bits;
        let view = CullView::from_matrix(projection, area.size, bits)?;
        Ok(CullView { origin: area.origin, ..view })
    }
}

/// One view of a frame.
pub struct ViewRequest<'a> {
    /// The state of the view. Every view needs its own state, the same in each frame.
    pub state: &'a mut RenderView,
    /// The camera, or a matrix. Both refer to an image of the size of `rect`.
    pub viewpoint: Viewpoint,
    /// The objects that own a pixel, for strategies that [need to know them in
    /// advance](Strategy::needs_still_scene).
    pub visible: Option<&'a VisibleSet>,
    /// The part of the image that the view is drawn to: not empty, and within the image. Where
    /// parts overlap, later views replace earlier ones.
    pub rect: Rect,
}

impl ViewRequest<'_> {
    /// Returns the requested view of the scene.
    pub(crate) fn view(&self, device: &Device) -> Result<CullView, Error> {
        self.viewpoint.view(device, self.rect)
    }
}

impl AsRef<OcclusionState> for ViewRequest<'_> {
    fn as_ref(&self) -> &OcclusionState {
        &self.state.visibility
    }
}

impl AsMut<OcclusionState> for ViewRequest<'_> {
    fn as_mut(&mut self) -> &mut OcclusionState {
        &mut self.state.visibility
    }
}

/// The request for a frame of several views.
#[derive(Clone, Copy)]
pub struct ViewsRequest<'a> {
    /// The strategy that decides what to draw.
    pub strategy: Strategy,
    /// The destination of a copy of the image, if one is wanted. Parts that no view covers are
    /// undefined.
    pub image: Option<&'a Readback>,
    /// The host's commands over the image, if there are any.
    pub overlay: Option<&'a dyn HostOverlay>,
    /// The tick of a host's timeline that the frame waits for on the GPU.
    pub after: Option<TimelineWait<'a>>,
}

/// The request for one frame.
#[derive(Clone, Copy)]
pub struct FrameRequest<'a> {
    /// The strategy that decides what to draw.
    pub strategy: Strategy,
    /// The camera or the matrix of the view.
    pub viewpoint: Viewpoint,
    /// The objects that own a pixel, for strategies that [need to know them in
    /// advance](Strategy::needs_still_scene).
    pub visible: Option<&'a VisibleSet>,
    /// The destination of a copy of the image, if one is wanted. Read it after the frame is over.
    pub image: Option<&'a Readback>,
    /// The destination of a copy of the scene's image before anything is drawn over it, if one is
    /// wanted.
    pub scene_image: Option<&'a Readback>,
    /// The host's commands over the image, if there are any.
    pub overlay: Option<&'a dyn HostOverlay>,
    /// The tick of a host's timeline that the frame waits for on the GPU.
    pub after: Option<TimelineWait<'a>>,
}

impl FrameRequest<'_> {
    /// Creates a request for a frame without any option.
    pub fn new(strategy: Strategy, viewpoint: impl Into<Viewpoint>) -> Self {
        let viewpoint = viewpoint.into();
        Self {
            strategy,
            viewpoint,
            visible: None,
            image: None,
            scene_image: None,
            overlay: None,
            after: None,
        }
    }
}

impl<T: Into<Viewpoint>> From<T> for FrameRequest<'_> {
    /// Creates a request for a frame of the default strategy without any option.
    fn from(viewpoint: T) -> Self {
        Self::new(Strategy::default(), viewpoint)
    }
}

impl<'a> From<&FrameRequest<'a>> for FrameRequest<'a> {
    fn from(request: &FrameRequest<'a>) -> Self {
        *request
    }
}

/// The report of a frame when it is submitted, for all its views together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameReport {
    /// The tick that is over once the GPU has drawn the frame.
    pub tick: Tick,
    /// The CPU time in the engine, without waits and without [`FrameReport::overlay_cpu`].
    pub cpu: Duration,
    /// The CPU time for everything drawn over the scene: the debug overlay, and the host's overlay.
    pub overlay_cpu: Duration,
    /// The number of proxies tested, by any tester.
    pub tests: u32,
    /// The number of occlusion queries recorded, including queries on draws.
    pub queries: u32,
    /// The number of times that the CPU waited for a result within the frame: 0 except for
    /// strategies that block ([`Strategy::is_blocking`]).
    pub waits: u32,
    /// The number of transparent objects in the frustum.
    pub transparent: u32,
    /// The counts of [sorted](crate::TransparencyMethod) fragments of transparent objects, in the
    /// newest frame whose counts were read back for this one.
    pub fragments: FragmentCounts,
    /// The number of poses uploaded: poses that are not on the GPU yet and that one of the views
    /// may show.
    pub poses: u32,
    /// The number of vertices that the GPU computes from these poses because their objects are
    /// drawn.
    pub skinned_vertices: u64,
    /// The number of vertices that the GPU computes only if the test of a proxy passes, once per
    /// such test.
    pub predicated_vertices: u64,
    /// The number of vertices of skinned meshes that the GPU did compute, in the frames that were
    /// read back for this one.
    pub revealed_vertices: u64,
    /// The number of ranges of draws under a predicate.
    pub predicated_draws: u32,
    /// The age in frames of the oldest answer that was read back for this frame; `None` without
    /// answers.
    pub oldest_answer_frames: Option<u64>,
    /// The age in frames of the youngest answer that was read back for this frame; `None` without
    /// answers.
    pub youngest_answer_frames: Option<u64>,
    /// The outcome of the newest frame of the first view whose results were read for this one;
    /// `None` before the first outcome.
    pub known: Option<FrameStats>,
    /// The counts of shadow maps.
    pub shadows: ::shadows::ShadowStats,
    /// The counts of the culler.
    pub plan: cull::PlanStats,
    /// The corrections of the costs ([`Renderer::costs`](crate::Renderer::costs)) by the cost
    /// model; `None` without a cost model.
    pub corrections: Option<Corrections>,
}

impl FrameReport {
    /// Adds the work for skinned meshes.
    pub(crate) fn add_skinned(&mut self, skinned: Skinned) {
        self.poses = skinned.poses;
        self.skinned_vertices = skinned.vertices;
        self.predicated_vertices = skinned.predicated_vertices;
        self.revealed_vertices = skinned.revealed_vertices;
    }

    /// Adds the counts of a view.
    pub(crate) fn add(&mut self, state: &RenderView) {
        let plan = state.plan();
        let predicated = plan.tests.iter().filter(|test| test.leaves.count > 0);
        self.predicated_draws += predicated.count() as u32;
        self.plan += plan.stats;
        self.known = self.known.or(state.newest_stats());
        // Views that are drawn together learn the same corrections.
        self.corrections = self.corrections.or(state.corrections());
        // `None` is less than any age, so the larger of two is the older age if there is one.
        self.oldest_answer_frames =
            self.oldest_answer_frames.max(state.visibility.answer_ages().max());
        let youngest =
            self.youngest_answer_frames.into_iter().chain(state.visibility.answer_ages().min());
        self.youngest_answer_frames = youngest.min();
    }
}

/// Records the copy of the image before anything is drawn over it, if one is wanted.
pub(crate) fn finish_scene(
    frame: &mut Frame<'_>,
    passes: &mut SceneRenderer,
    image: Option<&Readback>,
) -> Result<(), Error> {
    image.map_or(Ok(()), |image| finish_image(frame, passes, None, Some(image)))
}

/// Records the end of a frame after its views, under any strategy: the average of several samples,
/// a host's overlay, and the copy of the image if one is wanted.
pub(crate) fn finish_image(
    frame: &mut Frame<'_>,
    SceneRenderer { target, .. }: &mut SceneRenderer,
    overlay: Option<&dyn HostOverlay>,
    image: Option<&Readback>,
) -> Result<(), Error> {
    if target.needs_resolve() {
        frame.commands().pass("resolve samples", |commands| target.resolve(commands));
    }
    if let Some(overlay) = overlay {
        overlay.upload(frame.uploads())?;
        let commands = frame.commands();
        let over = target.begin_overlay(commands)?;
        let mut recorded = Ok(());
        commands.pass(HOST_OVERLAY, |commands| recorded = overlay.record(commands, &over));
        recorded?;
    }
    if let Some(image) = image {
        frame.commands().pass("copy image", |commands| target.copy_to(commands, image));
    }
    Ok(())
}

pub(crate) fn view_in(device: &Device, camera: &Camera, area: Rect) -> CullView {
    let bits = device.adapter().limits.sub_pixel_precision_bits;
    CullView { origin: area.origin, ..CullView::new(camera, area.size, bits) }
}
