//! Tests of next-frame queries: cheap, exact at rest, and wrong in between.

use antumbra_cull::{Aabb, Camera};
use glam::{Quat, Vec3};

use crate::random::Random;
use crate::scene::city;
use crate::walk::{STREET, Walk};

/// Runs a frame and returns the number of wrong pixels.
fn step(walk: &mut Walk, camera: &Camera) -> usize {
    walk.step_next_frame(camera);
    walk.wrong_pixels(camera)
}

#[test]
fn it_is_right_at_rest_and_draws_little() {
    for latency in 1..=4 {
        let mut walk = Walk::new(city(&mut Random::new(3), 12), latency);
        assert_eq!(step(&mut walk, &STREET), 0, "of what nothing is known is drawn");
        let all = walk.device.drawn.len();
        for _ in 0..20 {
            step(&mut walk, &STREET);
        }
        for frame in 0..20 {
            assert_eq!(step(&mut walk, &STREET), 0, "frame {frame}");
            assert!(walk.device.drawn.len() * 2 < all, "{} of {all}", walk.device.drawn.len());
            // Hidden objects are tested in every frame.
            assert!(walk.plan.tests.len() + walk.device.drawn.len() == all, "frame {frame}");
        }
    }
}

#[test]
fn what_comes_into_view_is_missing_for_as_long_as_its_answer_takes() {
    let wall = Aabb::new(Vec3::new(-20.0, -20.0, -6.0), Vec3::new(20.0, 20.0, -5.0));
    let behind = Aabb::new(Vec3::new(-1.0, -1.0, -10.0), Vec3::new(1.0, 1.0, -8.0));
    let camera = Camera { eye: Vec3::ZERO, ..STREET };
    // To the side, past the wall, but with both still in the frustum.
    let aside = Camera {
        eye: Vec3::new(26.0, 0.0, 0.0),
        forward: Quat::from_rotation_y(1.2) * Vec3::NEG_Z,
        ..STREET
    };
    for latency in 1..=4 {
        let mut walk = Walk::new(vec![wall, behind], latency);
        let aside = Camera { eye: Vec3::new(26.0, 0.0, -8.0), forward: -Vec3::X, ..aside };
        for _ in 0..12 {
            assert_eq!(step(&mut walk, &camera), 0);
        }
        assert_eq!(walk.device.drawn.len(), 1);
        let wrong: Vec<bool> = (0..8).map(|_| step(&mut walk, &aside) > 0).collect();
        let expected: Vec<bool> = (0..8).map(|frame| frame < latency).collect();
        assert_eq!(wrong, expected, "latency {latency}");
    }
}

#[test]
fn it_is_seldom_wrong_while_the_view_turns() {
    let mut walk = Walk::new(city(&mut Random::new(3), 12), 2);
    let mut camera = STREET;
    let mut wrong = 0;
    let mut drawn = 0;
    for _ in 0..100 {
        wrong += step(&mut walk, &camera);
        drawn += walk.device.drawn.len();
        camera.forward = Quat::from_rotation_y(0.02) * camera.forward;
    }
    assert!(wrong > 0, "then it would be exact");
    assert!(wrong * 50 < 100 * 48 * 32, "{wrong} pixels");
    assert!(drawn * 2 < 100 * walk.scene.bounds.len(), "{drawn} draws");
}

#[test]
fn histories_survive_a_rebuild() {
    let mut walk = Walk::new(city(&mut Random::new(3), 12), 1);
    for _ in 0..20 {
        step(&mut walk, &STREET);
    }
    let drawn = walk.device.drawn.len();
    let mut bounds = walk.scene.bounds.clone();
    bounds.extend(
        city(&mut Random::new(5), 2)
            .iter()
            .map(|city| Aabb::new(city.min - 900.0, city.max - 900.0)),
    );
    walk.hierarchy.rebuild(&bounds).unwrap();
    assert_eq!(step(&mut walk, &STREET), 0);
    assert_eq!(walk.device.drawn.len(), drawn);
}
