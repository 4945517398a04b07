//! A mesh that is culled in pieces looks the same as the whole mesh, bit for bit.

use cull::{Camera, Projection, Strategy};
use glam::{Affine3A, Vec3};
use gpu::Readback;
use render::{CostModel, Renderer, RendererOptions};
use scene::{FOV_Y_RAD, Mesh, MeshId, NEAR_M, Object, PieceLimits, Scene};
use tests::walk::{frame_loop, pixels_that_differ};
use tests::{Driver, run};

/// Returns a cave of rock around the origin as one mesh, and a copy of it that surrounds both.
fn cave() -> Scene {
    const ROWS: u16 = 48;
    let point = |row: u16, column: u16| {
        let down = std::f32::consts::PI * f32::from(row) / f32::from(ROWS);
        let around = std::f32::consts::PI * f32::from(column % (2 * ROWS)) / f32::from(ROWS);
        let sin = if row == 0 || row == ROWS { 0.0 } else { down.sin() };
        let direction = Vec3::new(sin * around.cos(), down.cos(), sin * around.sin());
        let waves = (direction.x * 13.0).sin() * (direction.z * 11.0).sin();
        let colour = [0.5 + 0.4 * waves, 0.5 + 0.4 * direction.y, 0.4];
        ((direction * (8.0 + 3.0 * waves)).to_array(), colour)
    };
    let square = |row: u16, column: u16| {
        let a = point(row, column);
        let b = point(row, column + 1);
        let c = point(row + 1, column + 1);
        let d = point(row + 1, column);
        // Seen from inside.
        [a, c, b, a, d, c]
    };
    let corners: Vec<_> = (0..ROWS)
        .flat_map(|row| (0..2 * ROWS).flat_map(move |column| square(row, column)))
        .collect();
    let mut scene = Scene::single(Mesh::of_triangles("cave", &corners));
    let transform = Affine3A::from_scale(Vec3::splat(1.7));
    scene.objects.push(Object { mesh: MeshId(0), transform, tint: u32::MAX });
    scene
}

#[test]
fn pieces_have_the_bits_of_the_whole() {
    run(Driver::Lavapipe, |device| {
        let cameras: Vec<Camera> = (0..10_u8)
            .map(|frame| {
                let (sin, cos) = (f32::from(frame) * 0.35).sin_cos();
                Camera {
                    eye: Vec3::new(2.0 * cos, 0.3, 2.0 * sin),
                    forward: Vec3::new(cos, 0.1, -sin).normalize(),
                    up: Vec3::Y,
                    projection: Projection::perspective(FOV_Y_RAD),
                    near: NEAR_M,
                }
            })
            .collect();
        for with_surfaces in [false, true] {
            let whole = if with_surfaces { cave().with_surfaces() } else { cave() };
            let mut cut = whole.clone();
            let map = cut.cut_large_meshes(PieceLimits { cut_above: 1000, piece: 256 });
            assert_eq!(
                map.part_of(cull::ObjectId(cut.objects.len() as u32 - 1)),
                Some(cull::ObjectId(1))
            );
            let options = RendererOptions {
                methods: methods::all(),
                size: [320, 180],
                cost_model: CostModel::Off,
                ..RendererOptions::default()
            };
            let images_of = |scene: &Scene, strategy: Strategy| {
                let mut renderer = Renderer::new(device, scene, &options).unwrap();
                let mut view = renderer.new_view().unwrap();
                let loops = frame_loop(&mut renderer, &mut view, strategy, &cameras);
                let draws: u64 = loops.outcomes.iter().map(|outcome| outcome.draws).sum();
                let pixels = |image: &Readback| image.rgba8().unwrap().to_vec();
                (loops.images.iter().map(pixels).collect::<Vec<Vec<u8>>>(), draws)
            };
            let (expected, _) = images_of(&whole, Strategy::FRUSTUM);
            let (plain, in_frustum) = images_of(&cut, Strategy::FRUSTUM);
            let all = cut.objects.len() as u64 * cameras.len() as u64;
            assert!(in_frustum < all / 2, "{in_frustum} of {all}");
            for strategy in [
                Strategy::ANTUMBRA,
                Strategy::ANTUMBRA_QUERIES,
                Strategy::ANTUMBRA_FLAGS,
                Strategy::ANTUMBRA_COMPUTE,
            ] {
                let (images, draws) = images_of(&cut, strategy);
                assert!(draws < in_frustum, "{strategy:?}: {draws} of {in_frustum}");
                for (frame, (image, whole)) in images.iter().zip(&expected).enumerate() {
                    assert_eq!(pixels_that_differ(image, whole), 0, "{strategy:?}, frame {frame}");
                }
            }
            for (image, whole) in plain.iter().zip(&expected) {
                assert_eq!(pixels_that_differ(image, whole), 0);
            }
        }
    });
}
