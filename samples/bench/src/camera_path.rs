//! The camera of each frame: along a path of the scene, along a recorded path, or as a clip moves
//! it.

use antumbra::cull::Camera;
use scenes::{CameraPath, PathKind, Routes};

use crate::choices;
use crate::options::PathChoice;
use crate::playback::Orbit;
use crate::recorded_path::RecordedPath;
use crate::run_error::RunError;

/// The camera of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCamera {
    /// The number of the frame on its path.
    pub frame: u32,
    /// The camera.
    pub camera: Camera,
}

/// A camera for every frame.
#[derive(Clone, Debug)]
pub enum CameraTrack {
    /// A path made for the scene.
    Made(CameraPath),
    /// A recorded path from a file; the camera is the fallback for a path without frames.
    Recorded(RecordedPath, Camera),
    /// Cameras from a scene's file: for the first frame, and for the frames that follow. After the
    /// last one the camera stands still.
    Filmed(Camera, Vec<Camera>),
    /// A turn around the scene, in this number of frames.
    Around(Orbit, u32),
}

impl CameraTrack {
    /// Returns the path that was chosen, along `routes`.
    ///
    /// # Errors
    /// A path along streets in a scene without streets; a file that is not a path.
    pub fn new(choice: &PathChoice, routes: &Routes) -> Result<Self, RunError> {
        Ok(match choice {
            PathChoice::Made(path) => Self::Made(CameraPath::new(kind(*path), routes)?),
            PathChoice::Recorded(file) => {
                // Every scene can be flown over.
                let above = CameraPath::new(PathKind::Fly, routes)?;
                Self::Recorded(RecordedPath::read(file)?, above.camera(0))
            }
            PathChoice::OfFile(_) => {
                return Err(RunError::user("a scene that is made has no cameras of a file"));
            }
        })
    }

    /// Returns the camera of a frame, with the number of the frame.
    pub fn frame_camera(&self, frame: u32) -> FrameCamera {
        FrameCamera { frame, camera: self.camera(frame) }
    }

    /// Returns the camera of a frame.
    pub fn camera(&self, frame: u32) -> Camera {
        match self {
            Self::Made(path) => path.camera(frame),
            Self::Recorded(recorded, fallback) => recorded.camera(frame).unwrap_or(*fallback),
            Self::Filmed(first, others) => {
                let place = (frame as usize).min(others.len()).checked_sub(1);
                place.and_then(|place| others.get(place)).copied().unwrap_or(*first)
            }
            Self::Around(orbit, frames) => orbit.camera(frame, *frames),
        }
    }
}

fn kind(path: choices::CameraPathChoice) -> PathKind {
    match path {
        choices::CameraPathChoice::Street => PathKind::Street,
        choices::CameraPathChoice::Fly => PathKind::Fly,
        choices::CameraPathChoice::Cut => PathKind::Cut,
    }
}
