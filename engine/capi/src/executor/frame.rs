//! A frame of a host: all its views, recorded into the host's command buffer.

use std::ffi::c_void;

use cull::{CullConfig, CullView, DrawPhases, QueryShares};
use gpu::{Attachments, Commands, Device, Frame, FrameNumbers, RenderTarget, Target, Tick, vk};
use occlusion::{
    BucketId, HostScene, ObjectPass, ObjectRenderer, Rendering, ShaderSet, execute, list_draws,
};

use super::scene::{AntumbraView, HostedScene, HostedView};
use super::target::{AntumbraTargetDesc, near_depth};
use crate::decisions::camera::AntumbraCamera;
use crate::decisions::culler::{QUERY_BUDGET, queries, strategy};
use crate::error::Failure;
use crate::layout::{layout, pointers, versioned};
use crate::pointers::{read, slice};
use crate::table::Table;

/// The draws that follow a call of [`AntumbraBindCallback`].
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
    /// 1 for the first rendering of the view, which clears; 0 for others, which keep the contents.
    pub is_first: u32,
    /// The command buffer.
    pub commands: vk::CommandBuffer,
    /// The view.
    pub view: AntumbraView,
}
layout!(AntumbraRendering: struct_size, is_first, commands, view);

/// Binds pipeline, descriptors, vertex and index buffers for the indexed indirect draws of a
/// bucket that follow. Viewport and scissor cover the target, with y down: a host whose y points
/// up, or who draws to a part, sets its own here. No query and no condition may be left open.
pub type AntumbraBindCallback =
    Option<unsafe extern "C" fn(user: *mut c_void, binding: *const AntumbraBinding)>;

/// Begins or ends a rendering of the host's own, such as a render pass object.
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
    /// The most occlusion queries, any number, or `ANTUMBRA_NO_QUERIES`; leaves for which none is
    /// left are drawn. Default: 4096.
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
    /// Required: the number of this frame, above that of all frames before on the device.
    pub current: u64,
    /// The newest frame that is over on the GPU with all before it, or will never be submitted.
    /// Default: 0, none.
    pub safe: u64,
    /// Binds what draws need. Default: null, for a host that draws from lists: others must give it.
    pub bind: AntumbraBindCallback,
    /// The first argument of all callbacks. Default: null.
    pub user: *mut c_void,
    /// Begins a rendering. Default: null, for dynamic rendering to the images of the target.
    pub begin_rendering: AntumbraRenderingCallback,
    /// Ends a rendering. Default: null, as `begin_rendering`.
    pub end_rendering: AntumbraRenderingCallback,
    /// The most occlusion queries of all views together, any number, or `ANTUMBRA_NO_QUERIES`: what
    /// a view leaves goes to those with more to test. Default: 0, for the budgets of each.
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
        commands.set_viewport(&self.viewport(view));
        true
    }

    fn end_rendering(&mut self, commands: &Commands) {
        match self.desc.end_rendering {
            Some(callback) => self.call(callback, commands, Rendering::Next),
            None => commands.end_rendering(),
        }
    }

    fn bind(&self, commands: &Commands, _view: &CullView, bucket: BucketId, _pass: ObjectPass) {
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

/// Records a frame.
///
/// # Safety
/// As the rules of the interface, [`gpu::FrameRing::begin_in`] and [`Target::of_host`].
pub(crate) unsafe fn record(
    scene: &mut HostedScene,
    desc: &AntumbraFrameDesc,
) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    let views = unsafe { slice("desc.views", desc.views, desc.view_count as usize) }?;
    if desc.begin_rendering.is_some() != desc.end_rendering.is_some() {
        let message = "desc has one of begin_rendering and end_rendering: give both or none";
        return Err(Failure::argument(message));
    }
    if scene.attachments.pass.is_some() && desc.begin_rendering.is_none() {
        let message = "the scene has a render pass of yours: desc.begin_rendering must begin it";
        return Err(Failure::argument(message));
    }
    for (number, view) in views.iter().enumerate() {
        // SAFETY: the caller's promise, here and below.
        let view = unsafe { read("a view of desc.views", *view) }?.view;
        for other in &views[..number] {
            // SAFETY: as above.
            if unsafe { read("a view of desc.views", *other) }?.view == view {
                return Err(Failure::argument("desc.views has a view twice"));
            }
        }
    }
    let numbers = FrameNumbers { current: Tick(desc.current), safe: Tick(desc.safe) };
    // SAFETY: as above.
    let mut frame = unsafe { scene.frames.begin_in(desc.commands, numbers) }?;
    scene.scene.upload(&mut frame)?;
    let mut parts = Parts {
        device: &scene.device,
        scene: &mut scene.scene,
        views: &scene.views,
        shaders: &scene.shaders,
        attachments: &scene.attachments,
        draw_phases: scene.draw_phases,
    };
    // SAFETY: as above.
    unsafe {
        plan_views(&mut parts, &mut scene.shared_budget, desc, views)?;
        for view in views {
            record_view(&mut frame, &mut parts, desc, &read("a view of desc.views", *view)?)?;
        }
    }
    let tick = frame.end()?;
    for view in views {
        // SAFETY: as above.
        let view = unsafe { read("a view of desc.views", *view) }?.view;
        let hosted = scene.views.find(view)?;
        if let Some(state) = &mut hosted.write()?.state {
            state.submitted(tick, &scene.scene.executor().leaves, None);
        }
    }
    scene.scene.submitted(tick);
    Ok(())
}

/// The parts of a scene that planning and recording a view need.
struct Parts<'a> {
    device: &'a Device,
    scene: &'a mut HostScene,
    views: &'a Table<HostedView, AntumbraView>,
    shaders: &'a ShaderSet,
    attachments: &'a Attachments,
    draw_phases: DrawPhases,
}

/// One budget of queries for the views of a scene.
#[derive(Default)]
pub(crate) struct SharedBudget {
    shares: QueryShares,
    /// The queries in the newest plan of each view of a frame.
    used: Vec<usize>,
}

/// Plans the views of a frame, by budgets of their own or by that of the frame.
///
/// # Safety
/// As [`record`].
unsafe fn plan_views(
    parts: &mut Parts<'_>,
    SharedBudget { shares, used }: &mut SharedBudget,
    desc: &AntumbraFrameDesc,
    views: &[*const AntumbraViewFrame],
) -> Result<(), Failure> {
    used.clear();
    for view in views {
        // SAFETY: the caller's promise.
        let view = unsafe { read("a view of desc.views", *view) }?;
        used.push(match desc.query_budget {
            // SAFETY: as above.
            0 => unsafe { plan_view(parts, &view, queries(view.query_budget)) }?,
            _ => parts.views.find(view.view)?.write()?.query_count(),
        });
    }
    if desc.query_budget == 0 {
        return Ok(());
    }
    let mut outcome = Ok(());
    shares.plan_views(
        queries(desc.query_budget),
        used,
        |used| *used,
        |number, used, share| {
            // SAFETY: as above.
            let planned = unsafe {
                read("a view of desc.views", views[number])
                    .and_then(|view| plan_view(parts, &view, share))
            };
            match planned {
                Ok(queries) => *used = queries,
                Err(failure) => outcome = Err(failure),
            }
        },
    );
    outcome
}

/// Plans a view, and returns the number of its queries.
///
/// # Safety
/// As [`record`].
unsafe fn plan_view(
    parts: &mut Parts<'_>,
    view: &AntumbraViewFrame,
    query_budget: usize,
) -> Result<usize, Failure> {
    let Parts { device, scene, views, attachments, draw_phases, .. } = parts;
    // SAFETY: the caller's promise, here and below.
    let (camera, target) = unsafe {
        let target = read("view.target", view.target)?;
        (read("view.camera", view.camera)?, target)
    };
    if [camera.width, camera.height] != [target.width, target.height] {
        return Err(Failure::argument("view.camera and view.target have different sizes"));
    }
    if near_depth(camera.depth)? != attachments.near_depth {
        let message = "view.camera has another ANTUMBRA_DEPTH_.. than the scene's attachments";
        return Err(Failure::argument(message));
    }
    let eye = camera.view()?;
    let strategy = strategy(view.strategy)?;
    let hosted = views.find(view.view)?;
    let mut hosted = hosted.write()?;
    let HostedView { state, target: cached, lists, .. } = &mut *hosted;
    lists.clear();
    // SAFETY: as above.
    let target = unsafe { cached.update(device, &target, attachments) }?;
    let state = match state {
        Some(state) => state,
        None => state.insert(scene.new_view(target, CullConfig::default(), *draw_phases)?),
    };
    let (hierarchy, executor) = scene.parts_mut();
    state.collect(device.completed()?, hierarchy, &executor.leaves);
    state.plan_frame(hierarchy, &executor.leaves, strategy, &eye, query_budget);
    Ok(state.plan().query_count())
}

/// Records a planned view into a frame.
///
/// # Safety
/// As [`record`].
unsafe fn record_view(
    frame: &mut Frame<'_>,
    Parts { device, scene, views, shaders, attachments, draw_phases, .. }: &mut Parts<'_>,
    desc: &AntumbraFrameDesc,
    view: &AntumbraViewFrame,
) -> Result<(), Failure> {
    let hosted = views.find(view.view)?;
    let mut hosted = hosted.write()?;
    let HostedView { state: Some(state), target: cached, lists, .. } = &mut *hosted else {
        return Ok(());
    };
    // SAFETY: the caller's promise.
    let (eye, target) = unsafe {
        let target = read("view.target", view.target)?;
        let eye = read("view.camera", view.camera)?.view()?;
        (eye, cached.update(device, &target, attachments)?)
    };
    let (_, executor) = scene.parts_mut();
    match draw_phases {
        DrawPhases::PerRound => {
            let bind = desc.bind.ok_or_else(|| Failure::null("desc.bind"))?;
            let mut objects = HostObjects { desc, bind, view: view.view, target };
            execute(frame, executor, state, &mut objects, shaders, &eye)?;
        }
        DrawPhases::Two => {
            let tests = list_draws(frame, executor, state, &eye)?;
            tests.record(frame, executor, state, target, shaders)?;
            lists.update(state);
        }
    }
    target.restore(frame.commands());
    Ok(())
}
