//! The playing clips, and the fades between them.

use std::collections::HashSet;
use std::mem::discriminant;

use animation::{Clip, Pose};

/// The playing clips, and the clips that they replace.
#[derive(Clone, Debug, Default)]
pub(super) struct Playing {
    from: Vec<usize>,
    to: Vec<usize>,
    /// True if the fade starts from a mixed pose instead of from clips.
    is_from_mix: bool,
    /// The clips whose nodes have not returned to rest yet.
    lingering: Vec<usize>,
    began_s: f64,
    fade_s: f64,
}

impl Playing {
    /// Changes to other clips. A new fade starts from the pose of an unfinished one.
    pub(super) fn change(&mut self, clips: &[usize], seconds: f64, fade_s: f64) {
        self.is_from_mix = self.weight(seconds) < 1.0;
        self.from = std::mem::replace(&mut self.to, clips.to_vec());
        self.lingering.extend_from_slice(&self.from);
        (self.began_s, self.fade_s) = (seconds, fade_s);
    }

    /// Returns true if the fade starts from the pose in which the previous fade was interrupted.
    pub(super) fn is_from_mix(&self) -> bool {
        self.is_from_mix
    }

    pub(super) fn from(&self) -> &[usize] {
        &self.from
    }

    pub(super) fn to(&self) -> &[usize] {
        &self.to
    }

    /// Returns the finished share of the fade, 0 to 1.
    pub(super) fn weight(&self, seconds: f64) -> f32 {
        let is_over = self.lingering.is_empty() || self.fade_s <= 0.0;
        let done = if is_over { 1.0 } else { (seconds - self.began_s) / self.fade_s };
        if done.is_nan() { 1.0 } else { done.clamp(0.0, 1.0) as f32 }
    }

    /// Returns all clips whose nodes must be visited.
    pub(super) fn concerned(&self) -> impl Iterator<Item = usize> {
        self.lingering.iter().chain(&self.to).copied()
    }

    /// Removes the replaced clips once their nodes are at rest. Returns true if there were any.
    pub(super) fn settles(&mut self, seconds: f64) -> bool {
        if self.lingering.is_empty() || self.weight(seconds) < 1.0 {
            return false;
        }
        self.lingering.clear();
        true
    }
}

/// Sets the properties of the clips in a pose to their values at a time, each clip in a loop.
pub(super) fn sample(pose: &mut Pose, clips: &[Clip], playing: &[usize], seconds: f64) {
    for clip in playing.iter().filter_map(|clip| clips.get(*clip)) {
        pose.sample(clip, looped_s(clip.duration_s(), seconds));
    }
}

/// Returns the time in a looped clip. Between two rounds it is the end, so that a single pass
/// through the clip reaches its end.
fn looped_s(duration_s: f32, seconds: f64) -> f32 {
    let duration = f64::from(duration_s);
    if !(duration > 0.0 && seconds.is_finite()) {
        return 0.0;
    }
    let within = seconds.rem_euclid(duration);
    if within == 0.0 && seconds > 0.0 { duration_s } else { within as f32 }
}

/// Returns clips that can play together: the result of `SceneAnimator::compatible`.
pub(super) fn compatible(clips: &[Clip], first: Option<usize>) -> Vec<usize> {
    let mut moved = HashSet::new();
    let others = (0..clips.len()).filter(|clip| Some(*clip) != first);
    let order = first.into_iter().filter(|clip| *clip < clips.len()).chain(others);
    let mut chosen: Vec<usize> = order
        .filter(|clip| {
            let Some(clip) = clips.get(*clip) else { return false };
            let property =
                |channel: &animation::Channel| (channel.node, discriminant(&channel.track.values));
            let is_free = clip.channels.iter().all(|channel| !moved.contains(&property(channel)));
            if is_free {
                moved.extend(clip.channels.iter().map(property));
            }
            is_free
        })
        .collect();
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_arrives_at_its_end() {
        for (seconds, expected) in
            [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (2.5, 0.5), (4.0, 2.0), (-0.5, 1.5)]
        {
            assert_eq!(looped_s(2.0, seconds), expected, "{seconds}");
        }
        for broken in [looped_s(0.0, 1.0), looped_s(2.0, f64::NAN), looped_s(2.0, f64::INFINITY)] {
            assert_eq!(broken, 0.0);
        }
    }

    #[test]
    fn one_fades_into_the_other_once() {
        let mut playing = Playing::default();
        playing.change(&[0], 0.0, 0.0);
        assert_eq!((playing.weight(0.0), playing.settles(0.0)), (1.0, false));
        playing.change(&[1], 10.0, 0.5);
        assert_eq!([9.0, 10.0, 10.25, 10.5].map(|s| playing.weight(s)), [0.0, 0.0, 0.5, 1.0]);
        assert!(!playing.settles(10.25) && playing.settles(10.5) && !playing.settles(11.0));
        assert_eq!(playing.weight(9.0), 1.0, "what is over does not come back");
        assert_eq!(playing.concerned().collect::<Vec<_>>(), [1]);
    }
}
