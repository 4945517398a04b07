//! Tests of tracks, poses and players against glTF 2.0, appendix C, and against their
//! documentation.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use antumbra_animation::{
    Channel, Clip, ClipError, ClipId, Interpolation, Playback, Player, Pose, Repeat, Rest, Rig,
    RigNode, RigNodeId, Track, TrackError, Trs, Values, Workspace,
};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;

fn node(parent: Option<u32>, weights: usize) -> RigNode {
    RigNode {
        name: String::new(),
        parent: parent.map(RigNodeId),
        rest: Rest::Parts(Trs::IDENTITY),
        weights: vec![0.0; weights],
    }
}

fn rig() -> Rig {
    let fixed =
        RigNode { rest: Rest::Matrix(Affine3A::from_scale(Vec3::splat(2.0))), ..node(None, 0) };
    Rig::new(vec![node(None, 0), node(Some(0), 2), fixed, node(Some(2), 0)]).unwrap()
}

fn track(interpolation: Interpolation, times_s: &[f32], values: Values) -> Track {
    Track::new(interpolation, times_s.to_vec(), values, 2).unwrap()
}

fn clip(node: u32, track: Track) -> Clip {
    Clip::new("clip".into(), vec![Channel { node: RigNodeId(node), track }], &rig()).unwrap()
}

fn sampled(clip: &Clip, node: u32, time_s: f32) -> Trs {
    let mut pose = Pose::new(&rig());
    pose.sample(clip, time_s);
    *pose.parts(RigNodeId(node)).unwrap()
}

#[test]
fn steps_stay_lines_are_straight_and_ends_are_clamped() {
    let values = || Values::Translation(vec![Vec3::X, Vec3::Y * 3.0]);
    let at = |interpolation, time_s| {
        sampled(&clip(0, track(interpolation, &[1.0, 2.0], values())), 0, time_s).translation
    };
    assert_eq!(at(Interpolation::Step, 1.999), Vec3::X);
    assert_eq!(at(Interpolation::Step, 2.0), Vec3::Y * 3.0);
    assert_eq!(at(Interpolation::Linear, 1.5), Vec3::new(0.5, 1.5, 0.0));
    for interpolation in [Interpolation::Step, Interpolation::Linear] {
        assert_eq!(at(interpolation, 0.0), Vec3::X);
        assert_eq!(at(interpolation, 9.0), Vec3::Y * 3.0);
        assert_eq!(at(interpolation, f32::NAN), Vec3::X);
    }
}

#[test]
fn cubics_scale_their_tangents_by_the_interval() {
    // Keys of (3 t - 2)^3 at 0 and 2 with its slopes: the spline equals this cubic.
    let value = |t: f32| (3.0 * t - 2.0).powi(3);
    let slope = |t: f32| 9.0 * (3.0 * t - 2.0).powi(2);
    let key = |t| [slope(t), value(t), slope(t)].map(Vec3::splat);
    let keys = [key(0.0), key(2.0)].concat();
    let clip = clip(0, track(Interpolation::Cubic, &[0.0, 2.0], Values::Scale(keys)));
    for step in 0..=20 {
        let time_s = step as f32 * 0.1;
        let found = sampled(&clip, 0, time_s).scale.x;
        assert!((found - value(time_s)).abs() < 1e-3, "{found} at {time_s}");
    }
}

#[test]
fn weights_go_by_key_and_target() {
    let weights = Values::Weights(vec![0.0, 1.0, 1.0, 0.0]);
    let clip = clip(1, track(Interpolation::Linear, &[0.0, 1.0], weights));
    let mut pose = Pose::new(&rig());
    pose.sample(&clip, 0.25);
    assert_eq!(pose.weights(RigNodeId(1)), [0.25, 0.75]);
    pose.reset(&rig());
    assert_eq!((pose.weights(RigNodeId(1)), pose.moved()), ([0.0, 0.0].as_slice(), [].as_slice()));
}

#[test]
fn what_is_no_clip_is_refused_with_the_reason() {
    let moved =
        |times_s: &[f32], values| Track::new(Interpolation::Linear, times_s.to_vec(), values, 2);
    let places = |count| Values::Translation(vec![Vec3::ONE; count]);
    assert_eq!(moved(&[], places(0)), Err(TrackError::Empty));
    assert!(matches!(moved(&[-2e9], places(1)), Err(TrackError::NoTime { key: 0, .. })));
    assert!(matches!(moved(&[f32::NAN], places(1)), Err(TrackError::NoTime { key: 0, .. })));
    assert_eq!(moved(&[1.0, 1.0], places(2)), Err(TrackError::NotLater { key: 1, time_s: 1.0 }));
    assert_eq!(moved(&[1.0], places(2)), Err(TrackError::Count { values: 2, needed: 1 }));
    assert_eq!(
        moved(&[1.0], Values::Weights(vec![0.0])),
        Err(TrackError::Count { values: 1, needed: 2 })
    );
    let wild = Values::Scale(vec![Vec3::new(0.0, f32::INFINITY, 0.0)]);
    assert_eq!(moved(&[1.0], wild), Err(TrackError::NotFinite { value: 0 }));
    let far = Values::Scale(vec![Vec3::new(0.0, -2.0e9, 0.0)]);
    assert_eq!(moved(&[1.0], far), Err(TrackError::TooLarge { value: 0 }));
    let late = TrackError::TooLate { key: 0, time_s: 2.0e9 };
    assert_eq!(moved(&[2.0e9], places(1)), Err(late));
    let nowhere = Values::Rotation(vec![Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)]);
    assert_eq!(moved(&[1.0], nowhere), Err(TrackError::NoRotation { value: 0 }));

    let of = |nodes: &[u32]| {
        let channel = |node: &u32| Channel {
            node: RigNodeId(*node),
            track: track(Interpolation::Linear, &[0.0], places(1)),
        };
        Clip::new("clip".into(), nodes.iter().map(channel).collect(), &rig()).map(|_| ())
    };
    assert_eq!(of(&[0, 1]), Ok(()));
    assert_eq!(of(&[9]), Err(ClipError::NoNode { channel: 0, node: 9 }));
    assert_eq!(of(&[0, 0]), Err(ClipError::Twice { channel: 1, node: 0 }));
    assert_eq!(of(&[2]), Err(ClipError::Matrix { channel: 0, node: 2 }));
    let weights = track(Interpolation::Linear, &[0.0], Values::Weights(vec![0.0; 2]));
    let channel = Channel { node: RigNodeId(0), track: weights };
    let error = Clip::new("clip".into(), vec![channel], &rig()).unwrap_err();
    assert_eq!(error, ClipError::NoTargets { channel: 0, node: 0 });
}

#[test]
fn playbacks_clamp_loop_and_run_backwards() {
    let once = Playback { repeat: Repeat::Once, ..Playback::looped(ClipId(0), 10.0) };
    let looped = Playback { repeat: Repeat::Loop, ..once };
    let backwards = Playback { speed: -2.0, ..looped };
    let at = |playback: Playback, now_s| playback.time_s(3.0, now_s);
    assert_eq!([0.0, 10.0, 11.0, 99.0].map(|now_s| at(once, now_s)), [0.0, 0.0, 1.0, 3.0]);
    assert_eq!([9.0, 13.0, 14.0].map(|now_s| at(looped, now_s)), [0.0, 3.0, 1.0]);
    assert_eq!([10.0, 11.0, 12.0].map(|now_s| at(backwards, now_s)), [3.0, 1.0, 2.0]);
    assert_eq!(at(looped, f64::NAN), 0.0);
    assert_eq!(looped.time_s(0.0, 99.0), 0.0);
    // After a year, times are still precise.
    assert!((at(looped, 10.0 + 3.0 * 1e7 + 0.125) - 0.125).abs() < 1e-6);
}

fn still(node: u32, place: Vec3) -> Clip {
    clip(node, track(Interpolation::Linear, &[0.0], Values::Translation(vec![place])))
}

#[test]
fn players_fade_and_later_layers_win() {
    let rig = rig();
    let clips = [still(0, Vec3::X), still(1, Vec3::Y), still(0, Vec3::Z * 8.0)];
    let mut workspace = Workspace::new(&rig);
    let mut pose = Pose::new(&rig);
    let mut player = Player::new();
    let layer = player.play(Playback::looped(ClipId(0), 5.0));
    player.cross_fade(layer, Playback::looped(ClipId(1), 6.0), 6.0, 2.0);
    let mut places = |player: &Player, now_s| {
        player.pose_at(&rig, &clips, now_s, &mut workspace, &mut pose);
        [0, 1].map(|node| pose.parts(RigNodeId(node)).unwrap().translation)
    };
    // Times may come in any order.
    assert_eq!(places(&player, 8.0), [Vec3::ZERO, Vec3::Y]);
    assert_eq!(places(&player, 6.5), [Vec3::X * 0.75, Vec3::Y * 0.25]);
    assert_eq!(places(&player, 4.0), [Vec3::X, Vec3::ZERO]);
    let playing =
        |player: &Player, now_s| player.playing(now_s).map(|clip| clip.0).collect::<Vec<_>>();
    assert_eq!(playing(&player, 6.0), [0]);
    assert_eq!(playing(&player, 7.0), [0, 1]);
    assert_eq!(playing(&player, 8.0), [1]);

    let over = player.play(Playback::looped(ClipId(2), 7.0));
    assert_eq!(places(&player, 7.0), [Vec3::Z * 8.0, Vec3::Y * 0.5]);
    player.mix(over, Playback::looped(ClipId(0), 7.0), 7.0, 0.5);
    assert_eq!(places(&player, 7.0), [Vec3::new(0.5, 0.0, 4.0), Vec3::Y * 0.5]);
    player.stop(over);
    assert_eq!(places(&player, 7.0), [Vec3::X * 0.5, Vec3::Y * 0.5]);
    player.stop(layer);
    assert_eq!(places(&player, 7.0), [Vec3::ZERO; 2]);
    let unknown = player.play(Playback::looped(ClipId(99), 0.0));
    player.cross_fade(unknown, Playback::looped(ClipId(98), 0.0), 0.0, f32::NAN);
    assert_eq!(places(&player, 7.0), [Vec3::ZERO; 2]);
}

fn rotation() -> impl Strategy<Value = Quat> {
    prop::array::uniform4(-1.0_f32..1.0).prop_map(|q| {
        let q = Quat::from_array(q);
        if q.length() > 0.1 { q.normalize() } else { Quat::IDENTITY }
    })
}

proptest! {
    /// Checks that rotations take the shorter arc, at constant speed, in unit length.
    #[test]
    fn rotations_take_the_shorter_arc(from in rotation(), to in rotation(), t in 0.0_f32..1.0) {
        let values = Values::Rotation(vec![from, to]);
        let found = sampled(&clip(0, track(Interpolation::Linear, &[0.0, 1.0], values)), 0, t).rotation;
        prop_assert!((found.length() - 1.0).abs() < 1e-5);
        let angle = |a: Quat, b: Quat| 2.0 * a.dot(b).abs().min(1.0).acos();
        let whole = angle(from, to);
        prop_assert!((angle(from, found) - t * whole).abs() < 4e-3, "{} of {whole}", angle(from, found));
        prop_assert!((angle(to, found) - (1.0 - t) * whole).abs() < 4e-3);
    }

    /// Checks that a blend meets both ends, has unit length between them, and is symmetric in them.
    #[test]
    fn blends_meet_both_ends(a in rotation(), b in rotation(), weight in 0.0_f32..1.0) {
        let rig = rig();
        let turn = |q| track(Interpolation::Step, &[0.0], Values::Rotation(vec![q]));
        let pose = |q| {
            let mut pose = Pose::new(&rig);
            pose.sample(&clip(0, turn(q)), 0.0);
            pose
        };
        let blended = |a, b, weight| {
            let mut from: Pose = pose(a);
            from.blend(&pose(b), weight);
            from.parts(RigNodeId(0)).unwrap().rotation
        };
        prop_assert!(blended(a, b, 0.0).dot(a).abs() > 0.9999);
        prop_assert!(blended(a, b, 1.0).dot(b).abs() > 0.9999);
        prop_assert!((blended(a, b, weight).length() - 1.0).abs() < 1e-5);
        if a.dot(b).abs() > 0.01 {
            prop_assert!(blended(a, b, weight).dot(blended(b, a, 1.0 - weight)).abs() > 0.9999);
        }
    }
}

#[test]
fn keys_before_zero_count_for_what_follows_them() {
    let places = || Values::Translation(vec![Vec3::ZERO, Vec3::X * 4.0]);
    let early = clip(0, track(Interpolation::Linear, &[-1.0, 3.0], places()));
    assert_eq!(early.duration_s(), 3.0);
    assert_eq!(sampled(&early, 0, 0.0).translation, Vec3::X);
    assert_eq!(sampled(&early, 0, 3.0).translation, Vec3::X * 4.0);
    let over = clip(0, track(Interpolation::Step, &[-2.0, -1.0], places()));
    assert_eq!((over.duration_s(), sampled(&over, 0, 0.0).translation), (0.0, Vec3::X * 4.0));
}
