//! Transparent objects with sorted fragments: exact where objects intersect, the same in any order
//! and with any culling. Errors are always reported.

use cull::Strategy;
use glam::{Affine3A, Vec3, vec3};
use gpu::{Device, Readback, SampleCount};
use render::{
    DriverAssumption, FragmentCounts, FrameReport, FrameRequest, Rect, Renderer, RendererOptions,
    TransparencyFallback, TransparencyMethod, TransparencyOptions, ViewRequest, ViewsRequest,
};
use scene::{Alpha, Material, MeshId, Object, Scene, SurfaceVertex, Surfaces};
use shadows::{ShadowMethod, ShadowOptions};
use tests::run_on_all;
use tests::section::{front, plane, planes};
use tests::surface_fixture::{mesh, scene, snorm16};
use tests::walk::{images_that_differ, pixels_that_differ};

use crate::shading::transparent::{camera, compare, exact, options, scene as panes, unculled};

const SIDE: u32 = 96;
/// The backdrop. All colours here are linear.
const BEHIND: [f32; 3] = [0.2, 0.3, 0.4];

/// A quad in front of the camera whose depth is a plane: `z` at (x, y).
#[derive(Clone, Copy)]
struct Sheet {
    half_m: f32,
    slope: [f32; 2],
    z_m: f32,
    colour: [f32; 4],
}

impl Sheet {
    fn z_at(&self, x: f32, y: f32) -> f32 {
        self.slope[0] * x + self.slope[1] * y + self.z_m
    }
}

/// Returns intersecting sheets, with more sheets behind them than are sorted at once.
fn sheets() -> Vec<Sheet> {
    let crossing = [
        ([0.5, 0.1], [1.0, 0.1, 0.0, 0.5]),
        ([-0.5, 0.2], [0.0, 0.8, 0.1, 0.6]),
        ([0.1, -0.6], [0.1, 0.1, 0.9, 0.4]),
        ([0.0, 0.55], [0.9, 0.9, 0.0, 0.7]),
    ];
    let crossing = crossing.map(|(slope, colour)| Sheet { half_m: 0.9, slope, z_m: 0.1, colour });
    let parallel = (0..30).map(|number| {
        let share = number as f32 / 30.0;
        let colour = [share, 1.0 - share, 0.5, 0.08];
        Sheet { half_m: 0.8, slope: [0.0; 2], z_m: -0.6 - 0.01 * number as f32, colour }
    });
    crossing.into_iter().chain(parallel).collect()
}

/// Returns a scene of sheets in front of an opaque sheet.
fn scene_of(sheets: &[Sheet]) -> Scene {
    let [red, green, blue] = BEHIND;
    let behind =
        Sheet { half_m: 2.0, slope: [0.0; 2], z_m: -0.98, colour: [red, green, blue, 1.0] };
    let all = || std::iter::once(&behind).chain(sheets);
    let meshes = (0..).zip(all()).map(|(material, sheet)| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|[x, y]: [f32; 2]| {
            let x_m = x * sheet.half_m;
            let y_m = y * sheet.half_m;
            vec3(x_m, y_m, sheet.z_at(x_m, y_m))
        });
        let vertex = SurfaceVertex {
            normal: snorm16(Vec3::Z, 0),
            tangent: snorm16(Vec3::X, 1),
            uv: [[0.0; 2]; 2],
            colour: [u16::MAX; 4],
        };
        mesh(&corners, vec![vertex; 4], vec![0, 1, 2, 0, 2, 3], material)
    });
    let materials = all().map(|sheet| Material {
        base_colour: sheet.colour,
        alpha: if sheet.colour[3] < 1.0 { Alpha::Blend } else { Alpha::Opaque },
        is_unlit: true,
        ..Material::default()
    });
    let object =
        |mesh: u32| Object { mesh: MeshId(mesh), transform: Affine3A::IDENTITY, tint: u32::MAX };
    let surfaces = Surfaces {
        materials: materials.collect(),
        transparent: (1..=sheets.len() as u32).map(object).collect(),
        ..Surfaces::default()
    };
    scene(meshes.collect(), &[Affine3A::IDENTITY], surfaces)
}

fn sorted(options: RendererOptions) -> RendererOptions {
    let method = TransparencyMethod::SortedFragments;
    let transparency =
        TransparencyOptions { method, fragments_per_pixel: 80, ..Default::default() };
    RendererOptions { transparency, ..options }
}

fn of_side() -> RendererOptions {
    RendererOptions { size: [SIDE; 2], ..options(2) }
}

/// Returns an image, and the report of a frame whose counts are known.
fn drawn(device: &Device, scene: &Scene, options: &RendererOptions) -> (Vec<u8>, FrameReport) {
    let mut renderer = Renderer::new(device, scene, options).unwrap();
    let mut view = renderer.new_view().unwrap();
    let image = Readback::new(device, options.size).unwrap();
    let request = FrameRequest::new(Strategy::FRUSTUM, front(2.0));
    let request = FrameRequest { image: Some(&image), ..request };
    let mut report = FrameReport::default();
    for _ in 0..3 {
        report = renderer.render(&mut view, request).unwrap();
    }
    renderer.wait_idle(&mut view).unwrap();
    assert_eq!(renderer.fragment_counts(), report.fragments, "each frame stores the same");
    (image.rgba8().unwrap().to_vec(), report)
}

/// Returns the sRGB-encoded colour of a pixel, from its sheets in the order of their depths. `None`
/// where two sheets are too near to each other, or at an edge.
fn expected(sheets: &[Sheet], x: f32, y: f32) -> Option<[u8; 3]> {
    let reach_m = x.abs().max(y.abs());
    if sheets.iter().any(|sheet| (sheet.half_m - reach_m).abs() < 0.02) {
        return None;
    }
    let mut there: Vec<&Sheet> = sheets.iter().filter(|sheet| sheet.half_m > reach_m).collect();
    there.sort_by(|a, b| a.z_at(x, y).total_cmp(&b.z_at(x, y)));
    if there.windows(2).any(|pair| pair[1].z_at(x, y) - pair[0].z_at(x, y) < 0.002) {
        return None;
    }
    let blended = there.iter().fold(BEHIND, |behind, sheet| {
        let alpha = sheet.colour[3];
        std::array::from_fn(|part| behind[part] * (1.0 - alpha) + sheet.colour[part] * alpha)
    });
    Some(blended.map(|light| {
        let encoded = match light {
            0.0..0.0031308 => light * 12.92,
            _ => 1.055 * light.powf(1.0 / 2.4) - 0.055,
        };
        (encoded * 255.0).round() as u8
    }))
}

/// Returns the numbers of pixels that equal the colour of their sheets, and that differ from it.
fn judged(sheets: &[Sheet], image: &[u8]) -> [usize; 2] {
    let mut right_and_wrong = [0; 2];
    for (place, found) in (0..).zip(image.as_chunks::<4>().0) {
        let at = |pixel: u32| (pixel as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let Some(wanted) = expected(sheets, at(place % SIDE), -at(place / SIDE)) else { continue };
        let is_wrong = wanted.iter().zip(found).any(|(wanted, found)| wanted.abs_diff(*found) > 1);
        right_and_wrong[usize::from(is_wrong)] += 1;
    }
    right_and_wrong
}

#[test]
fn sheets_that_cross_are_blended_as_their_depths_say_at_each_pixel() {
    run_on_all(|device| {
        let sheets = sheets();
        let scene = scene_of(&sheets);
        let (image, report) = drawn(device, &scene, &sorted(of_side()));
        let [right, wrong] = judged(&sheets, &image);
        assert!(right > 7000 && wrong == 0, "{right} right, {wrong} wrong");
        assert!(report.fragments.is_exact() && report.fragments.visible > 100_000);
        let (image, report) = drawn(device, &scene, &of_side());
        assert!(judged(&sheets, &image)[1] > 1000, "no order of objects is right");
        assert_eq!(report.fragments, FragmentCounts::default());
    });
}

#[test]
fn no_order_of_objects_changes_a_bit() {
    run_on_all(|device| {
        let mut scene = scene_of(&sheets());
        let surfaces = scene.surfaces.as_mut().unwrap();
        // Some sheets are in the same place as others, in different colours.
        let again: Vec<Object> = surfaces.transparent[4..20].to_vec();
        let doubled = again.iter().enumerate().map(|(number, object)| {
            let mesh = MeshId(1 + (object.mesh.0 + number as u32) % 30);
            let transform = Affine3A::from_translation(Vec3::Z * 0.1);
            [Object { transform, ..*object }, Object { mesh, transform, ..*object }]
        });
        surfaces.transparent.extend(doubled.flatten().collect::<Vec<_>>());
        let options = sorted(of_side());
        let (image, report) = drawn(device, &scene, &options);
        assert_eq!(report.fragments.without_room, 0);
        for turned in [1, 7, 20] {
            let transparent = &mut scene.surfaces.as_mut().unwrap().transparent;
            transparent.reverse();
            transparent.rotate_left(turned);
            let (again, counts) = drawn(device, &scene, &options);
            assert_eq!(pixels_that_differ(&image, &again), 0, "turned by {turned}");
            assert_eq!(counts.fragments, report.fragments);
        }
    });
}

#[test]
fn every_strategy_shows_the_same_fragments() {
    run_on_all(|device| {
        let expected = unculled(device, &sorted(options(1)));
        compare(device, &expected, &exact(), &sorted(options(2)));
        compare(device, &expected, &[Strategy::ANTUMBRA], &sorted(options(3)));
    });
}

/// Returns a stereo pair of each frame of a walk through panes that are lit, shadowed and cut.
fn stereo(device: &Device, strategy: Strategy) -> Vec<Readback> {
    let mut scene = panes();
    let surfaces = scene.surfaces.as_mut().unwrap();
    surfaces.materials.iter_mut().for_each(|material| material.is_unlit = false);
    let shadows = ShadowOptions { method: ShadowMethod::Maps, ..ShadowOptions::default() };
    let options = RendererOptions { size: [160, 90], shadows, ..sorted(options(2)) };
    let mut renderer = Renderer::new(device, &scene, &options).unwrap();
    let mut eyes = [renderer.new_view().unwrap(), renderer.new_view().unwrap()];
    let mut images = Vec::new();
    for frame in 0..6 {
        match frame {
            2 => renderer.set_section(planes(&[plane([1.0, 0.2, 0.0], 0.7)])).unwrap(),
            5 => renderer.set_section(cull::SectionPlanes::default()).unwrap(),
            _ => {}
        }
        let image = Readback::new(device, [160, 90]).unwrap();
        let mut targets: Vec<ViewRequest<'_>> = (0..)
            .zip(&mut eyes)
            .map(|(eye, state): (u32, _)| {
                let mut camera = camera(frame);
                camera.eye.x += 0.3 * eye as f32;
                let rect = Rect { origin: [eye * 80, 0], size: [80, 90] };
                ViewRequest { state, viewpoint: camera.into(), visible: None, rect }
            })
            .collect();
        let request = ViewsRequest { strategy, image: Some(&image), overlay: None, after: None };
        renderer.render_views(&mut targets, &request).unwrap();
        images.push(image);
    }
    renderer.wait_idle(&mut eyes[0]).unwrap();
    let snapshot = renderer.snapshot(&mut eyes[0], renderer.view_of(&camera(5)));
    let from_above = Readback::new(device, [160, 90]).unwrap();
    renderer.top_down(&snapshot.unwrap(), &from_above).unwrap();
    images
}

#[test]
fn lit_shadowed_and_cut_fragments_are_the_same_for_two_eyes() {
    run_on_all(|device| {
        let expected = stereo(device, Strategy::FRUSTUM);
        let found = stereo(device, Strategy::ANTUMBRA);
        for (frame, (expected, found)) in expected.iter().zip(&found).enumerate() {
            let wrong = images_that_differ(expected, found);
            assert_eq!(wrong, 0, "frame {frame}");
        }
        let differ = |a: usize, b: usize| images_that_differ(&expected[a], &expected[b]);
        assert!(differ(1, 2) > 500, "planes cut");
    });
}

#[test]
fn what_finds_no_room_or_is_left_out_is_counted() {
    run_on_all(|device| {
        let whole = |z_m, colour| Sheet { half_m: 2.0, slope: [0.0; 2], z_m, colour };
        let near = whole(0.5, [1.0, 0.0, 0.0, 0.5]);
        let far = whole(-0.5, [0.0, 1.0, 0.0, 0.5]);
        let scene = scene_of(&[near, far]);
        let with = |fragments_per_pixel, blended_most| {
            let method = TransparencyMethod::SortedFragments;
            let transparency = TransparencyOptions { method, fragments_per_pixel, blended_most };
            drawn(device, &scene, &RendererOptions { transparency, ..of_side() })
        };
        let pixels = SIDE * SIDE;
        let all = FragmentCounts { visible: 2 * pixels, ..FragmentCounts::default() };
        let (image, report) = with(2, 2);
        assert_eq!(report.fragments, all);
        assert_eq!(judged(&[near, far], &image)[1], 0);
        let (image, report) = with(2, 1);
        assert_eq!(report.fragments, FragmentCounts { left_out: pixels, ..all });
        assert_eq!(judged(&[near], &image)[1], 0, "the nearest is blended");
        let (_, report) = with(1, 2);
        assert_eq!(report.fragments, FragmentCounts { without_room: pixels, ..all });
        let (image, report) = with(0, 2);
        assert_eq!(report.fragments, FragmentCounts { without_room: 2 * pixels, ..all });
        assert_eq!(judged(&[], &image)[1], 0);
        assert!(!report.fragments.is_exact());
    });
}

#[test]
fn where_fragments_cannot_be_sorted_objects_are_for_a_reason() {
    run_on_all(|device| {
        let scene = scene_of(&sheets());
        let several = RendererOptions { samples: SampleCount::Four, ..of_side() };
        let (image, report) = drawn(device, &scene, &sorted(several.clone()));
        assert_eq!(pixels_that_differ(&image, &drawn(device, &scene, &several).0), 0);
        assert_eq!(report.fragments, FragmentCounts::default());
        let method_and_reason = |options| {
            let renderer = Renderer::new(device, &scene, &options).unwrap();
            (renderer.transparency_method(), renderer.transparency_fallback())
        };
        let several_samples = TransparencyFallback::SeveralSamples;
        let objects = TransparencyMethod::SortedObjects;
        assert_eq!(method_and_reason(sorted(several.clone())), (objects, Some(several_samples)));
        assert_eq!(method_and_reason(several), (objects, None));
        let fragments = TransparencyMethod::SortedFragments;
        assert_eq!(method_and_reason(sorted(of_side())), (fragments, None));
        let disabled = vec![DriverAssumption::EarlyTests];
        let distrusting = RendererOptions { disabled, ..sorted(of_side()) };
        let disabled = Some(TransparencyFallback::DriverQuirk);
        assert_eq!(method_and_reason(distrusting), (objects, disabled));
        assert_eq!(several_samples.to_string(), "a pixel has several samples");
    });
}
