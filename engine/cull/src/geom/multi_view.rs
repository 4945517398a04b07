//! The views of one plan: one view, or several that are drawn in one pass (multiview rendering).
//!
//! A plan for several views includes everything that any of them sees. The views share one history:
//! a proxy shows if a sample of it passes in any view, so a hidden node is hidden in all views. The
//! rules for one view extend to several. A box is in the frustum if it is in any view's frustum. It
//! has a proxy if the proxy lies beyond the near plane of every view that sees the box, with the
//! largest margin that any of these views needs.
//!
//! A plan of casters has one view, and the shadow volumes of boxes in place of the boxes.

use thiserror::Error;

use crate::geom::bounds::Aabb;
use crate::geom::box_shadow_volumes::BoxShadowVolumes;
use crate::geom::frustum::{Containment, PlaneMask};
use crate::geom::outline::covered_pixels;
use crate::geom::view::CullView;

/// The views of one plan: one view, or several that are drawn in one pass, each to its layer of the
/// image. Examples are the eyes of a stereo pair and the faces of a cube.
#[derive(Clone, Copy, Debug)]
pub struct MultiView<'a> {
    views: &'a [CullView],
    volumes: Option<&'a BoxShadowVolumes<'a>>,
}

/// The reason why views cannot be drawn in one pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MultiViewError {
    /// No view, or more than [`MultiView::MAX`].
    #[error(
        "{count} views in one pass: there may be 1 to {}; plan the others by themselves",
        MultiView::MAX
    )]
    Count {
        /// The number of views.
        count: usize,
    },
    /// A view whose image differs in size or place, or whose depths grow in the other direction.
    #[error(
        "view {number} of a pass differs from the first in the size or place of its image, or in \
         the direction of depth: the layers of one image have these in common"
    )]
    Unlike {
        /// The index of the view, from 0.
        number: usize,
    },
}

impl<'a> From<&'a CullView> for MultiView<'a> {
    fn from(view: &'a CullView) -> Self {
        Self { views: std::slice::from_ref(view), volumes: None }
    }
}

impl<'a> MultiView<'a> {
    /// The most views of a plan: the number that every device with multiview rendering can draw in
    /// one pass (the least `maxMultiviewViewCount` that Vulkan allows).
    pub const MAX: usize = 6;

    /// Creates the views of one pass; each view is drawn to the layer of its index.
    ///
    /// # Errors
    /// [`MultiViewError::Count`] for no view or more than [`MultiView::MAX`];
    /// [`MultiViewError::Unlike`] for views of different sizes, places or directions of depth.
    pub fn new(views: &'a [CullView]) -> Result<Self, MultiViewError> {
        let (Some(first), 1..=Self::MAX) = (views.first(), views.len()) else {
            return Err(MultiViewError::Count { count: views.len() });
        };
        let common = |view: &CullView| (view.size, view.origin, view.depth);
        match views.iter().position(|view| common(view) != common(first)) {
            Some(number) => Err(MultiViewError::Unlike { number }),
            None => Ok(Self { views, volumes: None }),
        }
    }

    /// Creates a view for a plan of shadows: the leaves of the plan are casters, and its proxies
    /// are [shadow volumes](BoxShadowVolumes).
    #[must_use]
    pub fn of_shadows(view: &'a CullView, volumes: &'a BoxShadowVolumes<'a>) -> Self {
        Self { views: std::slice::from_ref(view), volumes: Some(volumes) }
    }

    /// Returns true if the plan is about shadows: its draws hide nothing in the view.
    pub(crate) fn is_of_shadows(self) -> bool {
        self.volumes.is_some()
    }

    /// Returns the views, at least one.
    #[must_use]
    pub fn as_slice(self) -> &'a [CullView] {
        self.views
    }

    /// Returns the first view, whose image size, place and direction of depth all views share.
    #[must_use]
    pub fn first(self) -> &'a CullView {
        &self.views[0]
    }

    /// Tests a box against the frustums by `masks`, which belong to a box around it. `is_cut_away`
    /// returns true for a view whose section planes remove the box. Returns the containment in the
    /// frustum that the box is farthest inside, and the masks for its parts.
    pub(crate) fn classify(
        self,
        bounds: &Aabb,
        masks: ViewMasks,
        is_cut_away: impl Fn(&CullView) -> bool,
    ) -> (Containment, ViewMasks) {
        if let Some(volumes) = self.volumes {
            return if is_cut_away(self.first()) {
                (Containment::Outside, masks)
            } else {
                (volumes.classify(bounds, self.first()), masks)
            };
        }
        let mut below = masks;
        let mut place = Containment::Outside;
        for (view, mask) in self.views.iter().zip(&mut below.0) {
            if *mask != PlaneMask::OUTSIDE {
                let (of_view, remaining) = if is_cut_away(view) {
                    (Containment::Outside, *mask)
                } else {
                    view.frustum.classify(bounds, *mask)
                };
                *mask = match of_view {
                    Containment::Outside => PlaneMask::OUTSIDE,
                    _ => remaining,
                };
                place = place.max(of_view);
            }
        }
        (place, below)
    }

    /// Returns the box to test in place of `bounds`, or `None` if it must count as visible, because
    /// a part of the proxy is too near for a view that sees the box. `masks` belong to `bounds`.
    pub(crate) fn proxy(self, bounds: &Aabb, masks: ViewMasks) -> Option<Aabb> {
        if let Some(volumes) = self.volumes {
            return volumes.proxy(bounds, self.first());
        }
        // The usual case, in one pass: a node of a plan for one view is seen by this view.
        if let [view] = self.views {
            return view.margin.proxy(bounds);
        }
        let seeing = || {
            let views = self.views.iter().zip(masks.0);
            views.filter(|(_, mask)| *mask != PlaneMask::OUTSIDE).map(|(view, _)| &view.margin)
        };
        // Written so that a NaN makes the box visible.
        let distance = seeing().try_fold(0.0_f32, |most, margin| {
            let distance = margin.distance_m(bounds);
            (distance >= 0.0).then(|| most.max(distance))
        })?;
        let is_far = seeing().all(|margin| margin.is_beyond_near(bounds, distance));
        is_far.then(|| bounds.enlarged(distance))
    }

    /// Returns the square of the distance from the nearest eye to a box (square metres).
    pub(crate) fn distance_squared(self, bounds: &Aabb) -> f32 {
        let of = |view: &CullView| view.rays.distance_squared(bounds);
        self.views[1..].iter().fold(of(self.first()), |nearest, view| nearest.min(of(view)))
    }

    /// Returns the length seen under an angle of 1 radian at a distance (metres), smallest of all
    /// views.
    pub(crate) fn metres_per_radian(self, distance_m: f32) -> f32 {
        let of = |view: &CullView| view.rays.metres_per_radian(distance_m);
        self.views[1..].iter().fold(of(self.first()), |least, view| least.min(of(view)))
    }

    /// Returns the approximate number of pixels that a box covers in all views together.
    pub(crate) fn covered_pixels(self, bounds: &Aabb) -> f32 {
        self.views.iter().map(|view| covered_pixels(view, bounds)).sum()
    }
}

/// The planes of each view that a box still has to be tested against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ViewMasks([PlaneMask; MultiView::MAX]);

impl ViewMasks {
    /// All planes of all views.
    pub(crate) const ALL: Self = Self([PlaneMask::ALL; MultiView::MAX]);

    /// Returns true if the box that gave these masks is completely inside of a view's frustum.
    pub(crate) fn is_inside(self) -> bool {
        self.0.iter().any(|mask| mask.is_inside())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::camera::{Camera, Projection};

    fn looking(eye: Vec3, forward: Vec3) -> CullView {
        let projection = Projection::perspective(std::f32::consts::FRAC_PI_2);
        let up = if forward.y == 0.0 { Vec3::Y } else { Vec3::X };
        CullView::new(&Camera { eye, forward, up, projection, near: 0.1 }, [64, 64], 8)
    }

    fn cube(centre: Vec3, half: f32) -> Aabb {
        Aabb::new(centre - half, centre + half)
    }

    #[test]
    fn views_of_one_pass_have_one_kind_of_image() {
        let view = looking(Vec3::ZERO, Vec3::NEG_Z);
        let count = |count| MultiView::new(&vec![view; count]).map(|_| ());
        assert_eq!((count(1), count(MultiView::MAX)), (Ok(()), Ok(())));
        for wrong in [0, MultiView::MAX + 1] {
            assert_eq!(count(wrong), Err(MultiViewError::Count { count: wrong }));
        }
        let unlike = [view, view, CullView { origin: [1, 0], ..view }];
        let error = MultiView::new(&unlike).map(|_| ()).unwrap_err();
        assert_eq!(error, MultiViewError::Unlike { number: 2 });
    }

    #[test]
    fn a_box_is_inside_where_one_view_has_it_and_stays_outside_below_a_node_that_is() {
        let pair = [Vec3::NEG_Z, Vec3::X].map(|forward| looking(Vec3::ZERO, forward));
        let views = MultiView::new(&pair).unwrap();
        let ahead = cube(Vec3::NEG_Z * 10.0, 1.0);
        let (place, masks) = views.classify(&ahead, ViewMasks::ALL, |_| false);
        assert_eq!((place, masks.is_inside()), (Containment::Inside, true));
        // The second view is not tested again.
        let (place, _) = views.classify(&cube(Vec3::X * 10.0, 1.0), masks, |_| false);
        assert_eq!(place, Containment::Inside, "the first has nothing left to ask");
        assert_eq!(masks.0[1], PlaneMask::OUTSIDE);
        let behind = cube(Vec3::new(-10.0, 0.0, 10.0), 1.0);
        let behind = views.classify(&behind, ViewMasks::ALL, |_| false);
        assert_eq!(behind.0, Containment::Outside);
    }

    #[test]
    fn a_proxy_has_the_largest_margin_and_no_view_that_sees_it_cuts_it() {
        let pair = [Vec3::ZERO, Vec3::Z * 90.0].map(|eye| looking(eye, Vec3::NEG_Z));
        let views = MultiView::new(&pair).unwrap();
        let masks = |bounds: &Aabb| views.classify(bounds, ViewMasks::ALL, |_| false).1;
        let proxy = |bounds: &Aabb| views.proxy(bounds, masks(bounds));
        let far = cube(Vec3::NEG_Z * 10.0, 1.0);
        let [near_one, far_one] = pair.map(|view| view.margin.proxy(&far).unwrap());
        assert!(far_one.contains(&near_one) && far_one != near_one);
        assert_eq!(proxy(&far), Some(far_one));
        // At the first eye, but far from the second.
        assert_eq!(proxy(&cube(Vec3::ZERO, 1.0)), None);
        // Behind the first eye, which does not see it.
        assert!(proxy(&cube(Vec3::Z * 40.0, 1.0)).is_some());
        // The margin for the second view would reach the near plane of the first.
        let margin = pair[0].margin.distance_m(&far);
        let close = cube(Vec3::NEG_Z * (1.0 + 0.11 + 4.0 * margin), 1.0);
        assert!(pair.iter().all(|view| view.margin.proxy(&close).is_some()));
        assert_eq!(proxy(&close), None);
    }

    #[test]
    fn the_nearest_eye_counts() {
        let pair = [Vec3::ZERO, Vec3::Z * 90.0].map(|eye| looking(eye, Vec3::NEG_Z));
        for pair in [pair, [pair[1], pair[0]]] {
            let views = MultiView::new(&pair).unwrap();
            assert_eq!(views.distance_squared(&cube(Vec3::NEG_Z * 11.0, 1.0)), 100.0);
        }
    }
}
