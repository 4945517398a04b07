//! Frames as they were measured against what they should have taken.

use crate::costs::CostTable;
use crate::plan::{FramePlan, Tester};

/// What a frame was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameContents {
    /// Objects that were drawn.
    pub draws: u32,
    /// Their triangles, if they are known; else the average of the scene.
    pub triangles: Option<u64>,
    /// Tests by query, own draws included.
    pub queries: u32,
    /// Boxes tested by query.
    pub queried_boxes: u32,
    /// Boxes tested by flag.
    pub flagged_boxes: u32,
    /// Pixels of all boxes.
    pub proxy_pixels: f32,
    /// Ranges under a predicate.
    pub predicates: u32,
    /// Breaks of rendering.
    pub breaks: u32,
}

impl FrameContents {
    /// What a plan asks for, whose proxies cover `proxy_pixels`, and of which `draws` objects were
    /// drawn.
    #[must_use]
    pub fn of(plan: &FramePlan, draws: u32, proxy_pixels: f32) -> Self {
        let by = |tester| plan.tests.iter().filter(|test| test.tester == tester).count() as u32;
        Self {
            draws,
            triangles: None,
            queries: plan.query_count() as u32,
            queried_boxes: by(Tester::Query),
            flagged_boxes: by(Tester::Flag),
            proxy_pixels,
            predicates: plan.tests.iter().filter(|test| !test.leaves.is_empty()).count() as u32,
            breaks: plan.rounds.len() as u32,
        }
    }

    /// What this should take.
    pub(super) fn predicted_ns(&self, table: &CostTable, triangles_per_leaf: f32) -> f32 {
        let draws = self.draws as f32;
        let triangles =
            self.triangles.map_or(draws * triangles_per_leaf, |triangles| triangles as f32);
        let drawing = draws * table.draw_ns + triangles * table.triangle_ns;
        let waits = if self.breaks > 0 { table.break_wait_share } else { 0.0 };
        drawing * (1.0 + waits)
            + self.queries as f32 * table.query_ns
            + self.queried_boxes as f32 * table.query_box_ns
            + self.flagged_boxes as f32 * table.flag_box_ns
            + self.proxy_pixels * table.hidden_pixel_ns
            + self.predicates as f32 * table.predicate_ns
            + self.breaks as f32 * table.break_ns
    }
}

/// Frames that must agree.
const FRAMES: usize = 31;
/// The farthest that the scale goes.
const MOST: f32 = 100.0;
/// How far it follows at a time.
const STEP: f32 = 0.1;

/// How many times longer frames take than they should.
#[derive(Clone, Debug)]
pub(super) struct Observed {
    ratios: [f32; FRAMES],
    next: usize,
    scale: f32,
}

impl Default for Observed {
    fn default() -> Self {
        Self { ratios: [1.0; FRAMES], next: 0, scale: 1.0 }
    }
}

impl Observed {
    pub(super) fn scale(&self) -> f32 {
        self.scale
    }

    /// Whenever as many frames as needed are there, the scale goes a part of the way to their median,
    /// so that neither outliers nor one strange moment decide.
    pub(super) fn note(&mut self, measured_ns: f32, predicted_ns: f32) {
        let ratio = measured_ns / predicted_ns;
        let is_usable = measured_ns > 0.0 && predicted_ns > 0.0 && ratio > 0.0 && ratio.is_finite();
        if !is_usable {
            return;
        }
        self.ratios[self.next] = ratio;
        self.next += 1;
        if self.next == FRAMES {
            self.next = 0;
            let mut sorted = self.ratios;
            sorted.sort_unstable_by(f32::total_cmp);
            let median = sorted[FRAMES / 2].clamp(1.0 / MOST, MOST);
            self.scale *= (median / self.scale).powf(STEP);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_follows_slowly_and_outliers_do_not_move_it() {
        let mut observed = Observed::default();
        for frame in 0..31 * 4 {
            let is_odd_one = frame % 5 == 0;
            observed.note(if is_odd_one { 1.0e9 } else { 1.0e6 }, 1.0e6);
        }
        assert_eq!(observed.scale(), 1.0);
        for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
            (0..100).for_each(|_| observed.note(bad, 1.0e6));
            (0..100).for_each(|_| observed.note(1.0e6, bad));
        }
        assert_eq!(observed.scale(), 1.0);
        (0..31).for_each(|_| observed.note(4.0e6, 1.0e6));
        assert!(observed.scale() > 1.1 && observed.scale() < 1.2, "{}", observed.scale());
        (0..31 * 100).for_each(|_| observed.note(4.0e6, 1.0e6));
        assert!((observed.scale() - 4.0).abs() < 0.1, "{}", observed.scale());
        (0..31 * 300).for_each(|_| observed.note(1.0e12, 1.0));
        assert!(observed.scale() <= MOST);
    }

    #[test]
    fn a_frame_takes_what_its_parts_take() {
        let table = CostTable::uniform(1.0);
        let contents = FrameContents { draws: 10, queries: 3, breaks: 2, ..Default::default() };
        assert_eq!(contents.predicted_ns(&table, 4.0), 10.0 + 40.0 + 3.0 + 2.0);
        let counted = FrameContents { triangles: Some(7), ..contents };
        assert_eq!(counted.predicted_ns(&table, 4.0), 10.0 + 7.0 + 3.0 + 2.0);
        let slow = CostTable { break_wait_share: 0.5, ..table };
        assert_eq!(counted.predicted_ns(&slow, 4.0), 17.0 * 1.5 + 3.0 + 2.0);
    }
}
