//! Tests that the boxes of the fox's poses are right and not much too large. The folder
//! `ANTUMBRA_ASSETS` must contain `fox.glb`; otherwise the test is skipped with a message.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;

use animation::{Pose, Skeleton};
use antumbra_import::{GltfScene, LoadOptions, load};
use cull::Aabb;
use glam::{Affine3A, Vec3};
use scene::{Mesh, PoseBounds, SkinnedMesh};

fn fox() -> Option<GltfScene> {
    let Ok(folder) = std::env::var("ANTUMBRA_ASSETS") else {
        // Not by `eprintln!`, whose output is hidden if the test passes.
        let _told =
            writeln!(std::io::stderr(), "SKIPPED: ANTUMBRA_ASSETS names no folder with fox.glb");
        return None;
    };
    let path = Path::new(&folder).join("fox.glb");
    let fox = load(&path, &LoadOptions::default(), &mut |_| ControlFlow::Continue(()));
    Some(fox.unwrap_or_else(|error| panic!("{error}")))
}

/// Returns the box of all vertices in a pose.
fn tight(mesh: &Mesh, skinned_mesh: &SkinnedMesh, matrices: &[Affine3A]) -> Aabb {
    let skin = skinned_mesh.skin.as_ref().unwrap();
    let rows = skin.joints.iter().zip(&skin.weights);
    mesh.vertices.iter().zip(rows).fold(Aabb::EMPTY, |all, (vertex, (joints, weights))| {
        let at =
            |joint: u16| matrices[usize::from(joint)].transform_point3(Vec3::from(vertex.position));
        let vertex = joints.iter().zip(weights).map(|(joint, weight)| at(*joint) * *weight).sum();
        all.union(&Aabb::new(vertex, vertex))
    })
}

/// A check of the fox's poses, each mixed from two clips.
struct Watch<'a> {
    fox: &'a GltfScene,
    skeleton: Skeleton,
    bounds: PoseBounds,
    poses: [Pose; 2],
    matrices: Vec<Affine3A>,
    /// The sums of the surface areas of the boxes and of the tightest boxes.
    surfaces: [f64; 2],
    largest_ratio: f32,
}

impl<'a> Watch<'a> {
    fn new(fox: &'a GltfScene) -> Self {
        let (mesh, skinned_mesh) = Self::mesh(fox);
        Self {
            fox,
            skeleton: Skeleton::new(&fox.rig, &fox.skins[0], &[]).unwrap(),
            bounds: PoseBounds::of(mesh, skinned_mesh),
            poses: [Pose::new(&fox.rig), Pose::new(&fox.rig)],
            matrices: Vec::new(),
            surfaces: [0.0; 2],
            largest_ratio: 0.0,
        }
    }

    fn mesh(fox: &GltfScene) -> (&Mesh, &SkinnedMesh) {
        let skinned_mesh = &fox.scene.surfaces.as_ref().unwrap().skinned_meshes[0];
        (&fox.scene.meshes[skinned_mesh.mesh.0 as usize], skinned_mesh)
    }

    fn look(&mut self, clips: [(usize, f32); 2], weight: f32) {
        let rig = &self.fox.rig;
        for (pose, (clip, share)) in self.poses.iter_mut().zip(clips) {
            let clip = &self.fox.clips[clip];
            pose.reset(rig);
            pose.sample(clip, clip.duration_s() * share);
        }
        let [pose, other] = &mut self.poses;
        pose.blend(other, weight);
        self.skeleton.joint_matrices(rig, pose, &mut self.matrices);
        let (mesh, skinned_mesh) = Self::mesh(self.fox);
        let tight = tight(mesh, skinned_mesh, &self.matrices);
        let bounds = self.bounds.bounds(&self.matrices, &[]).unwrap();
        assert!(bounds.contains(&tight), "{clips:?}, {weight}: {bounds:?} and {tight:?}");
        assert!(self.fox.placements[0].reach.contains(&bounds), "{clips:?}, {weight}: {bounds:?}");
        let ratio = (bounds.max - bounds.min) / (tight.max - tight.min);
        self.largest_ratio = self.largest_ratio.max(ratio.max_element());
        self.surfaces[0] += f64::from(bounds.half_area());
        self.surfaces[1] += f64::from(tight.half_area());
    }

    fn is_close(&self, what: &str) {
        let surface = self.surfaces[0] / self.surfaces[1];
        println!("{what}: at most {} as long, {surface:.3} of the surface", self.largest_ratio);
        assert!(self.largest_ratio < 2.0, "{what}: {}", self.largest_ratio);
        assert!(surface < 1.5, "{what}: {surface} of the surface");
    }
}

#[test]
fn boxes_of_clips_hold_and_are_not_much_too_large() {
    let Some(fox) = fox() else { return };
    for (number, clip) in fox.clips.iter().enumerate() {
        let mut watch = Watch::new(&fox);
        for sample in 0..=1000_u16 {
            watch.look([(number, f32::from(sample) / 1000.0); 2], 0.0);
        }
        watch.is_close(&clip.name);
    }
}

#[test]
fn boxes_of_blends_hold_and_are_not_much_too_large() {
    let Some(fox) = fox() else { return };
    let mut watch = Watch::new(&fox);
    for (first, second) in [(0, 1), (0, 2), (1, 2)] {
        for (x, y) in (0..=16_u8).flat_map(|x| (0..=16_u8).map(move |y| (x, y))) {
            for weight in 0..=8_u8 {
                let [x, y] = [x, y].map(|side| f32::from(side) / 16.0);
                watch.look([(first, x), (second, y)], f32::from(weight) / 8.0);
            }
        }
    }
    watch.is_close("blends");
}
