//! Shadow volumes against ray casting: both agree at every pixel that is farther than one pixel
//! from an edge.

use cull::{Aabb, Camera, Strategy};
use glam::{Vec3, vec3};
use scene::PunctualLight;
use shadows::ShadowOptions;
use tests::box_rays::{is_blocked, shown_at, towards};
use tests::{run_on_all, shadow_scene};

use super::{SIZE, image, renderer, volumes};

/// The point at a pixel, its normal, and true if no box lies between the point and the light.
#[derive(Clone, Copy)]
struct Seen {
    place: Vec3,
    normal: Vec3,
    is_lit: bool,
}

impl Seen {
    fn at(boxes: &[Aabb], camera: &Camera, light: &PunctualLight, pixel: [u32; 2]) -> Option<Self> {
        let middle = pixel.map(|side| side as f32 + 0.5);
        let (place, normal) = shown_at(boxes, camera, SIZE, middle)?;
        let from = place + normal * 1e-3;
        let (along, end) = towards(light, from);
        Some(Self { place, normal, is_lit: !is_blocked(boxes, from, along, end) })
    }

    /// Returns true for a point on the same face in the same light.
    fn is_as(&self, other: &Self) -> bool {
        let is_face =
            self.normal == other.normal && (self.place - other.place).dot(self.normal).abs() < 1e-3;
        is_face && self.is_lit == other.is_lit
    }
}

/// Returns cameras over the yard, in the shadow of the roof, in the shadow of the wall and close to
/// it, and with a near plane across edges of shadows.
fn cameras() -> [Camera; 5] {
    let look = |eye: Vec3, at: Vec3, near: f32| Camera {
        eye,
        forward: (at - eye).normalize(),
        near,
        ..shadow_scene::camera()
    };
    [
        shadow_scene::camera(),
        look(vec3(6.5, 1.2, 0.6), vec3(0.0, 0.6, -4.0), 0.1),
        look(vec3(-6.0, 0.4, -6.6), vec3(-3.0, 0.1, -12.0), 0.05),
        look(vec3(0.3, 1.5, 3.4), vec3(1.0, 0.3, -3.0), 1.0),
        look(vec3(-1.0, 9.0, -2.0), vec3(0.5, 0.0, -3.0), 2.0),
    ]
}

#[test]
fn volumes_agree_with_ray_casting_one_pixel_from_edges() {
    run_on_all(|device| {
        let boxes = shadow_scene::boxes();
        let mut by_light = Vec::new();
        for light in shadow_scene::lights() {
            let scene = shadow_scene::scene(&boxes, &[light]);
            let mut renderer = renderer(device, &scene, volumes());
            let mut view = renderer.new_view().unwrap();
            let mut draw = |options| {
                renderer.set_shadows(options).unwrap();
                cameras().map(|camera| image(&mut renderer, &mut view, Strategy::ANTUMBRA, camera))
            };
            let shadowed = draw(volumes());
            let lit = draw(ShadowOptions::default());
            let mut checked = 0;
            let mut dark = 0;
            for (camera, (lit, shadowed)) in cameras().iter().zip(lit.iter().zip(&shadowed)) {
                let [of_camera, in_shadow] = judge(&boxes, camera, &light, lit, shadowed);
                (checked, dark) = (checked + of_camera, dark + in_shadow);
            }
            by_light.push((checked, dark));
        }
        let is_enough = |(checked, dark): &(u32, u32)| *checked > 3_000 && *dark > 1_000;
        assert!(by_light.iter().all(is_enough), "{by_light:?}");
    });
}

/// Compares an image with rays. Returns the numbers of compared pixels and of pixels in shadow.
fn judge(
    boxes: &[Aabb],
    camera: &Camera,
    light: &PunctualLight,
    lit: &[u8],
    shadowed: &[u8],
) -> [u32; 2] {
    let pixels = (0..SIZE[0] * SIZE[1]).map(|at| [at % SIZE[0], at / SIZE[0]]);
    let seen: Vec<_> = pixels.map(|pixel| Seen::at(boxes, camera, light, pixel)).collect();
    let mut judged = [0, 0];
    let mut wrong = Vec::new();
    for y in 1..SIZE[1] - 1 {
        for x in 1..SIZE[0] - 1 {
            let at = |x: u32, y: u32| seen[(y * SIZE[0] + x) as usize];
            let Some(here) = at(x, y) else { continue };
            let mut around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| at(x, y)));
            let is_even =
                around.all(|neighbour| neighbour.is_some_and(|neighbour| neighbour.is_as(&here)));
            let (along, _) = towards(light, here.place);
            let place = (y * SIZE[0] + x) as usize * 4;
            let [lit, found] = [lit, shadowed].map(|image| &image[place..place + 4]);
            // Grazing or very weak light does not show.
            let is_bright = lit[0] > 120 && along.normalize().dot(here.normal) > 0.05;
            if !is_even || !is_bright {
                continue;
            }
            judged = [judged[0] + 1, judged[1] + u32::from(!here.is_lit)];
            // The two passes are compiled separately, so the last bit may be rounded differently.
            let is_lit = lit.iter().zip(found).all(|(lit, found)| lit.abs_diff(*found) <= 1);
            if is_lit != here.is_lit {
                wrong.push(format!("{x}, {y} at {}: {lit:?} became {found:?}", here.place));
            }
        }
    }
    let eye = camera.eye;
    assert!(wrong.is_empty(), "{} from {eye}, {:?}: {wrong:#?}", wrong.len(), light.kind);
    judged
}
