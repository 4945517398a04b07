//! Tests properties of the frustum test and the margin, over random projections.

use antumbra_cull::{
    Aabb, Camera, ClipY, Containment, CullView, DepthConvention, PlaneMask, Projection,
};
use glam::{DVec2, DVec4, Vec2, Vec3};
use proptest::prelude::*;

use crate::optics::Optics;
use crate::random::Random;
use crate::raster::ClipBox;

/// Returns a view of any kind, and a direction of sight that is not an axis.
fn view() -> impl Strategy<Value = CullView> {
    (camera(), optics(), [16_u32..2000, 16..2000], prop_oneof![Just(4_u32), Just(8)])
        .prop_map(|(camera, optics, size, bits)| optics.view(&camera, 3, size, bits))
}

fn camera() -> impl Strategy<Value = Camera> {
    let projection = prop_oneof![
        (0.2_f32..2.2).prop_map(Projection::perspective),
        (0.5_f32..90.0, 100.0_f32..300.0)
            .prop_map(|(height, far)| Projection::Orthographic { height, far }),
    ];
    (
        [-20.0_f32..20.0, -20.0..20.0, -20.0..20.0],
        [-1.0_f32..1.0, -0.8..0.8, -1.0..1.0],
        projection,
        0.01_f32..1.0,
    )
        .prop_map(|(eye, forward, projection, near)| Camera {
            eye: Vec3::from_array(eye),
            forward: Vec3::from_array(forward),
            up: Vec3::Y,
            projection,
            near,
        })
}

fn optics() -> impl Strategy<Value = Optics> {
    (
        prop_oneof![Just(DepthConvention::Reversed), Just(DepthConvention::Standard)],
        prop_oneof![Just(ClipY::Down), Just(ClipY::Up)],
        prop_oneof![Just(None), (100.0_f32..500.0).prop_map(Some)],
        [-0.9_f32..0.9, -0.9..0.9],
        prop_oneof![Just(0.0_f32), Just(0.5)],
        prop_oneof![Just(1.0_f32), 0.01_f32..100.0],
    )
        .prop_map(|(depth, y, far, off_centre, jitter, scale)| Optics {
            depth,
            y,
            far,
            off_centre: off_centre.into(),
            jitter,
            scale,
        })
}

fn small_box() -> impl Strategy<Value = Aabb> {
    ([-60.0_f32..60.0, -60.0..60.0, -60.0..60.0], [0.0_f32..9.0, 0.0..9.0, 0.0..9.0]).prop_map(
        |(min, size)| {
            let min = Vec3::from_array(min);
            Aabb::new(min, min + Vec3::from_array(size))
        },
    )
}

/// Returns the clip coordinates of a point of an object, computed as in its shader.
fn clip(view: &CullView, point: Vec3) -> DVec4 {
    (view.from_anchor * (point - view.anchor).extend(1.0)).as_dvec4()
}

/// Returns half of the image's size (pixels).
fn half_size(view: &CullView) -> DVec2 {
    DVec2::new(view.size[0].into(), view.size[1].into()) * 0.5
}

/// Returns the position of a point of an object on the screen (pixels).
fn project(view: &CullView, point: Vec3) -> DVec2 {
    let clip = clip(view, point);
    (clip.truncate().truncate() / clip.w + 1.0) * half_size(view)
}

/// Returns the depth of a point of an object as a rasteriser stores it; larger is nearer.
fn depth(view: &CullView, point: Vec3) -> f64 {
    let clip = clip(view, point);
    clip.z / clip.w * f64::from(view.depth.sign())
}

/// Returns the depth at the near plane; larger is nearer.
fn near_depth(view: &CullView) -> f64 {
    f64::from(view.depth.nearest() * view.depth.sign())
}

/// Returns the depth of a proxy at a position on the screen; larger is nearer.
fn proxy_depth(view: &CullView, proxy: &Aabb, position: DVec2) -> Option<f64> {
    let clip_box = ClipBox::of_proxy(view, proxy);
    let points = clip_box.points(position / half_size(view) - 1.0);
    points.map(|point| point.z / point.w * f64::from(view.depth.sign())).reduce(f64::max)
}

/// Returns a point on the screen: its position (0 to 1 from the upper left) and its view depth
/// (metres).
fn on_screen() -> impl Strategy<Value = [f32; 3]> {
    [0.0_f32..1.0, 0.0..1.0, 1.01..90.0]
}

/// Returns the world position of a point on the screen.
fn unproject(view: &CullView, point: [f32; 3]) -> Vec3 {
    let [x, y, depth] = point;
    view.rays.point(Vec2::new(x, y) * 2.0 - 1.0, depth)
}

/// Returns two corners at this distance from a point.
fn reach() -> impl Strategy<Value = [[f32; 3]; 2]> {
    let axis = || prop_oneof![Just(0.0_f32), 0.0_f32..9.0];
    [[axis(), axis(), axis()], [axis(), axis(), axis()]]
}

fn around(point: Vec3, low: [f32; 3], high: [f32; 3], scale: f32) -> Aabb {
    let [low, high] = [low, high].map(|reach| Vec3::from_array(reach) * scale);
    Aabb::new(point - low, point + high)
}

/// Returns true if a proxy covers a corner of its object on the screen and is not deeper.
fn covers(view: &CullView, corner: Vec3, proxy: &Aabb) -> bool {
    let there = proxy_depth(view, proxy, project(view, corner));
    there.is_some_and(|there| there >= depth(view, corner))
}

/// Checks that a proxy covers its object if both are drawn with their own matrices, and that it
/// would not without the term for coordinates, in a world at the origin and far from it.
#[test]
fn proxies_cover_objects_whose_matrix_is_another() {
    for (coordinate, scale, lost_min) in [(0.0, 1.0, 0), (1.0e5, 1.0, 2_000), (1.0e7, 100.0, 2_000)]
    {
        let mut random = Random::new(3);
        let mut checked = 0;
        let mut lost_without = 0;
        for round in 0..4_000 {
            let towards = random.point(-1.0, 1.0);
            let camera = Camera {
                eye: towards / towards.abs().max_element() * coordinate,
                forward: random.point(-1.0, 1.0),
                up: Vec3::Y,
                projection: Projection::perspective(random.between(0.2, 2.0)),
                near: 0.1 * scale,
            };
            let view = CullView::new(&camera, [1280, 720], 8);
            let ndc = random.point(-1.0, 1.0).truncate();
            let middle = view.rays.point(ndc, random.between(3.0, 30.0) * scale);
            let half = random.point(0.1, 2.0) * scale;
            let bounds = Aabb::new(middle - half, middle + half);
            let Some(proxy) = view.margin.proxy(&bounds) else { continue };
            let depths_m = bounds.corners().map(|corner| view.rays.depth_m(corner));
            let farthest_m = depths_m.into_iter().fold(0.0, f32::max);
            let [per_w, _] = view.margin.metres();
            let without = bounds.enlarged(per_w * farthest_m);
            for corner in bounds.corners() {
                checked += 1;
                assert!(covers(&view, corner, &proxy), "{round}: {camera:?} {bounds:?}");
                lost_without += u32::from(!covers(&view, corner, &without));
            }
        }
        println!("{coordinate} m: {lost_without} of {checked} corners need the term");
        assert!(checked > 5_000 && lost_without >= lost_min, "{lost_without} of {checked}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Checks that a box with a point on the screen is never outside, including with the masks of a
    /// parent.
    #[test]
    fn nothing_on_the_screen_is_rejected(
        view in view(),
        at in on_screen(),
        reach in reach(),
        parent in small_box(),
    ) {
        let bounds = around(unproject(&view, at), reach[0], reach[1], 1.0);
        let (above, mask) = view.frustum.classify(&parent.union(&bounds), PlaneMask::ALL);
        prop_assert_ne!(above, Containment::Outside);
        prop_assert_ne!(view.frustum.classify(&bounds, mask).0, Containment::Outside);
        prop_assert_ne!(view.frustum.classify(&bounds, PlaneMask::ALL).0, Containment::Outside);
    }

    /// Checks that all corners of a box inside of all planes are on the screen.
    #[test]
    fn what_is_inside_is_on_the_screen(view in view(), at in on_screen(), reach in reach()) {
        let bounds = around(unproject(&view, at), reach[0], reach[1], 0.1);
        let (containment, _) = view.frustum.classify(&bounds, PlaneMask::ALL);
        if containment != Containment::Inside {
            return Ok(());
        }
        let size = DVec2::new(view.size[0].into(), view.size[1].into());
        for corner in bounds.corners() {
            let pixel = project(&view, corner);
            prop_assert!(depth(&view, corner) < near_depth(&view) + 1.0e-3);
            prop_assert!(pixel.cmpge(DVec2::splat(-0.01)).all());
            prop_assert!(pixel.cmple(size + 0.01).all());
        }
    }

    /// Checks the claim of the margin: if a point of the object moves on the screen by a step of
    /// the grid, and the ray by another, the proxy still covers the point and is nearer, even if
    /// depths are rounded to 32 bits.
    #[test]
    fn snapping_loses_no_sample(
        (camera, optics, size) in (camera(), optics(), [16_u32..2000, 16..2000]),
        (seen, reach) in (on_screen(), reach()),
        bits in prop_oneof![Just(4_i32), Just(8)],
        at in [0.0_f32..=1.0, 0.0..=1.0, 0.0..=1.0],
        onto in 0_usize..3,
        angles in [0.0_f64..6.3, 0.0..6.3],
    ) {
        let view = optics.view(&camera, 5, size, bits as u32);
        let bounds = around(unproject(&view, seen), reach[0], reach[1], 0.5);
        let Some(proxy) = view.margin.proxy(&bounds) else {
            return Ok(());
        };
        // On the surface, where the bound is tightest.
        let mut at = Vec3::from_array(at);
        at[onto] = at[onto].round();
        let point = bounds.min + (bounds.max - bounds.min) * at;
        let point = point.clamp(bounds.min, bounds.max);
        let pixel = project(&view, point);
        let step = std::f64::consts::SQRT_2 * 0.5_f64.powi(bits);
        let sample = angles
            .iter()
            .fold(pixel, |position, angle| position + DVec2::from_angle(*angle) * step);
        let nearer = proxy_depth(&view, &proxy, sample);
        prop_assert!(nearer.is_some(), "{:?} at {} missed by {:?}", point, sample, proxy);
        let nearer = nearer.unwrap();
        prop_assert!(nearer <= near_depth(&view), "the near plane cuts the proxy");
        // Four units in the last place for both depths.
        let constant = f64::from(view.rays.depth[0]);
        let own = depth(&view, point);
        let terms = constant.abs() + (own * f64::from(view.depth.sign()) - constant).abs();
        let rounding = 8.0 * f64::from(f32::EPSILON) * terms;
        prop_assert!(nearer >= own + rounding, "{nearer} {own} {rounding}");
    }

    /// Checks that boxes with a proxy are completely beyond the near plane, and that nearer boxes
    /// have none.
    #[test]
    fn proxies_are_beyond_the_near_plane(view in view(), bounds in small_box()) {
        let ahead = |bounds: &Aabb| {
            bounds.corners().iter().all(|corner| view.rays.depth_m(*corner) > view.rays.near)
        };
        match view.margin.proxy(&bounds) {
            Some(proxy) => prop_assert!(ahead(&proxy) && proxy.contains(&bounds)),
            None => {
                let behind = bounds.enlarged(0.5 + 1.0e-4 * bounds.largest_coordinate());
                let [margin, _] = view.margin.metres();
                if margin < 0.001 {
                    prop_assert!(!ahead(&behind));
                }
            }
        }
    }
}
