//! Section planes in scenes with surfaces, lights and shadows, near the origin and far from it.

use cull::{Camera, ObjectId, SectionMember, SectionPlanes, Strategy};
use glam::{DVec3, Vec3, vec3};
use gpu::Device;
use render::RendererOptions;
use shadows::{CasterCulling, ShadowMethod, ShadowOptions};
use tests::section::{CutScene, plane, planes};
use tests::shapes::box_at;
use tests::{run_on_all, shadow_scene};

const SIZE: [u32; 2] = [160, 120];
const GROUND: ObjectId = ObjectId(0);

/// Frames at rest after which shadow maps are kept.
const KEPT_AFTER: usize = 8;

fn options(method: ShadowMethod) -> RendererOptions {
    let shadows = ShadowOptions {
        method,
        distance_m: Some(60.0),
        sun_side: 256,
        spot_side: 256,
        point_side: 128,
        layers_max: 16,
        ..ShadowOptions::default()
    };
    RendererOptions { size: SIZE, shadows, ..RendererOptions::default() }
}

/// Returns a ground with two blocks, and the objects between them.
fn boxes(blocks: usize) -> Vec<cull::Aabb> {
    let mut boxes = vec![box_at(vec3(0.0, -0.5, 0.0), vec3(16.0, 0.5, 16.0))];
    let block = |x: f32| box_at(vec3(x, 2.0, -3.0), vec3(1.0, 2.0, 1.0));
    boxes.extend([-3.0, 4.0].map(block).into_iter().take(blocks));
    boxes
}

fn camera(away: Vec3) -> Camera {
    let eye = vec3(1.0, 6.0, 11.0);
    Camera {
        eye: eye + away,
        forward: (vec3(0.0, 0.0, -1.5) - eye).normalize(),
        ..shadow_scene::camera()
    }
}

/// Returns the number of pixels whose red differs much.
fn apart(a: &[[u8; 3]], b: &[[u8; 3]]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a[0].abs_diff(b[0]) > 16).count()
}

#[test]
fn what_is_cut_away_casts_no_shadow_by_maps() {
    run_on_all(|device| {
        let [sun, ..] = shadow_scene::lights();
        let shown = |blocks: usize, section: SectionPlanes| {
            let scene = shadow_scene::scene(&boxes(blocks), &[sun]);
            let mut shown = CutScene::new(device, &scene, options(ShadowMethod::Maps));
            shown.renderer.set_section_member(GROUND, SectionMember::Whole);
            // A plane that cuts nothing, for long enough that maps are kept: those of the same
            // passes must be drawn again.
            shown.renderer.set_section(planes(&[plane([-1.0, 0.0, 0.0], 100.0)])).unwrap();
            for _ in 0..KEPT_AFTER {
                shown.pixels(camera(Vec3::ZERO), Strategy::ANTUMBRA);
            }
            shown.renderer.set_section(section).unwrap();
            shown.pixels(camera(Vec3::ZERO), Strategy::ANTUMBRA)
        };
        let none = SectionPlanes::default();
        let left = planes(&[plane([-1.0, 0.0, 0.0], 2.0)]);
        let one = shown(1, none);
        let both = shown(2, none);
        assert!(apart(&one, &both) > 300, "the block and its shadow are small");
        assert!(apart(&one, &shown(2, left)) < 10);
        let lost = {
            let scene = shadow_scene::scene(&boxes(2), &[sun]);
            let mut shown = CutScene::new(device, &scene, options(ShadowMethod::Volumes));
            shown.renderer.set_section(left).unwrap();
            shown.renderer.degradations()
        };
        assert_eq!(lost.planes_without_shadows, 1);
    });
}

#[test]
fn what_is_cut_away_casts_its_shadow_by_volumes_whether_casters_are_culled_or_not() {
    run_on_all(|device| {
        let [sun, ..] = shadow_scene::lights();
        let shown = |blocks: usize, culling: CasterCulling| {
            let scene = shadow_scene::scene(&boxes(blocks), &[sun]);
            let mut options = options(ShadowMethod::Volumes);
            options.shadows.culling = culling;
            let mut shown = CutScene::new(device, &scene, options);
            shown.renderer.set_section_member(GROUND, SectionMember::Whole);
            shown.renderer.set_section(planes(&[plane([-1.0, 0.0, 0.0], 2.0)])).unwrap();
            let draw = |strategy| shown.pixels(camera(Vec3::ZERO), strategy);
            let images = [Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::ANTUMBRA].map(draw);
            assert!(images.iter().all(|image| *image == images[0]), "{culling:?}");
            images.into_iter().next().unwrap()
        };
        let unculled = shown(2, CasterCulling::Unculled);
        assert!(apart(&unculled, &shown(1, CasterCulling::Unculled)) > 100, "a small shadow");
        assert!(shown(2, CasterCulling::Culled) == unculled);
    });
}

/// Returns images of a cut scene at a distant place, by several strategies.
fn images(device: &Device, away: Vec3) -> Vec<Vec<[u8; 3]>> {
    let moved = |bounds: cull::Aabb| cull::Aabb::new(bounds.min + away, bounds.max + away);
    let boxes: Vec<cull::Aabb> = boxes(2).into_iter().map(moved).collect();
    let lights = shadow_scene::lights().map(|mut light| {
        light.position = light.position.round() + away;
        light
    });
    let normal = DVec3::new(-0.2, -0.5, -0.8);
    let offset_m = 1.2 - normal.dot(away.as_dvec3());
    let section = planes(&[plane(normal.to_array(), offset_m)]);
    // The texels of a sun's maps lie elsewhere.
    let scene = shadow_scene::scene(&boxes, &lights[1..]);
    let mut images = Vec::new();
    for method in [ShadowMethod::Off, ShadowMethod::Maps, ShadowMethod::Volumes] {
        let mut shown = CutScene::new(device, &scene, options(method));
        shown.renderer.set_section(section).unwrap();
        let draw = |strategy| shown.pixels(camera(away), strategy);
        let drawn = [Strategy::FRUSTUM, Strategy::ANTUMBRA, Strategy::ANTUMBRA].map(draw);
        assert!(drawn.iter().all(|image| *image == drawn[0]), "{method:?} {away}");
        images.extend(drawn);
    }
    images
}

#[test]
fn a_cut_model_far_from_the_origin_looks_the_same() {
    run_on_all(|device| {
        let here = images(device, Vec3::ZERO);
        for away in [vec3(35_360.0, 12.0, -35_360.0), vec3(-707_120.0, 300.0, 707_120.0)] {
            for (number, (a, b)) in here.iter().zip(images(device, away)).enumerate() {
                let wrong = a.iter().zip(&b).filter(|(a, b)| a != b).count();
                // The border of a cut or a line may move to the other side of a pixel's middle.
                assert!(wrong <= 12, "{away}, image {number}: {wrong}");
            }
        }
    });
}
