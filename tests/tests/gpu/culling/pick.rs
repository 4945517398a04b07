//! The object at a pixel, the reason why it is drawn or not, its outline, and the image of the
//! scene alone.

use cull::{Camera, Decision, ObjectId, Outcome, Projection, Strategy};
use glam::{Affine3A, Vec2, Vec3};
use gpu::{Readback, SampleCount};
use render::{
    CostModel, DebugOverlay, FrameRequest, PointedSurface, RenderView, Renderer, RendererOptions,
};
use scene::{Mesh, MeshId, Object, ObjectChange, Scene};
use scenes::{CameraPath, GeneratedScene, PathKind, city};
use tests::scene_rays::{SceneRays, Sides};
use tests::shapes::square_camera;
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [320, 180];

fn options() -> RendererOptions {
    RendererOptions { size: SIZE, cost_model: CostModel::Off, ..RendererOptions::default() }
}

/// Draws a frame and waits for it. Returns the surface at a pixel.
fn pointed(
    renderer: &mut Renderer,
    view: &mut RenderView,
    camera: Camera,
    pixel: [u32; 2],
) -> Option<PointedSurface> {
    view.point_at(Some(pixel)).unwrap();
    renderer.render(view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
    renderer.wait_idle(view).unwrap();
    let found = view.pointed().expect("it is over");
    assert_eq!((found.pixel, found.frame), (pixel, view.plan().frame));
    found.surface
}

#[test]
fn the_object_of_a_pixel_is_that_of_the_nearest_triangle() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = city(300, 5).unwrap();
        let mut camera = CameraPath::new(PathKind::Fly, &routes).unwrap().camera(7);
        // The horizon and the sky are in the image.
        camera.forward.y = -0.1;
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let rays = renderer.view_of(&camera).rays;
        let triangles = SceneRays::new(&scene);
        let mut right = 0;
        let mut objects = std::collections::BTreeSet::new();
        let mut empty = 0;
        let pixels =
            (0..SIZE[1]).step_by(18).flat_map(|y| (0..SIZE[0]).step_by(32).map(move |x| [x, y]));
        let pixels: Vec<[u32; 2]> = pixels.collect();
        for pixel in &pixels {
            let found = pointed(&mut renderer, &mut view, camera, *pixel);
            let [x, y] = [0, 1].map(|side| (pixel[side] as f32 + 0.5) / SIZE[side] as f32);
            let ndc = Vec2::new(x, y) * 2.0 - 1.0;
            let eye = rays.point(ndc, 0.0);
            let along = (rays.point(ndc, 1.0) - eye).as_dvec3();
            let expected = triangles.first(eye.as_dvec3(), along, Sides::Fronts);
            let object = found.map(|surface| surface.object);
            let is_right = object.map(|object| object.0) == expected.map(|met| met.object as u32);
            right += usize::from(is_right);
            if let (Some(found), Some(expected), true) = (found, expected, is_right) {
                let apart_m = found.point.distance(expected.place);
                assert!(apart_m < 1e-3 * expected.distance, "{found:?}, {expected:?}");
            }
            empty += usize::from(found.is_none());
            objects.extend(object);
        }
        // At an edge, a single sub-pixel decides.
        assert!(right * 100 >= pixels.len() * 98, "{right} of {}", pixels.len());
        assert!(objects.len() > 10 && empty > 5, "{objects:?}, {empty}");
    });
}

/// Returns a far square of `half` metres around the ray, and many frames in front of it. The boxes
/// of all frames contain the ray, but only their corners have geometry.
fn behind_frames(frames: u32, half: f32) -> Scene {
    let corners = |corners: [[f32; 2]; 3]| corners.map(|[x, y]| ([x, y, 0.0], [1.0; 3]));
    let low = corners([[-1.0, -1.0], [-0.9, -1.0], [-1.0, -0.9]]);
    let high = corners([[1.0, 1.0], [0.9, 1.0], [1.0, 0.9]]);
    let mut scene = Scene::single(Mesh::of_triangles("frame", &[low, high].concat()));
    let square = [
        corners([[-half, -half], [half, -half], [half, half]]),
        corners([[-half, -half], [half, half], [-half, half]]),
    ];
    scene.meshes.push(Mesh::of_triangles("square", &square.concat()));
    let object = |(mesh, distance_m): (u32, f32)| Object {
        mesh: MeshId(mesh),
        transform: Affine3A::from_translation(Vec3::NEG_Z * distance_m),
        tint: u32::MAX,
    };
    let places = (0..frames).map(|number| (0, 2.0 + number as f32 / frames as f32));
    scene.objects = places.chain([(1, 9.0)]).map(object).collect();
    scene
}

#[test]
fn what_is_behind_thousands_of_boxes_is_found() {
    const FRAMES: u32 = 5_200;
    run_on_all(|device| {
        let camera = Camera { projection: Projection::perspective(0.9), ..square_camera() };
        for (half, expected) in [(1.0, Some(ObjectId(FRAMES))), (0.0, None)] {
            let scene = behind_frames(FRAMES, half);
            let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
            let mut view = renderer.new_view().unwrap();
            let middle = [SIZE[0] / 2, SIZE[1] / 2];
            let found = pointed(&mut renderer, &mut view, camera, middle);
            assert_eq!(found.map(|surface| surface.object), expected);
        }
    });
}

#[test]
fn with_several_samples_object_and_depth_are_of_one_surface() {
    run(Driver::Lavapipe, |device| {
        // A wall, and in front of it a triangle with slanted sides.
        let wall = [[-30.0, -30.0, -8.0], [90.0, -30.0, -8.0], [-30.0, 90.0, -8.0]];
        let near = [[-1.0, -1.0, -2.0], [1.3, -0.7, -2.0], [-0.2, 1.1, -2.0]];
        let mut scene = Scene::single(Mesh::of_triangles("wall", &wall.map(|at| (at, [1.0; 3]))));
        scene.meshes.push(Mesh::of_triangles("near", &near.map(|at| (at, [1.0; 3]))));
        scene.objects.push(Object { mesh: MeshId(1), ..scene.objects[0] });
        let options = RendererOptions { samples: SampleCount::Four, ..options() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut found = [0; 2];
        // Along the left side, from (-1, -1) to (-0.2, 1.1) at a distance of 2 m.
        for place in 0..66 {
            let row = 44 + place / 3 * 4;
            let side = 115.0 + (135.0 - row as f32) * 36.0 / 94.5;
            let pixel = [side as u32 + place % 3 - 1, row];
            let Some(surface) = pointed(&mut renderer, &mut view, square_camera(), pixel) else {
                panic!("{pixel:?}: the wall is everywhere");
            };
            let number = surface.object.0 as usize;
            let place = [-8.0, -2.0][number];
            assert!((surface.point.z - place).abs() < 0.1, "{pixel:?}: {surface:?}");
            found[number] += 1;
        }
        assert!(found.iter().all(|count| *count > 3), "{found:?}");
    });
}

#[test]
fn with_several_samples_every_pixel_of_a_wall_has_its_owner() {
    run(Driver::Lavapipe, |device| {
        // A rectangle in front of a wall that fills its box. A sample may be inside it while the
        // middle of the pixel is outside.
        let wall = [[-30.0, -30.0, -8.0], [90.0, -30.0, -8.0], [-30.0, 90.0, -8.0]];
        let corner = |x: f32, y: f32| [x, y, -2.0];
        let a = corner(-1.013, -0.517);
        let b = corner(1.307, -0.517);
        let c = corner(1.307, 0.711);
        let d = corner(-1.013, 0.711);
        let near = [a, b, c, a, c, d];
        let mut scene = Scene::single(Mesh::of_triangles("wall", &wall.map(|at| (at, [1.0; 3]))));
        scene.meshes.push(Mesh::of_triangles("near", &near.map(|at| (at, [1.0; 3]))));
        scene.objects.push(Object { mesh: MeshId(1), ..scene.objects[0] });
        let options = RendererOptions { samples: SampleCount::Four, ..options() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let seen = renderer.view_of(&square_camera());
        let mut found = [0; 2];
        for edge in [a, c] {
            let clip = seen.clip(edge.into());
            let place = (clip.truncate().truncate() / clip.w + 1.0) * 0.5;
            let x = place.x * f64::from(SIZE[0]);
            let y = place.y * f64::from(SIZE[1]);
            let middle = [SIZE[0] / 2, SIZE[1] / 2];
            for step in 0..3 {
                for pixel in [[x as u32 + step - 1, middle[1]], [middle[0], y as u32 + step - 1]] {
                    let Some(surface) = pointed(&mut renderer, &mut view, square_camera(), pixel)
                    else {
                        panic!("{pixel:?}: the wall is everywhere");
                    };
                    found[surface.object.0 as usize] += 1;
                }
            }
        }
        assert!(found.iter().all(|count| *count > 2), "{found:?}");
    });
}

#[test]
fn what_is_explained_of_objects_is_what_was_drawn() {
    run(Driver::Lavapipe, |device| {
        let GeneratedScene { scene, routes } = city(1000, 5).unwrap();
        let path = CameraPath::new(PathKind::Street, &routes).unwrap();
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let mut counts = [0; 3];
        for frame in 0..120 {
            let camera = path.camera(frame);
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
            if frame % 24 == 23 {
                check(&mut renderer, &mut view, &camera, &scene, &mut counts);
            }
        }
        let [drawn, hidden, outside] = counts;
        assert!(drawn > 20 && hidden > 100 && outside > 100, "{drawn}, {hidden}, {outside}");
        let seen = renderer.view_of(&path.camera(119));
        assert!(renderer.explain_object(&view, &seen, ObjectId(u32::MAX)).is_none());
    });
}

/// Waits for the newest frame, and checks that the explanation of each object says if it was drawn.
/// Counts the drawn, hidden and outside objects.
fn check(
    renderer: &mut Renderer,
    view: &mut RenderView,
    camera: &Camera,
    scene: &Scene,
    counts: &mut [usize; 3],
) {
    let [drawn, hidden, outside] = counts;
    let seen = renderer.view_of(camera);
    let snapshot = renderer.snapshot(view, seen).unwrap();
    for (number, object) in (0..).zip(&scene.objects) {
        let id = ObjectId(number);
        let (explained, outcome) = renderer.explain_object(view, &seen, id).unwrap();
        let leaf = renderer.hierarchy().leaf_of(id).unwrap();
        let was_drawn = snapshot.drawn.iter().any(|range| range.contains(leaf));
        let triangles = scene.meshes[object.mesh.0 as usize].triangles();
        assert_eq!(renderer.triangles_of(id), triangles);
        let (count, is_drawn) = match (explained.decision, outcome) {
            (Decision::Outside, _) => (&mut *outside, false),
            (Decision::Tested { .. }, Some((frame, Outcome::Hidden))) => {
                assert_eq!(frame, explained.frame);
                (&mut *hidden, false)
            }
            (Decision::Tested { .. }, None) => panic!("{number}: {explained:?}"),
            _ => (&mut *drawn, true),
        };
        *count += 1;
        assert_eq!(was_drawn, is_drawn, "{number}: {explained:?}, {outcome:?}");
    }
}

#[test]
fn each_answer_is_about_the_frame_that_it_names() {
    run(Driver::Lavapipe, |device| {
        // A wall that moves away from the eye by a metre per frame.
        let wall = Mesh::of_triangles(
            "wall",
            &[[-9.0, -9.0, 0.0], [27.0, -9.0, 0.0], [-9.0, 27.0, 0.0]].map(|at| (at, [1.0; 3])),
        );
        let mut scene = Scene::single(wall);
        scene.objects[0].transform.translation.z = -1.0;
        let options = RendererOptions { frames_in_flight: 3, ..options() };
        let mut renderer = Renderer::new(device, &scene, &options).unwrap();
        let mut view = renderer.new_view().unwrap();
        let camera = square_camera();
        let eye = camera.eye.z;
        let mut answers = Vec::new();
        let mut distances = std::collections::HashMap::new();
        for metres in 1..=12 {
            let transform = Affine3A::from_translation(Vec3::new(0.0, 0.0, eye - metres as f32));
            renderer.update(&[ObjectChange::Move { object: ObjectId(0), transform }]).unwrap();
            view.point_at((metres != 7).then_some([160, 60])).unwrap();
            renderer.render(&mut view, FrameRequest::new(Strategy::ANTUMBRA, camera)).unwrap();
            distances.insert(view.plan().frame, f64::from(metres));
            answers.extend(view.pointed().copied());
        }
        renderer.wait_idle(&mut view).unwrap();
        answers.extend(view.pointed().copied());
        answers.dedup();
        // Answers do not wait, belong to their frame, and are absent for the frame without a
        // pointer.
        assert!(answers.len() >= 3, "{answers:?}");
        for answer in &answers {
            let metres = distances[&answer.frame];
            let surface = answer.surface.unwrap();
            let distance = f64::from(eye) - surface.point.z;
            assert!((distance - metres).abs() < 1e-3, "{metres}: {surface:?}");
            assert_ne!(metres, 7.0);
        }
        assert_eq!(distances[&answers.last().unwrap().frame], 12.0);
    });
}

#[test]
fn an_outline_and_a_debug_overlay_are_not_in_the_image_of_the_scene() {
    run_on_all(|device| {
        let GeneratedScene { scene, routes } = city(300, 5).unwrap();
        let camera = CameraPath::new(PathKind::Street, &routes).unwrap().camera(7);
        let mut renderer = Renderer::new(device, &scene, &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let [plain, whole, alone] = [0; 3].map(|_| Readback::new(device, SIZE).unwrap());
        let request = FrameRequest::new(Strategy::ANTUMBRA, camera);
        let bare = FrameRequest { image: Some(&plain), ..request };
        renderer.render(&mut view, bare).unwrap();
        let surface = pointed(&mut renderer, &mut view, camera, [160, 100]);
        let object = surface.map(|surface| surface.object);
        assert!(object.is_some(), "something is in the middle of the street");
        renderer.outline(object).unwrap();
        renderer
            .set_debug_overlay(DebugOverlay { has_boxes: true, ..DebugOverlay::default() })
            .unwrap();
        let both = FrameRequest { image: Some(&whole), scene_image: Some(&alone), ..request };
        renderer.render(&mut view, both).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        let differing = |a: &Readback, b: &Readback| {
            let [a, b] = [a, b].map(|image| image.rgba8().unwrap());
            a.chunks(4).zip(b.chunks(4)).filter(|(a, b)| a != b).count()
        };
        assert_eq!(differing(&plain, &alone), 0);
        assert!(differing(&plain, &whole) > 50);
        // Only the outline differs, and it disappears again.
        renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
        renderer.render(&mut view, both).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        assert!((20..5000).contains(&differing(&plain, &whole)));
        renderer.outline(None).unwrap();
        renderer.render(&mut view, both).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        assert_eq!(differing(&plain, &whole), 0);
    });
}
