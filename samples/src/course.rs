//! Where a camera goes: along a path of the scene, or along one that was recorded.

use cull::Camera;
use render::scene::{CameraPath, PathKind, Scene};

use crate::choices;
use crate::options::PathChoice;
use crate::recorded_path::RecordedPath;
use crate::run::RunError;

/// A camera for every frame.
#[derive(Clone, Debug)]
pub enum Course {
    /// Made for the scene.
    Made(CameraPath),
    /// From a file.
    Recorded(RecordedPath, CameraPath),
}

impl Course {
    /// The path that was chosen, through `scene`.
    ///
    /// # Errors
    /// A walk where there are no streets; a file that is no path.
    pub fn new(choice: &PathChoice, scene: &Scene) -> Result<Self, RunError> {
        Ok(match choice {
            PathChoice::Made(path) => Self::Made(CameraPath::new(kind(*path), scene)?),
            PathChoice::Recorded(file) => {
                // Every scene can be flown over.
                let above = CameraPath::new(PathKind::Fly, scene)?;
                Self::Recorded(RecordedPath::read(file)?, above)
            }
        })
    }

    /// The camera of a frame.
    pub fn camera(&self, frame: u32) -> Camera {
        match self {
            Self::Made(path) => path.camera(frame),
            Self::Recorded(recorded, above) => {
                recorded.camera(frame).unwrap_or_else(|| above.camera(frame))
            }
        }
    }
}

fn kind(path: choices::CameraPath) -> PathKind {
    match path {
        choices::CameraPath::Street => PathKind::Street,
        choices::CameraPath::Fly => PathKind::Fly,
        choices::CameraPath::Cut => PathKind::Cut,
    }
}
