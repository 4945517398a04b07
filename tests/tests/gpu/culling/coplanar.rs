//! Scenes full of surfaces at the same depth: boxes with shared faces, in one plane, one inside the
//! other, cutting each other. With surfaces they are drawn depth first, and the order of draws is
//! not visible.

use cull::{Camera, ObjectId, Projection, Strategy};
use glam::{Affine3A, Quat, Vec3, vec3};
use gpu::{Device, PredicationMode, Readback};
use render::{
    CostModel, DebugOverlay, FrameRequest, Rect, Renderer, RendererOptions, ShaderSet, ViewRequest,
    ViewsRequest,
};
use scene::{
    Alpha, MaterialId, Mesh, MeshId, Object, Scene, SpriteEnd, SpriteShape, Sprites, SurfaceMesh,
    pack_sprite_colour,
};
use tests::shapes::coloured_cubes;
use tests::walk::{frame_loop, images_that_differ};
use tests::{Driver, run, run_on_all};

const SIZE: [u32; 2] = [160, 90];
const COLOURS: u32 = 7;

/// Returns the strategies that promise to be exact, in resting or in moving scenes.
fn exact() -> impl Iterator<Item = Strategy> {
    methods::strategies()
        .into_iter()
        .filter(|strategy| strategy.is_exact() && *strategy != Strategy::FRUSTUM)
}

fn object(number: u32, low: Vec3, high: Vec3, turn_rad: f32) -> Object {
    let transform =
        Affine3A::from_scale_rotation_translation(high - low, Quat::from_rotation_y(turn_rad), low);
    Object { mesh: MeshId(number % COLOURS), transform, tint: u32::MAX }
}

/// Returns rows of walls across the way, of three boxes each in the same place, some slightly
/// turned. Between the walls are boxes with corners on a coarse grid, and under everything
/// overlapping tiles in one plane.
fn ties() -> Scene {
    let mut objects = Vec::new();
    let mut state = 12_345_u32;
    let mut random = |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % below
    };
    for row in 0..6 {
        let x = row as f32 * 8.0;
        for part in 0..6 {
            let z = part as f32 * 4.0 - 12.0;
            let gap = if part == row { 3.0 } else { 0.0 };
            for copy in 0..3 {
                let turn = if copy == 2 { 0.01 } else { 0.0 };
                let high = vec3(x + 0.5, 5.0, z + 4.0 - gap);
                objects.push(object(copy + row * 2, vec3(x, 0.0, z), high, turn));
            }
        }
        for number in 0..30 {
            let whole = |most: u32, random: &mut dyn FnMut(u32) -> u32| random(most) as f32;
            let a = whole(7, &mut random);
            let b = whole(24, &mut random);
            let low = vec3(x + a, 0.0, b - 12.0);
            let sides = [3, 4, 3].map(|most| 1.0 + whole(most, &mut random));
            objects.push(object(number, low, low + Vec3::from(sides), 0.0));
            let tile = vec3(x + a - 1.0, -1.0, b - 13.0);
            objects.push(object(number + 3, tile, tile + vec3(6.0, 1.0, 5.0), 0.0));
        }
    }
    coloured_cubes(COLOURS, objects)
}

/// Returns cameras along the walls and through them, so that something is seen for the first time
/// in most frames.
fn cameras(frames: u32) -> Vec<Camera> {
    let camera = |frame: u32| {
        let along = frame as f32 / frames as f32;
        let turn = (along * 9.0).sin() * 0.7;
        Camera {
            eye: vec3(
                -6.0 + along * 46.0,
                2.3 + 2.5 * (along * 7.0).sin(),
                (along * 5.0).sin() * 6.0,
            ),
            forward: vec3(turn.cos(), -0.15, turn.sin()),
            up: Vec3::Y,
            projection: Projection::perspective(1.1),
            near: 0.05,
        }
    };
    (0..frames).map(camera).collect()
}

fn options(frames_in_flight: usize) -> RendererOptions {
    RendererOptions {
        methods: methods::all(),
        size: SIZE,
        frames_in_flight,
        cost_model: CostModel::Off,
        ..Default::default()
    }
}

/// Draws with one strategy from an empty history.
fn images(renderer: &mut Renderer, strategy: Strategy, cameras: &[Camera]) -> Vec<Readback> {
    let mut view = renderer.new_view().unwrap();
    if strategy != methods::IDEAL {
        return frame_loop(renderer, &mut view, strategy, cameras).images;
    }
    let mut finding = renderer.new_view().unwrap();
    let draw = |camera: &Camera| {
        let image = Readback::new(renderer.device(), SIZE).unwrap();
        let area = Rect::whole(SIZE);
        let visible = renderer.visible_set(&mut finding, camera, area).unwrap();
        let request = FrameRequest {
            visible: Some(&visible),
            image: Some(&image),
            ..FrameRequest::new(strategy, *camera)
        };
        renderer.render(&mut view, request).unwrap();
        renderer.wait_idle(&mut view).unwrap();
        image
    };
    cameras.iter().map(draw).collect()
}

/// Returns the number of pixels in each frame that differ from frustum culling, by strategy.
fn wrong(
    device: &Device,
    scene: &Scene,
    options: &RendererOptions,
    strategies: impl Iterator<Item = Strategy>,
    frames: u32,
) -> Vec<(Strategy, Vec<usize>)> {
    let cameras = cameras(frames);
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let expected = images(&mut renderer, Strategy::FRUSTUM, &cameras);
    let found = strategies.map(|strategy| {
        let found = images(&mut renderer, strategy, &cameras);
        let differ = |(a, b): (&Readback, &Readback)| images_that_differ(a, b);
        (strategy, expected.iter().zip(&found).map(differ).collect())
    });
    found.collect()
}

fn check(device: &Device, options: &RendererOptions, frames: u32) {
    check_scene(device, &ties(), options, frames);
}

fn check_scene(device: &Device, scene: &Scene, options: &RendererOptions, frames: u32) {
    let in_flight = options.frames_in_flight;
    for (strategy, pixels) in wrong(device, scene, options, exact(), frames) {
        assert!(pixels.iter().all(|wrong| *wrong == 0), "{strategy}, {in_flight}: {pixels:?}");
    }
}

#[test]
fn lavapipe_ties_do_not_show() {
    run(Driver::Lavapipe, |device| check(device, &options(2), 16));
}

#[test]
#[ignore = "long walk"]
fn ties_do_not_show_with_any_number_of_frames_in_flight() {
    run_on_all(|device| {
        for in_flight in 1..=3 {
            check(device, &options(in_flight), 16);
        }
    });
}

#[test]
fn every_way_to_skip_draws_is_exact_with_ties() {
    run(Driver::Lavapipe, |device| {
        for (in_flight, predication) in
            [PredicationMode::Counts, PredicationMode::Instances, PredicationMode::Compacted]
                .into_iter()
                .enumerate()
        {
            let options = options(in_flight + 1);
            check(device, &RendererOptions { predication: Some(predication), ..options }, 8);
        }
    });
}

/// Returns the scene of [`ties`] with holes: two materials have an alpha cutoff of a half, by the
/// corners of faces.
fn with_holes() -> Scene {
    let mut scene = ties();
    let surfaces = scene.surfaces.as_mut().unwrap();
    for number in [1, 4] {
        surfaces.materials[number].alpha = Alpha::Mask { cutoff: 0.5 };
        for (corner, vertex) in surfaces.meshes[number].vertices.iter_mut().enumerate() {
            vertex.colour[3] = if corner % 2 == 0 { u16::MAX } else { 0 };
        }
    }
    scene
}

/// Returns images of a scene in which everything is drawn.
fn images_of(device: &Device, scene: &Scene) -> Vec<Readback> {
    let mut renderer = Renderer::new(device, scene, &options(2)).unwrap();
    images(&mut renderer, Strategy::FRUSTUM, &cameras(6))
}

/// Returns the number of differing pixels, over all images.
fn differing(some: &[Readback], others: &[Readback]) -> usize {
    let differ = |(a, b): (&Readback, &Readback)| images_that_differ(a, b);
    some.iter().zip(others).map(differ).sum()
}

#[test]
fn what_is_seen_through_holes_is_exact() {
    run_on_all(|device| {
        check_scene(device, &with_holes(), &options(2), 6);
        let whole = images_of(device, &ties());
        let cut = images_of(device, &with_holes());
        assert!(differing(&whole, &cut) > 1000, "there are holes");
    });
}

/// Adds clouds of points and tangles of lines before, behind and in the walls of a scene: some
/// turned, some mirrored, some flat.
pub fn with_sprites(mut scene: Scene) -> Scene {
    let mut state = 99_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for shape in [SpriteShape::Point, SpriteShape::Line] {
        let mesh = MeshId(scene.meshes.len() as u32);
        let mut end = || SpriteEnd {
            position: [random(), random(), random()],
            colour: pack_sprite_colour([random(), random(), 1.0]),
        };
        let ends = (0..600).map(|_| end()).collect();
        let sprites = Sprites { mesh, shape, radius_m: 0.03, ends, normals: Vec::new() };
        let vertices = Vec::new();
        let indices = Vec::new();
        let name = "sprites".to_owned();
        let bounds = sprites.bounds();
        scene.meshes.push(Mesh { name, vertices, indices, bounds, has_backs: false });
        let surfaces = scene.surfaces.as_mut().unwrap();
        surfaces.meshes.push(SurfaceMesh { vertices: Vec::new(), material: MaterialId(0) });
        surfaces.sprites.push(sprites);
        for number in 0..24 {
            let at = vec3(random() * 46.0, random() * 3.0, random() * 24.0 - 12.0);
            let scale = [vec3(2.0, 2.0, 2.0), vec3(-1.0, 3.0, 1.5), vec3(4.0, 0.0, 2.0)];
            let turn = Quat::from_rotation_y(random() * 6.0) * Quat::from_rotation_x(random());
            let scale = scale[number % 3];
            let transform = Affine3A::from_scale_rotation_translation(scale, turn, at);
            scene.objects.push(Object { mesh, transform, tint: u32::MAX });
        }
    }
    scene
}

#[test]
fn points_and_lines_are_exact_and_seen() {
    run_on_all(|device| {
        let scene = with_holes();
        let sprites = with_sprites(scene.clone());
        sprites.validate().unwrap();
        check_scene(device, &sprites, &options(2), 6);
        let seen = differing(&images_of(device, &scene), &images_of(device, &sprites));
        assert!(seen > 500, "{seen} pixels of sprites");
    });
}

#[test]
fn all_else_goes_on_with_surfaces() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &ties(), &options(2)).unwrap();
        let mut left = renderer.new_view().unwrap();
        let mut right = renderer.new_view().unwrap();
        let has_wireframe = device.capabilities().has(gpu::OptionalFeature::Wireframe);
        let corner = Rect { origin: [100, 0], size: [60, 40] };
        let cameras = cameras(12);
        left.watch(&[ObjectId(3), ObjectId(30)]).unwrap();
        for (frame, camera) in cameras.iter().enumerate() {
            if frame == 4 {
                let overlay = DebugOverlay {
                    has_wireframe,
                    has_boxes: true,
                    has_depth_complexity: true,
                    top_down: Some(corner),
                };
                renderer.set_debug_overlay(overlay).unwrap();
            }
            if frame == 8 {
                renderer.set_debug_overlay(DebugOverlay::default()).unwrap();
                renderer.reload(ShaderSet::embedded().unwrap()).unwrap();
            }
            let mut halves = Rect::side_by_side(SIZE, 2);
            let mut eye = |history| ViewRequest {
                state: history,
                viewpoint: (*camera).into(),
                visible: None,
                rect: halves.next().unwrap(),
            };
            let eyes = &mut [eye(&mut left), eye(&mut right)];
            let strategies = [Strategy::ANTUMBRA, methods::HZB, methods::BATCHED];
            let strategy = strategies[frame % 3];
            let request = ViewsRequest { strategy, image: None, overlay: None, after: None };
            renderer.render_views(eyes, &request).unwrap();
        }
        let area = Rect { origin: [0, 0], size: [80, 90] };
        let view = renderer.view_in(cameras[11], area).unwrap();
        let snapshot = renderer.snapshot(&mut left, view).unwrap();
        let image = Readback::new(device, SIZE).unwrap();
        renderer.top_down(&snapshot, &image).unwrap();
        renderer.render_snapshot(&snapshot, cameras[3], Some(&image), None).unwrap();
        renderer.wait_idle(&mut left).unwrap();
        assert!(!left.visible_samples().is_empty());
        // Some colours of the scene: neither only sky nor only black.
        let pixels = image.rgba8().unwrap();
        let mut colours: Vec<&[u8]> = pixels.chunks_exact(4).collect();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() >= 4, "{colours:?}");
        renderer.resize([128, 72]).unwrap();
        renderer.render(&mut left, FrameRequest::new(methods::HZB, cameras[0])).unwrap();
        renderer.wait_idle(&mut left).unwrap();
    });
}

#[test]
fn without_surfaces_the_order_of_draws_shows() {
    // Otherwise this scene would prove nothing.
    run_on_all(|device| {
        let scene = Scene { surfaces: None, ..ties() };
        let found = wrong(device, &scene, &options(2), exact(), 8);
        let pixels: usize = found.iter().flat_map(|(_, pixels)| pixels).sum();
        assert!(pixels > 100, "{found:?}");
    });
}

#[test]
fn many_objects_are_left_out() {
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &ties(), &options(2)).unwrap();
        let cameras = cameras(12);
        let mut draws = |strategy| -> u64 {
            let mut view = renderer.new_view().unwrap();
            let found = frame_loop(&mut renderer, &mut view, strategy, &cameras);
            found.draws()
        };
        let all = draws(Strategy::FRUSTUM);
        for (strategy, percent) in
            [(Strategy::ANTUMBRA, 66), (methods::CHC, 66), (methods::HZB, 85)]
        {
            let drawn = draws(strategy);
            assert!(drawn * 100 < all * percent, "{strategy}: {drawn} of {all}");
        }
    });
}

#[test]
fn next_frame_is_right_once_its_answers_are_home() {
    // A query around the draw of a tied surface must count it as visible, too, or it would flicker
    // forever.
    run_on_all(|device| {
        let mut renderer = Renderer::new(device, &ties(), &options(2)).unwrap();
        let [from, .., to] = cameras(12)[..] else { panic!("cameras") };
        for camera in [from, to] {
            let cameras = [camera; 10];
            let expected = images(&mut renderer, Strategy::FRUSTUM, &cameras[..1]);
            let found = images(&mut renderer, methods::NEXT_FRAME, &cameras);
            for image in &found[6..] {
                assert_eq!(images_that_differ(&expected[0], image), 0);
            }
        }
    });
}
