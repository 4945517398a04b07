//! Section planes: parts that are cut away disappear, cut solids are closed by caps of the right
//! size, and every strategy draws the same image.

mod dragged;
mod lines;
mod lit;
mod picked;

use cull::{Camera, ObjectId, SectionMember, SectionPlanes, Strategy};
use glam::Vec3;
use gpu::Device;
use render::RendererOptions;
use tests::run_on_all;
use tests::section::{CutScene, Solid, front, plane, planes, scene_of};

const SIDE: u32 = 400;
const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];

fn options() -> RendererOptions {
    RendererOptions { size: [SIDE; 2], ..RendererOptions::default() }
}

/// Pixels are a tenth of a millimetre.
const HEIGHT_M: f32 = 0.04;

/// Returns the area (mm2) with light in one colour channel and none in the others.
fn area_mm2(pixels: &[[u8; 3]], channel: usize) -> f64 {
    let is_it = |pixel: &&[u8; 3]| (0..3).all(|other| (pixel[other] > 0) == (other == channel));
    pixels.iter().filter(is_it).count() as f64 * 0.01
}

/// Returns a plane that cuts away the half of the world in front of it: z <= offset remains.
fn behind(offset_m: f64) -> SectionPlanes {
    planes(&[plane([0.0, 0.0, -1.0], offset_m)])
}

fn cut(device: &Device, solid: Solid, section: SectionPlanes) -> Vec<[u8; 3]> {
    let mut shown = CutScene::new(device, &scene_of(&[(solid, RED, Vec3::ZERO)]), options());
    shown.renderer.set_section(section).unwrap();
    shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA)
}

#[test]
fn a_cube_cut_in_half_has_a_cap_of_its_square() {
    run_on_all(|device| {
        assert_eq!(area_mm2(&cut(device, Solid::cube(0.02), behind(0.0)), 0), 400.0);
    });
}

#[test]
fn a_bore_is_open_in_the_cap() {
    run_on_all(|device| {
        let radius_mm = 5.0_f64;
        let corners = 256_u32;
        let mut solid = Solid::bored_cube(0.02, radius_mm as f32 * 1.0e-3, corners);
        // The hole runs along y, so the solid is turned to show it to the eye.
        for corner in solid.triangles.as_flattened_mut() {
            *corner = Vec3::new(corner.x, corner.z, -corner.y);
        }
        let area = area_mm2(&cut(device, solid, behind(0.0)), 0);
        let turn = std::f64::consts::TAU / f64::from(corners);
        let polygon_mm2 = 0.5 * f64::from(corners) * radius_mm * radius_mm * turn.sin();
        // A pixel at the border counts by its middle. The error is at most half a pixel along the
        // circle, and errors cancel out.
        assert!((area - (400.0 - polygon_mm2)).abs() < 0.3, "{area} mm2");
        assert!((area - (400.0 - 25.0 * std::f64::consts::PI)).abs() < 0.4, "{area} mm2");
    });
}

#[test]
fn a_plane_that_is_clear_of_a_solid_or_touches_it_makes_no_cap_and_changes_no_bit() {
    run_on_all(|device| {
        let scene = scene_of(&[(Solid::cube(0.02), RED, Vec3::ZERO)]);
        let mut shown = CutScene::new(device, &scene, options());
        let camera = Camera {
            eye: Vec3::new(0.3, 0.2, 1.0),
            forward: Vec3::new(-0.3, -0.2, -1.0),
            ..front(HEIGHT_M)
        };
        let whole = shown.pixels(camera, Strategy::ANTUMBRA);
        for offset_m in [1.0, 0.01] {
            shown.renderer.set_section(behind(offset_m)).unwrap();
            assert!(whole == shown.pixels(camera, Strategy::ANTUMBRA), "{offset_m} m");
        }
        for offset_m in [-0.01, -1.0] {
            shown.renderer.set_section(behind(offset_m)).unwrap();
            let pixels = shown.pixels(camera, Strategy::ANTUMBRA);
            assert_eq!(area_mm2(&pixels, 0), 0.0, "{offset_m} m");
        }
        shown.renderer.set_section(SectionPlanes::default()).unwrap();
        assert!(whole == shown.pixels(camera, Strategy::ANTUMBRA), "without planes");
    });
}

#[test]
fn mixed_winding_has_a_full_cap_and_an_open_shell_none() {
    run_on_all(|device| {
        let mut mixed = Solid::cube(0.02);
        for [_, b, c] in mixed.triangles.iter_mut().step_by(2) {
            std::mem::swap(b, c);
        }
        assert_eq!(area_mm2(&cut(device, mixed, behind(0.0)), 0), 400.0);
        let mut open = Solid::cube(0.02);
        // Without the face at the back, the solid is open.
        open.triangles.retain(|corners| corners.iter().any(|corner| corner.z > 0.0));
        assert_eq!(area_mm2(&cut(device, open, behind(0.0)), 0), 0.0);
    });
}

#[test]
fn one_looks_into_an_open_shell() {
    run_on_all(|device| {
        let mut open = Solid::cube(0.02);
        open.triangles.retain(|corners| corners.iter().any(|corner| corner.y < 0.01));
        let pixels = cut(device, open, behind(0.0));
        // The back wall, from inside.
        assert_eq!(area_mm2(&pixels, 0), 400.0);
    });
}

#[test]
fn one_looks_into_a_box_whose_walls_are_meshes_of_their_own() {
    run_on_all(|device| {
        let mut walls: Vec<(Vec3, Solid)> = Vec::new();
        for [a, b, c] in Solid::cube(0.02).triangles {
            let normal = (b - a).cross(c - a).normalize().round();
            let wall = walls.iter_mut().find(|(other, _)| *other == normal);
            match wall {
                Some((_, wall)) => wall.triangles.push([a, b, c]),
                None => walls.push((normal, Solid { triangles: vec![[a, b, c]] })),
            }
        }
        assert_eq!(walls.len(), 6);
        let walls: Vec<_> = walls.into_iter().map(|(_, wall)| (wall, RED, Vec3::ZERO)).collect();
        let mut shown = CutScene::new(device, &scene_of(&walls), options());
        shown.renderer.set_section(behind(0.0)).unwrap();
        let pixels = shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA);
        // The far wall, which no plane meets.
        assert_eq!(area_mm2(&pixels, 0), 400.0);
    });
}

#[test]
fn a_plane_that_touches_a_solid_at_its_place_cuts_nothing() {
    run_on_all(|device| {
        for z_m in [-0.77_f32, -0.53, -0.33, -0.11] {
            let scene = scene_of(&[(Solid::cube(0.02), RED, Vec3::Z * z_m)]);
            let mut shown = CutScene::new(device, &scene, options());
            let whole = shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA);
            assert_eq!(area_mm2(&whole, 0), 400.0, "{z_m} m");
            let face_m = |offset_m: f64| (f64::from(z_m) * 100.0).round() * 0.01 + offset_m;
            shown.renderer.set_section(behind(face_m(0.01))).unwrap();
            assert!(whole == shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA), "{z_m} m");
            shown.renderer.set_section(behind(face_m(-0.01))).unwrap();
            let pixels = shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA);
            assert_eq!(area_mm2(&pixels, 0), 0.0, "{z_m} m");
        }
    });
}

#[test]
fn solids_that_share_a_wall_keep_their_own_colours() {
    run_on_all(|device| {
        let scene = scene_of(&[
            (Solid::cube(0.02), RED, Vec3::new(-0.01, 0.0, 0.0)),
            (Solid::cube(0.02), GREEN, Vec3::new(0.01, 0.0, 0.0)),
        ]);
        let mut shown = CutScene::new(device, &scene, options());
        shown.renderer.set_section(behind(0.0)).unwrap();
        let pixels = shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA);
        assert_eq!((area_mm2(&pixels, 0), area_mm2(&pixels, 1)), (400.0, 400.0));
        // One solid stays whole: it has no cap and stands out.
        shown.renderer.set_section_member(ObjectId(1), SectionMember::Whole);
        let pixels = shown.pixels(front(HEIGHT_M), Strategy::ANTUMBRA);
        assert_eq!((area_mm2(&pixels, 0), area_mm2(&pixels, 1)), (400.0, 400.0));
        assert_eq!(shown.renderer.section_member(ObjectId(1)), SectionMember::Whole);
    });
}

#[test]
fn a_cap_lies_where_its_plane_does() {
    run_on_all(|device| {
        // A wall that crosses the plane hides exactly the part of the cap behind it.
        let angle = 37.0_f64.to_radians();
        let cutting = plane([angle.sin(), 0.0, -angle.cos()], 0.0);
        for zoom in [1.0_f32, 1000.0] {
            // The wall's front lies at z = 0, where the plane is at x = 0.
            let mut wall = Solid::cube(0.2);
            wall.triangles.iter_mut().flatten().for_each(|corner| corner.z -= 0.1);
            let scene =
                scene_of(&[(Solid::cube(0.02), RED, Vec3::ZERO), (wall, GREEN, Vec3::ZERO)]);
            let mut shown = CutScene::new(device, &scene, options());
            shown.renderer.set_section_member(ObjectId(1), SectionMember::Whole);
            shown.renderer.set_section(planes(&[cutting])).unwrap();
            let camera = Camera { near: 0.9, ..front(0.01 / zoom) };
            let pixels = shown.pixels(camera, Strategy::ANTUMBRA);
            // On the left the plane lies behind the wall, on the right before it.
            let wrong = pixels.iter().enumerate().filter(|(number, [red, ..])| {
                let column = *number as u32 % SIDE;
                let is_cap = *red > 0;
                let is_near_the_edge = column.abs_diff(SIDE / 2) <= 1;
                !is_near_the_edge && is_cap != (column >= SIDE / 2)
            });
            let wrong = wrong.count();
            // The rounding error of depths: 2^-20 of the distance to the eye, in pixels across the
            // plane.
            let pixel_m = 0.01 / zoom / SIDE as f32;
            let allowed_columns =
                (1.0_f32 / 1048576.0 / pixel_m / angle.tan() as f32).ceil() as u32;
            assert!(wrong <= (SIDE * allowed_columns) as usize, "zoom {zoom}: {wrong}");
        }
    });
}
