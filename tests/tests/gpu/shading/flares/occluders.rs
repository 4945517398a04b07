//! Masked, skinned and transparent objects in front of a light hide it.

use cull::Strategy;
use glam::{Vec3, vec3};
use render::{FlareSamples, Renderer};
use scene::{
    Alpha, Material, Mesh, MeshId, Object, Scene, SkinWeights, SkinnedMesh, SkinnedMeshId,
    SurfaceMesh, Surfaces,
};
use tests::run_on_all;
use tests::surface_fixture::{quad, scene};

use super::{SIDE, STRATEGIES, lamp, moved, settled};

/// The first pixel of the lamp's block and the pixel after its last one, across and down.
const BLOCK: [u32; 2] = [57, 70];

/// Returns the samples of a lamp at a distance of 10 m, whose block has a side of 13 pixels.
fn samples(renderer: &mut Renderer) -> FlareSamples {
    let middle = lamp(vec3(-0.03, 0.04, -10.0), 1.0);
    renderer.set_flares(&[middle]).unwrap();
    let found = STRATEGIES.map(|strategy| {
        let mut view = renderer.new_view().unwrap();
        let found = settled(renderer, &mut view, strategy);
        renderer.wait_idle(&mut view).unwrap();
        found
    });
    let [plain, ..] = found;
    assert_eq!((plain.total, plain.block), (169, 169));
    assert!(found.iter().all(|found| *found == plain), "{found:?}");
    plain
}

type Quad = (Mesh, SurfaceMesh);

/// Returns a rectangle between two columns of pixels that covers all rows of the block.
fn columns(from: u32, to: u32, distance_m: f32, material: u32) -> Quad {
    quad(SIDE, [from, 20], [to, 110], distance_m, [[0.0; 2], [1.0; 2]], material, |_| {})
}

fn with_materials(quads: Vec<Quad>, materials: Vec<Material>) -> Scene {
    let places = vec![moved(Vec3::ZERO); quads.len()];
    scene(quads, &places, Surfaces { materials, ..Surfaces::default() })
}

#[test]
fn holes_of_masked_objects_let_light_through() {
    run_on_all(|device| {
        let masked = |alpha: f32| Material {
            base_colour: [1.0, 1.0, 1.0, alpha],
            alpha: Alpha::Mask { cutoff: 0.5 },
            ..Material::default()
        };
        let [left, _] = BLOCK;
        // Alpha grows from 0 at the left to 1 at the right, so the right half covers.
        let from = left - 9;
        let to = left + 17;
        let change = |vertex: &mut scene::SurfaceVertex| {
            vertex.colour[3] = if vertex.uv[0][0] > 0.5 { u16::MAX } else { 0 };
        };
        let graded = quad(SIDE, [from, 20], [to, 110], 5.0, [[0.0; 2], [1.0; 2]], 0, change);
        let materials = vec![masked(1.0), masked(0.4)];
        let mut scene = with_materials(vec![graded, columns(0, SIDE, 4.0, 1)], materials);
        let mut renderer = Renderer::new(device, &scene, &super::options(2)).unwrap();
        let found = samples(&mut renderer);
        // The middle of the square is 4 columns into the block. The column there may be visible or
        // hidden.
        assert!((4 * 13..=5 * 13).contains(&found.visible), "{found:?}");
        assert_eq!(found.let_through, 1.0);
        // Without holes the square hides the rest.
        scene.surfaces.as_mut().unwrap().materials[0].alpha = Alpha::Opaque;
        let mut renderer = Renderer::new(device, &scene, &super::options(2)).unwrap();
        assert_eq!(samples(&mut renderer).visible, 0);
    });
}

#[test]
fn skinned_objects_hide_a_light_where_their_pose_is() {
    run_on_all(|device| {
        let [left, _] = BLOCK;
        let (mesh, surface) = columns(left, left + 13, 5.0, 0);
        let corners = mesh.vertices.len();
        let mut scene = with_materials(vec![(mesh, surface)], vec![Material::default()]);
        let skin = SkinWeights {
            joint_count: 1,
            joints: vec![[0; 4]; corners],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; corners],
            sets: 1,
        };
        let skinned = SkinnedMesh { mesh: MeshId(0), skin: Some(skin), targets: Vec::new() };
        scene.surfaces.as_mut().unwrap().skinned_meshes = vec![skinned];
        let mut renderer = Renderer::new(device, &scene, &super::options(2)).unwrap();
        // The size of a pixel at the distance of the object.
        let pixel_m = 5.0 * 2.0 / SIDE as f32;
        for aside in [0, 4, -6, 13, 2] {
            let joint = moved(Vec3::X * (aside as f32 * pixel_m));
            renderer.set_pose(SkinnedMeshId(0), &[joint], &[]).unwrap();
            let found = samples(&mut renderer);
            assert_eq!(found.visible, i32::unsigned_abs(aside) * 13, "{aside}: {found:?}");
        }
    });
}

/// Returns a scene of a wall behind everything, other opaque quads, and panes.
fn panes(opaque: Vec<Quad>, panes: Vec<Quad>, alphas: &[f32]) -> Scene {
    let mut quads = vec![columns(0, SIDE, 90.0, 0)];
    quads.extend(opaque);
    let opaque_count = quads.len();
    quads.extend(panes);
    let glass = |alpha: &f32| Material {
        base_colour: [0.2, 0.5, 0.9, *alpha],
        alpha: Alpha::Blend,
        ..Material::default()
    };
    let mut materials = vec![Material::default()];
    materials.extend(alphas.iter().map(glass));
    let mut scene = with_materials(quads, materials);
    let transparent: Vec<Object> = scene.objects.drain(opaque_count..).collect();
    scene.surfaces.as_mut().unwrap().transparent = transparent;
    scene
}

#[test]
fn transparent_objects_take_their_alpha() {
    run_on_all(|device| {
        let [left, _] = BLOCK;
        let cover = |distance_m: f32, material| columns(0, SIDE, distance_m, material);
        let all = 13 * 13;
        let some = 13 * 5;
        let wall = || vec![columns(left + 5, left + 30, 7.0, 0)];
        let share = |samples: u32| samples as f32 / all as f32;
        for (name, opaque, glass, visible, fraction) in [
            ("behind the light", vec![], vec![cover(20.0, 1)], all, 1.0),
            ("one pane", vec![], vec![cover(5.0, 1)], all, 0.5),
            ("two panes", vec![], vec![cover(5.0, 1), cover(6.0, 2)], all, 0.125),
            ("the other way round", vec![], vec![cover(6.0, 1), cover(5.0, 2)], all, 0.125),
            ("full cover", vec![], vec![cover(5.0, 3)], all, 0.0),
            (
                "over five columns",
                vec![],
                vec![columns(0, left + 5, 5.0, 1)],
                all,
                1.0 - 0.5 * share(some),
            ),
            ("a wall behind a pane", wall(), vec![cover(5.0, 1)], some, share(some) * 0.5),
            ("a pane behind a wall", wall(), vec![cover(8.0, 1)], some, share(some) * 0.5),
            (
                "a pane behind a wall and beside it",
                wall(),
                vec![columns(left + 2, left + 40, 8.0, 2)],
                some,
                share(13 * 2) + share(13 * 3) * 0.25,
            ),
        ] {
            let scene = panes(opaque, glass, &[0.5, 0.75, 1.0]);
            let mut renderer = Renderer::new(device, &scene, &super::options(2)).unwrap();
            let found = samples(&mut renderer);
            assert_eq!(found.visible, visible, "{name}: {found:?}");
            assert!((found.fraction() - fraction).abs() < 1.0e-5, "{name}: {found:?}");
        }
    });
}

#[test]
fn transmittances_are_known_to_a_32nd() {
    run_on_all(|device| {
        for alpha in [0.03, 0.1, 0.33, 0.61, 0.97] {
            let pane = columns(0, SIDE, 5.0, 1);
            let scene = panes(vec![], vec![pane], &[alpha]);
            let mut renderer = Renderer::new(device, &scene, &super::options(2)).unwrap();
            let mut view = renderer.new_view().unwrap();
            renderer.set_flares(&[lamp(vec3(0.0, 0.0, -10.0), 1.0)]).unwrap();
            let found = settled(&mut renderer, &mut view, Strategy::ANTUMBRA);
            let error = (found.let_through - (1.0 - alpha)).abs();
            assert!(error <= 0.5 / 32.0 + 1.0e-4, "{alpha}: {found:?}");
            renderer.wait_idle(&mut view).unwrap();
        }
    });
}
