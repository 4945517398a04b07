//! The shadow volumes of boxes: a plan of casters tests them in place of the boxes themselves.
//!
//! A caster matters to a view only if its shadow falls on something that the view sees. All such
//! receivers lie in the shadow volume of the caster's box: the points whose way to the light meets
//! the box. So the volume is the proxy. If no sample of it passes the depth test, every visible
//! surface in its pixels is nearer than its front. Then no visible surface is in it, and the caster
//! may be left out (Stich, Wächter, Keller, "Efficient and Robust Shadow Volumes Using Hierarchical
//! Occlusion Culling and Geometry Shaders", GPU Gems 3, chapter 11).
//!
//! The volume of a box is the hull of two images of it: the box moved towards the light, and the
//! box moved away from the light until no receiver is beyond. A factor `k` moves a point `v`
//! to `v + k (w v - l)`, where `l` and `w` are the light in homogeneous coordinates: along its rays
//! for a sun (w = 0), or scaled from the light as the centre otherwise (w = 1).
//!
//! # Margins
//! A filter lights a receiver by the casters around it. So a caster counts if it misses the
//! receiver's ray to the light by at most the reach of the filter. It also counts if it is deeper
//! than the receiver by at most the depth range that the filter assumes for the receiver's plane.
//! So the box is enlarged by the reach ([`LightReach::spread_m`]), and its volume begins nearer to
//! the light by the depth range ([`LightReach::lead`]). The enlargement also includes the margin of
//! proxies ([`Margin`](crate::Margin)) for the farthest receiver. A box that moves towards a local
//! light shrinks, and so does its margin, so the margin is larger from the start to make up for it.

use glam::{Vec2, Vec3, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::frustum::{Containment, Frustum, PlaneMask};
use crate::geom::margin::rounding;
use crate::geom::view::CullView;

/// The least distance of a box from the light, relative to the light's reach, for a volume of its
/// own.
const NEAREST_SHARE: f32 = 1.0 / 64.0;

/// The least margin of a volume in metres, and relative to the size of its surroundings: against
/// the rounding of far vertices, which clipping carries to the eye.
const LEAST_MARGIN: [f32; 2] = [0.01, 2.0e-6];

/// The rays of a light and the reach of its shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightReach {
    /// The light in homogeneous coordinates: a point (metres) with w = 1, or the unit vector
    /// towards a sun with w = 0.
    pub light: Vec4,
    /// The distance from the light beyond which its shadows do not matter, in metres; infinite for
    /// a sun.
    pub reach_m: f32,
    /// The distance by which filters reach beyond a receiver's ray to the light, in metres.
    pub spread_m: f32,
    /// The distance by which a caster may be deeper than the receiver that it shadows: in metres
    /// under a sun, otherwise relative to the caster's distance to the light and below 1.
    pub lead: f32,
}

/// The lengths of the shadow volume of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeLength {
    /// The factor by which the box is moved towards the light.
    pub towards: f32,
    /// The factor by which the box is moved away from the light.
    pub away: f32,
}

/// The shadow volumes of boxes under one light, as one view tests them.
#[derive(Clone, Debug)]
pub struct BoxShadowVolumes<'a> {
    reach: LightReach,
    receivers: Aabb,
    /// The volumes in which casters are drawn.
    frusta: &'a [Frustum],
    margin_m: f32,
    /// A ball around the visible part of the near plane.
    near: (Vec3, f32),
}

impl<'a> BoxShadowVolumes<'a> {
    /// Creates the volumes for a view that sees only `receivers`. A caster counts only if it is in
    /// one of the light's `frusta`.
    #[must_use]
    pub fn new(view: &CullView, reach: LightReach, receivers: Aabb, frusta: &'a [Frustum]) -> Self {
        let farthest_m = receivers
            .corners()
            .into_iter()
            .map(|corner| view.rays.depth_m(corner))
            .fold(view.rays.near, f32::max);
        let [per_w, least] = view.margin.metres();
        let span_m = 2.0 * receivers.half_extent().length() + receivers.largest_coordinate();
        let least = least + LEAST_MARGIN[0] + LEAST_MARGIN[1] * span_m;
        let margin_m = reach.spread_m + per_w * view.rays.kind.w(farthest_m) + least;
        let centre = view.rays.point(Vec2::ZERO, view.rays.near);
        let radius_m = [Vec2::ONE, Vec2::new(1.0, -1.0)]
            .map(|corner| view.rays.point(corner, view.rays.near).distance(centre))
            .into_iter()
            .fold(least, f32::max);
        Self { reach, receivers, frusta, margin_m, near: (centre, radius_m) }
    }

    /// Returns the light.
    #[must_use]
    pub fn light(&self) -> &LightReach {
        &self.reach
    }

    /// Returns the lengths of the volume of `proxy`, a box that [`MultiView`](crate::MultiView)
    /// enlarged.
    #[must_use]
    pub fn length(&self, proxy: &Aabb) -> VolumeLength {
        let LightReach { light, reach_m, lead, .. } = self.reach;
        let l = light.truncate();
        if light.w == 0.0 {
            return VolumeLength { towards: lead, away: self.way_out_m(proxy, l) };
        }
        let distance_m = proxy.distance_squared(l).sqrt();
        if distance_m == 0.0 {
            return VolumeLength { towards: 0.0, away: 0.0 };
        }
        VolumeLength { towards: lead, away: (reach_m / distance_m - 1.0).max(0.0) }
    }

    /// Returns the distance along a sun's rays after which a box has left the box of receivers, in
    /// metres: the smallest of the distances along the three axes.
    fn way_out_m(&self, proxy: &Aabb, towards: Vec3) -> f32 {
        let apart = (proxy.centre() - self.receivers.centre()) * towards.signum();
        let ways = (apart + proxy.half_extent() + self.receivers.half_extent()) / towards.abs();
        // Rays parallel to an axis give infinity; `min` ignores the NaN of 0 / 0.
        ways.to_array().into_iter().fold(f32::INFINITY, f32::min).max(0.0)
    }

    /// Returns the box around the whole reach of a local light, which is tested as its own volume;
    /// `None` if the near plane may cut it, and for a sun.
    #[must_use]
    pub fn whole(&self, view: &CullView) -> Option<Aabb> {
        let position = self.reach.light.truncate();
        let is_local = self.reach.light.w != 0.0;
        is_local.then(|| self.proxy(&Aabb::new(position, position), view)).flatten()
    }

    /// Returns the factor that compensates the shrinking of a box that is moved towards the light.
    fn growth(&self) -> f32 {
        if self.reach.light.w == 0.0 { 1.0 } else { (1.0 - self.reach.lead).recip() }
    }

    /// Returns the box whose volume contains all shadows of `bounds`: `bounds` enlarged by the
    /// margin. If the light is in this box or close to it, returns the box around the whole reach
    /// of the light, which is its own volume.
    fn enlarged(&self, bounds: &Aabb) -> Aabb {
        let LightReach { light, reach_m, .. } = self.reach;
        let enlarged = bounds.enlarged(self.margin_m * self.growth());
        if light.w == 0.0 {
            return enlarged;
        }
        let position = light.truncate();
        let least_m = reach_m * NEAREST_SHARE;
        // Written so that a NaN selects the whole reach.
        if enlarged.distance_squared(position) > least_m * least_m {
            enlarged
        } else {
            Aabb::new(position, position).enlarged(reach_m + self.margin_m)
        }
    }

    /// Returns `Outside` for a box whose shadows the view cannot see, according to the light's
    /// reach, its frusta and the planes of the view.
    pub(crate) fn classify(&self, bounds: &Aabb, view: &CullView) -> Containment {
        let LightReach { light, reach_m, .. } = self.reach;
        let is_lit =
            light.w == 0.0 || bounds.distance_squared(light.truncate()) <= reach_m * reach_m;
        let is_drawn =
            |frustum: &Frustum| frustum.classify(bounds, PlaneMask::ALL).0 != Containment::Outside;
        if bounds.is_empty() || !is_lit || !self.frusta.iter().any(is_drawn) {
            return Containment::Outside;
        }
        let proxy = self.enlarged(bounds);
        let VolumeLength { towards, away } = self.length(&proxy);
        let l = light.truncate();
        let most = |normal: Vec3| {
            let of_box = normal.dot(proxy.centre()) + normal.abs().dot(proxy.half_extent());
            let drawn = |k: f32| of_box + k * (light.w * of_box - normal.dot(l));
            drawn(-towards).max(drawn(away))
        };
        if view.frustum.is_outside(most) { Containment::Outside } else { Containment::Intersects }
    }

    /// Returns the box whose volume is tested in place of `bounds`, or `None` if its shadows must
    /// count as visible because the near plane may cut the volume.
    pub(crate) fn proxy(&self, bounds: &Aabb, view: &CullView) -> Option<Aabb> {
        let proxy = self.enlarged(bounds);
        let VolumeLength { towards, away } = self.length(&proxy);
        let LightReach { light, .. } = self.reach;
        let (centre, radius_m) = self.near;
        // The points that a factor moves to the centre lie on its ray to the light.
        let (way, [first, last]) = if light.w == 0.0 {
            (light.truncate(), [-towards, away])
        } else {
            let share = |k: f32| 1.0 - (1.0 + k).recip();
            (light.truncate() - centre, [share(-towards), share(away)])
        };
        let around =
            proxy.enlarged(radius_m * self.growth() + rounding(&proxy, view.rays.coordinate));
        // Written so that a NaN makes the shadows visible.
        is_missed(&around, centre, way, [first, last]).then_some(proxy)
    }
}

/// Returns true if no point `from + way * u`, for `u` in `range`, is in a box.
fn is_missed(bounds: &Aabb, from: Vec3, way: Vec3, range: [f32; 2]) -> bool {
    let [mut first, mut last] = range;
    if !(bounds.is_finite() && from.is_finite() && way.is_finite()) {
        return false;
    }
    for axis in 0..3 {
        let low = bounds.min[axis] - from[axis];
        let high = bounds.max[axis] - from[axis];
        if way[axis].abs() < f32::MIN_POSITIVE {
            if low > 0.0 || high < 0.0 {
                return true;
            }
            continue;
        }
        let a = low / way[axis];
        let b = high / way[axis];
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    first > last
}

#[cfg(test)]
mod tests {
    mod margins;

    use super::*;
    use crate::geom::camera::{Camera, Projection};
    use crate::rng::SplitMix64;

    const RECEIVERS: Aabb = Aabb { min: Vec3::splat(-40.0), max: Vec3::splat(40.0) };

    struct Numbers(SplitMix64);

    impl Numbers {
        fn between(&mut self, low: f32, high: f32) -> f32 {
            low + (high - low) * (self.0.between(0, 1 << 20) as f32 / (1 << 20) as f32)
        }

        fn point(&mut self, half: f32) -> Vec3 {
            Vec3::from_array([(); 3].map(|()| self.between(-half, half)))
        }
    }

    fn reaches(numbers: &mut Numbers) -> LightReach {
        let is_sun = numbers.between(0.0, 1.0) < 0.5;
        let (light, reach_m) = if is_sun {
            (numbers.point(1.0).normalize().extend(0.0), f32::INFINITY)
        } else {
            (numbers.point(20.0).extend(1.0), numbers.between(2.0, 60.0))
        };
        let lead = numbers.between(0.0, if is_sun { 2.0 } else { 0.9 });
        LightReach { light, reach_m, spread_m: 0.1, lead }
    }

    /// Returns true if a point is in the volume of an enlarged box. Follows the definition in 64
    /// bits: searches a point of the box that a factor moves to `point`.
    fn is_in_volume(proxy: &Aabb, length: VolumeLength, light: Vec4, point: Vec3) -> bool {
        let light = light.as_dvec4();
        let point = point.as_dvec3();
        (0..=4000).any(|step| {
            let [first, last] = [-length.towards, length.away].map(f64::from);
            // Quadratic: dense where the volume begins.
            let share = f64::from(step) / 4000.0;
            let k = first + (last - first) * share * share;
            let from = (point + k * light.truncate()) / (1.0 + k * light.w);
            let slack = 1.0e-3 + 0.02 * share;
            from.cmpge(proxy.min.as_dvec3() - slack).all()
                && from.cmple(proxy.max.as_dvec3() + slack).all()
        })
    }

    #[test]
    fn what_a_view_sees_in_the_shadow_of_a_box_is_in_its_volume() {
        let mut numbers = Numbers(SplitMix64::new(3));
        let mut seen = 0;
        let mut tested = 0;
        let mut cut = 0;
        for round in 0..10_000 {
            let reach = reaches(&mut numbers);
            let eye = numbers.point(30.0);
            let forward = numbers.point(1.0);
            let projection = Projection::perspective(1.2);
            let camera = Camera { eye, forward, up: Vec3::Y, projection, near: 0.1 };
            let view = CullView::new(&camera, [320, 180], 8);
            let volumes = BoxShadowVolumes::new(&view, reach, RECEIVERS, &[]);
            let size = numbers.point(4.0).abs() + 0.05;
            let low = match round % 2 {
                0 => numbers.point(25.0),
                // Between the eye and the light.
                _ => {
                    let towards = reach.light.truncate() - eye * reach.light.w;
                    eye + towards.normalize() * numbers.between(0.0, 20.0) - size * 0.5
                }
            };
            let bounds = Aabb::new(low, low + size);
            // A receiver behind a caster in the box.
            let caster = low + size * (numbers.point(0.5) + 0.5);
            let ray = caster * reach.light.w - reach.light.truncate();
            let receiver = caster + ray * numbers.between(0.0, 4.0) * numbers.between(0.0, 1.0);
            let from_light = receiver.distance(reach.light.truncate());
            let is_lit = reach.light.w == 0.0 || from_light <= reach.reach_m;
            let is_seen = view.frustum.classify(&Aabb::new(receiver, receiver), PlaneMask::ALL).0
                != Containment::Outside;
            if !is_lit || !is_seen || !RECEIVERS.contains_point(receiver) {
                continue;
            }
            seen += 1;
            let proxy = volumes.enlarged(&bounds);
            let length = volumes.length(&proxy);
            assert!(is_in_volume(&proxy, length, reach.light, receiver), "{reach:?} {bounds:?}");
            let is_kept = view.frustum.is_outside(|normal| {
                let l = reach.light.truncate();
                let of_box = normal.dot(proxy.centre()) + normal.abs().dot(proxy.half_extent());
                let drawn = |k: f32| of_box + k * (reach.light.w * of_box - normal.dot(l));
                drawn(-length.towards).max(drawn(length.away))
            });
            assert!(!is_kept, "{reach:?} {bounds:?}");
            // If the near plane is in the volume, there is no proxy.
            let near = view.rays.point(Vec2::new(numbers.between(-1.0, 1.0), 0.5), view.rays.near);
            if let Some(proxy) = volumes.proxy(&bounds, &view) {
                tested += 1;
                let tight = proxy.enlarged(-0.1);
                let is_cut = !tight.is_empty() && is_in_volume(&tight, length, reach.light, near);
                assert!(!is_cut, "{reach:?} {bounds:?}");
            } else {
                cut += 1;
            }
        }
        assert!(seen > 500 && tested > 300 && cut > 30, "{seen} seen, {tested} tested, {cut} cut");
    }
}
