//! Faces: the views from which lights are drawn.

use std::f32::consts::PI;

use cull::{
    Aabb, Anchor, Camera, Containment, CullView, Hierarchy, LeafIndex, NodeId, PlaneMask,
    Projection, trigonometry,
};
use glam::{DVec3, Vec3};

use crate::light::{LightShape, ShadowLight, ShadowLightId, WIDEST_CONE_RAD};
use crate::options::ShadowOptions;

/// The identity of a face: the light, the number of the face, and for directional lights the view
/// of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId {
    /// The light.
    pub light: ShadowLightId,
    /// The view of the scene; 0 for lights that are not directional.
    pub view: u32,
    /// The number of the cascade, from the nearest on, or of the side of the cube (+x, -x, +y, -y,
    /// +z, -z).
    pub number: u32,
}

/// One view from a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// The identity of the face.
    pub id: FaceId,
    /// The light's view: depth is reversed; the image is as large as the face's map.
    pub view: CullView,
    /// The sphere in which a local light's shadows matter: centre and radius in metres.
    pub reach: Option<(Vec3, f32)>,
}

impl Face {
    /// Returns true if a box may be in the face's map.
    #[must_use]
    pub fn sees(&self, bounds: &Aabb) -> bool {
        !bounds.is_empty()
            && self.is_reached(bounds)
            && self.view.frustum.classify(bounds, PlaneMask::ALL).0 != Containment::Outside
    }

    fn is_reached(&self, bounds: &Aabb) -> bool {
        self.reach
            .is_none_or(|(centre, radius_m)| bounds.distance_squared(centre) <= radius_m * radius_m)
    }

    /// Adds the leaves of a hierarchy that may be in the face's map, in their order.
    pub fn casters(&self, hierarchy: &Hierarchy, found: &mut Vec<LeafIndex>) {
        let mut open: Vec<(NodeId, PlaneMask)> =
            hierarchy.root().map(|root| (root, PlaneMask::ALL)).into_iter().collect();
        while let Some((node, mask)) = open.pop() {
            let bounds = hierarchy.bounds(node);
            if bounds.is_empty() || !self.is_reached(&bounds) {
                continue;
            }
            let (containment, mask) = self.view.frustum.classify(&bounds, mask);
            match (containment, hierarchy.children(node)) {
                (Containment::Outside, _) => {}
                (_, Some([left, right])) => open.extend([(right, mask), (left, mask)]),
                (_, None) => found.push(hierarchy.leaves(node).first),
            }
        }
    }
}

/// The distance of the near plane of a local light, in metres.
const NEAR_M: f32 = 0.02;

/// The share by which a local light's map reaches beyond its cone or side of the cube, so that
/// filters have texels at the edge.
const BORDER: f32 = 1.0 / 8.0;

/// The ratio of the reaches of two neighbouring cascades.
pub(crate) const CASCADE_RATIO: f32 = 3.0;

/// The number of steps per side in which a cascade follows the eye. The cascade stays unchanged
/// while the eye moves within a step, and moves by whole texels.
const STEPS_PER_SIDE: u32 = 16;

/// The six sides of a cube: forward and up directions.
const SIDES: [(Vec3, Vec3); 6] = [
    (Vec3::X, Vec3::Y),
    (Vec3::NEG_X, Vec3::Y),
    (Vec3::Y, Vec3::Z),
    (Vec3::NEG_Y, Vec3::Z),
    (Vec3::Z, Vec3::Y),
    (Vec3::NEG_Z, Vec3::Y),
];

/// The scene around a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceSurroundings<'a> {
    /// The eyes of the scene's views.
    pub eyes: &'a [Vec3],
    /// The box around the scene.
    pub scene: Aabb,
    /// The distance from an eye up to which directional lights have shadows, in metres.
    pub sun_distance_m: f32,
    /// The bits of the device's sub-pixel grid (Vulkan's `subPixelPrecisionBits`).
    pub sub_pixel_bits: u32,
}

/// Returns the number of faces of a light, for this number of views of the scene.
#[must_use]
pub fn face_count(shape: &LightShape, options: &ShadowOptions, views: usize) -> u32 {
    match shape {
        LightShape::Sun { .. } => options.cascades * views as u32,
        LightShape::Spot { outer_rad, .. } if *outer_rad <= WIDEST_CONE_RAD => 1,
        LightShape::Spot { .. } | LightShape::Point { .. } => 6,
    }
}

/// Returns the wanted side of a light's maps, in texels.
#[must_use]
pub fn wanted_side(shape: &LightShape, options: &ShadowOptions) -> u32 {
    match shape {
        LightShape::Sun { .. } => options.sun_side,
        LightShape::Spot { outer_rad, .. } if *outer_rad <= WIDEST_CONE_RAD => options.spot_side,
        LightShape::Spot { .. } | LightShape::Point { .. } => options.point_side,
    }
}

/// Calls `found` for each face of a light whose maps have a side of `side` texels, in the order of
/// their numbers; for a directional light view by view.
pub fn faces_of(
    light: &ShadowLight,
    options: &ShadowOptions,
    side: u32,
    around: &FaceSurroundings<'_>,
    mut found: impl FnMut(Face),
) {
    let bits = around.sub_pixel_bits;
    let id = |view, number| FaceId { light: light.id, view, number };
    let local = |number, camera: Camera, reach| Face {
        id: id(0, number),
        view: CullView::new(&camera, [side; 2], bits),
        reach: Some(reach),
    };
    match light.shape {
        LightShape::Sun { towards } => {
            for (view, eye) in (0..).zip(around.eyes) {
                for number in 0..options.cascades {
                    let reach_m = cascade_reach_m(around.sun_distance_m, options.cascades, number);
                    let reach_m = reach_m + light.penumbra_m;
                    let place = cascade(-towards, *eye, reach_m, side, &around.scene);
                    let Cascade { camera, anchor } = place;
                    let view_of_sun = CullView::anchored(&camera, Some(anchor), [side; 2], bits);
                    found(Face { id: id(view, number), view: view_of_sun, reach: None });
                }
            }
        }
        LightShape::Spot { position, direction, outer_rad, reach_m }
            if outer_rad <= WIDEST_CONE_RAD =>
        {
            let up = direction.any_orthonormal_vector();
            let camera = from_point(position, direction, up, trigonometry::tan(outer_rad));
            found(local(0, camera, (position, reach_m)));
        }
        LightShape::Spot { position, reach_m, .. } | LightShape::Point { position, reach_m } => {
            for (number, (forward, up)) in (0..).zip(SIDES) {
                found(local(number, from_point(position, forward, up, 1.0), (position, reach_m)));
            }
        }
    }
}

/// Returns the distance from the eye to which a cascade reaches, in metres. The last of `cascades`
/// cascades reaches to `distance_m`.
#[must_use]
pub fn cascade_reach_m(distance_m: f32, cascades: u32, number: u32) -> f32 {
    let farther = cascades.saturating_sub(number + 1);
    distance_m / CASCADE_RATIO.powi(farther as i32)
}

fn from_point(position: Vec3, forward: Vec3, up: Vec3, tangent: f32) -> Camera {
    let fov_y = 2.0 * trigonometry::atan(tangent * (1.0 + BORDER));
    let projection = Projection::Perspective { fov_y: fov_y.min(PI - 0.1) };
    Camera { eye: position, forward, up, projection, near: NEAR_M }
}

/// The place of a cascade.
struct Cascade {
    camera: Camera,
    anchor: Anchor,
}

/// Returns the place of a cascade: a square of texels around the eye, whose middle moves in steps
/// of whole texels. It depends on the eye's position but not on its direction, so turning changes
/// nothing. It contains the depths of the whole scene, so it holds casters behind the eye.
///
/// The steps are counted from the origin of the world, wherever the eye is. They are computed in
/// double precision, along axes that are perpendicular and of unit length in double precision: the
/// error of single precision would be many texels at a distance of a million metres. The anchor
/// lies near the eye. It changes with the middle, and when the eye moves by a side of the square
/// along the light.
fn cascade(forward: Vec3, eye: Vec3, reach_m: f32, side: u32, scene: &Aabb) -> Cascade {
    // The axes that `CullView::new` chooses for this direction.
    let right = forward.cross(forward.any_orthonormal_vector()).normalize();
    let camera_up = right.cross(forward);
    let forward_64 = forward.as_dvec3().normalize();
    let up = right.as_dvec3().cross(forward_64).normalize();
    let right = forward_64.cross(up);
    let step_texels = (side / STEPS_PER_SIDE).max(1);
    // The eye is up to half a step away from the middle.
    let half_m = reach_m / (1.0 - step_texels as f32 / side as f32);
    let step_m = f64::from(2.0 * half_m * step_texels as f32 / side as f32);
    let eye = eye.as_dvec3();
    let snapped_m = |along: DVec3, step_m: f64| (along.dot(eye) / step_m).round() * step_m;
    let right_m = snapped_m(right, step_m);
    let up_m = snapped_m(up, step_m);
    // The scene's depths change in steps, too; otherwise each moving object would change them.
    let centre = scene.centre().as_dvec3();
    let half = scene.half_extent().as_dvec3();
    let centre_m = forward_64.dot(centre);
    let spread_m = forward_64.abs().dot(half).max(0.5);
    let depth_step_m = (spread_m * 2.0).log2().ceil().exp2() / 8.0;
    let first_m = ((centre_m - spread_m) / depth_step_m - 0.25).floor() * depth_step_m;
    let last_m = ((centre_m + spread_m) / depth_step_m + 0.25).ceil() * depth_step_m;
    let middle = right * right_m + up * up_m;
    let side_m = f64::from(2.0 * half_m);
    let place = (middle + forward_64 * snapped_m(forward_64, side_m)).as_vec3();
    let placed = place.as_dvec3();
    let seen = DVec3::new(right.dot(placed), up.dot(placed), forward_64.dot(placed))
        - DVec3::new(right_m, up_m, first_m);
    let far = (last_m - first_m) as f32;
    Cascade {
        camera: Camera {
            eye: (middle + forward_64 * first_m).as_vec3(),
            forward,
            up: camera_up,
            projection: Projection::Orthographic { height: 2.0 * half_m, far },
            near: 0.0,
        },
        anchor: Anchor { place, seen },
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec4, vec3};

    use super::*;

    const SCENE: Aabb =
        Aabb { min: Vec3::new(-60.0, -1.0, -80.0), max: Vec3::new(90.0, 30.0, 70.0) };

    const SUN_DISTANCE_M: f32 = 200.0;

    fn surroundings(eyes: &[Vec3], scene: Aabb) -> FaceSurroundings<'_> {
        FaceSurroundings { eyes, scene, sun_distance_m: SUN_DISTANCE_M, sub_pixel_bits: 8 }
    }

    fn faces(shape: LightShape, eye: Vec3) -> Vec<Face> {
        let light = ShadowLight { id: ShadowLightId(7), shape, penumbra_m: 0.25 };
        let options = ShadowOptions::default();
        let side = wanted_side(&shape, &options);
        let eyes = [eye];
        let around = surroundings(&eyes, SCENE);
        let mut all = Vec::new();
        faces_of(&light, &options, side, &around, |face| all.push(face));
        assert_eq!(all.len() as u32, face_count(&shape, &options, 1));
        all
    }

    fn place(face: &Face, point: Vec3) -> Vec4 {
        let clip = face.view.clip(point).as_vec4();
        clip / clip.w.abs()
    }

    #[test]
    fn cascades_hold_what_is_within_their_reach() {
        let towards = vec3(0.4, 0.8, -0.3).normalize();
        let mut random = 1_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / (1 << 24) as f32
        };
        for _ in 0..500 {
            let eye = vec3(next() * 100.0 - 50.0, next() * 20.0, next() * 100.0 - 50.0);
            for (number, face) in (0..).zip(faces(LightShape::Sun { towards }, eye)) {
                let reach_m = cascade_reach_m(SUN_DISTANCE_M, 4, number);
                let away = vec3(next() - 0.5, next() - 0.5, next() - 0.5).normalize() * reach_m;
                let point = (eye + away).clamp(SCENE.min, SCENE.max);
                let inside = place(&face, point);
                assert!(inside.x.abs() <= 1.0 && inside.y.abs() <= 1.0, "{inside}");
                assert!((0.0..=1.0).contains(&inside.z), "{inside}");
            }
        }
    }

    #[test]
    fn cascades_move_by_whole_texels_and_seldom() {
        let towards = vec3(0.4, 0.8, -0.3).normalize();
        let at = |metres: f32| faces(LightShape::Sun { towards }, vec3(metres, 1.7, 3.0));
        let mut changes = [0; 4];
        for step in 0..400 {
            let [before, after] = [step, step + 1].map(|step| at(step as f32 * 0.05));
            for (number, (before, after)) in before.iter().zip(&after).enumerate() {
                let texels = |face: &Face| place(face, Vec3::ZERO).truncate() * 1024.0;
                let moved = texels(after) - texels(before);
                let off = (moved - moved.round()).abs();
                assert!(off.x < 0.02 && off.y < 0.02, "{moved}");
                changes[number] += u32::from(before.view != after.view);
            }
        }
        assert!(changes[0] < 60 && changes[3] < 6, "20 m in 400 frames: {changes:?}");
    }

    /// Checks that texels have the same places in the world wherever the eye is, even where single
    /// precision resolves only whole metres.
    #[test]
    fn far_away_cascades_are_as_exact_as_near_the_origin() {
        let towards = vec3(0.4, 0.8, -0.3).normalize();
        let light = ShadowLight {
            id: ShadowLightId(0),
            shape: LightShape::Sun { towards },
            penumbra_m: 0.0,
        };
        let options = ShadowOptions::default();
        for away in [vec3(35_360.0, 0.0, 2e4), vec3(12_958_155.0, 4_865_579.0, -3e5)] {
            let scene = Aabb::new(SCENE.min + away, SCENE.max + away);
            for step in 0..40 {
                let eyes = [step, step + 1].map(|step| away + vec3(step as f32, 2.0, 3.0));
                let [before, after] = eyes.map(|eye| {
                    let mut all = Vec::new();
                    let eyes = [eye];
                    let around = surroundings(&eyes, scene);
                    faces_of(&light, &options, 2048, &around, |face| all.push(face));
                    all
                });
                for (before, after) in before.iter().zip(&after) {
                    let texels = |face: &Face, point: DVec3| {
                        let near = point - face.view.anchor.as_dvec3();
                        let clip = face.view.from_anchor.as_dmat4() * near.extend(1.0);
                        clip.truncate() * DVec3::new(1024.0, 1024.0, 1.0)
                    };
                    let point = away.as_dvec3() + DVec3::new(4.3, 1.7, 2.9);
                    let moved = texels(after, point) - texels(before, point);
                    let off = (moved - moved.round()).abs();
                    assert!(off.x < 0.02 && off.y < 0.02, "{away}: {moved}");
                    let aside = point + towards.any_orthonormal_vector().as_dvec3();
                    let across = texels(before, aside) - texels(before, point);
                    let texel_m = 2.0 * before.view.rays.right.length() / 2048.0;
                    let expected = f64::from(texel_m).recip();
                    let found = across.truncate().length();
                    assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
                    let inside = texels(before, eyes[0].as_dvec3()).abs() / 1024.0;
                    assert!(inside.x <= 0.1 && inside.y <= 0.1, "around the eye: {inside}");
                }
            }
        }
    }

    #[test]
    fn turning_and_moving_objects_change_no_cascade() {
        let shape = LightShape::Sun { towards: Vec3::Y };
        let light = ShadowLight { id: ShadowLightId(0), shape, penumbra_m: 0.0 };
        let options = ShadowOptions::default();
        let view_in = |scene| {
            let around = surroundings(&[Vec3::ZERO], scene);
            let mut all = Vec::new();
            faces_of(&light, &options, 512, &around, |face| all.push(face.view));
            all
        };
        let grown = Aabb::new(SCENE.min, SCENE.max + vec3(0.3, 0.5, 0.2));
        assert_eq!(view_in(SCENE), view_in(grown));
    }

    #[test]
    fn a_cube_sees_every_direction_by_a_face_with_a_border() {
        let position = vec3(3.0, 2.0, 1.0);
        let all = faces(LightShape::Point { position, reach_m: 20.0 }, Vec3::ZERO);
        for (face, (forward, _)) in all.iter().zip(SIDES) {
            for corner in [-1.0_f32, 1.0] {
                let (a, b) = forward.any_orthonormal_pair();
                let seen = place(face, position + 5.0 * (forward + corner * (a + b)).normalize());
                assert!(seen.w > 0.0 && seen.truncate().is_finite());
            }
            let ahead = place(face, position + forward);
            assert!(ahead.x.abs() < 1e-5 && ahead.y.abs() < 1e-5);
            let edge = place(face, position + forward + forward.any_orthonormal_vector());
            let reach = edge.x.abs().max(edge.y.abs());
            assert!(reach < 1.0 && reach > 0.6, "{reach}");
        }
    }

    #[test]
    fn wide_cones_have_six_faces() {
        let spot = |outer_rad| LightShape::Spot {
            position: Vec3::ONE,
            direction: Vec3::NEG_Y,
            outer_rad,
            reach_m: 9.0,
        };
        assert_eq!(faces(spot(0.6), Vec3::ZERO).len(), 1);
        assert_eq!(faces(spot(1.5), Vec3::ZERO).len(), 6);
        let face = &faces(spot(0.6), Vec3::ZERO)[0];
        let rim = place(face, Vec3::ONE + vec3(0.6_f32.tan(), -1.0, 0.0) * 4.0);
        assert!(rim.x.abs().max(rim.y.abs()) < 1.0);
    }
}
