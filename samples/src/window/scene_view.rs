//! The view of a scene: the first camera, the camera's paths, and the scene's motion.

use std::path::Path;

use antumbra::cull::{Camera, ObjectId};
use antumbra::import;
use antumbra::import::{GltfScene, SceneAnimator};
use antumbra::render::Renderer;
use antumbra::scene::{LightMove, Scene};

use super::clearance::clearance_m;
use super::detail::Detail;
use super::page_text::{Facts, fact};
use super::source::FileSource;
use bench::camera_path::CameraTrack;
use bench::playback::{self, Clips};
use bench::recorded_path::RecordedPath;
use bench::run_error::RunError;
use scenes::YardMotion;

/// The time of the transition from one clip to another, in seconds.
const FADE_S: f64 = 0.3;
/// The time step while time is stopped, in seconds.
const STEP_S: f64 = 1.0 / 60.0;
/// The longest time step: after a pause of the program, time does not jump.
const LONGEST_STEP_S: f32 = 0.25;
/// The speed of flight in scenes of the size of streets, in metres per second.
const WALKING_M: f32 = 4.0;
/// The least clear distance in front of a camera, in metres; below it, the view shows a wall.
const WALL_M: f32 = 2.5;
/// The number of times in a camera's clip at which a view without a wall in front is searched.
const MOMENTS: u32 = 16;
/// The approximate time of crossing a scene, in seconds.
const CROSSING_S: f32 = 30.0;

/// The guide of the camera, until the user steers.
#[derive(Debug)]
enum Guide {
    Nobody,
    Track(CameraTrack),
    /// A camera of the file, by its index.
    Camera(usize),
    /// A view of everything.
    Overview,
}

/// The view of a scene: its cameras, its paths, and what moves in it.
pub struct SceneView {
    /// The name that written files are given.
    pub name: String,
    /// The first camera.
    pub start: Camera,
    /// The speed of flight, in metres per second.
    pub speed_m: f32,
    /// The messages about the scene that are shown once.
    pub notes: Vec<String>,
    /// The keys to try next from the first camera.
    pub hint: Option<String>,
    /// The rule for coarser levels of detail; `None` for none.
    pub detail: Option<Detail>,
    guide: Guide,
    names: MeshNames,
    /// The camera that sees all of a file's scene.
    overview: Camera,
    life: Option<Life>,
    /// The motion of the courtyard, and its time in seconds.
    motion: Option<(YardMotion, f64)>,
}

/// The names of the meshes of a scene.
#[derive(Default)]
struct MeshNames {
    names: Vec<String>,
    /// The mesh of each object.
    meshes: Vec<u32>,
}

impl MeshNames {
    fn of(scene: &Scene) -> Self {
        Self {
            names: scene.meshes.iter().map(|mesh| mesh.name.clone()).collect(),
            meshes: scene.objects.iter().map(|object| object.mesh.0).collect(),
        }
    }
}

/// The motion in a scene from a file.
struct Life {
    animator: SceneAnimator,
    cameras: Vec<import::SceneCamera>,
    /// The playing clips.
    clips: Clips,
    /// The time in the scene.
    seconds: f64,
    is_paused: bool,
}

/// A scene that was read from a file, and its view.
pub struct SceneOfFile {
    /// The scene.
    pub scene: Scene,
    /// Its cameras and its motion.
    pub scene_view: SceneView,
}

impl SceneView {
    /// Creates the view of a scene without motion.
    pub fn still(name: &str, start: Camera) -> Self {
        Self {
            name: name.to_owned(),
            start,
            speed_m: WALKING_M,
            notes: Vec::new(),
            hint: None,
            detail: None,
            guide: Guide::Nobody,
            names: MeshNames::default(),
            overview: start,
            life: None,
            motion: None,
        }
    }

    /// Returns the view with the mesh names of `scene`.
    pub fn with_names(mut self, scene: &Scene) -> Self {
        self.names = MeshNames::of(scene);
        self
    }

    /// Returns the view with the motion of the courtyard.
    pub fn with_motion(self, motion: YardMotion) -> Self {
        Self { motion: Some((motion, 0.0)), ..self }
    }

    /// Returns the name of an object's mesh; `None` for objects that were added later.
    pub fn mesh_name(&self, object: ObjectId) -> Option<&str> {
        let mesh = *self.names.meshes.get(object.0 as usize)?;
        self.names.names.get(mesh as usize).map(String::as_str)
    }

    /// Returns the view with a camera on this path.
    pub fn with_track(mut self, track: Option<CameraTrack>) -> Self {
        self.guide = track.map_or(Guide::Nobody, Guide::Track);
        self
    }

    /// Creates the view of a file's scene for images of this size. A panel covers up to this share
    /// of the width on the left.
    ///
    /// # Errors
    /// A camera that the file does not have; a recorded path that is invalid.
    pub fn of_file(
        file: &Path,
        imported: GltfScene,
        settings: &FileSource,
        size: [u32; 2],
        covered: f32,
    ) -> Result<SceneOfFile, RunError> {
        let names = MeshNames::of(&imported.scene);
        let detail = settings.detail_pixels.map(|pixels| Detail::new(&imported.scene, pixels));
        let detail =
            if settings.has_detail_by_samples { detail.map(Detail::by_samples) } else { detail };
        let shown = bench::terminal::shown(file);
        let wanted = settings.camera.as_deref();
        let camera = playback::find_camera(&imported.cameras, wanted, &shown)?;
        let recorded = settings.recorded.as_deref().map(RecordedPath::read).transpose()?;
        let (scene, mut animator, cameras, notes) = SceneAnimator::of(imported);
        let mut notes: Vec<String> = notes.iter().map(ToString::to_string).collect();
        let own = camera.and_then(|place| animator.clip_of(cameras.get(place)?));
        let clips = Clips::all(&animator, own);
        notes.extend(clips.conflicts(&animator));
        animator.play(clips.playing(), 0.0, 0.0);
        let bounds = animator.bounds_playing(&scene);
        animator.pose(0.0);
        let around = playback::portrait(&bounds, size, covered);
        let first = camera.and_then(|place| Some((place, cameras.get(place)?)));
        // A camera that was not requested and that a clip moves may begin in a wall or right in
        // front of one.
        let is_free = wanted.is_none() && recorded.is_none();
        let driven = first.filter(|(_, camera)| is_free && animator.drive(clips.playing(), camera));
        let clear_s = driven.map(|(_, camera)| clear_moment(&mut animator, &scene, camera, size));
        let is_never_clear = clear_s == Some(None);
        let seconds = clear_s.flatten().unwrap_or_default();
        animator.pose(seconds);
        let (start, guide) = match (recorded, first) {
            (Some(path), _) => {
                let start = path.camera(0).unwrap_or(around);
                (start, Guide::Track(CameraTrack::Recorded(path, around)))
            }
            (None, Some(_)) if is_never_clear => (around, Guide::Overview),
            (None, Some((place, camera))) => (animator.seen_by(camera, size), Guide::Camera(place)),
            (None, None) => (around, Guide::Nobody),
        };
        let hint = driven.filter(|_| is_never_clear);
        let hint = hint.map(|(_, camera)| how_to_look(&camera.name, cameras.len()));
        let crossing_m = (bounds.max - bounds.min).length() / CROSSING_S;
        let scene_view = Self {
            name: file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            start,
            speed_m: if crossing_m.is_normal() { crossing_m } else { WALKING_M },
            notes,
            hint,
            detail,
            guide,
            names,
            overview: around,
            life: Some(Life { animator, cameras, clips, seconds, is_paused: false }),
            motion: None,
        };
        Ok(SceneOfFile { scene, scene_view })
    }

    /// Returns the camera of a path in a frame of `size` pixels; `None` while the user steers.
    pub fn camera(&self, frame: u32, size: [u32; 2]) -> Option<Camera> {
        match (&self.guide, &self.life) {
            (Guide::Track(track), _) => Some(track.camera(frame)),
            (Guide::Camera(place), Some(life)) => {
                Some(life.animator.seen_by(life.cameras.get(*place)?, size))
            }
            (Guide::Overview, _) => Some(self.overview),
            _ => None,
        }
    }

    /// Lets the user steer. Returns true if the camera followed a path before.
    pub fn take_over(&mut self) -> bool {
        !matches!(std::mem::replace(&mut self.guide, Guide::Nobody), Guide::Nobody)
    }

    /// Advances the time by `seconds`, and moves cameras accordingly.
    pub fn advance(&mut self, seconds: f32) {
        if let Some((_, passed_s)) = &mut self.motion
            && seconds.is_finite()
        {
            *passed_s += f64::from(seconds.clamp(0.0, LONGEST_STEP_S));
        }
        let Some(life) = &mut self.life else { return };
        if !life.is_paused && seconds.is_finite() {
            life.seconds += f64::from(seconds.clamp(0.0, LONGEST_STEP_S));
        }
        life.animator.pose(life.seconds);
    }

    /// Moves everything in `renderer` to its place at the current time. If `camera` is the only
    /// camera, meshes that it cannot see are not posed; with `None` all meshes are.
    ///
    /// # Errors
    /// When the renderer refuses a change.
    pub fn show(
        &mut self,
        renderer: &mut Renderer,
        camera: Option<&Camera>,
    ) -> Result<(), RunError> {
        if let Some((motion, passed_s)) = &self.motion {
            renderer.apply(&motion.at(*passed_s))?;
        }
        let Some(life) = &mut self.life else { return Ok(()) };
        let changes = match camera {
            Some(camera) => life.animator.changes_in(life.seconds, &[renderer.view_of(camera)]),
            None => life.animator.changes(life.seconds),
        };
        renderer.apply(changes)?;
        Ok(())
    }

    /// Returns the state of the moving light, if there is one.
    pub fn moved_light(&self) -> Option<LightMove> {
        let (motion, passed_s) = self.motion.as_ref()?;
        motion.at(*passed_s).lights.first().copied()
    }

    /// Returns true if there are clips or cameras to choose from.
    pub fn is_alive(&self) -> bool {
        self.life.is_some()
    }

    /// Stops or continues time. Returns a message about it.
    ///
    /// # Errors
    /// The reason why that is impossible.
    pub fn toggle_pause(&mut self) -> Result<String, String> {
        let life = self.living()?;
        life.is_paused = !life.is_paused;
        Ok(if life.is_paused { "time stands still" } else { "time goes on" }.to_owned())
    }

    /// Advances the time by one step, and stops it. Returns a message about it.
    ///
    /// # Errors
    /// The reason why that is impossible.
    pub fn step(&mut self) -> Result<String, String> {
        let life = self.living()?;
        life.is_paused = true;
        life.seconds += STEP_S;
        Ok(format!("one step: {:.3} s", life.seconds))
    }

    /// Plays only the next clip. Returns a message about it.
    ///
    /// # Errors
    /// The reason why that is impossible.
    pub fn next_clip(&mut self) -> Result<String, String> {
        let life = self.living()?;
        life.clips = life.clips.next(&life.animator);
        let told = life.change_clips();
        self.leave_standing_camera();
        Ok(told)
    }

    /// Plays all clips at once. Returns a message about it.
    ///
    /// # Errors
    /// The reason why that is impossible.
    pub fn all_clips(&mut self) -> Result<String, String> {
        let life = self.living()?;
        life.clips = Clips::all(&life.animator, None);
        let told = life.change_clips();
        self.leave_standing_camera();
        Ok(told)
    }

    /// Shows everything if the clip that moves the current camera does not play any more. Without
    /// the clip, the camera's place is often inside of an object.
    fn leave_standing_camera(&mut self) {
        let (Guide::Camera(place), Some(life)) = (&self.guide, &self.life) else { return };
        let Some(camera) = life.cameras.get(*place) else { return };
        let is_driven = life.animator.clip_of(camera).is_some();
        if is_driven && !life.animator.drive(life.clips.playing(), camera) {
            self.guide = Guide::Overview;
        }
    }

    /// Looks through a camera of the file, counted from 1. Returns a message about it.
    ///
    /// # Errors
    /// The reason why that is impossible.
    pub fn look_through(&mut self, number: u32) -> Result<String, String> {
        let place = (number as usize).saturating_sub(1);
        let Some(life) = &mut self.life else { return Err(NO_FILE.to_owned()) };
        let Some(camera) = life.cameras.get(place) else {
            return Err(match life.cameras.len() {
                0 => "the file has no camera".to_owned(),
                1 => "the file has one camera".to_owned(),
                count => format!("the file has {count} cameras"),
            });
        };
        let told = format!("camera {}", camera.name);
        let own = life.animator.clip_of(camera);
        if own.is_some_and(|clip| !life.clips.playing().contains(&clip)) {
            life.clips = Clips::all(&life.animator, own);
            life.change_clips();
        }
        self.guide = Guide::Camera(place);
        Ok(told)
    }

    /// Returns the facts that are always shown.
    pub fn facts(&self) -> Option<Facts> {
        let life = self.life.as_ref()?;
        let camera = match self.guide {
            Guide::Camera(place) => life.cameras.get(place).map(|camera| camera.name.clone()),
            Guide::Track(_) => Some("along the path".to_owned()),
            Guide::Overview => Some("over everything".to_owned()),
            Guide::Nobody => None,
        };
        let time = if life.is_paused {
            format!("{:.2} s, paused", life.seconds)
        } else {
            format!("{:.2} s", life.seconds)
        };
        let facts = [
            fact("file", self.name.clone()),
            fact("camera", camera.unwrap_or_else(|| "yours".to_owned())),
            fact("clips", life.clips.describe(&life.animator)),
            fact("time", time),
        ];
        let detail = self.detail.as_ref().map(|detail| fact("detail", detail.text()));
        Some(facts.into_iter().chain(detail).collect())
    }

    fn living(&mut self) -> Result<&mut Life, String> {
        match &mut self.life {
            Some(life) if !life.animator.clips().is_empty() => Ok(life),
            Some(_) => Err("the file has no clips".to_owned()),
            None => Err(NO_FILE.to_owned()),
        }
    }
}

/// Returns the first of [`MOMENTS`] times in a camera's clip, in seconds, at which no wall is right
/// in front of the camera.
fn clear_moment(
    animator: &mut SceneAnimator,
    scene: &Scene,
    camera: &import::SceneCamera,
    size: [u32; 2],
) -> Option<f64> {
    let clip = animator.clip_of(camera);
    let duration_s = clip.and_then(|clip| animator.duration_s(clip)).unwrap_or_default();
    let mut moments =
        (0..MOMENTS).map(|moment| f64::from(duration_s) * f64::from(moment) / f64::from(MOMENTS));
    moments.find(|seconds| {
        animator.pose(*seconds);
        clearance_m(scene, &animator.seen_by(camera, size)) >= WALL_M
    })
}

/// Returns a hint at the keys for the first of `count` cameras, which a clip moves, and for the
/// others.
fn how_to_look(first: &str, count: usize) -> String {
    let others = match count {
        0 | 1 => String::new(),
        2 => ", 2 through the other".to_owned(),
        _ => format!(", 2 to {} through others", count.min(9)),
    };
    format!("a clip moves the file's first camera, {first}: key 1 looks through it{others}")
}

const NO_FILE: &str = "that is for scenes out of files";

impl Life {
    fn change_clips(&mut self) -> String {
        self.animator.play(self.clips.playing(), self.seconds, FADE_S);
        format!("clips: {}", self.clips.describe(&self.animator))
    }
}
