//! The examples of pages: each is compiled here, and a tidy rule compares.

/// From docs/shadows.md.
///
/// ```no_run
/// # use antumbra::glam::{Vec3, vec3};
/// # use antumbra::render::RendererOptions;
/// # use antumbra::Renderer;
/// # fn cast(
/// #     device: antumbra::gpu::Device,
/// #     scene: antumbra::scene::Scene,
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// use antumbra::render::LightShadow;
/// use antumbra::scene::{LightId, LightKind, PunctualLight};
/// use antumbra::shadows::{ShadowMethod, ShadowOptions};
///
/// let mut scene = scene.with_surfaces(); // Its sun is LightId(0).
/// let lamp = PunctualLight {
///     kind: LightKind::Point,
///     colour: [1.0, 0.8, 0.5],
///     intensity: 20.0, // Candela.
///     range_m: Some(12.0),
///     position: vec3(-1.0, 3.0, 2.5),
///     direction: Vec3::NEG_Y,
///     cookie: None,
/// };
/// if let Some(surfaces) = &mut scene.surfaces {
///     surfaces.lights.push(lamp); // LightId(1).
/// }
/// let shadows = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
/// let options = RendererOptions { shadows, ..RendererOptions::default() };
/// let mut renderer = Renderer::new(&device, &scene, &options)?;
/// renderer.set_light_shadow(LightId(1), Some(LightShadow { is_cast: true, penumbra_m: 0.4 }))?;
/// # Ok(()) }
/// ```
struct ShadowsPage;

/// From docs/embedding.md.
///
/// ```no_run
/// # use antumbra::cull::{CullView, Hierarchy, QueryShares};
/// # use antumbra::occlusion::{PlanExecutor, OcclusionState};
/// # fn plan(
/// #     shares: &mut QueryShares,
/// #     mut states: Vec<OcclusionState>,
/// #     hierarchy: &Hierarchy,
/// #     executor: &PlanExecutor,
/// #     views: &[CullView],
/// # ) {
/// # let strategy = antumbra::Strategy::ANTUMBRA;
/// let used = |state: &OcclusionState| state.plan().query_count();
/// shares.plan_views(4096, &mut states, used, |number, state, share| {
///     state.plan_frame(hierarchy, &executor.leaves, strategy, &views[number], share);
/// });
/// # }
/// ```
struct EmbeddingPage;

/// From engine/import/README.md.
///
/// ```no_run
/// # use std::ops::ControlFlow;
/// # use antumbra::Renderer;
/// # fn play(
/// #     device: antumbra::gpu::Device,
/// #     path: &std::path::Path,
/// #     seconds: f64,
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// let mut go_on = |_| ControlFlow::Continue(());
/// let imported = antumbra::import::load(path, &Default::default(), &mut go_on)?;
/// let (scene, mut animator, cameras, notes) = antumbra::import::SceneAnimator::of(imported);
/// let mut renderer = Renderer::new(&device, &scene, &Default::default())?;
/// animator.play(&animator.compatible(None), 0.0, 0.0);
/// // before each frame:
/// renderer.apply(animator.changes(seconds))?;
/// # Ok(()) }
/// ```
#[cfg(feature = "import")]
struct ImportPage;
