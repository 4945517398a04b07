//! Scenes from files: loaded with progress, and reported.

use std::ops::ControlFlow;
use std::path::Path;

use antumbra::cull::Hierarchy;
use antumbra::import;
use antumbra::import::{Cause, GltfScene, LoadOptions, Stage};
use antumbra::render::object_bounds;
use antumbra::scene::Scene;

use crate::report::FileReport;
use crate::run_error::RunError;
use crate::terminal::shown;

/// The progress of loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadProgress<'a> {
    /// The current step.
    pub what: &'a str,
    /// The finished fraction of it, 0 to 1, if it is known.
    pub fraction: Option<f32>,
}

/// The function that receives the progress, and decides if loading continues.
pub type LoadProgressFn<'a> = dyn FnMut(LoadProgress<'_>) -> ControlFlow<()> + 'a;

/// Reports the progress, and checks that the scene is still wanted.
///
/// # Errors
/// When loading was given up.
pub fn report_progress(
    progress_fn: &mut LoadProgressFn<'_>,
    what: &str,
    fraction: Option<f32>,
) -> Result<(), RunError> {
    match progress_fn(LoadProgress { what, fraction }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(RunError::given_up()),
    }
}

/// Reads a file.
///
/// # Errors
/// A file that cannot be read, with the object in it and the reason; loading that was given up.
pub fn load(
    file: &Path,
    options: &LoadOptions,
    progress_fn: &mut LoadProgressFn<'_>,
) -> Result<GltfScene, RunError> {
    report_progress(progress_fn, &format!("reading {}", shown(file)), None)?;
    if file.is_dir() {
        let shown = shown(file);
        return Err(RunError::user(format!("cannot read the scene '{shown}': it is a folder")));
    }
    let loaded = import::load(file, options, &mut |progress| {
        let what = match progress.stage {
            Stage::Reading => "reading",
            Stage::Meshes => "making meshes of",
        };
        let what = format!("{what} {}", shown(file));
        progress_fn(LoadProgress { what: &what, fraction: Some(progress.fraction) })
    });
    loaded.map_err(|error| match error.cause {
        Cause::GivenUp => RunError::given_up(),
        cause => {
            // The engine's message has the file's name, not escaped.
            let said = error.to_string();
            let said = said.replace(&file.display().to_string(), &shown(file).to_string());
            match cause {
                Cause::NoMemory => RunError::machine(said),
                _ => RunError::user(said),
            }
        }
    })
}

/// Returns the hierarchy over a scene, after reporting the step.
///
/// # Errors
/// A scene over which no hierarchy can be built; loading that was given up.
pub fn hierarchy(
    scene: &Scene,
    progress_fn: &mut LoadProgressFn<'_>,
) -> Result<Hierarchy, RunError> {
    report_progress(progress_fn, "building the hierarchy", None)?;
    Hierarchy::build(&object_bounds(scene)?).map_err(RunError::machine)
}

/// Returns the report about a file.
pub fn report(file: &Path, imported: &GltfScene, load_ms: f64) -> FileReport {
    let scene = &imported.scene;
    let surfaces = scene.surfaces.as_ref();
    let count = |number: Option<usize>| number.unwrap_or_default() as u64;
    FileReport {
        path: file.display().to_string(),
        load_ms: Some(load_ms),
        meshes: scene.meshes.len() as u64,
        materials: count(surfaces.map(|surfaces| surfaces.materials.len())),
        textures: count(surfaces.map(|surfaces| surfaces.textures.len())),
        images: count(surfaces.map(|surfaces| surfaces.images.len())),
        lights: count(surfaces.map(|surfaces| surfaces.lights.len())),
        transparent_objects: count(surfaces.map(|surfaces| surfaces.transparent.len())),
        skinned_meshes: count(surfaces.map(|surfaces| surfaces.skinned_meshes.len())),
        cameras: imported.cameras.len() as u64,
        clips: imported.clips.len() as u64,
        playing: 0,
        notes: imported.notes.iter().map(ToString::to_string).collect(),
    }
}
