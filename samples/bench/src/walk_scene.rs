//! The scene of a walk: objects, camera path, motion, and the report about its file.

use std::ops::ControlFlow;
use std::path::Path;

use antumbra::glam::Vec3;
use antumbra::import;
use antumbra::import::{LoadOptions, SceneAnimator};
use antumbra::scene::Scene;
use scenes::GeneratedScene;

use crate::Options;
use crate::camera_path::CameraTrack;
use crate::moving::Moving;
use crate::options::{MadeScene, PathChoice, SceneChoice};
use crate::playback::{self, Clips, FrameClock, Orbit};
use crate::progress::WalkProgress;
use crate::recorded_path::RecordedPath;
use crate::report::FileReport;
use crate::run_error::RunError;
use crate::scene_file;
use crate::signals::Signals;
use crate::stopwatch::Stopwatch;
use crate::terminal::shown;

/// The scene of a walk, with its camera path and its motion.
pub struct WalkScene {
    /// The scene at rest.
    pub scene: Scene,
    /// The seed it was generated from; 0 where it comes out of a file.
    pub seed: u64,
    /// The camera's path.
    pub path: CameraTrack,
    /// The name of the path.
    pub path_name: String,
    /// The motion of objects along the walk, if they move.
    pub moving: Moving,
    /// The report about its file, if it comes from one.
    pub file: Option<FileReport>,
}

impl WalkScene {
    /// Makes or loads the scene that the options ask for.
    ///
    /// # Errors
    /// Numbers from which no scene can be made; a file that cannot be shown; a path or a camera
    /// that does not exist.
    pub fn build(
        options: &Options,
        progress: &dyn WalkProgress,
        signals: &Signals,
    ) -> Result<Self, RunError> {
        match &options.scene {
            SceneChoice::Made(made) => Self::make(made, options, progress),
            SceneChoice::File(file) => Self::load(file, options, progress, signals),
        }
    }

    fn make(
        made: &MadeScene,
        options: &Options,
        progress: &dyn WalkProgress,
    ) -> Result<Self, RunError> {
        let MadeScene { scene: kind, objects, seed } = *made;
        progress.stage(&if kind.takes_numbers() {
            format!("building the {kind} of about {objects} objects")
        } else {
            format!("building the {kind}")
        });
        let GeneratedScene { scene, routes } = made.make()?;
        let path = CameraTrack::new(&options.path, &routes)?;
        let moving = Moving::new(&scene, options.asked.moving_percent, seed)?;
        let scene = lit(scene, &path, options)?;
        let path_name = options.path.to_string();
        Ok(Self { scene, seed, path, path_name, moving, file: None })
    }

    fn load(
        file: &Path,
        options: &Options,
        progress: &dyn WalkProgress,
        signals: &Signals,
    ) -> Result<Self, RunError> {
        let mut clock = Stopwatch::start();
        let mut newest = String::new();
        let reading = LoadOptions {
            broken_parts: options.asked.file.broken_parts(),
            cut_above_triangles: options.cut_above_triangles,
            ..LoadOptions::default()
        };
        let imported = scene_file::load(file, &reading, &mut |loading| {
            if loading.what != newest {
                loading.what.clone_into(&mut newest);
                progress.stage(loading.what);
            }
            match signals.received() {
                Some(_) => ControlFlow::Break(()),
                None => ControlFlow::Continue(()),
            }
        })?;
        let load_ms = clock.lap_ms();
        let mut report = scene_file::report(file, &imported, load_ms);
        let size =
            [options.asked.size.width / options.asked.views.max(1), options.asked.size.height];
        let (scene, mut animator, cameras, _) = SceneAnimator::of(imported);
        let way = Way::of(&options.path, &cameras, file)?;
        let camera = match way {
            Way::Camera(place) => cameras.get(place),
            Way::Recorded(_) | Way::Around => None,
        };
        let own = camera.and_then(|camera| animator.clip_of(camera));
        let clips = Clips::all(&animator, own);
        report.playing = clips.playing().len() as u64;
        report.notes.extend(clips.conflicts(&animator));
        animator.play(clips.playing(), 0.0, 0.0);
        let orbit = Orbit::around(&animator.bounds_playing(&scene), size);
        let seconds = own.and_then(|clip| animator.duration_s(clip));
        let clock = FrameClock::of_walk(seconds, options.asked.frames);
        let path_name = match (&way, camera) {
            (Way::Recorded(_), _) => options.path.to_string(),
            (_, Some(camera)) => camera.name.clone(),
            (_, None) => "around".to_owned(),
        };
        let path = match (way, camera) {
            (Way::Recorded(path), _) => CameraTrack::Recorded(path, orbit.camera(0, 1)),
            (_, Some(camera)) => {
                playback::cameras(&mut animator, camera, clock, options.asked.frames, size)
            }
            (_, None) => CameraTrack::Around(orbit, options.asked.frames),
        };
        let moving = Moving::played(animator, clock);
        let scene = lit(scene, &path, options).map_err(|error| error.about(file))?;
        Ok(Self { scene, seed: 0, path, path_name, moving, file: Some(report) })
    }
}

/// Returns the scene under the lights that were asked for.
fn lit(scene: Scene, path: &CameraTrack, options: &Options) -> Result<Scene, RunError> {
    let Some(lights) = options.asked.lighting.lights else { return Ok(scene) };
    let step = options.asked.frames.div_ceil(MOST_EYES).max(1) as usize;
    let frames = (0..options.asked.frames).step_by(step);
    let eyes: Vec<Vec3> = frames.map(|frame| path.camera(frame).eye).collect();
    Ok(lights.light(scene, &eyes)?)
}

/// The most eyes along a path for which lamps are chosen.
const MOST_EYES: u32 = 256;

/// The source of the camera's path.
enum Way {
    Camera(usize),
    Recorded(RecordedPath),
    Around,
}

impl Way {
    /// Returns the camera or the recorded path that was chosen.
    fn of(
        choice: &PathChoice,
        cameras: &[import::SceneCamera],
        file: &Path,
    ) -> Result<Self, RunError> {
        let wanted = match choice {
            PathChoice::OfFile(wanted) => wanted.clone(),
            PathChoice::Recorded(path) => return Ok(Self::Recorded(RecordedPath::read(path)?)),
            PathChoice::Made(path) => Some(path.to_string()),
        };
        let wanted = wanted.as_deref();
        let is_camera = |name: &str| cameras.iter().any(|camera| camera.name == name);
        let recorded = wanted.filter(|name| !is_camera(name)).and_then(crate::choices::path_file);
        if let Some(path) = recorded {
            return Ok(Self::Recorded(RecordedPath::read(&path)?));
        }
        let camera = playback::find_camera(cameras, wanted, &shown(file))?;
        Ok(camera.map_or(Self::Around, Self::Camera))
    }
}
