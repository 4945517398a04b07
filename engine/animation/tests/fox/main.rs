//! The fox of the shared assets: its boxes hold, are not much too large, and are found in no time. Skipped,
//! and says so, without `ANTUMBRA_ASSETS`, the folder that has `fox.glb`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::io::Write;
use std::time::Instant;

use antumbra_animation::{Binding, DeformedMesh, Pose, Reach, Skeleton};
use cull::Aabb;
use glam::{Affine3A, Vec3};

mod glb;

use glb::Fox;

fn fox() -> Option<Fox> {
    let Ok(folder) = std::env::var("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, of which a test that passes shows nothing.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder with fox.glb");
        return None;
    };
    let path = std::path::Path::new(&folder).join("fox.glb");
    Some(glb::read(
        &std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())),
    ))
}

/// The box of all vertices in a pose.
fn skinned_box(fox: &Fox, matrices: &[Affine3A]) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for ((position, joints), weights) in fox.positions.iter().zip(&fox.joints).zip(&fox.weights) {
        let at = |joint: u16| matrices[usize::from(joint)].transform_point3(Vec3::from(*position));
        let vertex = joints.iter().zip(weights).map(|(joint, weight)| at(*joint) * *weight).sum();
        bounds = bounds.union(&Aabb::new(vertex, vertex));
    }
    bounds
}

fn ratio(bounds: &Aabb, tight: &Aabb) -> Vec3 {
    (bounds.max - bounds.min) / (tight.max - tight.min)
}

#[test]
fn boxes_hold_and_are_not_much_too_large() {
    let Some(fox) = fox() else { return };
    let skeleton = Skeleton::new(&fox.rig, &fox.skin, &[]).unwrap();
    let started = Instant::now();
    let binding =
        Binding { skeleton: &skeleton, joints: &fox.joints, weights: &fox.weights, sets: 1 };
    let mesh = DeformedMesh {
        positions: &fox.positions,
        targets: &[],
        node: fox.node,
        binding: Some(binding),
    };
    let reach = Reach::new(&fox.rig, mesh).unwrap();
    println!("reach: {:?}", started.elapsed());
    let mut pose = Pose::new(&fox.rig);
    let mut matrices = Vec::new();
    skeleton.joint_matrices(&fox.rig, &pose, &mut matrices);
    let rest = reach.rest_bounds().unwrap();
    let tight = skinned_box(&fox, &matrices);
    assert!(rest.contains(&tight));
    println!("rest: {} {tight:?}", ratio(&rest, &tight));
    for clip in &fox.clips {
        let started = Instant::now();
        let bounds = reach.clip_bounds(clip).unwrap();
        let took = started.elapsed();
        let mut tight = Aabb::EMPTY;
        for sample in 0..=1000 {
            pose.reset(&fox.rig);
            pose.sample(clip, clip.duration_s() * (sample as f32 / 1000.0));
            skeleton.joint_matrices(&fox.rig, &pose, &mut matrices);
            tight = tight.union(&skinned_box(&fox, &matrices));
        }
        let ratio = ratio(&bounds, &tight);
        println!("{}: {took:?}, {ratio} of {:?}", clip.name, tight);
        assert!(bounds.contains(&tight), "{}: {bounds:?} does not hold {tight:?}", clip.name);
        assert!(ratio.max_element() < 2.5, "{}: {ratio}", clip.name);
    }
}

#[test]
fn boxes_of_blends_hold_and_are_not_much_too_large() {
    let Some(fox) = fox() else { return };
    let skeleton = Skeleton::new(&fox.rig, &fox.skin, &[]).unwrap();
    let binding =
        Binding { skeleton: &skeleton, joints: &fox.joints, weights: &fox.weights, sets: 1 };
    let mesh = DeformedMesh {
        positions: &fox.positions,
        targets: &[],
        node: fox.node,
        binding: Some(binding),
    };
    let reach = Reach::new(&fox.rig, mesh).unwrap();
    let (mut pose, mut other, mut matrices) =
        (Pose::new(&fox.rig), Pose::new(&fox.rig), Vec::new());
    let mut all = Aabb::EMPTY;
    for (first, second) in [(0, 1), (0, 2), (1, 2)] {
        let (a, b) = (&fox.clips[first], &fox.clips[second]);
        let started = Instant::now();
        let bounds = reach.blend_bounds(&[a, b]).unwrap();
        let took = started.elapsed();
        let mut tight = Aabb::EMPTY;
        for (x, y) in (0..=16).flat_map(|x| (0..=16).map(move |y| (x, y))) {
            for weight in 0..=8 {
                pose.reset(&fox.rig);
                other.reset(&fox.rig);
                pose.sample(a, a.duration_s() * (x as f32 / 16.0));
                other.sample(b, b.duration_s() * (y as f32 / 16.0));
                pose.blend(&other, weight as f32 / 8.0);
                skeleton.joint_matrices(&fox.rig, &pose, &mut matrices);
                tight = tight.union(&skinned_box(&fox, &matrices));
            }
        }
        let ratio = ratio(&bounds, &tight);
        println!("{} and {}: {took:?}, {ratio} of {tight:?}", a.name, b.name);
        assert!(bounds.contains(&tight), "{bounds:?} does not hold {tight:?}");
        assert!(ratio.max_element() < 2.5, "{ratio}");
        all = all.union(&tight);
    }
    let clips: Vec<_> = fox.clips.iter().collect();
    assert!(reach.blend_bounds(&clips).unwrap().contains(&all));
}
