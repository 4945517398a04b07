//! The scene of a session: its renderer, and its view.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use antumbra::glam::Vec3;
use antumbra::gpu::{CancellationToken, Device};
use antumbra::render::{CostModel, Renderer, RendererOptions, ShaderSet};
use antumbra::scene::{Environment, Light, LightMove, Mesh, Scene, SkyDisk};
use antumbra::shadows::ShadowOptions;
use antumbra::{cull, import, methods, render, scene};
use scenes::{Courtyard, Daylight, GeneratedScene, Hour, Routes};

use super::scene_view::{SceneOfFile, SceneView};
use super::show::ShowOptions;
use super::source::{FileSource, SceneSource};
use crate::hud::{HudLevel, PANEL_SHARE};
use bench::camera_path::CameraTrack;
use bench::choices::{self, QuirksChoice};
use bench::options::{MadeScene, PathChoice};
use bench::run_error::RunError;
use bench::scene_file::{self, LoadProgress};

/// A scene that can be drawn, with its cameras and its motion.
pub struct LoadedScene {
    /// The renderer that draws it.
    pub renderer: Renderer,
    /// The cameras and the motion.
    pub scene_view: SceneView,
    /// The lights that change with the hour, if the scene has such lights.
    pub daylight: Option<Daylight>,
    /// The source of the same scene with lights that change with the hour, if such lights are
    /// possible but not loaded.
    pub lit: Option<SceneSource>,
}

/// The device to which scenes are loaded, and the options of showing them.
pub struct SceneLoader<'a> {
    /// The device.
    pub device: &'a Device,
    /// The options of showing scenes.
    pub options: &'a ShowOptions,
    /// The size of the first image, in pixels.
    pub size: [u32; 2],
    /// The token that cancels loading.
    pub cancellation: CancellationToken,
}

impl SceneLoader<'_> {
    /// Loads or generates the scene of a source, and reports progress.
    ///
    /// # Errors
    /// A scene that cannot be generated or shown; a failed device; a cancellation.
    pub fn load(
        &self,
        source: &SceneSource,
        progress_fn: &mut dyn FnMut(LoadProgress<'_>),
    ) -> Result<LoadedScene, RunError> {
        match source {
            SceneSource::Made { made, path, hour } => {
                progress_fn(LoadProgress { what: "making the scene", fraction: None });
                self.made(made, path.as_ref(), *hour)
            }
            SceneSource::Courtyard { hour } => self.courtyard(*hour),
            SceneSource::File { file, settings } => self.of_file(file, settings, &mut |told| {
                progress_fn(told);
                if self.cancellation.is_cancelled() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            }),
            SceneSource::Nothing { .. } => self.empty(),
        }
    }

    /// Creates an empty sky, which is shown until a scene is loaded.
    ///
    /// # Errors
    /// When the device fails.
    pub fn empty(&self) -> Result<LoadedScene, RunError> {
        let mut scene = Scene::single(Mesh::of_triangles("nothing", &[]));
        scene.objects.clear();
        // The scene has no tests, so their costs need not be measured.
        let renderer_options = RendererOptions {
            cost_model: CostModel::Off,
            shadows: ShadowOptions::default(),
            ..self.renderer_options()?
        };
        let scene = Arc::new(scene);
        let mut renderer = Renderer::new(self.device, &scene, &renderer_options)?;
        renderer.keep_scene(scene)?;
        let camera = cull::Camera {
            eye: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            projection: cull::Projection::perspective(scene::FOV_Y_RAD),
            near: scene::NEAR_M,
        };
        let scene_view = SceneView::still("nothing", camera);
        Ok(LoadedScene { renderer, scene_view, daylight: None, lit: None })
    }

    /// Generates a scene.
    fn made(
        &self,
        made: &MadeScene,
        path: Option<&PathChoice>,
        hour: Option<Hour>,
    ) -> Result<LoadedScene, RunError> {
        let GeneratedScene { scene, routes } = made.make()?;
        let track = path.map(|choice| CameraTrack::new(choice, &routes)).transpose()?;
        let start = match &track {
            Some(track) => track.camera(0),
            None => start(&routes)?.camera(0),
        };
        let (scene, daylight) = match hour {
            None => (scene, None),
            Some(hour) => {
                let (scene, night) = Daylight::new(scene, &eyes(&routes), LAMPS)?;
                (scene, Some(Daylight { hour, ..night }))
            }
        };
        let renderer_options = RendererOptions {
            shadows: match &daylight {
                None => ShadowOptions::default(),
                Some(_) => self.options.shadows.options(),
            },
            ..self.renderer_options()?
        };
        let scene = Arc::new(scene);
        let mut renderer = Renderer::new(self.device, &scene, &renderer_options)?;
        renderer.keep_scene(Arc::clone(&scene))?;
        if let Some(daylight) = &daylight {
            show_hour(&mut renderer, daylight)?;
        }
        let lit =
            SceneSource::Made { made: *made, path: path.cloned(), hour: Some(Hour::AFTERNOON) };
        Ok(LoadedScene {
            renderer,
            scene_view: SceneView::still(&made.scene.to_string(), start)
                .with_names(&scene)
                .with_track(track),
            lit: daylight.is_none().then_some(lit),
            daylight,
        })
    }

    /// Creates the courtyard, which has moving parts.
    fn courtyard(&self, hour: Hour) -> Result<LoadedScene, RunError> {
        let Courtyard { scene, daylight, motion, camera } = scenes::courtyard(hour);
        let scene = Arc::new(scene);
        let mut renderer = Renderer::new(self.device, &scene, &self.renderer_options()?)?;
        renderer.keep_scene(Arc::clone(&scene))?;
        show_hour(&mut renderer, &daylight)?;
        let scene_view = SceneView::still(&scene.name, camera).with_names(&scene);
        let scene_view = scene_view.with_motion(motion);
        Ok(LoadedScene { renderer, scene_view, daylight: Some(daylight), lit: None })
    }

    /// Loads a file, reports progress, and stops if it is cancelled.
    fn of_file(
        &self,
        file: &Path,
        settings: &FileSource,
        progress_fn: &mut dyn FnMut(LoadProgress<'_>) -> ControlFlow<()>,
    ) -> Result<LoadedScene, RunError> {
        let reading = import::LoadOptions {
            exposure: settings.exposure,
            broken_parts: self.options.broken_parts,
            cut_above_triangles: self.options.cut_above_triangles,
            ..import::LoadOptions::default()
        };
        let mut imported = scene_file::load(file, &reading, progress_fn)?;
        if settings.detail_pixels.is_some() {
            scene_file::report_progress(progress_fn, "making levels of detail", None)?;
            imported.make_levels(&import::LevelOptions::default());
        }
        if let Some(surfaces) = &mut imported.scene.surfaces {
            surfaces.environment = Some(sky_of(&imported.scene.light)?);
        }
        let hierarchy = scene_file::hierarchy(&imported.scene, progress_fn)?;
        scene_file::report_progress(progress_fn, "uploading it to the device", None)?;
        let renderer_options = self.renderer_options()?;
        let mut renderer =
            Renderer::with_hierarchy(self.device, &imported.scene, hierarchy, &renderer_options)
                .map_err(|error| RunError::from(error).about(file))?;
        let covered = if self.options.hud == HudLevel::Off { 0.0 } else { PANEL_SHARE };
        let SceneOfFile { scene, mut scene_view } =
            SceneView::of_file(file, imported, settings, self.size, covered)?;
        renderer.keep_scene(Arc::new(scene))?;
        scene_view.notes.extend(renderer.degradations().texts());
        scene_view.notes.extend(renderer.driver_quirks());
        Ok(LoadedScene { renderer, scene_view, daylight: None, lit: None })
    }

    /// Returns the options of renderers on the device. The device is tested first, once, if that is
    /// requested.
    fn renderer_options(&self) -> Result<RendererOptions, RunError> {
        let Self { device, options, size, ref cancellation } = *self;
        let cancellation = cancellation.clone();
        let untested = RendererOptions { cancellation, ..untested_options(options, size)? };
        if options.quirks == QuirksChoice::None {
            return Ok(untested);
        }
        let disabled = match options.disabled.get() {
            Some(disabled) => disabled.clone(),
            None => {
                let found = render::self_test(device, &untested)?.broken();
                options.disabled.get_or_init(|| found).clone()
            }
        };
        Ok(RendererOptions { disabled, ..untested })
    }
}

/// The most street lamps that are lit at night.
const LAMPS: u32 = 16;

/// The number of frames of a walk along which lamps are chosen.
const EYES: u32 = 600;

/// Sets the lights of a scene to its hour.
///
/// # Errors
/// A light or a material that the renderer does not have.
pub fn show_hour(renderer: &mut Renderer, daylight: &Daylight) -> Result<(), RunError> {
    let light = daylight.hour.light();
    renderer.set_scene_light(light);
    renderer.set_environment(Some(&sky_of(&light)?))?;
    for LightMove { light, to } in daylight.lights() {
        renderer.set_light(light, to)?;
    }
    if let Some((id, material)) = daylight.material() {
        renderer.set_material(id, &material)?;
    }
    Ok(())
}

/// Half of the angle that the sun's or the moon's disk covers: twice the real one, as in paintings.
const DISK_RAD: f32 = 0.0094;

/// The radiance of the disk, relative to a matt white surface in its light.
const DISK_RADIANCE: f32 = 12.0;

/// Returns the light of a sky that fits a scene's plain light.
fn sky_of(light: &Light) -> Result<Environment, RunError> {
    let disk = SkyDisk {
        towards: light.towards_sun.normalize_or(Vec3::Y),
        radius_rad: DISK_RAD,
        radiance: light.sun.map(|part| part.max(0.0) * DISK_RADIANCE),
    };
    let sky = Environment::of_sky(&light.sky_around()).and_then(|sky| sky.with_disk(disk));
    Ok(sky.map_err(render::Error::from)?)
}

/// Returns places along the streets, or above the scene if there are no streets.
fn eyes(routes: &Routes) -> Vec<Vec3> {
    let track = start(routes).ok();
    let frames = track.iter().flat_map(|track| (0..EYES).map(|frame| track.camera(frame).eye));
    frames.collect()
}

/// Returns the first camera: in a street, or above the scene if there are no streets.
fn start(routes: &Routes) -> Result<CameraTrack, RunError> {
    let made = |path| CameraTrack::new(&PathChoice::Made(path), routes);
    made(choices::CameraPathChoice::Street).or_else(|_| made(choices::CameraPathChoice::Fly))
}

/// Refuses options that the device cannot fulfil with any scene, before a scene is generated.
///
/// # Errors
/// An image beyond the device's limits, shaders that do not compile, and similar.
pub fn check_options(
    device: &Device,
    options: &ShowOptions,
    size: [u32; 2],
) -> Result<(), RunError> {
    Ok(untested_options(options, size)?.check(device)?)
}

/// Returns the options of renderers on a device that needs no test.
fn untested_options(options: &ShowOptions, size: [u32; 2]) -> Result<RendererOptions, RunError> {
    let shaders = options.shaders.as_deref().map(ShaderSet::compiled_from);
    Ok(RendererOptions {
        methods: methods::all(),
        size,
        samples: options.samples,
        transparency: options.transparency.options(),
        frames_in_flight: options.frames_in_flight as usize,
        shaders: shaders.transpose().map_err(render::Error::from)?,
        cost_model: options.cost_model.into(),
        shadows: options.shadows.options(),
        ..RendererOptions::default()
    })
}
