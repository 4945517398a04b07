//! From options to report: opens the device, builds the scene, walks, sums up.

use std::collections::BTreeMap;
use std::path::PathBuf;

use antumbra::cull::{ChcOptions, Hierarchy, Strategy};
use antumbra::gpu::{
    Adapter, Device, DeviceOptions, Instance, InstanceOptions, PredicationMode, WindowSystem,
};
use antumbra::occlusion::MethodConstructor;
use antumbra::render::{
    QueryResetCosts, Renderer, RendererOptions, SelfTest, ShaderSet, object_bounds,
};
use antumbra::scene::Scene;
use antumbra::{gpu, methods, render};
use etcetera::BaseStrategy as _;

use crate::choices::{DeviceChoice, PredicatesChoice, QuirksChoice, ValidationChoice};
use crate::options::{LeftOut, PathChoice, SceneChoice};
use crate::progress::WalkProgress;
use crate::provenance::Provenance;
use crate::recorded_path::RecordedPath;
use crate::report::{
    BuildReport, DeviceReport, FileReport, MemoryReport, Report, SceneReport, SectionReport,
    paired_ratios, ratios,
};
use crate::run_error::RunError;
use crate::shadow_choice::ShadowChoice;
use crate::signals::Signals;
use crate::statistics::kept;
use crate::stopwatch::Stopwatch;
use crate::transparency::TransparencyReport;
use crate::walk::Walk;
use crate::walk_images::WalkImages;
use crate::walk_scene::WalkScene;
use crate::{Options, memory};

/// The result of a walk.
pub struct Walked {
    /// The measurements of all strategies.
    pub report: Report,
    /// The images in `options.asked.out`.
    pub images: WalkImages,
}

/// Walks, measures, writes the images into `options.asked.out` (which exists and is writable).
/// After a signal it returns the measurements so far.
///
/// # Errors
/// When the device is missing or unsuited, or a signal came before anything was measured.
pub fn run(
    options: &Options,
    progress: &dyn WalkProgress,
    signals: &Signals,
) -> Result<Walked, RunError> {
    // The recorded path is checked before anything takes time.
    if let PathChoice::Recorded(file) = &options.path {
        RecordedPath::read(file)?;
    }
    let instance = open_instance(options.asked.device.validation, None)?;
    let adapter = pick_adapter(&instance, &options.asked.device.choice())?;
    progress.stage(&format!("opening {}", adapter.name));
    let device = open_device(&instance, &adapter)?;
    let mut walked = walk_on(&device, options, progress, signals)?;
    // The layers also report while everything is destroyed.
    drop(device);
    walked.report.validation_messages =
        u64::try_from(instance.validation_log().len()).unwrap_or(u64::MAX);
    Ok(walked)
}

/// Returns a line for each Vulkan device, in the order that `--device INDEX` counts, from 0.
///
/// # Errors
/// When there is no Vulkan loader or no driver.
pub fn list_devices() -> Result<Vec<String>, RunError> {
    let adapters = open_instance(ValidationChoice::Off, None)?.adapters()?;
    let line = |(index, adapter): (usize, &Adapter)| {
        let fitness = match adapter.missing() {
            None => String::new(),
            Some(missing) => format!(", cannot be used: it lacks {missing}"),
        };
        format!("{index}: {} ({}, Vulkan {}){fitness}", adapter.name, adapter.driver, adapter.api)
    };
    Ok(adapters.iter().enumerate().map(line).collect())
}

/// Tests the assumptions about the driver of the chosen device. Returns the device's name and the
/// results.
///
/// # Errors
/// A device that is missing or unsuited, a failed call.
pub fn self_test(options: &Options) -> Result<(String, SelfTest), RunError> {
    let instance = open_instance(options.asked.device.validation, None)?;
    let adapter = pick_adapter(&instance, &options.asked.device.choice())?;
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let found = render::self_test(&device, &renderer_options(options)?)?;
    Ok((format!("{} ({}, Vulkan {})", adapter.name, adapter.driver, adapter.api), found))
}

/// Returns an instance, with support for windows of a system if one is given.
pub fn open_instance(
    validation: ValidationChoice,
    windows: Option<WindowSystem>,
) -> Result<Instance, RunError> {
    let options = InstanceOptions {
        application: "Antumbra sample".to_owned(),
        validation: match validation {
            ValidationChoice::Off => gpu::Validation::Off,
            ValidationChoice::On => gpu::Validation::Core,
            ValidationChoice::Sync => gpu::Validation::Synchronization,
        },
        windows,
    };
    Ok(Instance::new(gpu::load_entry()?, &options)?)
}

/// Returns the device of a choice.
///
/// # Errors
/// A device that is missing or unsuited.
pub fn pick_adapter(instance: &Instance, choice: &DeviceChoice) -> Result<Adapter, RunError> {
    Ok(instance.pick_adapter(wanted(choice).as_deref())?)
}

/// Returns a choice as the engine takes it.
pub fn wanted(choice: &DeviceChoice) -> Option<String> {
    match choice {
        DeviceChoice::Best => None,
        DeviceChoice::Index(index) => Some(index.to_string()),
        DeviceChoice::Name(name) => Some(name.clone()),
    }
}

/// Opens a device, with the file of compiled pipelines.
///
/// # Errors
/// A device that cannot be opened.
pub fn open_device(instance: &Instance, adapter: &Adapter) -> Result<Device, RunError> {
    let options = DeviceOptions { pipeline_cache: pipeline_cache_file(), ..Default::default() };
    Ok(Device::new(instance, adapter, &options)?)
}

/// Returns the file of compiled pipelines: in the user's cache folder, if there is one.
pub fn pipeline_cache_file() -> Option<PathBuf> {
    let folders = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(folders.cache_dir().join("antumbra").join("pipelines.bin"))
}

/// Walks as [`run`] does, on an open device.
///
/// # Errors
/// As [`run`].
pub fn walk_on(
    device: &Device,
    options: &Options,
    progress: &dyn WalkProgress,
    signals: &Signals,
) -> Result<Walked, RunError> {
    let renderer_options = checked_options(device, options, signals)?;
    let mut clock = Stopwatch::start();
    let WalkScene { scene, seed, path, path_name, mut moving, mut file } =
        WalkScene::build(options, progress, signals)?;
    signals.check()?;
    let scene_ms = clock.lap_ms();
    let hierarchy = Hierarchy::build(&object_bounds(&scene)?).map_err(RunError::machine)?;
    let hierarchy_ms = clock.lap_ms();
    progress.stage("uploading it to the device");
    let mut renderer = upload(device, &scene, hierarchy, options, renderer_options)?;
    let upload = Some(clock.lap_ms());
    let build_ms = BuildReport { scene: Some(scene_ms), hierarchy: Some(hierarchy_ms), upload };
    if let Some(file) = &mut file {
        file.notes.extend(degradations(&mut renderer, &options.shadows)?);
    }
    let scene_report = scene_report(&options.scene, &scene, seed, file);
    // Everything is on the device now.
    drop(scene);
    let (strategies, left_out) = able(&renderer, options)?;
    if options.asked.time_passes {
        renderer.time_passes()?;
    }
    let options = &Options { strategies, left_out, ..options.clone() };
    let runs = Walk::new(&mut renderer, &path, &mut moving, options)?.run(progress, signals)?;
    let cut_short = signals.received().is_some();
    let mut images = WalkImages::default();
    if let Some(folder) = options.asked.out.as_ref().filter(|_| !cut_short) {
        progress.stage("drawing the images");
        let drawn = images.write(&mut renderer, &path, &mut moving, options, folder, signals);
        images.failures.extend(drawn.err());
    }
    let report = Report {
        file: String::new(),
        device: device_report(device.adapter()),
        scene: scene_report,
        lights: options.asked.lighting.lights.map(|lights| lights.to_string()),
        section: SectionReport::of(&options.section),
        path: path_name,
        views: options.asked.views,
        projection: options.asked.projection.to_string(),
        moving_percent: options.asked.moving_percent,
        moving_objects: moving.movers() as u64,
        frames: options.asked.frames,
        cut_short,
        size: [options.asked.size.width, options.asked.size.height],
        samples_per_pixel: options.asked.msaa.count(),
        frames_in_flight: options.asked.frames_in_flight,
        predicates: renderer.predication().name().to_owned(),
        skip_ns: skip_report(&renderer),
        tester: renderer.cheapest_tester().name().to_owned(),
        reset_ns: reset_report(&renderer),
        threshold_pixels: options.asked.threshold,
        costs_ns: costs_report(&renderer),
        validation_messages: 0,
        memory: memory_report(device),
        build_ms,
        ratios: ratios(&runs),
        paired_ratios: paired_ratios(&runs),
        driver_quirks: renderer.driver_quirks(),
        transparency: TransparencyReport::of(&renderer),
        left_out: options.left_out.clone(),
        provenance: Provenance::of_this_process(),
        runs,
    };
    Ok(Walked { report, images })
}

/// Returns the options of the renderer. Refuses what the device cannot do with any scene, before
/// one is made.
pub(crate) fn checked_options(
    device: &Device,
    options: &Options,
    signals: &Signals,
) -> Result<RendererOptions, RunError> {
    let cancellation = signals.cancellation();
    let renderer_options = RendererOptions { cancellation, ..renderer_options(options)? };
    renderer_options.check(device)?;
    for shadows in &options.shadows {
        let shadows = shadows.options();
        RendererOptions { shadows, ..renderer_options.clone() }.check(device)?;
    }
    Ok(renderer_options)
}

/// Returns a renderer of the scene.
pub(crate) fn upload(
    device: &Device,
    scene: &Scene,
    hierarchy: Hierarchy,
    options: &Options,
    renderer_options: RendererOptions,
) -> Result<Renderer, RunError> {
    let disabled = match options.asked.quirks {
        QuirksChoice::None => Vec::new(),
        QuirksChoice::Tested => render::self_test(device, &renderer_options)?.broken(),
    };
    let renderer_options = RendererOptions { disabled, ..renderer_options };
    let renderer = Renderer::with_hierarchy(device, scene, hierarchy, &renderer_options);
    let drawing = renderer.and_then(|mut renderer| {
        renderer.set_edges(options.asked.edges.options())?;
        renderer.set_section(options.section)?;
        Ok(renderer)
    });
    drawing.map_err(|error| match &options.scene {
        SceneChoice::File(file) => RunError::from(error).about(file),
        SceneChoice::Made(_) => error.into(),
    })
}

/// Returns the degradations of the scene with the renderer's own shadows and with each of these
/// ways to draw them.
fn degradations(
    renderer: &mut Renderer,
    shadows: &[ShadowChoice],
) -> Result<Vec<String>, RunError> {
    let mut texts = renderer.degradations().texts();
    for choice in shadows {
        renderer.set_shadows(choice.options())?;
        let lost = renderer.degradations().texts();
        let new: Vec<String> = lost.into_iter().filter(|text| !texts.contains(text)).collect();
        texts.extend(new);
    }
    Ok(texts)
}

fn device_report(adapter: &Adapter) -> DeviceReport {
    DeviceReport {
        name: adapter.name.clone(),
        driver: adapter.driver.clone(),
        api: adapter.api.clone(),
        conditional_rendering: adapter.has_conditional_rendering(),
    }
}

fn memory_report(device: &Device) -> MemoryReport {
    MemoryReport {
        peak_resident_mib: memory::peak_resident_mib(),
        gpu_allocated_mib: Some(device.memory_use().used_bytes as f64 / f64::from(1 << 20)),
    }
}

/// Returns the scene's name in reports: a file by its name without its folder.
fn scene_name(choice: &SceneChoice) -> String {
    match choice {
        SceneChoice::Made(made) => made.scene.to_string(),
        SceneChoice::File(file) => {
            file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned()
        }
    }
}

/// Returns the strategies that the device supports, and the others.
///
/// # Errors
/// The first reason, if it supports none.
fn able(renderer: &Renderer, options: &Options) -> Result<(Vec<Strategy>, Vec<LeftOut>), RunError> {
    let mut able = Vec::new();
    let mut left_out = options.left_out.clone();
    let mut first_reason = None;
    for strategy in &options.strategies {
        match renderer.supports(*strategy) {
            Ok(()) => able.push(*strategy),
            Err(error) => {
                let strategy = strategy.name().to_owned();
                let reason = error.to_string();
                left_out.push(LeftOut { strategy, reason });
                first_reason.get_or_insert(error);
            }
        }
    }
    match first_reason {
        Some(error) if able.is_empty() => Err(error.into()),
        _ => Ok((able, left_out)),
    }
}

fn scene_report(
    choice: &SceneChoice,
    scene: &Scene,
    seed: u64,
    file: Option<FileReport>,
) -> SceneReport {
    SceneReport {
        name: scene_name(choice),
        objects: scene.objects.len() as u64,
        triangles: scene.triangles(),
        seed,
        file,
    }
}

/// Returns times by their names, as reports keep them.
fn by_name<'a>(times: impl Iterator<Item = (&'a str, f64)>) -> BTreeMap<String, Option<f64>> {
    times.map(|(name, ns)| (name.to_owned(), ns.is_finite().then(|| kept(ns)))).collect()
}

/// Returns every measured cost.
fn costs_report(renderer: &Renderer) -> BTreeMap<String, Option<f64>> {
    let costs = renderer.costs().into_iter().flat_map(|table| table.entries());
    by_name(costs.map(|(name, ns)| (name, ns.into())))
}

/// Returns the expected time of skipping in a frame by each way.
fn skip_report(renderer: &Renderer) -> BTreeMap<String, Option<f64>> {
    let skip_ns = &renderer.culling_setup().skip_ns;
    by_name(skip_ns.iter().map(|(way, ns)| (way.name(), *ns)))
}

/// Returns the measured times of resets.
fn reset_report(renderer: &Renderer) -> BTreeMap<String, Option<f64>> {
    let QueryResetCosts { command_ns, cpu_ns } = renderer.culling_setup().reset_ns;
    by_name([("command", command_ns.into()), ("cpu", cpu_ns.into())].into_iter())
}

/// Returns all methods. CHC, the only method of the literature with a threshold, gets the same
/// threshold as ours.
fn all_methods(options: &Options) -> Vec<MethodConstructor> {
    let chc = methods::chc(ChcOptions {
        visibility_threshold_samples: options.asked.threshold,
        ..ChcOptions::default()
    });
    std::iter::once(chc).chain(methods::all()).collect()
}

fn renderer_options(options: &Options) -> Result<RendererOptions, RunError> {
    let shaders = options.asked.device.shaders.as_deref().map(ShaderSet::compiled_from);
    let shaders = shaders.transpose().map_err(render::Error::from)?;
    let frames_in_flight = options.asked.frames_in_flight.try_into().unwrap_or(1);
    Ok(RendererOptions {
        methods: all_methods(options),
        size: [options.asked.size.width, options.asked.size.height],
        samples: options.asked.msaa,
        transparency: options.asked.transparency.options(),
        frames_in_flight,
        predication: match options.asked.predicates {
            PredicatesChoice::Auto => None,
            PredicatesChoice::Conditional => Some(PredicationMode::Conditional),
            PredicatesChoice::Count => Some(PredicationMode::Counts),
            PredicatesChoice::Instances => Some(PredicationMode::Instances),
            PredicatesChoice::Compacted => Some(PredicationMode::Compacted),
        },
        shaders,
        threshold_samples: options.asked.threshold,
        cost_model: options.cost_model.into(),
        ..Default::default()
    })
}
