//! Legends for the colours of debug overlays.

use antumbra::render::palette::{
    BOX_BEHIND, BOX_HIDDEN, BOX_SHOWED, BOX_UNKNOWN, SELECTED, WIREFRAME,
};
use antumbra::render::{DebugOverlay, Rect};
use bench::legend;

use crate::hud::Legend;

/// Returns the legend of the view from above, in `area` or for a whole image.
pub fn from_above(area: Option<Rect>) -> Legend {
    Legend { title: legend::TITLE_FROM_ABOVE, entries: legend::from_above(), area }
}

/// Returns the legends of all debug overlays; `is_frozen` while the culling is frozen.
pub fn of(debug_overlay: DebugOverlay, is_frozen: bool) -> Vec<Legend> {
    let mut legends = Vec::new();
    if is_frozen {
        legends.push(from_above(None));
    }
    if debug_overlay.has_depth_complexity {
        let entries = legend::layers();
        legends.push(Legend { title: legend::TITLE_OF_LAYERS, entries, area: None });
    }
    if debug_overlay.has_boxes && !is_frozen {
        let entries = [BOX_HIDDEN, BOX_BEHIND, BOX_UNKNOWN, BOX_SHOWED].map(Into::into).to_vec();
        legends.push(Legend { title: "Boxes that are tested", entries, area: None });
    }
    if debug_overlay.has_wireframe {
        legends.push(Legend { title: "Wireframe", entries: vec![WIREFRAME.into()], area: None });
    }
    legends.extend(debug_overlay.top_down.map(|area| from_above(Some(area))));
    legends
}

/// Returns the legend of the outline of the selected object.
pub fn of_selection() -> Legend {
    Legend { title: "Outline", entries: vec![SELECTED.into()], area: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_that_is_shown_has_a_meaning() {
        let area = Rect { origin: [1, 2], size: [3, 4] };
        let nothing = DebugOverlay::default();
        let all = DebugOverlay {
            has_wireframe: true,
            has_boxes: true,
            has_depth_complexity: true,
            top_down: Some(area),
        };
        let titles = |debug_overlay, is_frozen| -> Vec<&str> {
            of(debug_overlay, is_frozen).iter().map(|legend| legend.title).collect()
        };
        assert!(titles(nothing, false).is_empty());
        let above = "Boxes and the camera";
        assert_eq!(
            titles(all, false),
            ["Depth complexity", "Boxes that are tested", "Wireframe", above]
        );
        // A frozen view shows the boxes by their level, with any debug overlay.
        assert_eq!(titles(nothing, true), [above]);
        assert_eq!(titles(all, true), [above, "Depth complexity", "Wireframe", above]);
        for legend in of(all, false) {
            let mut colours: Vec<[u8; 3]> =
                legend.entries.iter().flat_map(|entry| entry.colours.clone()).collect();
            let count = colours.len();
            colours.sort_unstable();
            colours.dedup();
            assert_eq!(colours.len(), count, "{}: a colour has one meaning", legend.title);
        }
    }
}
