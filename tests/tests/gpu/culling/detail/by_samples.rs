//! Levels of detail by visible samples: mostly hidden objects become coarser and fine again,
//! without flicker, and every strategy chooses the same levels.

use cull::{Camera, DetailBySamples, DetailPolicy, ObjectId, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::Device;
use render::{DetailView, Error, RenderView, Renderer};
use scene::{MeshId, Object, ObjectChange, Scene};
use tests::run_on_all;
use tests::shapes::{coloured_cubes, square_camera};
use tests::walk::pixels_that_differ;

use super::{coarser, options, render};

const HERO: ObjectId = ObjectId(0);
const WALL: ObjectId = ObjectId(1);
/// Triangles of the two levels of a cube.
const FINE: u64 = 12;
const COARSE: u64 = 6;
/// The number of frames until a change of visibility has its effect: two in flight, the next call,
/// and the call after it.
const LATE: usize = 4;

const POLICY: DetailPolicy = DetailPolicy {
    error_pixels: 0.5,
    hysteresis: 0.2,
    by_samples: Some(DetailBySamples { enough_samples: 400, most: 4.0 }),
};

fn placed(mesh: u32, low: Vec3, size: Vec3) -> Object {
    let transform = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, low);
    Object { mesh: MeshId(mesh), transform, tint: u32::MAX }
}

/// Returns the transform of a wall that leaves this number of columns of the hero's pixels free.
fn wall(columns: f32) -> Affine3A {
    // The hero's near side begins 80 / 7 columns left of the middle. A metre at the wall is 20
    // columns.
    let left = (columns - 80.0 / 7.0) / 20.0;
    placed(1, vec3(left, -4.0, -4.2), vec3(9.0, 8.0, 0.2)).transform
}

/// Returns a cube that fills 23 by 23 pixels, a wall in front of it, and smaller cubes around it.
fn scene() -> Scene {
    let mut objects = vec![placed(0, vec3(-1.0, -1.0, -9.0), Vec3::splat(2.0))];
    objects.push(Object { transform: wall(100.0), ..placed(1, Vec3::ZERO, Vec3::ONE) });
    objects.extend((0..40).map(|number| {
        let place = vec3((number % 8) as f32 * 1.3 - 5.0, (number / 8) as f32 - 2.5, -12.0);
        placed(2, place, Vec3::splat(0.7))
    }));
    let mut scene = coloured_cubes(3, objects);
    let level = |mesh: usize| vec![coarser(&scene.meshes[mesh].indices, 0.05)];
    let levels = vec![level(0), vec![], level(2)];
    scene.surfaces.as_mut().unwrap().levels = levels;
    scene
}

/// A renderer, its view and its strategy.
struct Side {
    renderer: Renderer,
    view: RenderView,
    strategy: Strategy,
}

impl Side {
    fn new(device: &Device, strategy: Strategy) -> Self {
        let renderer = Renderer::new(device, &scene(), &options()).unwrap();
        let mut view = renderer.new_view().unwrap();
        let watched: Vec<ObjectId> = (0..42).map(ObjectId).collect();
        view.watch(&watched).unwrap();
        Self { renderer, view, strategy }
    }

    /// Draws a frame. Returns the image, and the triangles of each object.
    fn frame(&mut self, camera: Camera, columns: f32) -> (gpu::Readback, Vec<u64>) {
        let Self { renderer, view, strategy } = self;
        renderer.update(&[ObjectChange::Move { object: WALL, transform: wall(columns) }]).unwrap();
        renderer.choose_detail_seen(&[DetailView { camera, state: view }], &POLICY).unwrap();
        let triangles = (0..42).map(|object| renderer.triangles_of(ObjectId(object))).collect();
        (render(renderer, view, *strategy, camera), triangles)
    }
}

/// Draws frames with each strategy, with separate counts, and checks that all agree. Returns the
/// triangles of the hero in each frame.
fn film(device: &Device, frames: &[(Camera, f32)]) -> Vec<u64> {
    let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA, methods::HZB];
    let mut sides = strategies.map(|strategy| Side::new(device, strategy));
    let films = sides.each_mut().map(|side| {
        let frames = frames.iter().map(|(camera, columns)| side.frame(*camera, *columns));
        let frames: Vec<_> = frames.collect();
        side.renderer.wait_idle(&mut side.view).unwrap();
        frames
    });
    let [plain, others @ ..] = &films;
    for (other, strategy) in others.iter().zip(&strategies[1..]) {
        for (number, (expected, found)) in plain.iter().zip(other).enumerate() {
            assert_eq!(expected.1, found.1, "{strategy}, frame {number}");
            let [a, b] = [&expected.0, &found.0].map(|image| image.rgba8().unwrap());
            assert_eq!(pixels_that_differ(&a, &b), 0, "{strategy}, frame {number}");
        }
    }
    plain.iter().map(|(_, triangles)| triangles[HERO.0 as usize]).collect()
}

#[test]
fn what_is_mostly_hidden_gets_coarser_and_comes_back() {
    run_on_all(|device| {
        let still = |columns: f32, frames: usize| vec![(square_camera(), columns); frames];
        // Seen, mostly hidden, wholly hidden, seen again.
        let frames = [still(100.0, 10), still(1.0, 10), still(-5.0, 10), still(100.0, 10)];
        let levels = film(device, &frames.concat());
        assert!(levels[..10].iter().all(|level| *level == FINE), "{levels:?}");
        assert!(levels[10 + LATE..30].iter().all(|level| *level == COARSE), "{levels:?}");
        assert!(levels[30 + LATE..].iter().all(|level| *level == FINE), "{levels:?}");
        let changes = levels.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(changes, 2, "{levels:?}");
    });
}

#[test]
fn nothing_flickers_at_the_threshold() {
    run_on_all(|device| {
        // One column of 23 rows is below 49 samples, the limit for the coarse level. Two or three
        // columns lie between 49 and 77 samples, the limit for the fine level.
        let film_of = |columns: &dyn Fn(usize) -> f32| {
            let mut frames = vec![(square_camera(), 100.0); 6];
            frames.extend((0..40).map(|frame| (square_camera(), columns(frame))));
            film(device, &frames)
        };
        let levels = film_of(&|_| 2.0);
        assert!(levels.iter().all(|level| *level == FINE), "{levels:?}");
        let levels = film_of(&|frame| if frame % 2 == 0 { 1.0 } else { 2.0 });
        let changes = levels.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!((changes, levels.last()), (1, Some(&COARSE)), "{levels:?}");
    });
}

#[test]
fn every_strategy_chooses_the_same_levels_in_motion() {
    run_on_all(|device| {
        let mut random = 9_u64;
        let frames = (0..50).map(|frame| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let columns = (random >> 33) as f32 / (1_u64 << 31) as f32 * 30.0 - 3.0;
            let eye = vec3((frame as f32 * 0.2).sin(), 0.1, 0.02 * frame as f32);
            (Camera { eye, ..square_camera() }, columns)
        });
        let levels = film(device, &frames.collect::<Vec<_>>());
        assert!(levels.contains(&FINE) && levels.contains(&COARSE), "{levels:?}");
    });
}

#[test]
fn without_counts_the_distance_decides() {
    run_on_all(|device| {
        let mut side = Side::new(device, Strategy::ANTUMBRA);
        side.view.watch(&[]).unwrap();
        for _ in 0..8 {
            assert_eq!(side.frame(square_camera(), 1.0).1[0], FINE);
        }
        side.view.watch(&[HERO]).unwrap();
        for _ in 0..8 {
            side.frame(square_camera(), 1.0);
        }
        assert_eq!(side.frame(square_camera(), 1.0).1[0], COARSE);
        // A view with a cleared history knows nothing until results arrive.
        side.view.reset();
        assert_eq!(side.frame(square_camera(), 1.0).1[0], FINE);
        side.renderer.wait_idle(&mut side.view).unwrap();
        let other = Renderer::new(device, &scene(), &options()).unwrap().new_view().unwrap();
        let of_other = DetailView { camera: square_camera(), state: &other };
        let error = side.renderer.choose_detail_seen(&[of_other], &POLICY);
        assert!(matches!(error, Err(Error::ForeignRenderer { .. })), "{error:?}");
    });
}
