//! The camera's path: recorded from the user's movements, or the model's own, and played back.

use crate::orbit::OrbitCamera;

/// The time between two recorded cameras, in seconds.
const RECORD_INTERVAL_S: f32 = 0.1;

/// The most recorded cameras: half an hour.
const MOST_RECORDED: usize = 18_000;

/// The time for one round on a model's own path, in seconds.
const ROUND_S: f32 = 12.0;

/// The camera's path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrbitPath {
    /// The model's own cameras, on a closed path.
    own: Vec<OrbitCamera>,
    /// The recorded cameras.
    recorded: Vec<OrbitCamera>,
    /// The time since the newest recorded camera, while recording.
    recording_s: Option<f32>,
    /// The time since the start, while playing.
    playing_s: Option<f32>,
}

impl OrbitPath {
    /// Creates the path of a model, with its own cameras if it has any.
    pub fn new(own: Vec<OrbitCamera>) -> Self {
        Self { own, ..Self::default() }
    }

    /// Returns true while recording.
    pub fn is_recording(&self) -> bool {
        self.recording_s.is_some()
    }

    /// Returns true while playing.
    pub fn is_playing(&self) -> bool {
        self.playing_s.is_some()
    }

    /// Begins a new recording, or ends the current one.
    pub fn toggle_recording(&mut self) {
        self.playing_s = None;
        if self.recording_s.take().is_none() {
            self.recorded.clear();
            self.recording_s = Some(RECORD_INTERVAL_S);
        }
    }

    /// Begins or ends playing. Plays the recorded path, or the model's own path if nothing was
    /// recorded. Returns false if there is nothing to play.
    pub fn toggle_playing(&mut self) -> bool {
        self.recording_s = None;
        if self.playing_s.take().is_none() && self.seconds() > 0.0 {
            self.playing_s = Some(0.0);
        }
        self.seconds() > 0.0
    }

    /// Ends playing and recording.
    pub fn stop(&mut self) {
        self.recording_s = None;
        self.playing_s = None;
    }

    /// Ends playing.
    pub fn stop_playing(&mut self) {
        self.playing_s = None;
    }

    /// Advances the time: records the camera, or returns the played one. A recorded path is played
    /// once, a model's own path until it is stopped.
    pub fn advance(&mut self, seconds: f32, camera: &OrbitCamera) -> Option<OrbitCamera> {
        if let Some(since_s) = &mut self.recording_s {
            *since_s += seconds;
            if *since_s >= RECORD_INTERVAL_S && self.recorded.len() < MOST_RECORDED {
                *since_s = 0.0;
                self.recorded.push(*camera);
            }
        }
        let playing_s = self.playing_s? + seconds;
        let whole_s = self.seconds();
        let is_over = self.is_recorded() && playing_s >= whole_s;
        self.playing_s = (!is_over).then_some(playing_s);
        let cameras = if self.is_recorded() { &self.recorded } else { &self.own };
        if is_over {
            return cameras.last().copied();
        }
        let count = cameras.len();
        let links = if self.is_recorded() { count - 1 } else { count };
        let place = (playing_s / whole_s).fract() * links as f32;
        let from = cameras.get(place as usize)?;
        let to = cameras.get((place as usize + 1) % count)?;
        Some(from.between(to, place.fract()))
    }

    fn is_recorded(&self) -> bool {
        self.recorded.len() > 1
    }

    /// Returns the length of the played path, in seconds; 0 without a path.
    fn seconds(&self) -> f32 {
        if self.is_recorded() {
            return (self.recorded.len() - 1) as f32 * RECORD_INTERVAL_S;
        }
        if self.own.len() > 1 { ROUND_S } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use antumbra::glam::Vec3;

    use super::*;

    fn camera(yaw_rad: f32) -> OrbitCamera {
        OrbitCamera { yaw_rad, ..OrbitCamera::around(Vec3::ZERO, 1.0) }
    }

    #[test]
    fn what_was_recorded_is_played_once() {
        let mut path = OrbitPath::default();
        assert!(!path.toggle_playing() && !path.is_playing(), "nothing to play");
        path.toggle_recording();
        for step in 0..=20 {
            assert_eq!(path.advance(0.1, &camera(step as f32 * 0.05)), None);
        }
        path.toggle_recording();
        assert!(path.toggle_playing());
        let half = path.advance(1.0, &camera(9.0)).unwrap();
        assert!((half.yaw_rad - 0.5).abs() < 0.01, "{half:?}");
        let last = path.advance(60.0, &camera(9.0)).unwrap();
        assert!((last.yaw_rad - 1.0).abs() < 1e-5 && !path.is_playing());
        assert_eq!(path.advance(1.0, &camera(9.0)), None);
    }

    #[test]
    fn the_models_own_path_is_closed() {
        let mut path = OrbitPath::new(vec![camera(0.0), camera(1.0)]);
        assert!(path.toggle_playing());
        let back = path.advance(ROUND_S * 2.75, &camera(9.0)).unwrap();
        assert!((back.yaw_rad - 0.5).abs() < 1e-4 && path.is_playing(), "{back:?}");
        path.stop();
        assert!(!path.is_playing());
    }
}
