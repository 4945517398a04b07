//! Tests of visible objects: at street level, little more than a district, for cities of any size.

use std::collections::HashSet;

use glam::{Vec2, Vec3};
use scene::FOV_Y_RAD;

use super::super::{CameraPath, GeneratedScene, PathKind, city};
use super::Boxes;

/// A distance beyond the reach of every view of these tests.
const REACH_M: f32 = 5000.0;

/// The distance between opposite corners of a district, plus a house, in metres.
const DISTRICT_M: f32 = 6.0 * 64.0 * 1.42 + 20.0;

const VIEWS: [u32; 12] = [0, 90, 300, 700, 1100, 1700, 2500, 3300, 4100, 5200, 6500, 8000];

/// Returns the number of objects that own at least one of 160 by 90 rays, averaged over the views.
fn seen_per_view(GeneratedScene { scene, routes }: &GeneratedScene) -> f32 {
    let boxes = Boxes::new(scene, 0.0, |_| true);
    let path = CameraPath::new(PathKind::Street, routes).unwrap();
    let size = Vec2::new(160.0, 90.0);
    let reach = (FOV_Y_RAD / 2.0).tan() * Vec2::new(size.x / size.y, 1.0);
    let mut sum = 0;
    for frame in VIEWS {
        let camera = path.camera(frame);
        let right = camera.forward.cross(camera.up).normalize();
        let up = right.cross(camera.forward);
        let mut seen = HashSet::new();
        for y in 0..size.y as u16 {
            for x in 0..size.x as u16 {
                let pixel = Vec2::new(f32::from(x) + 0.5, f32::from(y) + 0.5);
                let place = (pixel / size * 2.0 - Vec2::ONE) * reach;
                let towards = (camera.forward + right * place.x - up * place.y).normalize();
                seen.extend(
                    boxes.first_hit(camera.eye, towards, REACH_M).map(|(number, _)| number),
                );
            }
        }
        assert!(seen.len() > 10, "hardly anything to see in frame {frame}");
        sum += seen.len();
    }
    sum as f32 / VIEWS.len() as f32
}

#[test]
fn a_larger_city_shows_no_more_at_street_level() {
    let seen = [10_000, 100_000, 400_000].map(|count| seen_per_view(&city(count, 1).unwrap()));
    for many in &seen[1..] {
        assert!((many / seen[0] - 1.0).abs() < 0.1, "{seen:?}");
    }
    assert!((25.0..200.0).contains(&seen[0]), "{seen:?}");
}

#[test]
fn level_views_end_within_the_district() {
    for (count, seed) in [(1000, 1), (10_000, 2), (100_000, 3)] {
        let GeneratedScene { scene, routes } = city(count, seed).unwrap();
        let boxes = Boxes::new(&scene, 0.0, |_| true);
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut rays = 0;
        let mut leaks = 0;
        for frame in VIEWS {
            let eye = path.camera(frame).eye;
            for step in 0..1440u16 {
                let (sin, cos) = (f32::from(step) * 0.25 + 0.1).to_radians().sin_cos();
                let hit = boxes.first_hit(eye, Vec3::new(cos, 1e-4, sin), REACH_M);
                rays += 1;
                leaks += u32::from(hit.is_none_or(|(_, distance)| distance > DISTRICT_M));
            }
        }
        // Gaps of 0.3 m between walls and gate houses let some rays through.
        assert!(leaks * 500 < rays, "{leaks} of {rays} rays leave the district");
    }
}
