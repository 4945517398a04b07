//! The costs of a device's work, which decide if a test pays off.

use thiserror::Error;

use crate::cost::predication_costs::PredicationCosts;

/// The costs of the work in a frame, in nanoseconds of GPU time.
///
/// Only their ratios affect decisions. They may be measured on the device; no image depends on
/// them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostTable {
    /// The begin and end of an occlusion query, including the copy of its result and, if commands
    /// reset it, its reset.
    pub query_ns: f32,
    /// The box of a test by query without its pixels: a draw of its own.
    pub query_box_ns: f32,
    /// The box of a test by flag without its pixels: one instance of many.
    pub flag_box_ns: f32,
    /// A pixel of a proxy that fails the depth test.
    pub hidden_pixel_ns: f32,
    /// A pixel of a proxy that passes and sets a flag.
    pub flagged_pixel_ns: f32,
    /// A range of draws that depends on a result, including one skipped draw.
    pub predicate_ns: f32,
    /// Each further skipped draw of a range.
    pub skipped_draw_ns: f32,
    /// An indirect call without its draws.
    pub call_ns: f32,
    /// A draw without its triangles.
    pub draw_ns: f32,
    /// A triangle of an object, including its share of vertices and of small pixels.
    pub triangle_ns: f32,
    /// A break of rendering, in which results are made ready, if there is little to wait for.
    pub break_ns: f32,
    /// The additional cost of a break, as a share of the cost of all draws before it, because
    /// nothing overlaps with their end (0 to 1; the only entry that is not a time).
    pub break_wait_share: f32,
    /// A round of tests by compute shader without its boxes: a copy and a reduction of the depth.
    pub compute_round_ns: f32,
    /// A box tested by compute shader, of any size.
    pub compute_box_ns: f32,
}

impl Default for CostTable {
    /// Returns the costs measured on Mesa's software rasteriser (lavapipe 22.3, two cores,
    /// 1280x720), as a fallback if nothing can be measured. A GPU is faster in everything, but with
    /// similar ratios of setup to work.
    fn default() -> Self {
        Self {
            query_ns: 8_000.0,
            query_box_ns: 3_000.0,
            flag_box_ns: 1_000.0,
            hidden_pixel_ns: 0.6,
            flagged_pixel_ns: 1.5,
            predicate_ns: 50.0,
            skipped_draw_ns: 1.0,
            call_ns: 50.0,
            draw_ns: 1_400.0,
            triangle_ns: 40.0,
            break_ns: 150_000.0,
            break_wait_share: 0.2,
            compute_round_ns: 700_000.0,
            compute_box_ns: 4_000.0,
        }
    }
}

/// An impossible cost.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "the cost `{name}` is {value}: costs are finite and not negative, a share is at most 1; \
     take the default table if the clock of the device cannot be trusted"
)]
pub struct BadCost {
    /// The name of the entry of the [`CostTable`].
    pub name: &'static str,
    /// The refused value.
    pub value: f32,
}

impl CostTable {
    /// Returns a table with `ns` for every cost, and without the additional cost of breaks.
    #[must_use]
    pub const fn uniform(ns: f32) -> Self {
        Self {
            query_ns: ns,
            query_box_ns: ns,
            flag_box_ns: ns,
            hidden_pixel_ns: ns,
            flagged_pixel_ns: ns,
            predicate_ns: ns,
            skipped_draw_ns: ns,
            call_ns: ns,
            draw_ns: ns,
            triangle_ns: ns,
            break_ns: ns,
            break_wait_share: 0.0,
            compute_round_ns: ns,
            compute_box_ns: ns,
        }
    }

    /// Returns a table from values in the order of [`CostTable::entries`].
    #[must_use]
    pub fn from_values(value: impl Fn(usize) -> f32) -> Self {
        Self {
            query_ns: value(0),
            query_box_ns: value(1),
            flag_box_ns: value(2),
            hidden_pixel_ns: value(3),
            flagged_pixel_ns: value(4),
            predicate_ns: value(5),
            skipped_draw_ns: value(6),
            call_ns: value(7),
            draw_ns: value(8),
            triangle_ns: value(9),
            break_ns: value(10),
            break_wait_share: value(11),
            compute_round_ns: value(12),
            compute_box_ns: value(13),
        }
    }

    /// Returns all entries with their names, for reports.
    #[must_use]
    pub const fn entries(&self) -> [(&'static str, f32); 14] {
        [
            ("query_ns", self.query_ns),
            ("query_box_ns", self.query_box_ns),
            ("flag_box_ns", self.flag_box_ns),
            ("hidden_pixel_ns", self.hidden_pixel_ns),
            ("flagged_pixel_ns", self.flagged_pixel_ns),
            ("predicate_ns", self.predicate_ns),
            ("skipped_draw_ns", self.skipped_draw_ns),
            ("call_ns", self.call_ns),
            ("draw_ns", self.draw_ns),
            ("triangle_ns", self.triangle_ns),
            ("break_ns", self.break_ns),
            ("break_wait_share", self.break_wait_share),
            ("compute_round_ns", self.compute_round_ns),
            ("compute_box_ns", self.compute_box_ns),
        ]
    }

    /// Returns the table itself if all its entries are possible.
    ///
    /// # Errors
    /// [`BadCost`] for the first entry that is infinite, NaN, negative, or a share above 1.
    pub fn checked(self) -> Result<Self, BadCost> {
        let is_bad = |&(name, value): &(&str, f32)| {
            !value.is_finite() || value < 0.0 || (name == "break_wait_share" && value > 1.0)
        };
        match self.entries().into_iter().find(is_bad) {
            Some((name, value)) => Err(BadCost { name, value }),
            None => Ok(self),
        }
    }

    /// Returns the table with the costs of tests and of their breaks multiplied by `times`.
    pub(crate) fn with_tests_at(&self, times: f32) -> Self {
        let at = |item_cost: f32| (item_cost * times).min(f32::MAX);
        Self {
            query_ns: at(self.query_ns),
            query_box_ns: at(self.query_box_ns),
            flag_box_ns: at(self.flag_box_ns),
            hidden_pixel_ns: at(self.hidden_pixel_ns),
            flagged_pixel_ns: at(self.flagged_pixel_ns),
            predicate_ns: at(self.predicate_ns),
            skipped_draw_ns: at(self.skipped_draw_ns),
            call_ns: at(self.call_ns),
            draw_ns: self.draw_ns,
            triangle_ns: self.triangle_ns,
            break_ns: at(self.break_ns),
            break_wait_share: at(self.break_wait_share),
            compute_round_ns: at(self.compute_round_ns),
            compute_box_ns: at(self.compute_box_ns),
        }
    }

    /// Returns the table of a device that skips hidden draws at these costs. The cost of a round
    /// becomes part of its break.
    #[must_use]
    pub fn skipping_at(self, skip: &PredicationCosts) -> Self {
        Self {
            predicate_ns: skip.range_ns,
            skipped_draw_ns: skip.draw_ns,
            break_ns: self.break_ns + skip.round_ns,
            ..self
        }
    }

    /// Returns the cost of drawing an object of `triangles` triangles that earlier draws hide.
    #[must_use]
    pub fn leaf_ns(&self, triangles: f32) -> f32 {
        self.draw_ns + triangles * self.triangle_ns
    }
}

/// The properties of a scene that costs depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCosts {
    /// The average number of triangles per object.
    pub triangles_per_leaf: f32,
}

impl Default for SceneCosts {
    fn default() -> Self {
        Self { triangles_per_leaf: 100.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_broken_clock_says_is_refused_by_name() {
        let table = CostTable::default();
        assert_eq!(table.checked(), Ok(table));
        let values = table.entries().map(|(_, value)| value);
        assert_eq!(CostTable::from_values(|place| values[place]), table);
        assert!(CostTable::uniform(0.0).checked().is_ok());
        for value in [f32::NAN, f32::INFINITY, -1.0] {
            let bad = CostTable { predicate_ns: value, ..table }.checked().unwrap_err();
            assert_eq!(bad.name, "predicate_ns");
            assert!(bad.to_string().contains("predicate_ns"), "{bad}");
        }
        let share = CostTable { break_wait_share: 1.5, ..table };
        assert_eq!(share.checked().unwrap_err().name, "break_wait_share");
    }
}
