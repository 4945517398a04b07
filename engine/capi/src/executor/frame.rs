//! A frame of a host: all its views, recorded into the host's command buffer.

use std::ffi::c_void;
use std::fmt::{Display, Formatter};

use cull::{CullView, DrawPhases, Strategy};
use gpu::{Attachments, Commands, FrameNumbers, RenderTarget, Target, Tick, Viewport, vk};
use occlusion::{BucketId, DrawRequest, ObjectRenderer, PerView, Rendering};

use super::lists::KeptLists;
use super::scene::{AntumbraView, HostedScene, HostedView};
use super::target::{AntumbraTargetDesc, near_depth};
use crate::decisions::camera::AntumbraCamera;
use crate::decisions::culler::{QUERY_BUDGET, queries, strategy};
use crate::error::Failure;
use crate::layout::{layout, pointers, versioned};
use crate::pointers::{read, slice};

/// The draws that follow a call of `AntumbraBindCallback`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraBinding {
    /// Size of this struct in bytes, as the library was compiled.
    pub struct_size: u32,
    /// The bucket of the draws.
    pub bucket: u32,
    /// The command buffer.
    pub commands: vk::CommandBuffer,
    /// The view.
    pub view: AntumbraView,
}
layout!(AntumbraBinding: struct_size, bucket, commands, view);

/// A rendering that begins or ends.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraRendering {
    /// Size of this struct in bytes, as the library was compiled.
    pub struct_size: u32,
    /// 1 for the first rendering of the view, which clears (colours to 0, unless the rendering is
    /// the host's own); 0 for others, which keep the contents.
    pub is_first: u32,
    /// The command buffer.
    pub commands: vk::CommandBuffer,
    /// The view.
    pub view: AntumbraView,
}
layout!(AntumbraRendering: struct_size, is_first, commands, view);

/// Binds the pipeline, descriptor sets, vertex and index buffers for the indexed indirect draws of
/// a bucket that follow. Viewport and scissor cover the target, with y down. A host whose y axis
/// points up, or that draws to a part of the target, sets its own viewport and scissor here. The
/// callback must not leave a query or a conditional rendering open, and must not call the library
/// with this scene.
///
/// Objects must be rasterised as boxes are: the vertex shader snaps positions to the grid of
/// sub-pixels as share/antumbra/snap.glsl does (its steps are half the size of the image times
/// `2^subPixelPrecisionBits`), and declares `gl_Position` as `invariant` if several passes must
/// agree. Compare depths with "as near or nearer" (`VK_COMPARE_OP_GREATER_OR_EQUAL` for reversed
/// depth). Otherwise an object that is seen edge-on may be missed.
pub type AntumbraBindCallback =
    Option<unsafe extern "C" fn(user: *mut c_void, binding: *const AntumbraBinding)>;

/// Begins or ends a rendering of the host's own, such as a render pass object. Must not call the
/// library with this scene.
pub type AntumbraRenderingCallback =
    Option<unsafe extern "C" fn(user: *mut c_void, rendering: *const AntumbraRendering)>;

pointers!(AntumbraBindCallback, AntumbraRenderingCallback);

/// A view in a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraViewFrame {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// An `ANTUMBRA_STRATEGY_..`. Default: `ANTUMBRA_STRATEGY_ANTUMBRA`.
    pub strategy: u32,
    /// Required: the view.
    pub view: AntumbraView,
    /// Required: its camera.
    pub camera: *const AntumbraCamera,
    /// Required: its images.
    pub target: *const AntumbraTargetDesc,
    /// The most occlusion queries, any number, or `ANTUMBRA_NO_QUERIES`. Leaves for which no query
    /// is left are drawn. Default: 4096.
    pub query_budget: usize,
}
layout!(AntumbraViewFrame: struct_size, strategy, view, camera, target, query_budget);

versioned!(AntumbraViewFrame: 5,
    required: [camera, target],
    defaults: { query_budget: QUERY_BUDGET }
);

/// A frame to be recorded.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct AntumbraFrameDesc {
    /// Size of this struct in bytes.
    pub struct_size: u32,
    /// The number of views. Default: 0.
    pub view_count: u32,
    /// The views, each at most once. Default: null, with a `view_count` of 0.
    pub views: *const *const AntumbraViewFrame,
    /// Required: a primary command buffer that is being recorded, outside of renderings and
    /// queries.
    pub commands: vk::CommandBuffer,
    /// Required: the number of this frame, above the numbers of all earlier frames on the device,
    /// of other scenes, too.
    pub current: u64,
    /// The number of a frame: it and all earlier frames are over on the GPU, or will never be
    /// submitted. The newest such frame is best. Below `current`, and never below the `safe` of an
    /// earlier frame. Default: 0, none.
    pub safe: u64,
    /// Binds the state that draws need. Default: null, only for a host that draws from lists.
    pub bind: AntumbraBindCallback,
    /// The first argument of all callbacks. Default: null.
    pub user: *mut c_void,
    /// Begins a rendering. Default: null, for dynamic rendering to the images of the target.
    pub begin_rendering: AntumbraRenderingCallback,
    /// Ends a rendering. Default: null, as `begin_rendering`.
    pub end_rendering: AntumbraRenderingCallback,
    /// The most occlusion queries of all views together, any number, or `ANTUMBRA_NO_QUERIES`.
    /// Views with more to test get the queries that other views leave. Default: 0, for a budget per
    /// view.
    pub query_budget: usize,
}
layout!(AntumbraFrameDesc: struct_size, view_count, views, commands, current, safe, bind, user,
    begin_rendering, end_rendering, query_budget);

versioned!(AntumbraFrameDesc: 8, required: [commands, current], defaults: {});

/// The callbacks of a host for one view.
struct HostObjects<'a> {
    desc: &'a AntumbraFrameDesc,
    bind: unsafe extern "C" fn(*mut c_void, *const AntumbraBinding),
    view: AntumbraView,
    target: &'a mut Target,
}

impl HostObjects<'_> {
    fn call(
        &self,
        callback: unsafe extern "C" fn(*mut c_void, *const AntumbraRendering),
        commands: &Commands,
        rendering: Rendering,
    ) {
        let rendering = AntumbraRendering {
            struct_size: size_of::<AntumbraRendering>() as u32,
            is_first: u32::from(rendering == Rendering::First),
            commands: commands.raw(),
            view: self.view,
        };
        // SAFETY: the promise of the caller who gave the function.
        unsafe { callback(self.desc.user, &rendering) };
    }
}

impl ObjectRenderer for HostObjects<'_> {
    fn target(&mut self) -> &mut Target {
        self.target
    }

    fn rendering(&self, _view: &CullView, rendering: Rendering) -> RenderTarget {
        self.target.render_target((rendering == Rendering::First).then_some([0.0; 4]))
    }

    fn begin_rendering(
        &mut self,
        commands: &Commands,
        view: &CullView,
        rendering: Rendering,
    ) -> bool {
        let Some(callback) = self.desc.begin_rendering else {
            return commands.begin_rendering(self.rendering(view, rendering));
        };
        self.call(callback, commands, rendering);
        commands.set_viewport(&Viewport::covering(view.origin, view.size));
        true
    }

    fn end_rendering(&mut self, commands: &Commands) {
        match self.desc.end_rendering {
            Some(callback) => self.call(callback, commands, Rendering::Next),
            None => commands.end_rendering(),
        }
    }

    fn bind(&self, commands: &Commands, _view: &CullView, bucket: BucketId) {
        let binding = AntumbraBinding {
            struct_size: size_of::<AntumbraBinding>() as u32,
            bucket: bucket.0,
            commands: commands.raw(),
            view: self.view,
        };
        // SAFETY: the promise of the caller who gave the function.
        unsafe { (self.bind)(self.desc.user, &binding) };
    }
}

/// The place of a view in a frame, as messages name it.
#[derive(Clone, Copy)]
pub(crate) struct ViewPlace(usize);

impl Display for ViewPlace {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "desc.views[{}]", self.0)
    }
}

/// A view of a frame in C, checked.
struct ViewFrame {
    view: AntumbraView,
    eye: CullView,
    strategy: Strategy,
    query_budget: usize,
    target: AntumbraTargetDesc,
}

impl ViewFrame {
    /// Reads the view. Messages call it `place`.
    ///
    /// # Safety
    /// As [`record`].
    unsafe fn read(
        place: ViewPlace,
        pointer: *const AntumbraViewFrame,
        attachments: &Attachments,
    ) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        let frame = unsafe { read(place, pointer) }?;
        // SAFETY: as above.
        let target = unsafe { read(format_args!("{place}.target"), frame.target) }?;
        // SAFETY: as above.
        let camera = unsafe { read(format_args!("{place}.camera"), frame.camera) }?;
        if [camera.width, camera.height] != [target.width, target.height] {
            return Err(Failure::argument(format_args!(
                "{place}.camera and {place}.target have different sizes: {}x{} and {}x{} pixels",
                camera.width, camera.height, target.width, target.height
            )));
        }
        let of_view = |failure: Failure| failure.within(place);
        if near_depth(camera.depth).map_err(of_view)? != attachments.near_depth {
            return Err(Failure::argument(format_args!(
                "{place}.camera has another ANTUMBRA_DEPTH_.. than the scene's attachments"
            )));
        }
        Ok(Self {
            view: frame.view,
            eye: camera.view().map_err(of_view)?,
            strategy: strategy(frame.strategy).map_err(of_view)?,
            query_budget: queries(frame.query_budget),
            target,
        })
    }

    fn request(&self) -> DrawRequest<'_> {
        let Self { strategy, query_budget, .. } = *self;
        DrawRequest { strategy, query_budget, ..DrawRequest::from(&self.eye) }
    }
}

/// Records a frame.
///
/// # Safety
/// As the rules of the interface, [`gpu::FrameRing::begin_in`] and [`Target::of_host`].
pub(crate) unsafe fn record(
    hosted: &mut HostedScene,
    desc: &AntumbraFrameDesc,
) -> Result<(), Failure> {
    let HostedScene { scene, frames, attachments, draw_phases, views, .. } = hosted;
    check(desc, attachments, *draw_phases)?;
    // SAFETY: the caller's promise.
    let pointers = unsafe { slice("desc.views", desc.views, desc.view_count as usize) }?;
    let mut requests = PerView::new();
    let mut found = PerView::new();
    for (number, pointer) in pointers.iter().enumerate() {
        let place = ViewPlace(number);
        // SAFETY: as above.
        let request = unsafe { ViewFrame::read(place, *pointer, attachments) }?;
        let same = requests.iter().position(|other: &ViewFrame| other.view == request.view);
        if let Some(same) = same.map(ViewPlace) {
            let message = format_args!("{place} and {same} are a view twice: name each view once");
            return Err(Failure::argument(message));
        }
        let view = views.find(request.view);
        found.push(view.map_err(|failure| failure.within(format_args!("{place}.view")))?);
        requests.push(request);
    }
    let mut locked = PerView::new();
    for (number, view) in found.iter().enumerate() {
        locked.push(view.write().map_err(|failure| failure.within(ViewPlace(number)))?);
    }
    let mut states = PerView::new();
    let mut targets = PerView::new();
    let mut former_lists = PerView::new();
    for (number, (view, request)) in locked.iter_mut().zip(&requests).enumerate() {
        let HostedView { state, target, lists, .. } = &mut **view;
        let place = ViewPlace(number);
        let device = scene.device();
        // SAFETY: as above.
        let target = unsafe { target.update(place, device, &request.target, attachments) }?;
        let state = match state {
            Some(state) => state,
            None => state.insert(scene.new_view(target)?),
        };
        states.push((state, request.request()));
        targets.push((request.view, target));
        former_lists.push(lists);
    }
    let numbers = FrameNumbers { current: Tick(desc.current), safe: Tick(desc.safe) };
    // SAFETY: as above.
    let frame = unsafe { frames.begin_in(desc.commands, numbers) }?;
    // An error before this may be mended and tried again.
    former_lists.into_iter().for_each(KeptLists::clear);
    let mut scope = scene.begin(frame)?;
    let planned = if desc.query_budget == 0 {
        states
            .into_iter()
            .map(|(state, request)| scope.plan(state, request))
            .collect::<Result<PerView<_>, _>>()?
    } else {
        scope.plan_all(states, queries(desc.query_budget))?
    };
    for (planned, (view, target)) in planned.into_iter().zip(targets) {
        match desc.bind.filter(|_| *draw_phases == DrawPhases::PerRound) {
            Some(bind) => scope.record(planned, &mut HostObjects { desc, bind, view, target })?,
            None => scope.list(planned)?.record(&mut scope, target)?,
        }
    }
    scope.end()?;
    for view in locked.iter_mut().filter(|_| *draw_phases == DrawPhases::Two) {
        let HostedView { state, lists, .. } = &mut **view;
        state.iter().for_each(|state| lists.update(state));
    }
    Ok(())
}

/// Refuses callbacks that do not fit each other or the scene.
fn check(
    desc: &AntumbraFrameDesc,
    attachments: &Attachments,
    draw_phases: DrawPhases,
) -> Result<(), Failure> {
    if desc.begin_rendering.is_some() != desc.end_rendering.is_some() {
        let message = "desc has one of begin_rendering and end_rendering: give both or none";
        return Err(Failure::argument(message));
    }
    if attachments.pass.is_some() && desc.begin_rendering.is_none() {
        let message = "the scene has a render pass of yours: desc.begin_rendering must begin it";
        return Err(Failure::argument(message));
    }
    if draw_phases == DrawPhases::PerRound && desc.view_count > 0 && desc.bind.is_none() {
        return Err(Failure::null("desc.bind"));
    }
    Ok(())
}
