//! Stencil shadow volumes against rays, on both drivers and by each way of extruding. The eye is
//! outside volumes, inside, at their edge, and with its near plane across the edge. Meshes are good
//! and bad.

mod assets;
mod meshes;
mod rays;
mod renderings;
mod world;

use cull::{Camera, Projection, ProjectionKind};
use glam::{Affine3A, Quat, Vec3, Vec4, vec3};
use gpu::{Device, OptionalFeature};
use render::passes::VolumePath;
use tests::{Driver, drivers, run};

use meshes::{bad_mesh, bumpy_sphere, sheet};
use rays::judge;
use renderings::{Choice, Renderings};
use world::World;

const SIZE: [u32; 2] = [160, 112];

const SUN: Vec4 = Vec4::new(0.36, 0.48, 0.8, 0.0);
const LAMP: Vec4 = Vec4::new(-1.5, 4.0, 2.5, 1.0);

/// Returns a floor with a box, a ball, and a one-sided sheet.
fn room() -> World {
    let mut world = World::default();
    world.add(&sheet(40.0, 9), Affine3A::IDENTITY);
    let cube = tests::shapes::cube(0, 2);
    let at = vec3(-2.0, 0.5, -1.0);
    world.add_mesh(&cube, Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), at));
    world.add(&bumpy_sphere(1, 0.0), Affine3A::from_translation(vec3(1.5, 1.5, 0.5)));
    let upright = Quat::from_rotation_x(1.2);
    world.add(&sheet(1.2, 2), Affine3A::from_rotation_translation(upright, vec3(0.2, 1.4, -3.0)));
    // Turned inside out and mirrored, so that its outside shows again.
    let turned = bumpy_sphere(2, 0.3).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let mirrored = Affine3A::from_scale_rotation_translation(
        vec3(-0.6, 0.8, 0.7),
        Quat::from_rotation_z(0.4),
        vec3(-0.5, 2.2, 1.0),
    );
    world.add(&turned, mirrored);
    world
}

fn camera(eye: Vec3, at: Vec3, near: f32) -> Camera {
    let projection = Projection::perspective(1.1);
    Camera { eye, forward: at - eye, up: Vec3::Y, projection, near }
}

/// Returns the ways of extruding that a device supports.
fn paths(device: &Device) -> Vec<VolumePath> {
    if device.capabilities().has(OptionalFeature::GeometryShaders) {
        vec![VolumePath::GeometryShader, VolumePath::Compute]
    } else {
        vec![VolumePath::Compute]
    }
}

/// Draws a world by all ways and checks each. Returns the numbers of lit and shaded pixels. Volumes
/// end at a finite distance if the device's sub-pixel grid is fine.
fn check(device: &Device, world: &World, cameras: &[Camera], lights: &[Vec4]) -> [u32; 2] {
    let mut renderings: Vec<Renderings> =
        paths(device).into_iter().map(|path| Renderings::new(device, world, SIZE, path)).collect();
    let mut judged = [0; 2];
    for camera in cameras {
        let mut masks = Vec::new();
        for renderings in &mut renderings {
            for choice in [Choice::ByEye, Choice::AllFail] {
                masks.push(renderings.draw(device, world, camera, lights, choice));
            }
        }
        let view = renderings[0].view(device, camera);
        let is_fine = device.adapter().limits.sub_pixel_precision_bits >= 8;
        let ends = renderings.iter().all(|rendering| rendering.ended > 0);
        assert!(ends == is_fine || view.rays.kind == ProjectionKind::Orthographic, "ends: {ends}");
        for mask in &masks {
            let of_mask = judge(world, &view, lights, mask);
            judged = [judged[0] + of_mask[0], judged[1] + of_mask[1]];
        }
        // Each way emits the same triangles.
        if let [by_geometry, all_by_geometry, by_compute, all_by_compute] = &masks[..] {
            assert!(by_geometry == by_compute, "the ways differ");
            assert!(all_by_geometry == all_by_compute, "the ways differ where all is z-fail");
        }
    }
    judged
}

#[test]
fn volumes_agree_with_rays_wherever_the_eye_is() {
    let cameras = [
        camera(vec3(4.0, 3.0, 7.0), vec3(0.0, 0.8, 0.0), 0.1),
        camera(vec3(-6.0, 0.7, 2.0), vec3(0.0, 1.0, 0.0), 0.1),
        // From below the sheet, which is invisible, and close above the floor.
        camera(vec3(0.6, 0.3, -6.5), vec3(0.2, 1.4, -3.0), 0.05),
        // In the shadow of the ball.
        camera(vec3(1.1, 0.9, -0.4), vec3(-1.0, 0.2, -1.5), 0.02),
        // At the edge of a shadow, with a near plane that reaches across it.
        camera(vec3(2.3, 1.0, -0.5), vec3(0.5, 0.4, -1.5), 0.6),
        camera(vec3(-2.0, 0.6, -2.2), vec3(-2.0, 0.1, -6.0), 0.5),
    ];
    for driver in drivers() {
        run(driver, |device| {
            let [lit, shaded] = check(device, &room(), &cameras, &[SUN, LAMP]);
            assert!(lit > 50_000 && shaded > 20_000, "{driver:?}: {lit} lit, {shaded} shaded");
        });
    }
}

#[test]
fn parallel_views_agree_with_rays() {
    let projection = Projection::Orthographic { height: 9.0, far: 30.0 };
    let high = camera(vec3(5.0, 6.0, 7.0), vec3(0.0, 0.5, 0.0), 0.0);
    // The near plane cuts volumes and objects.
    let middle = camera(vec3(0.5, 1.5, 1.0), vec3(-0.4, 0.5, -1.0), 0.0);
    let cameras = [high, middle].map(|camera| Camera { projection, ..camera });
    for driver in drivers() {
        run(driver, |device| {
            let [lit, shaded] = check(device, &room(), &cameras, &[SUN, LAMP]);
            assert!(lit > 10_000 && shaded > 3_000, "{driver:?}: {lit} lit, {shaded} shaded");
        });
    }
}

#[test]
fn bad_meshes_agree_with_rays() {
    for (driver, seeds) in [(Driver::Lavapipe, 0..40), (Driver::SwiftShader, 0..16)] {
        run(driver, |device| {
            let mut judged = [0; 2];
            for seed in seeds {
                let mut world = World::default();
                world.add(&sheet(12.0, 5), Affine3A::IDENTITY);
                world.add(&bad_mesh(seed), Affine3A::from_translation(vec3(0.0, 1.7, 0.0)));
                let around = Quat::from_rotation_y(seed as f32 * 1.7);
                let eye = around * vec3(1.0, 2.0 + (seed % 3) as f32, 4.0);
                let cameras = [camera(eye, vec3(0.0, 0.8, 0.0), 0.05)];
                let of_seed = check(device, &world, &cameras, &[SUN, LAMP]);
                judged = [judged[0] + of_seed[0], judged[1] + of_seed[1]];
            }
            let [lit, shaded] = judged;
            assert!(lit > 100_000 && shaded > 20_000, "{driver:?}: {lit} lit, {shaded} shaded");
        });
    }
}
