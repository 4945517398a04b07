//! Tests that share the result of another test: the tests of nodes that lie behind a hidden box and
//! within its outline.
//!
//! If no sample of a proxy shows, then at every sample that the proxy covers, the depth buffer is
//! nearer than the proxy's front. So an object shows no sample if the proxy covers all its samples
//! and the object lies completely beyond the proxy's front. Then the object needs no test of its
//! own: if the proxy in front stays hidden, so does the object. If the proxy shows, the leaves
//! behind it are tested individually.
//!
//! A ray from the eye has entered a box once it has passed the planes of all faces that the eye
//! sees from outside (the slab method). So every point on the inner side of these planes and within
//! the outline is beyond the front, inside of the box or behind it.
//!
//! The margin of the proxy behind covers rounding: its outline is at least a quarter of a pixel
//! wider than the samples of its object, and its nearest depth is nearer by the same (see
//! [`Margin`](crate::Margin)). The proxy in front loses less than this to the sub-pixel grid. But
//! the outline of the proxy in front is computed on the CPU and rasterized on the GPU, each with
//! its own rounding, and this error in pixels grows as the proxy gets nearer. So a box serves as a
//! front only if the error is at most a sixteenth of a pixel.
//!
//! In a plan for several views this holds in each view that may see the box behind: the front's
//! result is zero only if it shows in none of them.

use crate::geom::multi_view::MultiView;
use crate::plan::candidates::Candidate;
use crate::plan::frame_plan::{FramePlan, ProxyTest, QueryKind, VisibilityTest};
use crate::plan::fronts::{Fronts, SharedProxy};

/// The limits of sharing.
struct Limits {
    /// The least share of the image that a front must cover.
    front_area: f32,
    /// The most fronts; the largest are kept.
    fronts: usize,
    /// The most leaves behind one front: all of them are tested individually if it shows.
    leaves_behind: u32,
    /// The most leaves behind one front per frame that the front has been hidden; an unknown node
    /// has no leaves behind it. A node that was hidden only briefly is the most likely to show.
    leaves_behind_per_frame: u32,
}

/// The limits in use. Halving or doubling any of them changes no count of a walk by more than 1 %
/// (docs/lab/cull_config.md).
const LIMITS: Limits =
    Limits { front_area: 0.002, fronts: 48, leaves_behind: 4_096, leaves_behind_per_frame: 64 };

/// Makes tests of `plan` share the results of other tests where possible. `candidates` are the
/// candidates that the tests were made from. `fronts` keeps its memory.
pub(crate) fn share_proxies(
    plan: &mut FramePlan,
    candidates: &[Candidate],
    views: MultiView<'_>,
    fronts: &mut Fronts,
) {
    let hidden_frames = candidates.iter().map(|test| test.hidden_frames);
    plan.stats.shared_proxies =
        share_in_order(&mut plan.tests, hidden_frames, views, &LIMITS, fronts);
}

/// Makes tests share the results of others, front to back, and requests individual tests of their
/// leaves. Returns the number of such tests.
///
/// `hidden_frames` holds, for each test, the number of frames for which its node has been hidden,
/// if it is known to be hidden. A node that was hidden for n frames shows in the next frame with a
/// probability of about 1 / n (Laplace's rule of succession). So the number of leaves behind a
/// front may grow with n, while the expected cost of a front that shows does not. `fronts` keeps
/// its memory.
fn share_in_order(
    tests: &mut [ProxyTest],
    hidden_frames: impl Iterator<Item = Option<u32>>,
    views: MultiView<'_>,
    limits: &Limits,
    fronts: &mut Fronts,
) -> u32 {
    fronts.clear();
    let mut behind = 0;
    let [width, height] = views.first().size.map(|pixels| pixels as f32);
    let least_area = limits.front_area * width * height * views.as_slice().len() as f32;
    for ((number, test), hidden_frames) in (0..).zip(tests).zip(hidden_frames) {
        if test.tester != VisibilityTest::Flag || test.leaves.count == 0 {
            continue;
        }
        if !fronts.look_at(&test.bounds, views) {
            continue;
        }
        let leaves = test.leaves.count;
        if let Some(front) = fronts.before(&test.bounds, leaves, views) {
            front.leaves_behind += leaves;
            test.tester = VisibilityTest::SharedProxy(front.test);
            test.tag.kind = QueryKind::PerLeaf;
            behind += 1;
            continue;
        }
        let known = hidden_frames.unwrap_or(0).saturating_mul(limits.leaves_behind_per_frame);
        let most_behind = known.min(limits.leaves_behind);
        if most_behind > 0 {
            let bounds = test.bounds;
            let front = SharedProxy { test: number, bounds, leaves_behind: 0, most_behind };
            fronts.add(front, views, least_area, limits.fronts);
        }
    }
    behind
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3, Vec2, Vec3};

    use super::*;
    use crate::geom::bounds::Aabb;
    use crate::geom::camera::{Camera, Projection};
    use crate::geom::outline::{Outline, screen_corners};
    use crate::geom::view::CullView;
    use crate::ids::{FrameId, Generation, LeafIndex, LeafRange, NodeId};
    use crate::plan::frame_plan::QueryTag;
    use crate::rng::SplitMix64;

    /// Returns the position of a point on the screen in pixels, computed in 64 bits.
    fn exactly(point: Vec3, view: &CullView) -> DVec2 {
        let clip = view.view_proj.as_dmat4() * point.as_dvec3().extend(1.0);
        let [width, height] = view.size.map(f64::from);
        (clip.truncate().truncate() / clip.w + 1.0) * 0.5 * DVec2::new(width, height)
    }

    #[test]
    fn only_sharp_outlines_are_in_front_wherever_the_world_is() {
        let mut rng = SplitMix64::new(7);
        let mut between = |low: f32, high: f32| {
            low + (high - low) * (rng.between(0, 1 << 20) as f32 / (1 << 20) as f32)
        };
        let mut sharp = 0;
        let mut blunt = 0;
        for _ in 0..20_000 {
            let distance = 10.0_f32.powf(between(0.0, 5.0));
            let eye =
                Vec3::new(distance, between(-1.0, 1.0) * distance, between(-1.0, 1.0) * distance);
            let forward = Vec3::new(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0));
            let size = 10.0_f32.powf(between(-1.0, 2.0));
            let projection = if between(0.0, 1.0) < 0.5 {
                Projection::perspective(1.0)
            } else {
                Projection::Orthographic { height: size * 8.0, far: size * 20.0 }
            };
            let camera = Camera { eye, forward, up: Vec3::Y, projection, near: 0.01 };
            let view = CullView::new(&camera, [1280, 720], 8);
            let aside = Vec2::new(between(-1.0, 1.0), between(-1.0, 1.0));
            let distance = size * between(0.5, 8.0);
            let centre = view.rays.point(aside, distance);
            let half = Vec3::new(between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.0)) * size;
            let bounds = Aabb::new(centre - half, centre + half);
            let Some(corners) = screen_corners(&bounds, &view) else { continue };
            let outline = Outline::around(corners);
            let nearest = bounds.corners().map(|corner| view.rays.depth_m(corner));
            let is_near = nearest.into_iter().any(|depth_m| depth_m < view.rays.near);
            if is_near || !outline.is_sharp(&bounds, &view) {
                blunt += 1;
                continue;
            }
            sharp += 1;
            let corners = bounds.corners().map(|corner| exactly(corner, &view));
            for point in outline.points() {
                let away = corners.iter().map(|corner| corner.distance(point.as_dvec2()));
                let away = away.fold(f64::INFINITY, f64::min);
                assert!(away <= 1.0 / 16.0, "{away} pixels at {distance} m from the origin");
            }
        }
        assert!(sharp > 5_000 && blunt > 1_000, "{sharp} sharp, {blunt} blunt");
    }

    /// Returns true if the second of two tests of four leaves in a row shares the result of the
    /// first. The first test has been hidden for `hidden_frames` and may have `leaves_behind`
    /// leaves behind it.
    fn shares_after(
        hidden_frames: Option<u32>,
        leaves_behind: u32,
        front: Aabb,
        behind: Aabb,
        view: &CullView,
    ) -> bool {
        let leaves = LeafRange { first: LeafIndex(0), count: 4 };
        let test = |bounds| ProxyTest {
            tag: QueryTag {
                node: NodeId(0),
                generation: Generation(0),
                frame: FrameId(1),
                kind: QueryKind::Proxy,
                sample_threshold: 0,
            },
            bounds,
            leaves,
            level: 3,
            tester: VisibilityTest::Flag,
        };
        let mut tests = [test(front), test(behind)];
        let limits =
            Limits { front_area: 1.0e-6, fronts: 4, leaves_behind, leaves_behind_per_frame: 2 };
        let hidden_frames = [hidden_frames, None].into_iter();
        let behind =
            share_in_order(&mut tests, hidden_frames, view.into(), &limits, &mut Fronts::default());
        assert_eq!(behind == 1, matches!(tests[1].tester, VisibilityTest::SharedProxy(0)));
        behind == 1
    }

    fn shares(front: Aabb, behind: Aabb, view: &CullView) -> bool {
        shares_after(Some(100), 100, front, behind, view)
    }

    #[test]
    fn what_is_unknown_or_was_just_hidden_answers_for_nothing_else() {
        let forward = Vec3::NEG_Z;
        let camera = Camera {
            eye: Vec3::ZERO,
            forward,
            up: Vec3::Y,
            projection: Projection::perspective(1.2),
            near: 0.05,
        };
        let view = CullView::new(&camera, [640, 360], 8);
        let at = |z: f32| Aabb::new(Vec3::new(-1.0, -1.0, z - 1.0), Vec3::new(1.0, 1.0, z));
        let after =
            |hidden_frames, most| shares_after(hidden_frames, most, at(-4.0), at(-20.0), &view);
        assert!(![None, Some(0), Some(1)].into_iter().any(|frames| after(frames, 100)));
        assert!([Some(2), Some(3), Some(u32::MAX)].into_iter().all(|frames| after(frames, 100)));
        assert!(!after(Some(u32::MAX), 3), "more than any may");
    }

    /// Returns the fraction of the way from `eye` to `point` at which it enters the box, if it
    /// does.
    fn entry(bounds: &Aabb, eye: DVec3, point: DVec3) -> Option<f64> {
        let way = point - eye;
        let low = bounds.min.as_dvec3() - eye;
        let high = bounds.max.as_dvec3() - eye;
        let mut enter = f64::NEG_INFINITY;
        let mut leave = f64::INFINITY;
        for axis in 0..3 {
            if way[axis] == 0.0 {
                if low[axis] > 0.0 || high[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let a = low[axis] / way[axis];
            let b = high[axis] / way[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave && leave >= 0.0).then_some(enter)
    }

    #[test]
    fn what_is_behind_is_entered_after_what_is_in_front() {
        let mut rng = SplitMix64::new(11);
        let mut between = |low: f32, high: f32| {
            low + (high - low) * (rng.between(0, 1 << 20) as f32 / (1 << 20) as f32)
        };
        let mut shared = 0;
        let mut apart = 0;
        for _ in 0..40_000 {
            let mut sides = |least: f32, most: f32| {
                Vec3::new(between(least, most), between(least, most), between(least, most))
            };
            let forward = sides(-1.0, 1.0);
            let eye = sides(-20.0, 20.0);
            let is_orthographic = shared % 2 == 0;
            let projection = if is_orthographic {
                Projection::Orthographic { height: 14.0, far: 200.0 }
            } else {
                Projection::perspective(1.2)
            };
            let camera = Camera { eye, forward, up: Vec3::Y, projection, near: 0.05 };
            let view = CullView::new(&camera, [640, 360], 8);
            let front = (sides(-4.0, 4.0), sides(0.2, 6.0));
            let behind = (sides(-9.0, 9.0), sides(0.1, 2.0));
            let near = between(4.0, 20.0);
            let far = between(0.0, 40.0);
            let at = |(aside, half): (Vec3, Vec3), distance: f32| {
                let centre = eye + view.rays.forward * distance + aside;
                Aabb::new(centre - half, centre + half)
            };
            let front = at(front, near);
            let behind = at(behind, near + far);
            if !shares(front, behind, &view) {
                apart += 1;
                continue;
            }
            shared += 1;
            // The quarter of a pixel by which the margin enlarges the proxy behind is not part of
            // the object.
            let depth = view.rays.depth_m(behind.centre()).max(view.rays.near);
            let paid = 0.25 * view.pixel_m(depth);
            let low = behind.min + paid;
            let high = behind.max - paid;
            for _ in 0..12 {
                // A corner, or a point of an edge or a face.
                let share = Vec3::from_array([0; 3].map(|_| between(-0.5, 1.5).clamp(0.0, 1.0)));
                let point = low + (high - low).max(Vec3::ZERO) * share;
                let at = exactly(point, &view);
                if at.min_element() < 0.0 || at.x > 640.0 || at.y > 360.0 {
                    continue;
                }
                let point = point.as_dvec3();
                let eye = if is_orthographic {
                    point - view.rays.forward.as_dvec3() * 1_000.0
                } else {
                    eye.as_dvec3()
                };
                let entered = entry(&front, eye, point);
                let is_beyond = entered.is_some_and(|at| at <= 1.0 + 1.0e-6);
                assert!(is_beyond, "{front:?} {behind:?} {entered:?}");
            }
        }
        assert!(shared > 500 && apart > 5_000, "{shared} share, {apart} do not");
    }

    #[test]
    fn blunt_outlines_answer_for_nobody() {
        let offsets = [(0.0, true), (3.0e6, false)];
        for (distance, may_share) in offsets {
            let eye = Vec3::new(distance, 0.0, 0.0);
            let camera = Camera {
                eye,
                forward: Vec3::NEG_Z,
                up: Vec3::Y,
                projection: Projection::perspective(1.0),
                near: 0.1,
            };
            let view = CullView::new(&camera, [640, 360], 8);
            let at = |z: f32, half: f32| {
                let centre = eye + Vec3::new(0.0, 0.0, z);
                Aabb::new(centre - Vec3::splat(half), centre + Vec3::splat(half))
            };
            assert_eq!(
                shares(at(-20.0, 4.0), at(-60.0, 2.0), &view),
                may_share,
                "{distance} m away"
            );
        }
    }
}
