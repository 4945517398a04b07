//! Where on the picture the parts of a page go, and which of them there is room for. In points.

/// Of the picture, what text may cover at most.
const MOST_COVERED: f32 = 0.5;
/// Between texts, and between texts and edges.
pub const MARGIN: f32 = 8.0;

/// How large the parts of a page are.
#[derive(Debug, Clone, Default)]
pub struct Sizes {
    /// Height of a row of text.
    pub row: f32,
    /// The graph with what is written beside it.
    pub graph: [f32; 2],
    /// Groups of facts, the most important first: width of the names, width of the values, rows.
    pub groups: Vec<(f32, f32, usize)>,
    /// The list of keys, without margins.
    pub keys: Option<[f32; 2]>,
    /// The notice with its margins; nothing else may be where it is.
    pub notice_height: f32,
}

/// Where the parts go: their upper left corners.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places {
    /// The panel behind the graph and the groups.
    pub panel: [f32; 2],
    /// Names and values of each group that has room.
    pub groups: Vec<[[f32; 2]; 2]>,
    /// The panel of the keys, where they have room.
    pub keys: Option<[f32; 2]>,
}

impl Sizes {
    /// Arranges all parts on a picture of `screen` points, in as many columns as it takes.
    pub fn arrange(&self, screen: [f32; 2]) -> Option<Places> {
        let height = screen[1] - self.notice_height;
        let keys = self.keys.map(|[width, height]| [width + 2.0 * MARGIN, height + 2.0 * MARGIN]);
        let room = screen[0] - keys.map_or(0.0, |[width, _]| width + MARGIN);
        // The fewest columns that are not too high.
        (1..=self.groups.len().max(1)).find_map(|columns| {
            let places = self.columns(columns);
            let [panel, keys] = [places.panel, keys.unwrap_or_default()];
            let fits = panel[0] <= room && panel[1] <= height && keys[1] <= height;
            let covered = panel[0] * panel[1] + keys[0] * keys[1];
            let is_little = covered <= MOST_COVERED * screen[0] * screen[1];
            let at = [screen[0] - keys[0], 0.0];
            (fits && is_little).then(|| Places { keys: self.keys.map(|_| at), ..places })
        })
    }

    /// The graph, and below it the groups in so many columns, each about as high as the others.
    fn columns(&self, columns: usize) -> Places {
        let below_graph = self.graph[1] + 2.0 * MARGIN;
        let rows = |group: &(f32, f32, usize)| (group.2 as f32 + 0.5) * self.row;
        let heights: f32 = self.groups.iter().map(rows).sum();
        let highest = self.groups.iter().map(rows).fold(0.0, f32::max);
        let limit = (heights / columns as f32).max(highest);
        let mut places = Places::default();
        let [mut left, mut y, mut bottom] = [MARGIN, 0.0, 0.0_f32];
        let mut begin = 0;
        for (place, group) in self.groups.iter().enumerate() {
            // Half a group over is nearer to even than a group less.
            if place > begin && y + 0.5 * rows(group) > limit {
                left = self.close(&mut places, begin..place, left);
                (begin, y) = (place, 0.0);
            }
            places.groups.push([[left, below_graph + y]; 2]);
            y += rows(group);
            bottom = bottom.max(y - 0.5 * self.row);
        }
        let right = self.close(&mut places, begin..self.groups.len(), left);
        places.panel =
            [right.max(self.graph[0] + 2.0 * MARGIN), below_graph + bottom + MARGIN.min(bottom)];
        places
    }

    /// Puts the values of a column beside its names; answers where the next column begins.
    fn close(&self, places: &mut Places, groups: std::ops::Range<usize>, left: f32) -> f32 {
        let column = &self.groups[groups.clone()];
        let names = column.iter().map(|group| group.0).fold(0.0, f32::max);
        let values = column.iter().map(|group| group.1).fold(0.0, f32::max);
        for place in &mut places.groups[groups] {
            place[1][0] = left + names + MARGIN;
        }
        left + names + values + 2.0 * MARGIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(scale: f32) -> Sizes {
        let group = |rows| (110.0 * scale, 150.0 * scale, rows);
        Sizes {
            row: 15.0 * scale,
            graph: [300.0 * scale, 56.0 * scale],
            groups: [3, 5, 8, 10, 8].map(group).to_vec(),
            keys: Some([220.0 * scale, 225.0 * scale]),
            notice_height: 40.0 * scale,
        }
    }

    #[test]
    fn nothing_overlaps_and_nothing_is_cut() {
        for (scale, screen) in
            [(1.0, [1280.0, 720.0]), (0.7, [640.0, 360.0]), (1.0, [1920.0, 1080.0])]
        {
            let sizes = sizes(scale);
            let Some(places) = sizes.arrange(screen) else { continue };
            let corners = |place: usize| {
                let ([x, y], group) = (places.groups[place][0], sizes.groups[place]);
                let right = places.groups[place][1][0] + group.1;
                [x, y, right, y + group.2 as f32 * sizes.row]
            };
            for one in 0..places.groups.len() {
                let a = corners(one);
                assert!(a[2] <= places.panel[0] && a[3] <= places.panel[1], "{screen:?}: {a:?}");
                for other in 0..one {
                    let b = corners(other);
                    let is_apart = a[0] >= b[2] || b[0] >= a[2] || a[1] >= b[3] || b[1] >= a[3];
                    assert!(is_apart, "{screen:?}: {a:?} {b:?}");
                }
            }
            assert!(places.panel[1] <= screen[1] - sizes.notice_height);
            assert!(places.keys.is_some_and(|keys| keys[0] >= places.panel[0]));
        }
    }

    #[test]
    fn a_large_picture_has_one_column_and_a_tiny_one_has_no_room() {
        let places = sizes(1.0).arrange([1920.0, 1080.0]).unwrap();
        assert!(places.groups.iter().all(|group| group[0][0] == MARGIN));
        assert_eq!(places.groups.len(), 5);
        assert_eq!(sizes(1.0).arrange([640.0, 360.0]), None);
        assert_eq!(sizes(1.0).arrange([1.0, 1.0]), None);
    }
}
