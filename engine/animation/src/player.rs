//! Players: which clips play, as a pure function of time.

use crate::clip::Clip;
use crate::pose::Pose;
use crate::rig::Rig;

/// Names a clip: an index into the clips of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipId(pub u32);

/// Names a layer of a [`Player`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LayerId(pub u32);

/// What comes after the end of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Repeat {
    /// It stays as it ended.
    Once,
    /// It begins again.
    Loop,
}

/// A clip that plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Which.
    pub clip: ClipId,
    /// When it began, in seconds of the player's time; before that it is as it begins.
    pub start_s: f64,
    /// How fast: 1 as it is, negative backwards from its end.
    pub speed: f32,
    /// What comes after its end.
    pub repeat: Repeat,
}

impl Playback {
    /// Returns a clip that plays again and again from now on, as fast as it is.
    pub fn looped(clip: ClipId, now_s: f64) -> Self {
        Self { clip, start_s: now_s, speed: 1.0, repeat: Repeat::Loop }
    }

    /// Returns which moment of a clip of this duration it shows.
    pub fn time_s(&self, duration_s: f32, now_s: f64) -> f32 {
        let duration = f64::from(duration_s);
        let played_s = (now_s - self.start_s).max(0.0) * f64::from(self.speed);
        let played_s = if self.speed < 0.0 { duration + played_s } else { played_s };
        let time_s = match self.repeat {
            Repeat::Loop if duration > 0.0 && played_s > duration => played_s % duration,
            Repeat::Loop if duration > 0.0 && played_s < 0.0 => played_s.rem_euclid(duration),
            Repeat::Once | Repeat::Loop => played_s,
        };
        // What is no number begins at the beginning.
        if time_s.is_finite() { time_s.clamp(0.0, duration) as f32 } else { 0.0 }
    }
}

/// A clip on its way in, over those before it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Voice {
    playback: Playback,
    fade_start_s: f64,
    /// 0 is there at once.
    fade_s: f32,
    /// How much of it there is at last.
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

/// Which clips play. A **layer** is one clip, or several that fade from one to the next; what one
/// of these does not move fades from or to rest. Layers play at once, and where two move the same
/// property, the later wins.
///
/// It is a value: the pose depends on it and on the time alone, in whatever order times are asked
/// for, from the last change on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Player {
    layers: Vec<Vec<Voice>>,
}

/// Poses that a [`Player`] needs on the way; keep one for as long as the rig.
#[derive(Clone, Debug)]
pub struct Workspace {
    layer: Pose,
    voice: Pose,
}

impl Workspace {
    /// For players on this rig.
    pub fn new(rig: &Rig) -> Self {
        Self { layer: Pose::new(rig), voice: Pose::new(rig) }
    }
}

impl Player {
    /// Nothing plays.
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

    /// From what plays in a layer to another clip, from `now_s` on, in `fade_s` seconds. Until then
    /// the layer is as it was; what is faded over by others for good is forgotten. An unknown layer
    /// stays unknown.
    pub fn cross_fade(&mut self, layer: LayerId, to: Playback, now_s: f64, fade_s: f32) {
        self.add(layer, now_s, Voice { playback: to, fade_start_s: now_s, fade_s, weight: 1.0 });
    }

    /// Mixes another clip into a layer, with a weight from 0 to 1 that stays: 0 is all that was
    /// there, 1 all of the clip.
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

    /// Ends what plays in a layer: what it moved is at rest again, or as other layers have it.
    pub fn stop(&mut self, layer: LayerId) {
        if let Some(voices) = self.layers.get_mut(layer.0 as usize) {
            voices.clear();
        }
    }

    /// Returns the clips that have a part in the pose at a time, some perhaps twice.
    pub fn playing(&self, now_s: f64) -> impl Iterator<Item = ClipId> {
        let heard = move |voices: &Vec<Voice>| first_heard(voices, now_s);
        let voices = self.layers.iter().flat_map(move |voices| voices.iter().skip(heard(voices)));
        let parts = voices.filter(move |voice| voice.weight(now_s) > 0.0);
        parts.map(|voice| voice.playback.clip)
    }

    /// The pose at a time: `pose` goes back to rest, then each layer sets what its clips move.
    /// Clips that are not there move nothing. The work goes with what moves and has moved last, not
    /// with the rig.
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

/// Returns the last of a layer's voices that leaves nothing of those before it, or the first.
fn first_heard(voices: &[Voice], now_s: f64) -> usize {
    voices.iter().rposition(|voice| voice.covers(now_s)).unwrap_or(0)
}
