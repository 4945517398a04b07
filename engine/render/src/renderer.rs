//! The renderer: runs a whole frame, from the results of earlier frames to the submit.

use ::shadows::{ShadowMethod, ShadowOptions};
use cull::{
    Aabb, Camera, CostTable, CullConfig, CullView, Culler, DrawPhases, Hierarchy, ObjectId,
    QueryShares, SkippedWork, Strategy, VisibilityTest, VisibilityTestSupport,
};
use gpu::{
    CancellationToken, Device, FrameRing, OptionalFeature, PassTime, PredicationMode, SampleCount,
    Target, Tick,
};
use occlusion::{
    AntumbraMethod, CostModel, CulledScene, CullingSetup, DriverAssumption, DriverQuirks,
    FrameTimes, LeafTableInfo, Method, MethodConstructor, MethodSupport, OcclusionPasses,
    OcclusionState, Rect, ShaderSet,
};
use scene::{LensFlare, Scene};

use crate::debug::debug_overlay::DebugOverlay;
use crate::debug::depth_complexity::LayerCounts;
use crate::debug::visible_set::{SceneRevision, SeenLeaves};
use crate::error::Error;
use crate::executor_choice::decide;
use crate::gpu_scene::{GpuScene, GpuSceneOptions};
use crate::kept_scene::KeptScene;
use crate::render_view::{DeviceGeneration, RenderView, RendererId};
use crate::resources::limits::{check_leaves, check_memory};
use crate::resources::object_bounds::{check_hierarchy, object_bounds};
use crate::resources::spare_capacity::SpareCapacity;
use crate::resources::sprites::has_sprites;
use crate::scene_renderer::SceneRenderer;
use crate::shading::surfaces::{SurfaceOptions, TextureStorage};
use crate::shading::transparency::{TransparencyOptions, usable_transparency};
use crate::shadows::{Shadows, can_skip, usable_shadows};
use crate::update::UpdateScratch;
use crate::views::view_in;

/// The highest number of frames in flight. Each has its own memory for everything that a frame
/// writes, and more than a few only make results older.
pub const MAX_FRAMES_IN_FLIGHT: usize = 16;

/// The options of a [`Renderer`].
#[derive(Debug, Clone)]
pub struct RendererOptions {
    /// Size of the image in pixels.
    pub size: [u32; 2],
    /// The number of samples per pixel. With several, edges are smooth, and every image that is
    /// shown or read has averaged pixels. Queries, thresholds and counts of samples count every
    /// sample.
    pub samples: SampleCount,
    /// The number of frames that may be in flight at once, up to [`MAX_FRAMES_IN_FLIGHT`]. 0 counts
    /// as 1; more than 4 only make results older.
    pub frames_in_flight: usize,
    /// The predication mode that skips hidden draws. `None` takes the cheapest mode by measured
    /// costs ([`Renderer::culling_setup`]), or without these the device's usual mode.
    pub predication: Option<PredicationMode>,
    /// The shaders; `None` takes the embedded ones.
    pub shaders: Option<ShaderSet>,
    /// The configuration of the culler.
    pub cull_config: CullConfig,
    /// The methods in addition to Antumbra's own. If several have the same strategy, the first is
    /// used.
    pub methods: Vec<MethodConstructor>,
    /// The highest number of occlusion queries in a frame, for all its views together. Leaves for
    /// which no query is left are drawn.
    pub query_budget: usize,
    /// The number of samples up to which a test counts as hidden, so that its leaves are not drawn.
    /// With 0 the image is exact. Otherwise each such test may cost this number of pixels
    /// ([`FrameStats::samples_below_threshold`](crate::FrameStats::samples_below_threshold) is an
    /// upper bound for a frame). All tests are then queries that count samples, and conditional
    /// rendering is not available. Applies to [`Strategy::ANTUMBRA`] and
    /// [`Strategy::ANTUMBRA_QUERIES`]; other methods have thresholds of their own.
    pub threshold_samples: u32,
    /// The costs of tests and draws, by which tests that do not pay are left out. On devices with
    /// timestamps, the times of frames correct them.
    pub cost_model: CostModel,
    /// Room for objects that are [added later](Renderer::update), in addition to the room of
    /// removed ones. Together with the scene's objects they must fit into a hierarchy and the
    /// device.
    pub spare_objects: usize,
    /// Room for other things that are added later ([`Renderer::add_meshes`],
    /// [`Renderer::add_textures`], [`Renderer::add_materials`], [`Renderer::add_lights`]).
    pub spare: SpareCapacity,
    /// The storage of textures on the GPU; `None` takes the device's best.
    /// [`Renderer::degradations`] reports the choice.
    pub textures: Option<TextureStorage>,
    /// The highest number of bytes of meshes and textures that a frame copies to the GPU, but at
    /// least one byte of a mesh or one row of a texture.
    pub upload_bytes_per_frame: usize,
    /// The shadows of the lights of surfaces.
    pub shadows: ShadowOptions,
    /// The order in which transparent objects are blended.
    pub transparency: TransparencyOptions,
    /// The assumptions about the driver that a [self-test](crate::self_test) found broken. Tests
    /// and executors that depend on them are replaced by the safest remaining ones, with a warning.
    pub disabled: Vec<DriverAssumption>,
    /// Cancels the creation of the renderer, which may take long, from another thread or a signal
    /// handler. It is checked between the parts of the upload; creation then fails with
    /// [`gpu::Error::Cancelled`]. A complete renderer ignores it.
    pub cancellation: CancellationToken,
}

impl Default for RendererOptions {
    fn default() -> Self {
        Self {
            size: [1280, 720],
            samples: SampleCount::One,
            frames_in_flight: 2,
            predication: None,
            shaders: None,
            cull_config: CullConfig::default(),
            methods: Vec::new(),
            query_budget: 8192,
            threshold_samples: 0,
            cost_model: CostModel::default(),
            spare_objects: 0,
            spare: SpareCapacity::default(),
            textures: None,
            upload_bytes_per_frame: 1 << 20,
            shadows: ShadowOptions::default(),
            transparency: TransparencyOptions::default(),
            disabled: Vec::new(),
            cancellation: CancellationToken::default(),
        }
    }
}

/// Creates Antumbra's own method, and the given ones.
fn methods_of(options: &RendererOptions) -> Vec<Box<dyn Method>> {
    let ours: Box<dyn Method> = Box::new(AntumbraMethod);
    let given = options.methods.iter().map(MethodConstructor::construct);
    std::iter::once(ours).chain(given).collect()
}

impl RendererOptions {
    fn surfaces(&self) -> SurfaceOptions {
        SurfaceOptions {
            textures: self.textures,
            spare: self.spare.clone(),
            cancellation: self.cancellation.clone(),
            ..SurfaceOptions::default()
        }
    }

    /// Refuses options that are impossible on a device with any scene. Creating a renderer checks
    /// them as well: use this to check before the scene is created.
    ///
    /// # Errors
    /// [`Error::FramesInFlight`], [`Error::Cost`], [`Error::Shadows`],
    /// [`Error::MultisampledVolumes`]; a size or samples beyond the device's limits; a
    /// [predication](RendererOptions::predication) mode that the device lacks or that does not
    /// support the threshold.
    pub fn check(&self, device: &Device) -> Result<(), Error> {
        if self.frames_in_flight > MAX_FRAMES_IN_FLIGHT {
            return Err(Error::FramesInFlight {
                wanted: self.frames_in_flight,
                most: MAX_FRAMES_IN_FLIGHT,
            });
        }
        if let CostModel::Table(table) = self.cost_model {
            table.checked()?;
        }
        self.shadows.check()?;
        if self.shadows.method == ShadowMethod::Volumes && self.samples != SampleCount::One {
            return Err(Error::MultisampledVolumes);
        }
        Target::check(device, self.size, self.samples)?;
        PredicationMode::choose(device, self.predication, 1, self.threshold_samples)?;
        Ok(())
    }
}

/// A scene on a device, with the passes that draw it.
pub struct Renderer {
    pub(crate) id: RendererId,
    pub(crate) generation: DeviceGeneration,
    /// The options that the renderer was created with.
    pub(crate) options: RendererOptions,
    /// True if meshes, textures or the environment are no longer those of the scene that the
    /// renderer was created from.
    pub(crate) has_other_content: bool,
    /// The data for another device, if it is kept.
    pub(crate) kept: Option<Box<KeptScene>>,
    pub(crate) device: Device,
    pub(crate) frames: FrameRing,
    pub(crate) scene: CulledScene,
    pub(crate) passes: SceneRenderer,
    pub(crate) shaders: ShaderSet,
    /// The object whose box is outlined.
    pub(crate) outlined: Option<ObjectId>,
    /// The lights that flare in every image.
    pub(crate) flares: Vec<LensFlare>,
    pub(crate) debug_overlay: DebugOverlay,
    pub(crate) seen_leaves: Option<SeenLeaves>,
    pub(crate) methods: Vec<Box<dyn Method>>,
    pub(crate) revision: SceneRevision,
    pub(crate) update_scratch: UpdateScratch,
    /// The views of the newest frame, kept to allocate nothing in the steady state.
    pub(crate) views: Vec<CullView>,
    /// The tick of the frame whose image the target holds.
    pub(crate) shown_tick: Option<Tick>,
    pub(crate) pass_times: Vec<PassTime>,
    pub(crate) frame_times: FrameTimes,
    /// The usable options of transparency.
    pub(crate) transparency: TransparencyOptions,
    pub(crate) query_shares: QueryShares,
    /// True once a frame was drawn without tests, for which there was no memory.
    pub(crate) has_untested_frames: bool,
}

impl Renderer {
    /// Builds the hierarchy over `scene` and uploads everything.
    ///
    /// # Errors
    /// Impossible options: [`Error::FramesInFlight`], [`Error::Cost`], too many objects together
    /// with the room for more, a threshold where queries do not count or with conditional
    /// rendering. A scene or size beyond the device's limits, no memory, a shader that does not
    /// compile, a failed call; [`gpu::Error::Cancelled`].
    pub fn new(device: &Device, scene: &Scene, options: &RendererOptions) -> Result<Self, Error> {
        options.check(device)?;
        let mut bounds = object_bounds(scene)?;
        let count = bounds.len().saturating_add(options.spare_objects);
        check_leaves(device, count)?;
        check_memory("the boxes of the objects", count, size_of::<Aabb>())?;
        bounds.resize(count, Aabb::EMPTY);
        let hierarchy = Hierarchy::build(&bounds)?;
        Self::with_hierarchy(device, scene, hierarchy, options)
    }

    /// Creates a renderer like [`Renderer::new`], with a hierarchy that has already been built over
    /// the scene's objects. Free leaves after the objects are room for more.
    ///
    /// # Errors
    /// The errors of [`Renderer::new`].
    pub fn with_hierarchy(
        device: &Device,
        scene: &Scene,
        hierarchy: Hierarchy,
        options: &RendererOptions,
    ) -> Result<Self, Error> {
        options.check(device)?;
        let shaders = match &options.shaders {
            Some(shaders) => shaders.clone(),
            None => ShaderSet::embedded()?,
        };
        let shaders = if has_sprites(scene) { shaders.with_sprites() } else { shaders };
        // Steps that fail on bad input come first, slow steps later.
        let target = Target::multisampled(device, options.size, options.samples, "target")?;
        let attachments = target.attachments();
        let quirks = DriverQuirks::new(&options.disabled);
        quirks.texts().iter().for_each(|text| tracing::warn!("{text}"));
        let shadows =
            usable_shadows(&quirks, options.shadows, |predication| can_skip(device, predication));
        let transparency = usable_transparency(&quirks, options.transparency);
        let occlusion_passes = OcclusionPasses::with_quirks(device, &shaders, attachments, quirks)?;
        check_hierarchy(scene, &hierarchy)?;
        let slots = options.frames_in_flight.max(1);
        let surfaces = SurfaceOptions { transparency, ..options.surfaces() };
        let shadows = Shadows::new(device, shadows, &target, scene.surfaces.is_some(), slots)?;
        let content = GpuSceneOptions {
            frames_in_flight: slots,
            samples: attachments.samples,
            surfaces: &surfaces,
            upload_bytes_per_frame: options.upload_bytes_per_frame,
            shadows: shadows.options.method,
        };
        let gpu_scene = GpuScene::upload(device, scene, &hierarchy, &content)?;
        let mut passes = SceneRenderer::new(device, &shaders, gpu_scene, target, shadows)?;
        options.cancellation.check()?;
        let draws = hierarchy.leaf_objects().len() as u64;
        let setup = decide(&mut passes, &occlusion_passes, &shaders, draws, options)?;
        let meshes = LeafTableInfo {
            mesh_draws: passes.gpu_scene.geometry.mesh_draws().clone(),
            predication: Some(setup.predication),
            frames_in_flight: slots,
        };
        let draw_of = |object| passes.gpu_scene.geometry.draw_of(object);
        let scene = CulledScene::of_meshes(device, occlusion_passes, hierarchy, meshes, draw_of)?;
        let id = RendererId::new();
        let mut frames = FrameRing::new(device, slots)?;
        let frame_times = FrameTimes::new(device, setup.table.as_ref());
        frame_times.enable(&mut frames)?;
        Ok(Self {
            id,
            generation: DeviceGeneration::default(),
            has_other_content: false,
            kept: None,
            device: device.clone(),
            frames,
            scene: scene.with_setup(setup),
            passes,
            shaders,
            outlined: None,
            flares: Vec::new(),
            debug_overlay: DebugOverlay::default(),
            seen_leaves: None,
            methods: methods_of(options),
            revision: SceneRevision::first(id),
            update_scratch: UpdateScratch::default(),
            views: Vec::new(),
            shown_tick: None,
            pass_times: Vec::new(),
            frame_times,
            transparency: options.transparency,
            options: options.clone(),
            query_shares: QueryShares::default(),
            has_untested_frames: false,
        })
    }

    /// Creates a view of the scene without history.
    ///
    /// # Errors
    /// A failed call.
    pub fn new_view(&self) -> Result<RenderView, Error> {
        Ok(RenderView::new(self.id, self.generation, self.new_visibility()?))
    }

    /// Creates the rings of a view, without history.
    pub(crate) fn new_visibility(&self) -> Result<OcclusionState, Error> {
        let mut culler = Culler::with_testers(self.options.cull_config, self.testers());
        culler.set_sample_threshold(self.options.threshold_samples);
        Ok(self.scene.view_of(culler)?)
    }

    /// Returns the given or measured costs on this device; `None` without a cost model.
    pub fn costs(&self) -> Option<CostTable> {
        self.culling_setup().table
    }

    /// Returns the decisions that were made at creation: the predication mode, and the costs behind
    /// it.
    pub fn culling_setup(&self) -> &CullingSetup {
        self.scene.culling_setup()
    }

    /// Returns the tester that is expected to cost least in a frame of the scene.
    pub fn cheapest_tester(&self) -> VisibilityTest {
        let work = SkippedWork::of_leaves(self.scene.hierarchy().leaf_objects().len() as u32);
        self.culling_setup().tester(&work, self.size(), self.testers())
    }

    /// Returns the testers that plans may use on this device.
    fn testers(&self) -> VisibilityTestSupport {
        self.scene.testers(&self.passes.target, DrawPhases::PerRound)
    }

    /// Returns `wanted`, a strategy that the device supports, or a replacement for it if the driver
    /// cannot be trusted with its tests.
    pub(crate) fn usable(&self, wanted: Strategy) -> Strategy {
        self.testers().counting(self.options.threshold_samples).strategy(wanted)
    }

    /// Returns a sentence for each broken assumption about the driver, with its replacement. Empty
    /// for a driver that is trusted ([`RendererOptions::disabled`]).
    pub fn driver_quirks(&self) -> Vec<String> {
        self.scene.passes().quirks().texts()
    }

    /// Refuses a strategy that the device does not support with this scene and size.
    ///
    /// # Errors
    /// [`Error::NoMethod`]; [`gpu::Error::Unsupported`], with the name of what is missing;
    /// [`gpu::Error::TooLarge`], with the limit; [`Error::CannotCount`] if there is a threshold.
    pub fn supports(&self, strategy: Strategy) -> Result<(), Error> {
        self.method(strategy).map(drop)
    }

    /// Returns the index of the method for `strategy`.
    pub(crate) fn method(&self, strategy: Strategy) -> Result<usize, Error> {
        let place = self.methods.iter().position(|method| method.strategies().contains(&strategy));
        let place = place.ok_or(Error::NoMethod(strategy))?;
        let needs_depths =
            self.options.samples != SampleCount::One && strategy != Strategy::FRUSTUM;
        if needs_depths && !self.device.capabilities().has(OptionalFeature::SampleDepths) {
            return Err(Error::SampleDepths {
                device: self.device.adapter().name.clone(),
                strategy,
            });
        }
        let support = MethodSupport {
            scene: &self.scene,
            size: self.size(),
            threshold_samples: self.options.threshold_samples,
        };
        self.methods[place].supports(strategy, &support)?;
        Ok(place)
    }

    /// Returns true if strategies that are called exact draw every visible object.
    pub(crate) fn is_exact(&self) -> bool {
        self.options.threshold_samples == 0
    }

    /// Returns the number of samples up to which a test counts as hidden
    /// ([`RendererOptions::threshold_samples`]).
    pub fn threshold_samples(&self) -> u32 {
        self.options.threshold_samples
    }

    /// Returns the device that the renderer draws on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the size of the image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.passes.target.size()
    }

    /// Returns the number of samples per pixel.
    pub fn samples(&self) -> SampleCount {
        self.options.samples
    }

    /// Returns the hierarchy over the scene's objects.
    pub fn hierarchy(&self) -> &Hierarchy {
        self.scene.hierarchy()
    }

    /// Returns the predication mode that skips hidden draws.
    pub fn predication(&self) -> PredicationMode {
        self.scene.leaves().predicates().predication()
    }

    /// Draws a debug overlay over the images from now on; an empty one costs nothing.
    ///
    /// # Errors
    /// A wireframe on a device without [`gpu::OptionalFeature::Wireframe`]; depth complexity on a
    /// device without [`gpu::OptionalFeature::FragmentStores`]; an area that is not within the
    /// image; a failed call. The former overlay then stays.
    pub fn set_debug_overlay(&mut self, debug_overlay: DebugOverlay) -> Result<(), Error> {
        debug_overlay.top_down.map_or(Ok(()), |area| self.check_area(area))?;
        debug_overlay.prepare(&mut self.passes.pipelines, &self.device, &self.shaders)?;
        if !debug_overlay.has_depth_complexity {
            self.passes.layer_counts = LayerCounts::default();
        }
        self.debug_overlay = debug_overlay;
        Ok(())
    }

    /// Returns the box that is outlined.
    pub(crate) fn outlined_bounds(&self) -> Option<Aabb> {
        let node = self.scene.hierarchy().node_of(self.outlined?)?;
        Some(self.scene.hierarchy().bounds(node)).filter(|bounds| !bounds.is_empty())
    }

    /// Returns the debug overlay in use.
    pub fn debug_overlay(&self) -> DebugOverlay {
        self.debug_overlay
    }

    /// Notes that the newest recorded frame was submitted.
    pub(crate) fn submitted(&mut self, tick: Tick) {
        self.passes.submitted(tick);
        self.scene.submitted(tick);
        self.show_arrived();
    }

    /// Returns the GPU time of each pass in the previous frame that used the slot of the newest
    /// frame. With N frames in flight this is N frames earlier, for any view. Empty if passes were
    /// not timed.
    pub fn pass_times(&self) -> &[PassTime] {
        &self.pass_times
    }

    /// Returns the view of `camera` on this renderer's image.
    pub fn view_of(&self, camera: &Camera) -> CullView {
        let view = view_in(&self.device, camera, Rect::whole(self.size()));
        CullView { section: self.passes.section.planes, ..view }
    }

    /// Waits until every frame is over and reads its results. Do not use it in a frame loop: it
    /// counts as a blocking wait.
    ///
    /// # Errors
    /// A view of another renderer, a lost device, or a frame that takes too long.
    pub fn wait_idle(&mut self, state: &mut RenderView) -> Result<(), Error> {
        self.check_view(state)?;
        self.device.wait_idle()?;
        let completed = self.device.completed()?;
        state.collect(completed, &self.scene);
        if let Some(fragments) = self.passes.gpu_scene.fragments_mut() {
            fragments.collect(completed);
        }
        Ok(())
    }
}

/// Checks that a renderer can be created on one thread and used on another.
const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Renderer>();
};
