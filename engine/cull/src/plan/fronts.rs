//! The proxies of a plan whose results others may share, with their outlines in each view.

use glam::{Vec2, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::frustum::{Containment, PlaneMask};
use crate::geom::multi_view::MultiView;
use crate::geom::outline::{Outline, ScreenExtent, screen_corners};
use crate::geom::view::CullView;

/// A proxy whose result others may share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedProxy {
    pub(crate) test: u32,
    pub(crate) bounds: Aabb,
    /// The number of leaves behind it, which are tested individually if it shows.
    pub(crate) leaves_behind: u32,
    /// The most leaves that may be behind it.
    pub(crate) most_behind: u32,
}

/// The outlines of a box in one view: of the whole box, and of its part on the screen.
#[derive(Clone, Copy, Debug)]
struct BoxOutline {
    whole: Outline,
    seen: Outline,
}

/// The box examined last, in one view.
#[derive(Clone, Copy, Debug)]
struct BoxInView {
    /// The corners on the screen (pixels); `None` if the box is outside of the view.
    corners: Option<[Vec2; 8]>,
    /// The extent of the part on the screen.
    extent: ScreenExtent,
    /// The outlines, once something needs them: most boxes are distinguished by their extents.
    outlines: Option<BoxOutline>,
}

/// The fronts of a plan, and the box examined last. Reused from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Fronts {
    fronts: Vec<SharedProxy>,
    /// The area of each front on the screen (square pixels).
    areas: Vec<f32>,
    /// The place of the smallest front.
    smallest: Option<usize>,
    /// The extent of each front, one per view. Nothing where the front hides nothing.
    extents: Vec<ScreenExtent>,
    /// The outline of each front, one per view. Empty where the front hides nothing.
    outlines: Vec<Outline>,
    /// The box examined last, one per view.
    looked_at: Vec<BoxInView>,
}

impl Fronts {
    /// Forgets all fronts.
    pub(crate) fn clear(&mut self) {
        self.fronts.clear();
        self.areas.clear();
        self.smallest = None;
        self.extents.clear();
        self.outlines.clear();
    }

    /// Examines a box in all views. Returns false if the numbers fail, if a view that may see the
    /// box has a part of it behind the eye, or if the box is not completely before the eye in any
    /// view.
    pub(crate) fn look_at(&mut self, bounds: &Aabb, views: MultiView<'_>) -> bool {
        self.looked_at.clear();
        let mut is_anywhere = false;
        for view in views.as_slice() {
            let in_view = match screen_corners(bounds, view) {
                Some(corners) => BoxInView::of(corners, view),
                None if is_outside(bounds, view) => BoxInView::OUTSIDE,
                None => return false,
            };
            is_anywhere |= in_view.corners.is_some();
            self.looked_at.push(in_view);
        }
        is_anywhere
    }

    /// Returns the first front that hides the whole box that was [examined](Fronts::look_at) last,
    /// in every view that sees the box, and that may have `leaves` more leaves behind it.
    pub(crate) fn before(
        &mut self,
        bounds: &Aabb,
        leaves: u32,
        views: MultiView<'_>,
    ) -> Option<&mut SharedProxy> {
        let views = views.as_slice();
        let Self { fronts, extents, outlines, looked_at, .. } = self;
        let mut in_views = extents.chunks_exact(views.len()).zip(fronts.iter()).enumerate();
        let (place, _) = in_views.find(|(place, (extents, front))| {
            // Most fronts fail here.
            let contain =
                |(front, box_in): (&ScreenExtent, &BoxInView)| front.contains(box_in.extent);
            extents.iter().zip(&*looked_at).all(contain)
                && front.leaves_behind.saturating_add(leaves) <= front.most_behind
                && looked_at.iter_mut().zip(views).zip(&outlines[place * views.len()..]).all(
                    |((box_in, view), outline)| {
                        box_in.extent.is_nothing()
                            || front.is_before(bounds, view.rays.eye())
                                && box_in.outlines(view).seen.points().all(|at| outline.holds(at))
                    },
                )
        })?;
        self.fronts.get_mut(place)
    }

    /// Adds a front, whose box was [examined](Fronts::look_at) last, if it covers at least
    /// `least_area` (square pixels) in all views together. If there are more than `most` fronts,
    /// the smallest is removed.
    pub(crate) fn add(
        &mut self,
        front: SharedProxy,
        views: MultiView<'_>,
        least_area: f32,
        most: usize,
    ) {
        let smallest = self.smallest.filter(|_| self.fronts.len() >= most);
        let is_enough =
            |area: f32| area >= least_area && smallest.is_none_or(|place| area > self.areas[place]);
        if !is_enough(self.looked_at.iter().map(|box_in| box_in.extent.area()).sum()) {
            return;
        }
        let start = self.outlines.len();
        let mut area = 0.0;
        for (box_in, view) in self.looked_at.iter_mut().zip(views.as_slice()) {
            let BoxOutline { whole, seen } = box_in.outlines(view);
            // A box that the near plane may cut hides nothing in this view.
            let hides = view.margin.is_beyond_near(&front.bounds, 0.0)
                && whole.is_sharp(&front.bounds, view);
            if hides {
                area += seen.area();
            }
            let outline = if hides { whole } else { Outline::EMPTY };
            self.extents.push(ScreenExtent::around(outline.points()));
            self.outlines.push(outline);
        }
        // A front of unknown area is not added.
        if !is_enough(area) {
            self.extents.truncate(start);
            self.outlines.truncate(start);
            return;
        }
        if let Some(place) = smallest {
            self.fronts[place] = front;
            self.areas[place] = area;
            let first = place * self.looked_at.len();
            self.extents.copy_within(start.., first);
            self.extents.truncate(start);
            self.outlines.copy_within(start.., first);
            self.outlines.truncate(start);
        } else {
            self.fronts.push(front);
            self.areas.push(area);
        }
        let areas = self.areas.iter().enumerate();
        self.smallest = areas.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(place, _)| place);
    }
}

impl BoxInView {
    const OUTSIDE: Self = Self { corners: None, extent: ScreenExtent::NOTHING, outlines: None };

    fn of(corners: [Vec2; 8], view: &CullView) -> Self {
        let mut box_in = Self {
            corners: Some(corners),
            extent: ScreenExtent::around(corners.into_iter()),
            outlines: None,
        };
        if !ScreenExtent::of_screen(view).contains(box_in.extent) {
            box_in.extent = ScreenExtent::around(box_in.outlines(view).seen.points());
        }
        box_in
    }

    /// Returns the outlines, computed at the first call.
    fn outlines(&mut self, view: &CullView) -> BoxOutline {
        *self.outlines.get_or_insert_with(|| {
            let whole = self.corners.map_or(Outline::EMPTY, Outline::around);
            let seen = if ScreenExtent::of_screen(view).contains(self.extent) {
                whole
            } else {
                whole.clipped(view.size.map(|pixels| pixels as f32))
            };
            BoxOutline { whole, seen }
        })
    }
}

impl SharedProxy {
    /// Returns true if a box is completely on the inner side of the faces that are seen from `eye`,
    /// which is in homogeneous coordinates.
    fn is_before(&self, behind: &Aabb, eye: Vec4) -> bool {
        let low = self.bounds.min;
        let high = self.bounds.max;
        let beyond_low = eye.truncate().cmpge(low * eye.w) | behind.min.cmpge(low);
        let beyond_high = eye.truncate().cmple(high * eye.w) | behind.max.cmple(high);
        (beyond_low & beyond_high).all()
    }
}

fn is_outside(bounds: &Aabb, view: &CullView) -> bool {
    view.frustum.classify(bounds, PlaneMask::ALL).0 == Containment::Outside
}
