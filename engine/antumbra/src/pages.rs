//! The examples in documentation pages. They are compiled here, and a tidy rule compares the
//! copies.

/// From docs/book/src/shadows.md.
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

/// From docs/book/src/embedding.md.
///
/// ```no_run
/// # use antumbra::cull::CullView;
/// # use antumbra::occlusion::{CulledScene, Error, ObjectRenderer, OcclusionState};
/// # fn record(
/// #     scene: &mut CulledScene,
/// #     frame: antumbra::gpu::Frame<'_>,
/// #     state: &mut OcclusionState,
/// #     view: &CullView,
/// #     objects: &mut dyn ObjectRenderer,
/// # ) -> Result<(), Error> {
/// let mut scope = scene.begin(frame)?; // uploads changes
/// scope.draw(state, view, objects)?; // reads results, plans, records
/// scope.end()?;
/// # Ok(())
/// # }
/// ```
///
/// ```no_run
/// # use antumbra::occlusion::{DrawRequest, Error, FrameScope, ObjectRenderer, OcclusionState};
/// # fn record<'a>(
/// #     scope: &mut FrameScope<'a, '_>,
/// #     states: &'a mut [OcclusionState],
/// #     requests: &[DrawRequest<'_>],
/// #     objects: &mut [&mut dyn ObjectRenderer],
/// # ) -> Result<(), Error> {
/// let views = states.iter_mut().zip(requests.iter().copied());
/// let planned = scope.plan_all(views, 4096)?;
/// for (view, objects) in planned.into_iter().zip(objects) {
///     scope.record(view, *objects)?;
/// }
/// # Ok(())
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
