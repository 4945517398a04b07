//! Players: the clips that play, as a pure function of time.

use crate::clip::Clip;
use crate::pose::Pose;
use crate::rig::Rig;

/// The identity of a clip: an index into the clips of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipId(pub u32);

/// The identity of a layer of a [`Player`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LayerId(pub u32);

/// The behaviour at the end of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Repeat {
    /// The clip stops at its end.
    Once,
    /// The clip restarts.
    Loop,
}

/// The playback of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// The clip that plays, an index into the list given to [`Player::pose_at`].
    pub clip: ClipId,
    /// The time at which the clip begins, in seconds of the player's time. Before this time, the
    /// first pose is shown.
    pub start_s: f64,
    /// The speed: 1 for the clip's own speed, negative for backwards from its end.
    pub speed: f32,
    /// The behaviour at the end of the clip.
    pub repeat: Repeat,
}

impl Playback {
    /// Returns a playback that repeats from `now_s` on, at the clip's own speed.
    pub fn looped(clip: ClipId, now_s: f64) -> Self {
        Self { clip, start_s: now_s, speed: 1.0, repeat: Repeat::Loop }
    }

    /// Returns the time within the clip, whose duration is `duration_s`.
    pub fn time_s(&self, duration_s: f32, now_s: f64) -> f32 {
        let duration = f64::from(duration_s);
        let played_s = (now_s - self.start_s).max(0.0) * f64::from(self.speed);
        let played_s = if self.speed < 0.0 { duration + played_s } else { played_s };
        let time_s = match self.repeat {
            Repeat::Loop if duration > 0.0 && played_s > duration => played_s % duration,
            Repeat::Loop if duration > 0.0 && played_s < 0.0 => played_s.rem_euclid(duration),
            Repeat::Once | Repeat::Loop => played_s,
        };
        // NaN counts as the beginning.
        if time_s.is_finite() { time_s.clamp(0.0, duration) as f32 } else { 0.0 }
    }
}

/// A clip that fades in over the earlier clips of its layer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Voice {
    playback: Playback,
    fade_start_s: f64,
    /// The duration of the fade; 0 switches immediately.
    fade_s: f32,
    /// The final weight.
    weight: f32,
}

impl Voice {
    fn weight(&self, now_s: f64) -> f32 {
        let fading_s = now_s - self.fade_start_s;
        let is_over = fading_s >= f64::from(self.fade_s);
        let share = if is_over { 1.0 } else { (fading_s / f64::from(self.fade_s)).max(0.0) as f32 };
        share * self.weight
    }

    fn covers(&self, now_s: f64) -> bool {
        self.weight(now_s) >= 1.0
    }
}

/// The state of playback. A **layer** is one clip, or several clips that fade from one to the next.
/// A property that one of these clips does not animate fades from or to its rest value. All layers
/// play at the same time. Where two layers animate the same property, the later layer wins.
///
/// The player is a value: the pose depends only on the player and the time. Poses may be computed
/// in any order for all times after the last change of the player.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Player {
    layers: Vec<Vec<Voice>>,
}

/// The scratch poses of a [`Player`]; one workspace can be used for the lifetime of a rig.
#[derive(Clone, Debug)]
pub struct Workspace {
    layer: Pose,
    voice: Pose,
}

impl Workspace {
    /// Creates a workspace for players on this rig.
    pub fn new(rig: &Rig) -> Self {
        Self { layer: Pose::new(rig), voice: Pose::new(rig) }
    }
}

impl Player {
    /// Creates a player in which nothing plays.
    pub fn new() -> Self {
        Self::default()
    }

    /// Plays a clip in a new layer over all others.
    pub fn play(&mut self, playback: Playback) -> LayerId {
        let fade_start_s = f64::NEG_INFINITY;
        let voice = Voice { playback, fade_start_s, fade_s: 0.0, weight: 1.0 };
        self.layers.push(vec![voice]);
        LayerId(self.layers.len().saturating_sub(1) as u32)
    }

    /// Fades from the clips of a layer to another clip, from `now_s` on, in `fade_s` seconds. The
    /// pose before `now_s` does not change. Clips that later clips have fully replaced are removed.
    /// An unknown layer is ignored.
    pub fn cross_fade(&mut self, layer: LayerId, to: Playback, now_s: f64, fade_s: f32) {
        self.add(layer, now_s, Voice { playback: to, fade_start_s: now_s, fade_s, weight: 1.0 });
    }

    /// Mixes another clip into a layer with a constant weight from 0 to 1: 0 keeps the old pose, 1
    /// replaces it.
    pub fn mix(&mut self, layer: LayerId, with: Playback, now_s: f64, weight: f32) {
        let weight = if weight.is_finite() { weight.clamp(0.0, 1.0) } else { 0.0 };
        self.add(layer, now_s, Voice { playback: with, fade_start_s: now_s, fade_s: 0.0, weight });
    }

    fn add(&mut self, layer: LayerId, now_s: f64, voice: Voice) {
        if let Some(voices) = self.layers.get_mut(layer.0 as usize) {
            let heard = first_heard(voices, now_s);
            voices.drain(..heard);
            voices.push(voice);
        }
    }

    /// Stops the clips of a layer: the nodes that it moved return to rest, or follow other layers.
    pub fn stop(&mut self, layer: LayerId) {
        if let Some(voices) = self.layers.get_mut(layer.0 as usize) {
            voices.clear();
        }
    }

    /// Returns the clips that contribute to the pose at a time, possibly with repetitions.
    pub fn playing(&self, now_s: f64) -> impl Iterator<Item = ClipId> {
        let heard = move |voices: &Vec<Voice>| first_heard(voices, now_s);
        let voices = self.layers.iter().flat_map(move |voices| voices.iter().skip(heard(voices)));
        let parts = voices.filter(move |voice| voice.weight(now_s) > 0.0);
        parts.map(|voice| voice.playback.clip)
    }

    /// Computes the pose at a time. The pose is reset to rest, then each layer sets the properties
    /// of its clips. Clips that do not exist are ignored. The work is proportional to the number of
    /// nodes that move or moved last, not to the size of the rig.
    pub fn pose_at(
        &self,
        rig: &Rig,
        clips: &[Clip],
        now_s: f64,
        workspace: &mut Workspace,
        pose: &mut Pose,
    ) {
        pose.reset(rig);
        let clip_of = |voice: &Voice| clips.get(voice.playback.clip.0 as usize);
        let Workspace { layer, voice: other } = workspace;
        for voices in &self.layers {
            let heard = voices.get(first_heard(voices, now_s)..).unwrap_or_default();
            layer.reset(rig);
            for (number, voice) in heard.iter().enumerate() {
                let Some(clip) = clip_of(voice) else { continue };
                let time_s = voice.playback.time_s(clip.duration_s(), now_s);
                if number == 0 {
                    layer.sample(clip, time_s);
                } else if voice.weight(now_s) > 0.0 {
                    other.reset(rig);
                    other.sample(clip, time_s);
                    layer.blend(other, voice.weight(now_s));
                }
            }
            for clip in heard.iter().filter(|voice| voice.weight(now_s) > 0.0).filter_map(clip_of) {
                pose.take(layer, clip);
            }
        }
    }
}

/// Returns the index of the last voice that fully covers the earlier voices of a layer, or 0.
fn first_heard(voices: &[Voice], now_s: f64) -> usize {
    voices.iter().rposition(|voice| voice.covers(now_s)).unwrap_or(0)
}
