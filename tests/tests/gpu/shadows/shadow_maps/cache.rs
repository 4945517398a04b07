//! The cache of shadow maps: images equal those with maps that are drawn in every frame, bit for
//! bit, while objects move, are added or removed, or change their shape.

use cull::{Aabb, ObjectId, Strategy};
use glam::{Affine3A, Vec3, vec3};
use render::{RenderView, Renderer};
use scene::{
    LightId, MaterialId, MeshId, MorphTarget, Object, ObjectChange, PoseUpdate, PunctualLight,
    Scene, SceneUpdate, SkinWeights, SkinnedMesh, SkinnedMeshId,
};
use shadows::{ShadowBias, ShadowCaching, ShadowOptions, ShadowStats};
use tests::{Driver, run, shadow_scene, shapes};

use super::{image, renderer, shadows};

/// A small generator of numbers that look random.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        ((self.0 >> 33) % u64::from(end)) as u32
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    fn place(&mut self) -> Affine3A {
        let low = vec3(self.unit() * 12.0 - 6.0, self.unit() * 2.0, self.unit() * 12.0 - 8.0);
        let size = 0.3 + Vec3::ONE * self.unit();
        shadow_scene::transform_of(&Aabb::new(low, low + size))
    }
}

/// The object that is skinned and morphed.
pub const FIGURE: ObjectId = ObjectId(1);

/// Returns the yard with a figure: a cube with two joints that grows a bump.
pub fn scene() -> Scene {
    let mut scene = shadow_scene::scene(&shadow_scene::boxes(), &shadow_scene::lights());
    let mesh = shapes::cube(u32::MAX, 3);
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.meshes.push(shapes::surface_of(&mesh, MaterialId(0)));
    let is_high = |position: &[f32; 3]| position[1] > 0.5;
    let positions: Vec<[f32; 3]> = mesh.vertices.iter().map(|vertex| vertex.position).collect();
    let skin = SkinWeights {
        joint_count: 2,
        joints: positions.iter().map(|position| [u16::from(is_high(position)), 0, 0, 0]).collect(),
        weights: vec![[1.0, 0.0, 0.0, 0.0]; positions.len()],
        sets: 1,
    };
    let bump = |position: &[f32; 3]| [0.0, if is_high(position) { 1.5 } else { 0.0 }, 0.0];
    let target =
        MorphTarget { positions: positions.iter().map(bump).collect(), ..MorphTarget::default() };
    surfaces.skinned_meshes =
        vec![SkinnedMesh { mesh: MeshId(1), skin: Some(skin), targets: vec![target] }];
    scene.meshes.push(mesh);
    let transform = Affine3A::from_translation(vec3(-3.0, 0.0, -1.0));
    scene.objects.insert(1, Object { mesh: MeshId(1), transform, tint: u32::MAX });
    scene
}

/// Makes the changes of a frame. Some objects always move, others sometimes move and then rest.
fn changes(frame: u32, random: &mut Random, added: &mut Vec<ObjectId>) -> SceneUpdate {
    let mut update = SceneUpdate::default();
    if frame % 50 > 35 {
        return update;
    }
    for object in 3..6 {
        let transform = random.place();
        update.objects.push(ObjectChange::Move { object: ObjectId(object), transform });
    }
    match random.below(12) {
        0 => {
            let object = Object { mesh: MeshId(0), transform: random.place(), tint: u32::MAX };
            update.objects.push(ObjectChange::Add { object });
        }
        1 => update.objects.extend(added.pop().map(|object| ObjectChange::Remove { object })),
        2 => {
            let object = ObjectId(10 + random.below(20));
            let transform = random.place();
            update.objects.push(ObjectChange::Move { object, transform });
        }
        _ => {}
    }
    if !frame.is_multiple_of(3) {
        let turn = Affine3A::from_rotation_y(frame as f32 * 0.1);
        update.joints = vec![Affine3A::IDENTITY, turn];
        update.weights = vec![random.unit()];
        update.poses =
            vec![PoseUpdate { skinned_mesh: SkinnedMeshId(0), joints: 0..2, weights: 0..1 }];
    }
    update
}

/// Returns a light of the yard in a frame. One light sometimes moves.
fn moved_light(frame: u32) -> PunctualLight {
    let [.., point] = shadow_scene::lights();
    let away = (frame / 40) as f32 * 0.3;
    PunctualLight { position: point.position + vec3(-away, 0.0, away), ..point }
}

/// A renderer, its view, and the ids of the objects that were added to it.
struct Side(Renderer, RenderView);

impl Side {
    fn new(device: &gpu::Device, caching: ShadowCaching, bias: ShadowBias) -> Self {
        let renderer = renderer(device, &scene(), ShadowOptions { caching, bias, ..shadows() });
        let view = renderer.new_view().unwrap();
        Self(renderer, view)
    }

    fn draw(&mut self, frame: u32, update: &SceneUpdate) -> (Vec<u8>, Vec<ObjectId>) {
        let has_room = update.objects.len() <= 3 || self.0.hierarchy().free_leaves() > 0;
        let added = if has_room { self.0.apply(update).unwrap().added } else { Vec::new() };
        self.0.set_light(LightId(2), moved_light(frame)).unwrap();
        let mut camera = shadow_scene::camera();
        camera.eye += vec3(0.01, 0.0, -0.005) * frame as f32;
        (image(&mut self.0, &mut self.1, Strategy::ANTUMBRA, camera), added)
    }
}

fn compare(device: &gpu::Device, frames: u32, bias: ShadowBias) -> [u64; 2] {
    let mut random = Random(7);
    let [mut cached, mut afresh] = [ShadowCaching::Cached, ShadowCaching::Uncached]
        .map(|caching| Side::new(device, caching, bias));
    let mut added = Vec::new();
    let mut drawn = [0, 0];
    for frame in 0..frames {
        let update = changes(frame, &mut random, &mut added);
        let (expected, new) = afresh.draw(frame, &update);
        let (found, same) = cached.draw(frame, &update);
        assert_eq!(new, same);
        added.extend(new);
        let wrong = tests::walk::pixels_that_differ(&expected, &found);
        assert_eq!(wrong, 0, "pixels of frame {frame} with {bias:?}");
        for (sum, side) in drawn.iter_mut().zip([&cached, &afresh]) {
            *sum += u64::from(casters(&side.0).casters);
        }
    }
    assert!(cached.0.hierarchy().contains(FIGURE));
    drawn
}

fn casters(renderer: &Renderer) -> ShadowStats {
    renderer.shadow_stats()
}

fn compare_on_lavapipe(frames: u32) {
    run(Driver::Lavapipe, |device| {
        for bias in [ShadowBias::Plane, ShadowBias::Midpoint] {
            let [cached, afresh] = compare(device, frames, bias);
            assert!(cached * 2 < afresh, "{cached} casters of {afresh} were drawn");
        }
    });
}

#[test]
fn lavapipe_frames_are_those_with_maps_drawn_afresh() {
    compare_on_lavapipe(60);
}

#[test]
#[ignore = "long walk"]
fn lavapipe_a_thousand_frames_are_those_with_maps_drawn_afresh() {
    compare_on_lavapipe(1000);
}

#[test]
fn swiftshader_frames_are_those_with_maps_drawn_afresh() {
    run(Driver::SwiftShader, |device| {
        for bias in ShadowBias::ALL {
            compare(device, if bias == ShadowBias::BackFaces { 8 } else { 24 }, bias);
        }
    });
}

#[test]
fn at_rest_no_map_is_drawn() {
    run(Driver::Lavapipe, |device| {
        ShadowBias::ALL.into_iter().for_each(|bias| {
            let mut side = Side::new(device, ShadowCaching::Cached, bias);
            side.draw(0, &SceneUpdate::default());
            let first = casters(&side.0);
            assert_eq!((first.drawn_faces, first.lights), (first.faces, 3));
            // Maps are drawn with some of their casters at first, then once with all.
            let drawn = (0..20).map(|_| {
                side.draw(0, &SceneUpdate::default());
                let stats = casters(&side.0);
                (stats.drawn_faces, stats.drawn_faces - stats.culled_faces)
            });
            let drawn: Vec<(u32, u32)> = drawn.collect();
            let whole: u32 = drawn.iter().map(|(_, whole)| whole).sum();
            assert!(whole <= first.faces, "{drawn:?}");
            side.draw(0, &SceneUpdate::default());
            let last = casters(&side.0);
            assert_eq!(
                (last.drawn_faces, last.casters, last.faces),
                (0, 0, first.faces),
                "{drawn:?}"
            );
        })
    });
}
