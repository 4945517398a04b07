//! Shadow maps against ray casting: both agree wherever no edge of a shadow is near.

use cull::{Aabb, Camera, Strategy};
use glam::{Vec3, vec3};
use scene::PunctualLight;
use shadows::{ShadowBias, ShadowFilter, ShadowOptions};
use tests::box_rays::{is_blocked, shown_at, towards};
use tests::{run_on_all, shadow_scene};

use super::{SIZE, image, renderer, shadows};

/// Returns the point at a pixel, unless an edge is near.
fn shown(boxes: &[Aabb], camera: &Camera, x: u32, y: u32) -> Option<(Vec3, Vec3)> {
    let at = |right: f32, down: f32| {
        shown_at(boxes, camera, SIZE, [x as f32 + 0.5 + right, y as f32 + 0.5 + down])
    };
    let middle = at(0.0, 0.0)?;
    let around = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let is_same = |[right, down]: [f32; 2]| {
        at(right, down).is_some_and(|(place, normal)| {
            normal == middle.1 && (place - middle.0).dot(normal).abs() < 1e-3
        })
    };
    around.into_iter().all(is_same).then_some(middle)
}

/// The width (metres) around a place that must be lit or dark as a whole, which is larger than the
/// texels of these maps on these slopes.
const APART_M: f32 = 0.2;

/// Returns true if a place gets the light, false if it does not, `None` near an edge.
fn is_lit(boxes: &[Aabb], light: &PunctualLight, place: Vec3, normal: Vec3) -> Option<bool> {
    let (a, b) = normal.any_orthonormal_pair();
    let around = (-2..=2).flat_map(|x| (-2..=2).map(move |y| (x as f32 * 0.5, y as f32 * 0.5)));
    let mut seen = around.map(|(x, y)| {
        let near = place + (a * x + b * y) * APART_M + normal * 1e-3;
        let (along, end) = towards(light, near);
        !is_blocked(boxes, near, along, end)
    });
    let first = seen.next()?;
    seen.all(|other| other == first).then_some(first)
}

/// The number of pixels that are compared with rays.
pub struct Judged {
    pub checked: u32,
    pub dark: u32,
    /// Descriptions of the pixels that differ from rays.
    pub wrong: Vec<String>,
}

/// Compares an image of boxes with rays wherever no edge is near. `lit` is the image without
/// shadows.
pub fn judge(
    boxes: &[Aabb],
    camera: &Camera,
    light: &PunctualLight,
    lit: &[u8],
    shadowed: &[u8],
) -> Judged {
    let mut judged = Judged { checked: 0, dark: 0, wrong: Vec::new() };
    for (number, (lit, found)) in lit.chunks(4).zip(shadowed.chunks(4)).enumerate() {
        let x = number as u32 % SIZE[0];
        let y = number as u32 / SIZE[0];
        let Some((place, normal)) = shown(boxes, camera, x, y) else { continue };
        let (along, _) = towards(light, place);
        // Grazing or very weak light does not show.
        let is_bright = lit[0] > 120 && along.normalize().dot(normal) > 0.15;
        let Some(expected) = is_lit(boxes, light, place, normal).filter(|_| is_bright) else {
            continue;
        };
        judged.checked += 1;
        judged.dark += u32::from(!expected);
        // The two passes are compiled separately, so the last bit may be rounded differently.
        let is_lit = lit.iter().zip(found).all(|(lit, found)| lit.abs_diff(*found) <= 1);
        if is_lit != expected {
            judged.wrong.push(format!("{x}, {y} at {place}: {lit:?} became {found:?}"));
        }
    }
    judged
}

#[test]
fn maps_agree_with_ray_casting_away_from_edges() {
    run_on_all(|device| {
        let boxes = shadow_scene::boxes();
        let camera = shadow_scene::camera();
        let both = [ShadowBias::Plane, ShadowBias::Midpoint];
        let cases =
            shadow_scene::lights().into_iter().flat_map(|light| both.map(|bias| (light, bias)));
        for (light, bias) in cases {
            let scene = shadow_scene::scene(&boxes, &[light]);
            let options = ShadowOptions {
                bias,
                filter: ShadowFilter::Single,
                distance_m: Some(40.0),
                sun_side: 1024,
                spot_side: 1024,
                point_side: 512,
                ..shadows()
            };
            let mut renderer = renderer(device, &scene, options);
            let mut view = renderer.new_view().unwrap();
            let shadowed = image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            renderer.set_shadows(ShadowOptions::default()).unwrap();
            let lit = image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera);
            let Judged { checked, dark, wrong } = judge(&boxes, &camera, &light, &lit, &shadowed);
            assert!(wrong.is_empty(), "{bias:?} under {:?}: {wrong:#?}", light.kind);
            assert!(checked > 500 && dark > 10, "{checked} places, {dark} dark: {:?}", light.kind);
        }
    });
}

#[test]
fn nothing_shadows_itself() {
    run_on_all(|device| {
        let [sun, spot, point] = shadow_scene::lights();
        let along = |direction: Vec3| PunctualLight { direction: direction.normalize(), ..sun };
        let lights = [
            along(vec3(-0.5, -0.8, -0.3)),
            along(vec3(0.9, -0.4, 0.1)),
            along(vec3(0.02, -1.0, 0.01)),
            spot,
            point,
        ];
        for (number, light) in lights.into_iter().enumerate() {
            let mut renderer = renderer(
                device,
                &shadow_scene::scene(&[shadow_scene::GROUND], &[light]),
                shadows(),
            );
            let mut view = renderer.new_view().unwrap();
            let mut draw = |options| {
                renderer.set_shadows(options).unwrap();
                image(&mut renderer, &mut view, Strategy::ANTUMBRA, shadow_scene::camera())
            };
            let lit = draw(ShadowOptions::default());
            // Over all lights, each filter meets each bias.
            let both = [ShadowBias::Plane, ShadowBias::Midpoint].into_iter().cycle();
            for (filter, bias) in ShadowFilter::ALL.into_iter().zip(both.skip(number % 2)) {
                let shadowed = draw(ShadowOptions { filter, bias, ..shadows() });
                // The two passes are compiled separately, so the last bit may be rounded
                // differently.
                let wrong = lit.iter().zip(&shadowed).filter(|(a, b)| a.abs_diff(**b) > 1).count();
                assert_eq!(wrong, 0, "{filter:?}, {bias:?} under {light:?}");
            }
        }
    });
}
