//! The clips and cameras of a file, as one renderer plays them.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

use cull::{Camera, ObjectId};
use import::{SceneAnimator, SceneCamera};
use scene::{ObjectChange, SceneUpdate};

use crate::error::Failure;
use crate::renderer::scene_file::ANTUMBRA_CAMERA_OVERVIEW;

/// The animation of a renderer's scene, and its cameras.
pub(crate) struct Playback {
    pub animator: SceneAnimator,
    pub cameras: Arc<[SceneCamera]>,
    /// The view of everything at rest.
    pub overview: Camera,
    /// The objects of the file that the host removed. Other objects may have their ids.
    pub removed: HashSet<ObjectId>,
}

impl Playback {
    /// Plays these clips; `None` plays all clips that can play together.
    pub fn play(&mut self, clips: Option<&[u32]>, begin: f64, fade: f64) -> Result<(), Failure> {
        check_seconds("seconds", begin)?;
        check_seconds("fade_seconds", fade)?;
        if fade < 0.0 {
            return Err(Failure::argument(format_args!("fade_seconds is {fade}, below 0")));
        }
        let clips = match clips {
            None => self.animator.compatible(None),
            Some(clips) => {
                let listed = clips.iter().enumerate();
                listed.map(|(place, clip)| self.known(place, *clip)).collect::<Result<_, _>>()?
            }
        };
        self.animator.play(&clips, begin, fade);
        Ok(())
    }

    /// Returns the index of a clip of the caller's array, if there is such a clip.
    fn known(&self, place: usize, clip: u32) -> Result<usize, Failure> {
        let count = self.animator.clips().len();
        let known = Some(clip as usize).filter(|clip| *clip < count);
        known.ok_or_else(|| {
            let place = format!("clips[{place}]");
            missing(&place, clip, count, "clips")
        })
    }

    /// Returns the changes of the scene from the last call to a time.
    pub fn changes(&mut self, seconds: f64) -> Result<Cow<'_, SceneUpdate>, Failure> {
        check_seconds("seconds", seconds)?;
        let Self { animator, removed, .. } = self;
        let mut changes = Cow::Borrowed(animator.changes(seconds));
        if !removed.is_empty() {
            let is_there = |change: &ObjectChange| match change {
                ObjectChange::Move { object, .. } => !removed.contains(object),
                _ => true,
            };
            changes.to_mut().objects.retain(is_there);
        }
        Ok(changes)
    }

    /// Returns a camera at the time of the last changes, for images of a size in pixels.
    pub fn camera(&self, index: u32, size: [u32; 2]) -> Result<Camera, Failure> {
        if index == ANTUMBRA_CAMERA_OVERVIEW {
            return Ok(self.overview);
        }
        let camera = self.cameras.get(index as usize);
        let camera =
            camera.ok_or_else(|| missing("index", index, self.cameras.len(), "cameras"))?;
        Ok(self.animator.seen_by(camera, size))
    }
}

/// Returns the refusal of an index that is out of range.
pub(crate) fn missing(name: &str, index: u32, count: usize, elements: &str) -> Failure {
    Failure::argument(format_args!(
        "{name} is {index}, and the file has {count} {elements}, counted from 0"
    ))
}

fn check_seconds(name: &str, seconds: f64) -> Result<(), Failure> {
    if seconds.is_finite() {
        return Ok(());
    }
    Err(Failure::argument(format_args!("{name} is {seconds}, which is not a time")))
}
