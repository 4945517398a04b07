//! The proxies of a plan whose results others may share, with their outlines in each view.

use glam::{Vec2, Vec4};

use crate::geom::bounds::Aabb;
use crate::geom::frustum::{Containment, PlaneMask};
use crate::geom::multi_view::MultiView;
use crate::geom::outline::Outline;
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

/// The outline of a front in one view; empty where the front hides nothing.
#[derive(Clone, Copy, Debug)]
struct FrontOutline {
    outline: Outline,
    low: Vec2,
    high: Vec2,
}

/// The outlines of a box in one view: of the whole box, and of its part on the screen.
#[derive(Clone, Copy, Debug)]
struct BoxOutline {
    whole: Outline,
    seen: Outline,
}

/// The fronts of a plan, and the outlines of the box examined last. Reused from frame to frame for
/// its memory.
#[derive(Debug, Default)]
pub(crate) struct Fronts {
    fronts: Vec<SharedProxy>,
    /// The area of each front on the screen (square pixels).
    areas: Vec<f32>,
    /// The outlines of each front, one per view.
    outlines: Vec<FrontOutline>,
    /// The outlines of the box examined last, one per view.
    looked_at: Vec<BoxOutline>,
}

impl Fronts {
    /// Forgets all fronts.
    pub(crate) fn clear(&mut self) {
        self.fronts.clear();
        self.areas.clear();
        self.outlines.clear();
    }

    /// Finds the outlines of a box in all views. Returns false if the numbers fail, if a view that
    /// may see the box has a part of it behind the eye, or if the box is not completely before the
    /// eye in any view.
    pub(crate) fn look_at(&mut self, bounds: &Aabb, views: MultiView<'_>) -> bool {
        self.looked_at.clear();
        let mut is_anywhere = false;
        for view in views.as_slice() {
            let whole = match Outline::of(bounds, view) {
                Some(outline) => outline,
                None if is_outside(bounds, view) => Outline::EMPTY,
                None => return false,
            };
            is_anywhere |= !whole.is_empty();
            let seen = whole.clipped(view.size.map(|pixels| pixels as f32));
            self.looked_at.push(BoxOutline { whole, seen });
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
        let Self { fronts, outlines, looked_at, .. } = self;
        let views = views.as_slice();
        let hides = |(front, outlines): &(&mut SharedProxy, &[FrontOutline])| {
            let mut views = views.iter().zip(*outlines).zip(&*looked_at);
            front.leaves_behind.saturating_add(leaves) <= front.most_behind
                && views.all(|((view, outline), BoxOutline { seen, .. })| {
                    seen.is_empty()
                        || front.is_before(bounds, view.rays.eye()) && outline.holds(seen)
                })
        };
        let mut fronts = fronts.iter_mut().zip(outlines.chunks_exact(views.len()));
        fronts.find(hides).map(|(front, _)| front)
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
        let views = views.as_slice();
        let sharp = |(view, outlines): (&CullView, &BoxOutline)| {
            // A box that the near plane may cut hides nothing in this view.
            let hides = view.margin.is_beyond_near(&front.bounds, 0.0)
                && outlines.whole.is_sharp(&front.bounds, view);
            hides.then_some(*outlines)
        };
        let outlines = || views.iter().zip(&self.looked_at).map(sharp);
        let area: f32 = outlines().flatten().map(|outlines| outlines.seen.area()).sum();
        // A front of unknown area is not added.
        if area.is_nan() || area < least_area {
            return;
        }
        let place = if self.fronts.len() < most {
            self.fronts.len()
        } else {
            let areas = self.areas.iter().enumerate();
            let smallest = areas.min_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((place, _)) = smallest.filter(|(_, smallest)| **smallest < area) else {
                return;
            };
            place
        };
        if place == self.fronts.len() {
            self.fronts.push(front);
            self.areas.push(area);
            self.outlines.extend(outlines().map(FrontOutline::of));
        } else {
            self.fronts[place] = front;
            self.areas[place] = area;
            let of_front = self.outlines.iter_mut().skip(place * views.len());
            of_front.zip(outlines()).for_each(|(to, outline)| *to = FrontOutline::of(outline));
        }
    }
}

impl FrontOutline {
    fn of(outlines: Option<BoxOutline>) -> Self {
        let outline = outlines.map_or(Outline::EMPTY, |outlines| outlines.whole);
        let low = Vec2::INFINITY;
        let high = Vec2::NEG_INFINITY;
        let (low, high) = outline
            .points()
            .fold((low, high), |(low, high), point| (low.min(point), high.max(point)));
        Self { outline, low, high }
    }

    /// Returns true if this outline contains another completely.
    fn holds(&self, outline: &Outline) -> bool {
        outline.points().all(|point| point.cmpge(self.low).all() && point.cmple(self.high).all())
            && outline.points().all(|point| self.outline.holds(point))
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
