//! Tests that cameras move smoothly, jump when they should, and never enter an object.

use glam::Vec3;

use super::super::{
    CameraPath, GeneratedScene, GeneratorError, PathKind, Routes, Streets, city, field,
};
use super::Boxes;
use crate::path::EYE_HEIGHT_M;

fn scenes() -> Vec<GeneratedScene> {
    let counts = [1, 2, 30, 35, 60, 500, 10_000, 100_000];
    let cities = counts.map(|count| city(count, u64::from(count) + 1).unwrap());
    let fields = counts.map(|count| field(count, u64::from(count) + 1).unwrap());
    cities.into_iter().chain(fields).collect()
}

fn turn_between(a: Vec3, b: Vec3) -> f32 {
    a.normalize().angle_between(b.normalize()).to_degrees()
}

#[test]
fn walks_are_smooth_and_long_and_close() {
    for GeneratedScene { scene, routes } in scenes() {
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut turned = 0.0;
        let first = path.camera(0);
        let mut came_back = false;
        for frame in 0..40_000 {
            let now = path.camera(frame);
            let next = path.camera(frame + 1);
            let step = now.eye.distance(next.eye);
            assert!((0.08..0.11).contains(&step), "{}: {step} m at {frame}", scene.name);
            let turn = turn_between(now.forward, next.forward);
            assert!(turn < 3.0, "{}: {turn} degrees at {frame}", scene.name);
            if frame < 200 {
                turned += turn;
            }
            assert_eq!(now.eye.y, EYE_HEIGHT_M);
            came_back |= frame > 500 && now.eye.distance(first.eye) < 0.06;
        }
        assert!(turned > 60.0, "{}: a short run should see a turn, not {turned}", scene.name);
        assert!(came_back, "{} with {} objects", scene.name, scene.objects.len());
    }
}

#[test]
fn walkers_keep_clear_of_everything() {
    for GeneratedScene { scene, routes } in scenes() {
        let boxes = Boxes::new(&scene, 0.3, |_| true);
        for (kind, frames) in [(PathKind::Street, 40_000), (PathKind::Cut, 10_000)] {
            let path = CameraPath::new(kind, &routes).unwrap();
            for frame in 0..frames {
                let eye = path.camera(frame).eye;
                let hit = boxes.around(eye);
                assert!(hit.is_none(), "{} {kind} {frame}: {eye} in {hit:?}", scene.name);
            }
        }
    }
}

#[test]
fn flights_stay_above_the_roofs_and_look_down() {
    for GeneratedScene { scene, routes } in scenes() {
        let roof = scene.objects.iter().map(|object| scene.bounds_of(object).unwrap().max.y);
        let roof = roof.fold(0.0, f32::max);
        let path = CameraPath::new(PathKind::Fly, &routes).unwrap();
        for frame in 0..3000 {
            let now = path.camera(frame);
            let next = path.camera(frame + 1);
            assert!(now.eye.y > roof + 5.0);
            assert!((-0.8..-0.2).contains(&now.forward.y), "{}", now.forward);
            let step = now.eye.distance(next.eye);
            assert!((0.4..0.6).contains(&step), "{step}");
            assert!(turn_between(now.forward, next.forward) < 3.0);
        }
    }
}

#[test]
fn cuts_jump_every_tenth_frame_and_walk_in_between() {
    for GeneratedScene { routes, .. } in [city(10_000, 1).unwrap(), field(10_000, 1).unwrap()] {
        let path = CameraPath::new(PathKind::Cut, &routes).unwrap();
        let mut far = 0;
        for frame in 0..2000 {
            let now = path.camera(frame);
            let next = path.camera(frame + 1);
            let step = now.eye.distance(next.eye);
            if frame % 10 == 9 {
                far += u32::from(step > 10.0);
            } else {
                assert!((0.09..0.11).contains(&step), "{step} m at {frame}");
                assert_eq!(now.forward, next.forward);
            }
        }
        assert!(far > 180, "only {far} of 200 jumps lead somewhere else");
    }
}

#[test]
fn any_frame_has_a_camera_and_always_the_same() {
    let routes = city(500, 4).unwrap().routes;
    for kind in PathKind::ALL {
        let one = CameraPath::new(kind, &routes).unwrap();
        let other = CameraPath::new(kind, &routes).unwrap();
        assert_eq!(one.kind(), kind);
        for frame in [0, 1, 10, 12_345, 1 << 24, u32::MAX - 1, u32::MAX] {
            let camera = one.camera(frame);
            assert_eq!(camera, other.camera(frame));
            assert!(camera.eye.is_finite() && camera.forward.is_finite());
            assert!((camera.forward.length() - 1.0).abs() < 1e-3);
        }
    }
    let elsewhere = city(500, 5).unwrap().routes;
    let cut = |routes: &Routes| CameraPath::new(PathKind::Cut, routes).unwrap().camera(70);
    assert_ne!(cut(&routes), cut(&elsewhere));
}

#[test]
fn names_and_missing_streets_are_told() {
    for kind in PathKind::ALL {
        assert_eq!(kind.to_string().parse(), Ok(kind));
    }
    let error = "stret".parse::<PathKind>().unwrap_err();
    assert!(error.to_string().contains("stret") && error.to_string().contains("cut"), "{error}");
    let mut routes = city(100, 1).unwrap().routes;
    routes.streets = Streets::default();
    for kind in [PathKind::Street, PathKind::Cut] {
        assert!(matches!(CameraPath::new(kind, &routes), Err(GeneratorError::NoStreets)));
    }
    assert!(CameraPath::new(PathKind::Fly, &routes).is_ok());
}
