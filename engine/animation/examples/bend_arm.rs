//! Bends an arm of two bones, with a rig, a clip, poses at several times, and joint matrices.

use std::error::Error;

use antumbra_animation::{
    Channel, Clip, ClipId, Interpolation, Playback, Player, Pose, Rest, Rig, RigNode, RigNodeId,
    Skeleton, Skin, Track, Trs, Values, Workspace,
};
use glam::{Affine3A, Quat, Vec3};

/// Returns a bone that is one metre above its parent.
fn bone(name: &str, parent: Option<RigNodeId>) -> RigNode {
    let above = if parent.is_some() { Vec3::Y } else { Vec3::ZERO };
    let rest = Rest::Parts(Trs { translation: above, ..Trs::IDENTITY });
    RigNode { name: name.to_owned(), parent, rest, weights: Vec::new() }
}

fn main() -> Result<(), Box<dyn Error>> {
    let upper = RigNodeId(0);
    let lower = RigNodeId(1);
    let rig = Rig::new(vec![bone("upper", None), bone("lower", Some(upper))])?;
    let skin = Skin {
        joints: vec![upper, lower],
        inverse_bind: vec![Affine3A::IDENTITY, Affine3A::from_translation(Vec3::NEG_Y)],
    };
    let skeleton = Skeleton::new(&rig, &skin, &[])?;

    // Within two seconds the lower bone turns by a right angle, and back.
    let bent = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let turns = Values::Rotation(vec![Quat::IDENTITY, bent, Quat::IDENTITY]);
    let track = Track::new(Interpolation::Linear, vec![0.0, 1.0, 2.0], turns, 0)?;
    let clips = [Clip::new("bend".to_owned(), vec![Channel { node: lower, track }], &rig)?];
    let moving = rig.moved_by(&clips);

    let mut player = Player::new();
    player.play(Playback::looped(ClipId(0), 0.0));
    let mut workspace = Workspace::new(&rig);
    let mut pose = Pose::new(&rig);
    let mut world = Vec::new();
    let mut matrices = Vec::new();
    rig.world(&pose, &mut world);
    for quarter in 0..=8_u8 {
        let seconds = f64::from(quarter) * 0.25;
        player.pose_at(&rig, &clips, seconds, &mut workspace, &mut pose);
        rig.update_world(&moving, &pose, &mut world);
        skeleton.joint_matrices(&rig, &pose, &mut matrices);
        let skinned = matrices.get(1).ok_or("no second joint")?;
        let tip = skinned.transform_point3(Vec3::Y * 2.0);
        println!("{seconds:.2} s: the tip is at {:.2} m, {:.2} m", tip.x, tip.y);
    }
    Ok(())
}
